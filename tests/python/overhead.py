"""What a run from Python costs beside the same run by the C++ library, and what Python functions in a scene cost.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/python/overhead.py

Processor times, the least of many runs, the two in turns. With --check: whether the overhead is below a tenth.
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
warnings.simplefilter("ignore")


def least(call, count):
    times = []
    for _ in range(count):
        begun = time.thread_time()
        call()
        times.append(time.thread_time() - begun)
    return min(times)


def overhead(rounds=5, count=40):
    """Least seconds by the library and from Python: the scene's file is read, the run made, the arrays are there."""
    path = SCENES / "chatter.toml"

    def run():
        result = viscobar.run(path)
        return result.t, result.u, result.v, result.ends

    run()
    library, python = [], []
    for _ in range(rounds):
        library.append(float(subprocess.run([LIBRARY, path, str(count)], capture_output=True, text=True).stdout))
        python.append(least(run, count))
    return min(library), min(python)


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
        seconds = least(lambda: viscobar.run({**scene, "load": load}), 5)
        yield name, seconds, evaluations


if __name__ == "__main__":
    check = "--check" in sys.argv
    for attempt in range(3 if check else 1):
        library, python = overhead()
        print(f"chatter.toml: library {1e3 * library:.2f} ms, from Python {1e3 * python:.2f} ms, {100 * (python / library - 1):+.1f} %")
        if python < 1.1 * library:
            break
    else:
        sys.exit(1 if check else 0)
    if not check:
        for name, seconds, evaluations in functions():
            print(f"{name}: {1e3 * seconds:.1f} ms, {evaluations} evaluations of the load")
