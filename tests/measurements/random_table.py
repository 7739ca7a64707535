"""The command line and the table of random_scenes.py and random_chains.py."""
import argparse
import concurrent.futures
import os


def run(doc, kinds, columns, count, judge, show):
    """judge((program, kind, seed)) tells seed, changes, runs, failures, and of each column what is worst and by which method; it
    has `aside` where roundings decide. show(kind, seed) prints a scene."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("kinds", nargs="*", metavar="KIND")
    parser.add_argument("--count", type=int, default=count)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--show", action="store_true", help="print the scene of the first seed, and its differences")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    if options.show:
        show(options.kinds[0], options.seed)
        print("#", judge((program, options.kinds[0], options.seed)))
        return
    print(f"| kind | scenes | set aside | contact changes | runs | {' | '.join(columns)} |\n|---|---|---|---|---|{'---|' * len(columns)}")
    for kind in options.kinds or kinds:
        with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
            results = list(pool.map(judge, [(program, kind, options.seed + k) for k in range(options.count)]))
        kept = [r for r in results if "aside" not in r]
        cells = [kind, len(kept), len(results) - len(kept), sum(r["changes"] for r in kept), sum(r["runs"] for r in kept)]
        for key in columns:
            worst = max(((*r["worst"][key], r["seed"]) for r in kept if key in r["worst"]), default=None)
            cells.append(f"{worst[0]:.2g} ({worst[1]}, {worst[2]})" if worst else "-")
        print(f"| {' | '.join(map(str, cells))} |", flush=True)
        for r in kept:
            for failure in r["failures"]:
                print(f"seed {r['seed']}: {failure}", flush=True)
