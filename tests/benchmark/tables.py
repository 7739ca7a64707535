"""Markdown tables of docs/speed.md, docs/internals/scheme-speed.md and docs/internals/design.md from the results of scripts/benchmark.

Usage: tables.py DIRECTORY, which holds benchmark.json, process.json and, where SciPy is installed, scipy.json; or
tables.py DIRECTORY own-sundials, which holds release.json and own-sundials.json.
"""
import json
import math
import pathlib
import statistics
import sys


def medians(path):
    """name -> {"ms": CPU time, counters}, the medians over the repetitions."""
    runs = {}
    for row in json.loads(path.read_text())["benchmarks"]:
        if row.get("run_type") == "iteration":
            runs.setdefault(row["run_name"].split("/repeats:")[0], []).append(row)
    to_ms = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}
    result = {}
    for name, rows in runs.items():
        numbers = {key: statistics.median(row[key] for row in rows)
                   for key, value in rows[0].items() if isinstance(value, (int, float))}
        numbers["ms"] = numbers["cpu_time"] * to_ms[rows[0]["time_unit"]]
        result[name] = numbers
    return result


def number(value):
    if value is None or math.isnan(value):
        return "-"
    return f"{value:.0f}" if value >= 100 else f"{value:.2g}" if value < 1e-2 else f"{value:.3g}"


def table(title, head, rows):
    print(f"\n### {title}\n")
    print("| " + " | ".join(head) + " |")
    print("|---" * len(head) + "|")
    for row in rows:
        print("| " + " | ".join(x if isinstance(x, str) else number(x) for x in row) + " |")


def schemes(results):
    rows = []
    for nodes in (100, 1000, 10000, 100000, 1000000):
        triad = 1e9 * results[f"triad/{nodes}"]["per_node"]
        flight, contact = (1e9 * results[f"scheme/{state}/{nodes}"]["per_node"] for state in ("flight", "contact"))
        paper = [results.get(f"paper/{state}/{nodes}") for state in ("flight", "contact")]
        rows.append([str(nodes), triad, flight, contact, flight / triad, contact / triad]
                    + [1e9 * p["per_node"] / own if p else "" for p, own in zip(paper, (flight, contact))])
    table("Scheme (2.8): a step per node, ns",
          ["J", "triad", "step in flight", "in contact", "flight / triad", "contact / triad",
           "the paper's way / ours, in flight", "in contact"], rows)
    rows = [[str(nodes)] + [1e9 * results[f"{way}/{state}/{nodes}"]["per_node"] for state in ("flight", "contact")
                            for way in ("scheme", "plain")] for nodes in (10, 16, 27, 100)]
    table("Scheme (2.8) on short bars: a step per node, ns, beside plain loops that factor once",
          ["J", "in flight", "plain", "in contact", "plain"], rows)


def cheapest(results, names, elements, error):
    """Time of the cheapest run of the named contenders whose error is not above the given one."""
    times = [r["ms"] for key, r in results.items() if key.startswith("integrators/")
             and key.split("/")[1] in names and key.split("/")[2] == str(elements) and r["error"] <= error]
    return min(times, default=math.nan)


def integrators(results):
    for elements in (27, 1000, 10000):
        rows = []
        for key, run in results.items():
            parts = key.split("/")
            if parts[0] != "integrators" or parts[2] != str(elements):
                continue
            row = [parts[1].replace("_", ", "), f"1e-{parts[3]}", run["ms"], run["steps"], run["error"]]
            for own in ("cvode_local", "cvode_global"):
                row.append(run["ms"] / results[f"integrators/{own}/{elements}/{parts[3]}"]["ms"])
            row.append(run["ms"] / cheapest(results, ("cvode_local", "cvode_global"), elements, run["error"]))
            rows.append(row)
        table(f"The throw, lumped mass, epsilon 1e-4, J = {elements}",
              ["method", "tolerance", "ms", "steps", "error of u(0,t)", "time / cvode local", "time / cvode global",
               "time / cheapest cvode of no larger error"], rows)


def own_methods(results):
    rows = [[f"{mass}, {method}", *(results[f"{method}/epsilon/{mass}/{digits}"][what] for digits in range(3, 9))]
            for what in ("steps", "ms") for mass in ("lumped", "redistributed")
            for method in ("cvode", "ida", "arkode")]
    for row, what in zip(rows, ["steps"] * 6 + ["ms"] * 6):
        row[0] += f", {what}"
    table("The throw, J = 400, tolerance 1e-5 (global): steps and time by penalty",
          ["mass, method", *(f"epsilon 1e-{digits}" for digits in range(3, 9))], rows)
    rows = []
    for elements in (27, 100, 1000, 10000, 100000):
        row = [str(elements)]
        for mass in ("lumped", "redistributed"):
            run = results[f"cvode/mesh/{mass}/{elements}"]
            row += [run["steps"], 1e6 * run["ms"] / run["steps"] / elements]
        rows.append(row)
    table("The throw, tolerance 1e-6 (global), epsilon 1e-4: cvode by mesh",
          ["J", "steps, lumped", "ns a step and node", "steps, redistributed", "ns a step and node"], rows)


def policy(results):
    rows = []
    for scene in ("throw", "chatter 1e-4", "chatter 1e-6", "resting"):
        row = [scene, results[f"policy/cvode/{scene}"]["changes"]]
        for name in ("across", "restart", "kept", "last", "cvode", "cvode_global"):
            run = results[f"policy/{name}/{scene}"]
            row.append(f"{number(run['ms'])}, {number(run['steps'])}, {number(run['error'])}")
        rows.append(row)
    table("At a contact change: ms, steps, error of u(0,t)",
          ["scene", "changes", "stock, across the kink", "stock, restart", "restart, kept first step",
           "restart, a tenth of the last step", "cvode (local)", "cvode (global)"], rows)


def scipy(path):
    if not path.exists():
        print("\nSciPy (python3-scipy) is not installed: its table is left out.")
        return
    data = json.loads(path.read_text())
    time = {(row["name"], row["tolerance"]): row["seconds"] for row in data["rows"]}
    rows = []
    for row in data["rows"]:
        tolerance = row["tolerance"]
        rows.append([row["name"], f"{tolerance:.0e}", 1e3 * row["seconds"], row["steps"], row["error"],
                     *(row["seconds"] / time[f"cvode, {control}", tolerance] for control in ("local", "global"))])
    table(f"The throw, lumped mass, epsilon 1e-5, J = 400, beside SciPy {data['scipy']}; the least of several runs",
          ["method", "tolerance", "ms", "steps", "error of u(0,t)", "time / cvode local", "time / cvode global"], rows)


def process(path):
    costs = json.loads(path.read_text())
    rows = []
    for control, run in costs["runs"].items():
        rows.append([control, *(1e3 * seconds for seconds in (
            run["process"], run["integration"], costs["start"],
            run["process"] - run["integration"] - costs["start"], run["run"]))])
    table("`viscobar run`, 6 s, J = 200, tolerance 1e-8: ms, the least of 21",
          ["error control", "process", "integration", "start of the process (`viscobar --help`)",
           "scene, files and report", "the program's own clock, waits included"], rows)


def own_sundials(directory):
    """Stock CVODE (the better of its two forms) and cvode, with Debian's SUNDIALS and with one compiled with -O3."""
    builds = [medians(directory / name) for name in ("release.json", "own-sundials.json")]
    rows = []
    for key in builds[0]:
        parts = key.split("/")
        if parts[:2] == ["integrators", "cvode_local"]:
            names = [f"integrators/{name}/{parts[2]}/{parts[3]}" for name in ("stock_restart", "stock_plain")]
            label, both = f"J = {parts[2]}, 1e-{parts[3]}", key.replace("local", "global")
        elif parts[:2] == ["policy", "cvode"]:
            names = [f"policy/{name}/{parts[2]}" for name in ("restart", "across")]
            label, both = f"{parts[2]}, T = 6, J = 27, 1e-8", None
        else:
            continue
        stock = [min(build[name]["ms"] for name in names) for build in builds]
        own = [build[key]["ms"] for build in builds]
        rows.append([label, *stock, *own, *(a / b for a, b in zip(stock, own)),
                     *(a / build[both]["ms"] if both else "" for a, build in zip(stock, builds))])
    table("Stock CVODE beside cvode, SUNDIALS as Debian compiles it and with -O3: ms",
          ["scene", "stock, Debian's", "stock, -O3", "cvode (local), Debian's", "cvode (local), -O3", "stock / cvode local, Debian's",
           "stock / cvode local, -O3", "stock / cvode global, Debian's", "stock / cvode global, -O3"], rows)


def main(directory, what=None):
    directory = pathlib.Path(directory)
    if what == "own-sundials":
        return own_sundials(directory)
    results = medians(directory / "benchmark.json")
    for section in (schemes, integrators, own_methods, policy):
        section(results)
    scipy(directory / "scipy.json")
    process(directory / "process.json")


if __name__ == "__main__":
    main(*sys.argv[1:])
