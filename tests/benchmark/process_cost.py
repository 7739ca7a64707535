"""What a run costs around its integration: the process, the scene, the files.

Usage: process_cost.py build/release/viscobar results.json
"""
import json
import sys

import viscobar


def main(program, results):
    runs = {}
    for control in ("local", "global"):
        runs[control] = viscobar.run(program, "command.toml", 21, method__error_control=control)
        del runs[control]["left"]
    costs = {"runs": runs, "start": viscobar.least_seconds([program, "--help"])}
    with open(results, "w") as file:
        json.dump(costs, file, indent=1)


if __name__ == "__main__":
    main(*sys.argv[1:])
