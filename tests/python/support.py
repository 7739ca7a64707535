"""What the tests of the package share. They are run by ctest, and by hand:

PYTHONPATH=build/release/python /usr/bin/python3 tests/python/run_test.py
"""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "examples" / "scenes"
PROGRAM = os.environ.get("VISCOBAR_COMMAND", str(ROOT / "build" / "release" / "viscobar"))


def thrown(**changes):
    """A bar that meets an obstacle and leaves it; quick."""
    scene = {
        "bar": {"length": 1.0, "viscosity": 0.1},
        "left": {"kind": "obstacle", "gap": 0.1},
        "initial": {"displacement": 0.0, "velocity": -1.0},
        "time": {"end": 3.0},
        "mesh": {"elements": 20, "mass": "redistributed"},
        "contact": {"epsilon": 1e-3},
        "method": {"name": "cvode", "step": 1e-2},
        "output": {"every": 0.1},
    }
    for key, value in changes.items():
        table, leaf = key.split("__")
        scene.setdefault(table, {})[leaf] = value
    return scene


def long_scene():
    """One that takes minutes: there is time to stop it."""
    return thrown(time__end=1e6, output__every=1e3, mesh__elements=200, load__density="sin(50*t)*x")


def program(*arguments, code=0):
    """Runs the program; its standard output."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=250)
    assert done.returncode == code, done.stderr
    return done.stdout


def program_result(scene, *arguments):
    """ends.csv as columns, events.csv as rows and summary.json of a run of the program."""
    import numpy as np

    with tempfile.TemporaryDirectory() as directory:
        out = pathlib.Path(directory) / "out"
        program("run", scene, "-o", out, "--quiet", "--no-estimate", *arguments)
        lines = (out / "ends.csv").read_text().splitlines()
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        events = [line.split(",") for line in (out / "events.csv").read_text().splitlines()[1:]]
        return dict(zip(lines[0].split(","), rows.T)), events, json.loads((out / "summary.json").read_text())


class Test(unittest.TestCase):
    maxDiff = None


def main():
    unittest.main(verbosity=2)
