#!/usr/bin/env python3
"""What sensitivities cost, in instructions, by valgrind: scripts/sensitivity-cost calls it with the program that it
built. Counted is the call of simulate() alone.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

METHODS = ("rigid", "cvode", "ida", "arkode")
ELEMENTS = (50, 1000)
COUNTS = (0, 1, 3, 5)


def measured(program, method, elements, count, profile):
    """The instructions of a run, and what the program prints of it: steps, solves, factorisations."""
    done = subprocess.run(
        ["valgrind", "--tool=callgrind", "--toggle-collect=measured_run", f"--callgrind-out-file={profile}", program,
         method, str(elements), str(count)], check=True, capture_output=True, text=True)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1]), [int(number) for number in done.stdout.split()]


def inclusive(profile):
    """The instructions of each function with all that it calls."""
    shown = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=99.9", "--auto=no", profile],
                           check=True, capture_output=True, text=True).stdout
    counts = {}
    for line in shown.splitlines():
        found = re.match(r"\s*([\d,]+) (?:\([^)]*\)\s+)?\S+?:(.+?)(?: \[[^]]*\])?$", line)
        if found:
            name = re.sub(r"viscobar::|sundials::|\(anonymous namespace\)::", "", found[2]).split("(")[0]
            counts[name] = max(counts.get(name, 0), int(found[1].replace(",", "")))
    return counts


def main():
    program = sys.argv[1]
    print("| method | elements | parameters | steps | factorisations | instructions | runs without | of 1 + p runs |")
    print("|---|---|---|---|---|---|---|---|")
    where = {}
    with tempfile.TemporaryDirectory() as directory:
        profile = str(pathlib.Path(directory, "profile"))
        for method in METHODS:
            for elements in ELEMENTS:
                for count in COUNTS:
                    total, (steps, _, factorisations) = measured(program, method, elements, count, profile)
                    if count == 0:
                        alone = total
                    ratio = total / alone
                    print(f"| {method} | {elements} | {count} | {steps} | {factorisations} | {total / 1e6:.1f}e6 "
                          f"| {ratio:.2f} | {ratio / (1 + count):.2f} |", flush=True)
                    if elements == ELEMENTS[-1] and count in (COUNTS[0], COUNTS[-1]):
                        where[method, count] = total, inclusive(profile)
    for method in METHODS:
        (alone, before), (total, after) = where[method, COUNTS[0]], where[method, COUNTS[-1]]
        print(f"\n{method}, {ELEMENTS[-1]} elements: of what {COUNTS[-1]} parameters add")
        added = {name: count - before.get(name, 0) for name, count in after.items()}
        for name, count in sorted(added.items(), key=lambda pair: -pair[1])[:40]:
            if not name.startswith("0x") and 0.03 <= count / (total - alone) < 0.995:
                print(f"  {count / (total - alone):4.0%}  {name}")


if __name__ == "__main__":
    main()
