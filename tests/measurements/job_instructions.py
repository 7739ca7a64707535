"""Instructions of six kinds of job, whole processes, or processor times; of a bar of an ensemble by `rigid`.

python3 tests/measurements/job_instructions.py PROGRAM [PROGRAM BEFORE]
python3 tests/measurements/job_instructions.py --times PROGRAM OTHER
python3 tests/measurements/job_instructions.py --bars MEASURE_ENSEMBLE [MEASURE_ENSEMBLE BEFORE]

Times are taken in turn, fifteen of each; the ratio is the median of those of pairs. To count it needs valgrind, which knows AVX2 but not AVX-512: programs of -DVISCOBAR_LEVEL=x86-64-v3. Counts repeat to 1e-4. Both programs
run the examples of this folder's clone.
"""
import os
import re
import resource
import statistics
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


def run(command, scene, arguments):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("throw.toml", THROW), ("sweep.toml", SWEEP), ("readme.toml", scene)):
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
        done = subprocess.run([*command, *arguments, "-o", "out"], capture_output=True, text=True, cwd=folder)
        if done.returncode != 0:
            sys.exit(f"{' '.join(arguments)}: exit code {done.returncode}\n{done.stderr}")
        return done.stderr


def millions_of_instructions(program, scene, arguments):
    told = run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program], scene, arguments)
    return int(re.search(r"Collected : (\d+)", told)[1]) / 1e6


def millions_a_bar(program, scene, arguments):
    few, many = (millions_of_instructions(program, scene, ["bars", str(count), *arguments]) for count in (64, 128))
    return (many - few) / 64


def milliseconds(program, scene, arguments):
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return 1e3 * (usage.ru_utime + usage.ru_stime)

    before = used()
    run([program], scene, arguments)
    return used() - before


mode = sys.argv[1] if sys.argv[1:2] in (["--times"], ["--bars"]) else None
programs = [os.path.abspath(program) for program in sys.argv[2 if mode else 1:]]
if not programs or mode == "--times" and len(programs) != 2:
    sys.exit(__doc__)
of, measure, digits = {
    None: ("millions of instructions", millions_of_instructions, 1),
    "--times": ("ms of the processor", milliseconds, 1),
    "--bars": ("millions of instructions a bar", millions_a_bar, 3),
}[mode]
outputs = [(output, "", [output]) for output in ("events:8", "final", "impulse_left", "peak_left")]
print(f"| job | {of} |" + (" the other | ratio |" if len(programs) > 1 else ""))
print("|---|---|" + ("---|---|" if len(programs) > 1 else ""))
for name, scene, arguments in outputs if mode == "--bars" else jobs():
    pairs = [[measure(program, scene, arguments) for program in programs] for _ in range(15 if mode == "--times" else 1)]
    cells = [f"{statistics.median(values):,.{digits}f}" for values in zip(*pairs)]
    if len(programs) > 1:
        cells.append(f"{statistics.median(one / other for one, other in pairs):.2f}")
    print(f"| {name} | {' | '.join(cells)} |", flush=True)
