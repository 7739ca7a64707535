"""The two steppers of odeint beside what `automatic` takes: steps and milliseconds of 72 bars between two obstacles.

python3 tests/measurements/odeint_steppers.py PROGRAM

The last column is the time of the one that `automatic` takes over that of the other; the last line has its largest value, and
what a step of rosenbrock4 takes over one of dopri5, the median of runs of more than 1000 steps by both.
"""
import itertools
import json
import statistics
import subprocess
import sys
import tempfile

SCENE = """
[bar]
length = 1.0
viscosity = {viscosity}
[left]
kind = "obstacle"
gap = 0.1
[right]
kind = "obstacle"
gap = 0.1
side = "above"
[initial]
displacement = "0.1*x*(1-x)"
velocity = "0.8-0.4*x"
[time]
end = 6.0
[mesh]
elements = {elements}
mass = "consistent"
[contact]
epsilon = {epsilon}
restitution = {restitution}
[method]
name = "odeint"
stepper = "{stepper}"
relative_tolerance = {tolerance}
[output]
every = 6.0
write = []
"""
BARS = list(itertools.product((27, 200), (0.0, 0.01, 0.3), (1e-3, 1e-6, 1e-9), (0.5, 1.0), (1e-4, 1e-8)))


def told(program, command, folder, *options):
    text = subprocess.run([program, command, f"{folder}/scene.toml", "--json", *options], capture_output=True, text=True, check=True)
    return json.loads(text.stdout)


def main():
    worst, a_step = 0.0, []
    print("| elements | viscosity | epsilon | restitution | tolerance | rosenbrock4 | ms | dopri5 | ms | automatic | over the other |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for elements, viscosity, epsilon, restitution, tolerance in BARS:
            found = {}
            for stepper in ("rosenbrock4", "dopri5", "automatic"):
                with open(f"{folder}/scene.toml", "w") as file:
                    file.write(SCENE.format(**{k: v for k, v in locals().items() if k not in ("folder", "found", "file")}))
                if stepper == "automatic":
                    chosen = told(sys.argv[1], "check", folder)["stepper"]
                    continue
                runs = [told(sys.argv[1], "run", folder, "--no-estimate", "-o", f"{folder}/out") for _ in range(3)]
                found[stepper] = runs[0]["steps"], 1e3 * min(run["integration_seconds"] for run in runs)
            other = "dopri5" if chosen == "rosenbrock4" else "rosenbrock4"
            ratio = found[chosen][1] / found[other][1]
            worst = max(worst, ratio)
            (few, implicit), (many, explicit) = found["rosenbrock4"], found["dopri5"]
            if min(few, many) > 1000:
                a_step.append(implicit / few / (explicit / many))
            print(f"| {elements} | {viscosity} | {epsilon} | {restitution} | {tolerance} | {few} | {implicit:.1f} | {many} | "
                  f"{explicit:.1f} | {chosen} | {ratio:.3f} |", flush=True)
    print(f"\nlargest {worst:.1f}; a step of rosenbrock4 takes {statistics.median(a_step):.2f} of one of dopri5 ({len(a_step)} bars)")


if __name__ == "__main__":
    main()
