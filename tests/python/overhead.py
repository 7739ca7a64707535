"""What a run from Python costs beside the same run by the C++ library, and what Python functions in a scene cost.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/python/overhead.py

Processor times, the least of many runs in many processes, the two in turns: where a process lies in memory, or who
shares its core, makes all of its runs slower by up to a half. With --check: whether the overhead is below a tenth.
"""
import os
import subprocess
import sys
import time
import warnings

import numpy as np

import viscobar
from support import ROOT, SCENES

LIBRARY = os.environ.get("VISCOBAR_LIBRARY_TIME", str(ROOT / "build" / "release" / "tests" / "library_time"))
CHATTER = SCENES / "chatter.toml"
warnings.simplefilter("ignore")


def least(call, count):
    times = []
    for _ in range(count):
        begun = time.thread_time()
        call()
        times.append(time.thread_time() - begun)
    return min(times)


def from_python(count):
    """Least seconds from Python: the scene's file is read, the run made, the arrays are there."""

    def run():
        result = viscobar.run(CHATTER)
        return result.t, result.u, result.v, result.ends

    run()
    return least(run, count)


def seconds(*command):
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def overheads(attempts, rounds=8, count=20):
    """Least seconds by the library and from Python in all processes so far, after each attempt."""
    library = python = float("inf")
    for _ in range(attempts):
        for _ in range(rounds):
            library = min(library, seconds(LIBRARY, CHATTER, str(count)))
            python = min(python, seconds(sys.executable, __file__, "--from-python", str(count)))
        yield library, python


def functions():
    """Seconds of a loaded run with formulas and with Python functions, and how often the library evaluates the load."""
    scene = {
        "bar": {"length": 1.0, "viscosity": 0.01},
        "left": {"kind": "obstacle", "gap": 0.1},
        "initial": {"displacement": 0.0, "velocity": "-x"},
        "time": {"end": 6.0},
        "mesh": {"elements": 100, "mass": "redistributed"},
        "contact": {"epsilon": 1e-5},
        "method": {"name": "cvode"},
        "output": {"every": 0.01},
    }
    loads = [
        ('density = "sin(3*t-x)"', {"density": "sin(3*t-x)"}),
        ("density, of arrays", {"density": lambda x, t: np.sin(3 * t - x)}),
        ("density, of numbers", {"density": lambda x, t: float(np.sin(3 * t - float(x)))}),
        ('profile = "cos(x)", history = "sin(3*t)"', {"profile": "cos(x)", "history": "sin(3*t)"}),
        ("profile, history", {"profile": np.cos, "history": lambda t: np.sin(3 * t)}),
    ]
    for name, load in loads:
        result = viscobar.run({**scene, "load": load})
        evaluations = result.summary["load_evaluations"]
        yield name, least(lambda: viscobar.run({**scene, "load": load}), 5), evaluations


if __name__ == "__main__":
    if "--from-python" in sys.argv:
        print(from_python(int(sys.argv[-1])))
        sys.exit(0)
    check = "--check" in sys.argv
    for library, python in overheads(3 if check else 1):
        print(f"chatter.toml: library {1e3 * library:.2f} ms, from Python {1e3 * python:.2f} ms, {100 * (python / library - 1):+.1f} %")
        if python < 1.1 * library:
            break
    else:
        sys.exit(1 if check else 0)
    if not check:
        for name, time_of, evaluations in functions():
            print(f"{name}: {1e3 * time_of:.1f} ms, {evaluations} evaluations of the load")
