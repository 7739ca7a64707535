"""Judges the solutions in this folder by `viscobar compare --with` and prints the table of docs/solutions-of-others.md.

    table.py             prints it; viscobar is looked for in PATH, or where VISCOBAR_COMMAND says
    table.py --check     compares the finest step of each scheme with the page's
    table.py --commands  prints the command of each row
    table.py --make      solves the bars again by the programs that are named
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PAGE = ROOT / "docs" / "solutions-of-others.md"
PROGRAMS = {".py": ["/usr/bin/python3", "-B"], ".m": ["octave-cli", "-qf"]}

# Scheme, scene, names of its files without the step, {step: script and arguments}.
ROWS = [
    ("Siconos", "impacting-bar", "siconos-impacting-bar",
     {step: "siconos_bar.py impacting-bar " + step for step in ("2e-6", "1e-6", "5e-7")}),
    ("Siconos", "bouncing", "siconos-bouncing", {step: "siconos_bar.py bouncing " + step for step in ("0.008", "0.004")}),
    ("Siconos", "rebound", "siconos-rebound", {step: "siconos_bar.py rebound " + step for step in ("0.02", "0.01")}),
    ("GetFEM, Nitsche", "rebound", "getfem-rebound",
     {step: "getfem_bar.py rebound nitsche " + step for step in ("0.02", "0.01")}),
    ("GetFEM, Nitsche", "period-3", "getfem-period-3",
     {step: "getfem_bar.py period-3 nitsche " + step for step in ("0.02", "0.01", "0.005")}),
    ("GetFEM, penalty", "period-3", "getfem-period-3-penalty",
     {step: "getfem_bar.py period-3 penalty " + step for step in ("0.02", "0.01")}),
    ("SciPy, DOP853", "nonsmooth-mode", "scipy-nonsmooth-mode",
     {"0.01": "scipy_bar.py nonsmooth-mode DOP853 100 0.01 1e-6",
      "0.005": "scipy_bar.py nonsmooth-mode DOP853 200 0.005 1e-6"}),
    ("SciPy, BDF", "unit-left-end", "scipy-unit-left-end-bdf", {"0.02": "scipy_bar.py unit-left-end BDF 50 1e-6 1e-3"}),
    ("SciPy, Radau", "unit-left-end", "scipy-unit-left-end-radau",
     {"0.04": "scipy_bar.py unit-left-end Radau 25 1e-6 1e-8", "0.02": "scipy_bar.py unit-left-end Radau 50 1e-6 1e-8"}),
    ("Octave, ode15s", "shaken-stop", "octave-shaken-stop", {"0.05": "octave_bar.m 20 1", "0.025": "octave_bar.m 40 1"}),
]
HEAD = ("scheme", "scene", "step", "u_left", "ours", "order", "reaction_left", "ours", "order", "contacts", "latest",
        "missed", "made up", "untold")


def command(scene, name, steps):
    files = ",".join(f"examples/others/{name}-{step}.csv={step}" for step in steps)
    return ["compare", f"examples/scenes/{scene}.toml", "--with", files]


def share(value, size):
    return "rounding" if value < 1e-9 * size else f"{value / size:.3g}"


def power(column):
    return "" if column["order"] is None else f"{column['order']:.2f}"


def latest(judged):
    """The largest delay of a contact, where samples tell one."""
    delays = [contact["delay"] for contact in judged["contacts"] if contact["delay"] is not None]
    most = max(delays, key=abs, default=0.0)
    return f"{most:.3g}" if abs(most) > 1.001 * judged["sample"] else ""


def table():
    for scheme, scene, name, steps in ROWS:
        with tempfile.TemporaryDirectory() as out:
            told = subprocess.run([os.environ.get("VISCOBAR_COMMAND", "viscobar"), *command(scene, name, steps), "--json",
                                   "-o", out + "/judged"], cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout
        for step, judged in zip(steps, json.loads(told)["judged"]):
            u, force = judged["columns"]["u_left"], judged["columns"]["reaction_left"]
            yield (scheme, scene, step, share(u["largest"], u["size"]), share(u["own_error"], u["size"]),
                   power(u), share(force["root_mean_square"], force["size"]), share(force["own_error"], force["size"]),
                   power(force), str(sum(contact["begin"] is not None for contact in judged["contacts"])),
                   latest(judged), str(judged["missed"]), str(judged["made_up"]), str(judged["untold"]))


def same(page, told):
    """Numbers of three digits that are rounded once more, and move by our own error on another of our meshes."""
    for k, head in enumerate(HEAD):
        try:
            a, b = float(page[k]), float(told[k])
        except ValueError:
            if page[k] != told[k]:
                return False
            continue
        own = told[k] if head == "ours" else told[k + 1] if head in ("u_left", "reaction_left") else "0"
        allowed = 2.0 * float(own) if own not in ("rounding", "") else 0.0
        allowed += 0.01 * abs(b) if head in ("u_left", "reaction_left", "latest") else 0.05 if head == "order" else 0.0
        if abs(a - b) > allowed:
            return False
    return True


def main():
    if "--commands" in sys.argv:
        for _, scene, name, steps in ROWS:
            print("    viscobar", *command(scene, name, steps))
    elif "--make" in sys.argv:
        for _, _, name, steps in ROWS:
            for step, made_by in steps.items():
                script, *arguments = made_by.split()
                with open(HERE / f"{name}-{step}.csv", "w") as file:
                    subprocess.run([*PROGRAMS[pathlib.Path(script).suffix], HERE / script, *arguments], stdout=file,
                                   check=True)
    elif "--check" in sys.argv:
        lines = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in open(PAGE) if line.startswith("| ")]
        page = [cells for cells in lines if len(cells) == len(HEAD) and cells[0] != HEAD[0]]
        finest = {(scheme, scene, list(steps)[-1]) for scheme, scene, _, steps in ROWS}
        told = [row for row in table() if row[:3] in finest]
        wrong = [(a, b) for a, b in zip(page, told) if not same(a, b)]
        for a, b in wrong:
            print("the page:", *a, "\nthe judge:", *b, file=sys.stderr)
        if wrong or len(page) != len(told):
            sys.exit(f"{PAGE.name}: {len(wrong)} rows differ; {len(page)} there, {len(told)} told")
    else:
        for row in (HEAD, ["---"] * len(HEAD), *table()):
            print("|", " | ".join(row), "|")


main()
