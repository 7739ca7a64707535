"""Instructions of six kinds of job, whole processes.

python3 tests/measurements/job_instructions.py PROGRAM [PROGRAM BEFORE]

It needs valgrind, which knows AVX2 but not AVX-512: programs of -DVISCOBAR_LEVEL=x86-64-v3. Counts repeat to 1e-4. Both programs
run the examples of this folder's clone.
"""
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
THROW = """
[bar]
length = 1.0
viscosity = 0.1
[left]
kind = "obstacle"
gap = 0.1
[initial]
displacement = 0
velocity = -1
[time]
end = 6.0
[mesh]
elements = 27
[method]
relative_tolerance = 1e-6
step = 1e-3
"""
SWEEP = """
scene = "throw.toml"
[set]
method.name = "rigid"
mesh.elements = 24
[vary]
bar.viscosity = { from = 0.05, to = 0.5, count = 40 }
left.gap = { from = 0.05, to = 0.3, count = 50 }
"""
QUIET = ["--quiet", "--no-estimate", "--set", "output.write=[]"]


def throw(method, elements, *further):
    return ["run", "throw.toml", *QUIET, "--set", f"method.name={method}", "--set", f"mesh.elements={elements}", *further]


def jobs():
    readme = open(os.path.join(ROOT, "README.md")).read()
    scene = next(block for block in re.findall(r"```toml\n(.*?)```", readme, re.S) if "[bar]" in block)
    penalty = ["--set", "contact.epsilon=1e-4"]
    yield "scene of the README, `run` with all files", scene, ["run", "readme.toml", "--quiet"]
    yield "throw, `cvode`, 27 elements", "", throw("cvode", 27, *penalty)
    yield "throw, `cvode`, 1000 elements", "", throw("cvode", 1000, *penalty)
    yield "throw, `rigid`, 24 elements", "", throw("rigid", 24)
    yield "throw, `rigid`, 10,000 elements", "", throw("rigid", 10_000)
    yield "throw to T = 1, (2.8), 1000 elements", "", throw("fully_discrete", 1000, "--set", "time.end=1")
    chatter = os.path.join(ROOT, "examples/scenes/chatter.toml")
    yield "chatter, `limit`, 1e-2 to 1e-4", "", ["limit", chatter, "--epsilon", "1e-2:1e-4", "--budget", "0", "--threads", "1", "--quiet"]
    yield "sweep of 2,000 throws, `rigid`, 24 elements", "", ["sweep", "sweep.toml", "--threads", "1", "--quiet"]


def count(program, scene, arguments):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("throw.toml", THROW), ("sweep.toml", SWEEP), ("readme.toml", scene)):
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
        done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, *arguments, "-o", "out"],
                              capture_output=True, text=True, cwd=folder)
        found = re.search(r"Collected : (\d+)", done.stderr)
        if not found or done.returncode != 0:
            sys.exit(f"{' '.join(arguments)}: exit code {done.returncode}\n{done.stderr}")
        return int(found[1])


programs = [os.path.abspath(program) for program in sys.argv[1:]]
if not programs:
    sys.exit(__doc__)
print("| job | millions of instructions |" + (" before | ratio |" if len(programs) > 1 else ""))
print("|---|---|" + ("---|---|" if len(programs) > 1 else ""))
for name, scene, arguments in jobs():
    counts = [count(program, scene, arguments) for program in programs]
    cells = [f"{n / 1e6:,.1f}" for n in counts] + ([f"{counts[0] / counts[1]:.2f}"] if len(counts) > 1 else [])
    print(f"| {name} | {' | '.join(cells)} |", flush=True)
