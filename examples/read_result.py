"""Reads every file of a result of `viscobar run`: python3 read_result.py DIR. The field needs h5py."""
import csv, json, pathlib, sys

result = pathlib.Path(sys.argv[1])
summary = json.loads((result / "summary.json").read_text())
ends = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(open(result / "ends.csv"))]
events = list(csv.DictReader(open(result / "events.csv")))
energy = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(open(result / "energy.csv"))]
print(summary["title"], summary["method"], "to t =", ends[-1]["t"], "with", len(events), "contact changes")
import h5py
with h5py.File(result / "field.h5") as field:
    x, t, u, v, stress = (field[name][:] for name in ("x", "t", "u", "v", "stress"))
print("energy", energy[-1]["total"], "left,", energy[-1]["dissipated"], "dissipated; largest |stress| =", abs(stress).max())
print("field of", len(t), "times and", len(x), "nodes; largest |u| =", abs(u).max(), "largest |v| =", abs(v).max())
