"""Instructions of a step, by method: told in docs/internals/design.md, "The size of the house", and of ten bars for those
of one in docs/bars-in-line.md.

python3 tests/measurements/step_instructions.py [--bars] PROGRAM [PROGRAM BEFORE]

With --bars the rows of sections, unequal elements and bars in line alone, which write at their end. Each number is of
two runs, of times T and 2 T: the difference of instructions over that of steps, so that what a process costs at its
start and end is no part of it. It needs valgrind, which knows AVX2 but not AVX-512: build the programs by
cmake --preset package -B build/avx2 -DCMAKE_CXX_FLAGS=-march=x86-64-v3.
"""
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import tempfile

SCENE = """
[bar]
length = 1.0
viscosity = 0.01
[left]
kind = "obstacle"
gap = {gap}
[right]
kind = "obstacle"
gap = {gap}
[initial]
displacement = "x*(1-x)"
velocity = "-x*(1-x)"
[load]
density = "{load}"
[time]
end = {end}
[mesh]
elements = {elements}
mass = "{mass}"
[contact]
epsilon = 1e-6
[method]
name = "{method}"
relative_tolerance = 1e-6
absolute_tolerance = 1e-9
step = 1e-3
"""
SCENES = {  # nothing touches; ten contact changes, and a load
    "flight": dict(gap=10.0, load="0", mass="consistent", end=6.0),
    "driven": dict(gap=0.1, load="-0.2+sin(3*t)", mass="redistributed", end=10.0),
}
METHODS = ("cvode", "ida", "arkode", "fully_discrete")
# The same length in one bar, of a section or of unequal elements as well, and in ten, bonded or in contacts that are
# pushed shut.
BARS = {
    "one bar": "[bar]\nlength = 1.0\nviscosity = 0.01\n",
    "of a section": '[bar]\nlength = 1.0\nviscosity = 0.01\nsection = "1+0.1*x"\n',
    "unequal elements": "[[bar]]\nlength = 1.0\nviscosity = 0.01\nnodes = {nodes}\n",
    "ten, bonded": "[[bar]]\nlength = 0.1\nviscosity = 0.01\n" * 10,
    "ten, in contact": '[[joint]]\nkind = "contact"\n'.join(["[[bar]]\nlength = 0.1\nviscosity = 0.01\n"] * 10),
}
OF_BARS = """
[output]
every = {end}
[left]
kind = "fixed"
[right]
kind = "free"
force = "-2-sin(2*t)"
""" + SCENE[SCENE.index("[load]"):].replace("1e-6", "1e-3", 1)


def count(job):
    program, options, text = job
    with tempfile.TemporaryDirectory() as folder:
        scene, out = os.path.join(folder, "scene.toml"), os.path.join(folder, "out")
        with open(scene, "w") as file:
            file.write(text)
        done = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/profile", program, "run",
                               scene, "--json", *options, "-o", out], capture_output=True, text=True)
        found = re.search(r"Collected : (\d+)", done.stderr)
        if not found:
            raise SystemExit(f"{program}: {done.stderr[-800:]}")
        with open(os.path.join(out, "summary.json")) as file:
            return int(found[1]), json.load(file)["steps"]


def scene_text(scene, elements, method, times):
    if scene in SCENES:
        keys = SCENES[scene]
        return SCENE.format(**{**keys, "end": times * keys["end"], "elements": elements, "method": method})
    end = 5.0 if method == "rigid" else 0.5  # its steps are long
    nodes = [(j / elements) ** 1.2 for j in range(elements + 1)]
    return BARS[scene].format(nodes=nodes) + OF_BARS.format(load="-0.2+sin(3*t)", end=end * times, elements=elements, mass="fourth_order", method=method)


def main():
    bars_alone = "--bars" in sys.argv
    programs = [os.path.abspath(path) for path in sys.argv[1:] if path != "--bars"]
    rows = [(scene, elements, method) for scene, all_elements in (("flight", (27, 200, 1000)), ("driven", (200,)))
            for elements in all_elements for method in METHODS if not bars_alone]
    rows += [(scene, elements, method) for method in (*METHODS, "rigid", "exponential") for elements in (100, 1000)
             for scene in BARS if method != "exponential" or elements == 100]
    jobs = []
    for program in programs:
        known = subprocess.run([program, "run", "--help"], capture_output=True, text=True).stdout
        options = ["--no-estimate", "--set", 'output.write=["ends"]'] if "--no-estimate" in known else []
        for scene, elements, method in rows:
            jobs += [(program, options, scene_text(scene, elements, method, times)) for times in (1, 2)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(count, jobs))
    pairs = [found[k:k + 2] for k in range(0, len(found), 2)]
    of_program = [pairs[k:k + len(rows)] for k in range(0, len(pairs), len(rows))]
    print("| scene | elements | method | steps | instructions of a step | of one bar's | before, steps | instructions | of one bar's | ratio |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    of_one_bar = {}
    for k, (scene, elements, method) in enumerate(rows):
        cells, each = [], []
        for of in of_program:
            (first, few), (second, many) = of[k]
            each.append((second - first) / (many - few))
            one = of_one_bar.setdefault((elements, method, len(each)), each[-1]) if scene in BARS else None
            cells += [str(many - few), f"{each[-1]:,.0f}", f"{each[-1] / one:.2f}" if one else ""]
        if len(each) == 2:
            cells.append(f"{each[0] / each[1]:.2f}")
        print(f"| {scene} | {elements} | {method} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
