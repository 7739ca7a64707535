"""Reads every file of a result of `viscobar sweep`: python3 read_sweep.py DIR. The table needs h5py."""
import csv, json, pathlib, sys

result = pathlib.Path(sys.argv[1])
sweep = json.loads((result / "sweep.json").read_text())
rows = list(csv.DictReader(open(result / "sweep.csv")))  # the same as in sweep.h5, as text
seconds = sum(float(row["seconds"]) for row in csv.DictReader(open(result / "timings.csv")))
print(sweep["title"], "over", *sweep["keys"], "in", seconds, "seconds of", len(rows), "cases")
import h5py, numpy
with h5py.File(result / "sweep.h5") as file:
    table = file["rows"][file["done"][:] == 1]
print("failed:", (table["completed"] == 0).sum(), "largest penetration =", numpy.nanmax(table["max_penetration"]))
