"""Runs of the viscobar program, for the scripts beside this one."""
import csv
import json
import pathlib
import statistics
import subprocess
import tempfile
import time

HERE = pathlib.Path(__file__).parent


def run(program, scene, repetitions=1, **settings):
    """Median wall and integration seconds of `viscobar run`, its summary, and u(0, t)."""
    with tempfile.TemporaryDirectory() as out:
        command = [program, "run", str(HERE / scene), "--json", "-o", out]
        for key, value in settings.items():
            command += ["--set", f"{key.replace('__', '.')}={value}"]
        wall, integration, reading = [], [], []
        for _ in range(repetitions):
            begin = time.perf_counter()
            printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            wall.append(time.perf_counter() - begin)
            summary = json.loads(printed)
            integration.append(summary["integration_seconds"])
            reading.append(summary["wall_seconds"])
        with open(pathlib.Path(out) / "ends.csv") as file:
            left = [float(row["u_left"]) for row in csv.DictReader(file)]
    return {"wall": statistics.median(wall), "integration": statistics.median(integration),
            "run": statistics.median(reading), "steps": summary["steps"], "left": left}


def process_seconds(command, repetitions=21):
    """Median wall seconds of a command."""
    seconds = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)
