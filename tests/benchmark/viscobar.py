"""Runs of the viscobar program, for the scripts beside this one."""
import csv
import json
import os
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path(__file__).parent


def processor_seconds(command):
    """User and system seconds of a command, and what it printed."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        printed = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{command} returned {process.returncode}")
    return usage.ru_utime + usage.ru_stime, printed


def least_seconds(command, repetitions=21):
    return min(processor_seconds(command)[0] for _ in range(repetitions))


def run(program, scene, repetitions=1, **settings):
    """Least seconds of `viscobar run` by the processor's clock and, within, of the integration and of the whole run by
    the program's own; steps and u(0, t)."""
    with tempfile.TemporaryDirectory() as out:
        command = [program, "run", str(HERE / scene), "--json", "-o", out]
        for key, value in settings.items():
            command += ["--set", f"{key.replace('__', '.')}={value}"]
        process, summaries = [], []
        for _ in range(repetitions):
            seconds, printed = processor_seconds(command)
            process.append(seconds)
            summaries.append(json.loads(printed))
        with open(pathlib.Path(out) / "ends.csv") as file:
            left = [float(row["u_left"]) for row in csv.DictReader(file)]
    return {"process": min(process), "integration": min(s["integration_seconds"] for s in summaries),
            "run": min(s["wall_seconds"] for s in summaries), "steps": summaries[0]["steps"], "left": left}
