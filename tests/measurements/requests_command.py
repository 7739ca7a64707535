"""What `viscobar run --error` takes against the best setting by hand: the command in docs/accuracy-on-request.md.

python3 tests/measurements/requests_command.py build/release/viscobar

Processor time of the whole process, the least of nine. The settings by hand are those that `measure_requests gallery`
found.
"""
import os
import re
import subprocess
import sys
import tempfile

BY_HAND = [  # scene, request, elements, relative tolerance; no elements: characteristics
    ("rebound", 1e-3, 8, 1e-2), ("rebound", 1e-6, 64, 1e-5), ("rebound", 1e-8, 512, 1e-6),
    ("unit-both-ends", 1e-3, 8, 1e-3), ("unit-both-ends", 1e-6, 32, 1e-4), ("unit-both-ends", 1e-9, 128, 1e-7),
    ("unit-left-end-loaded", 1e-3, 8, 1e-3), ("unit-left-end-loaded", 1e-6, 32, 1e-4),
    ("unit-left-end-loaded", 1e-9, 256, 1e-5),
    ("nonsmooth-mode", 1e-6, None, None), ("steel-impact", 1e-6, None, None),
]


def without_choices(text):
    """The scene without what says of mesh, contact and method."""
    tables = re.split(r"(?m)^(?=\[)", text)
    return "".join(t for t in tables if t.split("]")[0] not in ("[mesh", "[contact", "[method"))


def measure(command):
    def once():
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        if status:
            raise SystemExit(f"failed: {' '.join(command)}")
        return usage.ru_utime + usage.ru_stime
    return 1e3 * min(once() for _ in range(9))


def main():
    program = os.path.abspath(sys.argv[1])
    scenes = os.path.join(os.path.dirname(__file__), "../../examples/scenes")
    print("| scene | request | run --error, ms | by hand, ms | ratio |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for scene, request, elements, tolerance in BY_HAND:
            path = os.path.join(folder, scene + ".toml")
            with open(os.path.join(scenes, scene + ".toml")) as source, open(path, "w") as target:
                target.write(without_choices(source.read()))
            run = [program, "run", path, "-q", "-o", os.path.join(folder, "out")]
            asked = measure([*run, "--error", f"{100 * request:g} %"])
            setting = [] if elements is None else ["--set", f"mesh.elements={elements}", "--set",
                                                   f"method.relative_tolerance={tolerance}"]
            by_hand = measure([*run, "--no-estimate", *setting])
            print(f"| {scene} | {request:.0e} | {asked:.1f} | {by_hand:.1f} | {asked / by_hand:.2f} |")


if __name__ == "__main__":
    main()
