"""Random scenes by the program, its files and all, against an independent code: the nodal equations of docs/ written down
as dense matrices (nodal_bar.py), integrated by SciPy's DOP853 from kink to kink.

python3 tests/measurements/random_scenes.py PROGRAM [KIND ...] [--count 300] [--seed 1] [--jobs 2] [--show]

KIND is laws, side, masses, gauges, series; absent: each. A row tells how many scenes, contact changes and runs there were,
and the largest difference, with its method and seed, of end traces (u, v), reactions, gauges, impulses and balance of energy.
The unit is 100 times rtol max|v| + atol, which docs/methods.md promises, both tolerances 1e-9, times what the scene magnifies a
change of its start by; of forces it is (E + eta)/h and the stiffness of contacts times that. A scene is set aside where that is
above 30, or a contact change is slower than 0.02.
"""
import csv
import json
import os
import subprocess
import tempfile

import numpy as np

import random_table
from nodal_bar import NodalBar

TOLERANCE = 1e-9
KINDS = ("laws", "side", "masses", "gauges", "series")
PENALISED = ("cvode", "ida", "arkode", "odeint", "exponential")


class Scene(NodalBar):
    """The numbers of a scene, and its file."""

    def __init__(self, kind, seed):
        self.random = np.random.default_rng([KINDS.index(kind), seed])
        self.kind = kind if kind != "gauges" else KINDS[self.random.choice([0, 1, 2, 4])]
        number, log, sometimes = self.number, self.log, self.sometimes
        self.length, self.density, self.modulus = number(0.5, 2), number(0.5, 2), number(0.5, 2)
        self.elements, self.end = int(number(3, 12)), number(2, 4)
        self.mass = str(self.random.choice(["fourth_order", "consistent", "lumped"]))
        self.viscosity = 0.0 if sometimes(0.3) else log(0.01, 0.5)
        self.speed, self.slope = number(-1, 1), 0.0
        self.side = self.load = None
        self.series = {}
        self.epsilon = 1 / log(3, 300)
        self.ends = [dict(kind="free"), dict(kind="free")]
        getattr(self, "draw_" + self.kind)()
        for end in self.ends:
            if end["kind"] == "obstacle":
                end.setdefault("gap", number(0.02, 0.3))
        self.every = self.end / 16
        places = [0.0, self.length, self.length / 2] + list(number(0, self.length, 3))
        self.gauges = sorted(set(places)) if kind == "gauges" else []

    def number(self, low, high, *shape):
        return self.random.uniform(low, high, *shape)

    def log(self, low, high):
        return float(np.exp(self.number(np.log(low), np.log(high))))

    def sometimes(self, share=0.5):
        return self.random.random() < share

    def draw_end(self, end, laws):
        end["kind"] = "obstacle"
        law = end["law"] = str(self.random.choice(laws))
        if law != "penalty":
            end["stiffness_law"] = self.log(3, 300)
            end["damping"] = self.log(0.01, 3) if law != "hertz" and self.sometimes(0.8) else 0.0

    def draw_laws(self):
        self.draw_end(self.ends[0], ["spring_damper", "spring_damper", "hertz", "hunt_crossley"])
        if self.sometimes(0.7):
            self.draw_end(self.ends[1], ["penalty", "spring_damper", "hertz", "hunt_crossley"])
        for end in self.ends:
            if self.sometimes(0.3):
                end["mass"] = self.log(0.01, 2)
        if self.sometimes():
            self.ends[0]["force"] = (self.number(-0.1, 0.1), self.number(1, 4), self.number(-0.1, 0.1) * self.sometimes())

    def draw_masses(self):
        for end in self.ends:
            if self.sometimes():
                self.draw_end(end, ["penalty", "penalty", "spring_damper"])
            if self.sometimes(0.8):
                end["mass"] = self.log(0.01, 5)
            if self.sometimes(0.3):
                end["force"] = (self.number(-0.1, 0.1), self.number(1, 4), self.number(-0.1, 0.1) * self.sometimes())
            if end["kind"] == "free" and self.sometimes(0.3) and self.mass != "fourth_order":
                end["stiffness"] = self.log(0.1, 10)
            if end["kind"] == "free" and self.sometimes(0.3):
                end["dashpot"] = self.log(0.01, 1)

    def draw_side(self):
        self.side = [(self.number(0, 8), self.number(0, 5) * self.sometimes()),
                     (self.number(0, 2), self.number(0, 2) * self.sometimes())]
        self.slope = self.number(-0.1, 0.1)
        if self.sometimes():
            self.load = self.number(-1, 1)
        if self.sometimes():
            self.ends[0]["kind"] = "fixed"
        elif self.sometimes():
            self.draw_end(self.ends[0], ["penalty", "spring_damper", "hertz"])
        if self.sometimes(0.3):
            self.ends[1]["kind"] = "fixed"
        else:
            for key, low, high in (("mass", 0.01, 1), ("stiffness", 0.1, 3), ("dashpot", 0.01, 0.4)):
                if self.sometimes() and (key, self.mass) != ("stiffness", "fourth_order"):
                    self.ends[1][key] = self.log(low, high)

    def draw_series(self):
        self.mass = str(self.random.choice(["consistent", "lumped"]))  # no jump filter
        for end in self.ends:
            if self.sometimes(0.4):
                self.draw_end(end, ["penalty", "spring_damper"])
        which = set(self.random.choice(["force", "history", "stiffness", "velocity", "motion", "gap"], 2, replace=False))
        if "gap" in which:
            self.draw_end(self.ends[0], ["penalty", "spring_damper"])
            which.discard("force")
        if "motion" in which:
            which.discard("velocity")
            self.ends[1] = dict(kind="fixed")
        for key in sorted(which):
            smooth = key in ("motion", "gap") or self.sometimes()
            count = int(self.number(12, 40))
            over = self.length if key in ("stiffness", "velocity") else self.end
            places = np.linspace(0, over, count)
            if not smooth:
                places[1:-1] += 0.3 * over / count * self.number(-1, 1, count - 2)
            if smooth:
                values = self.number(0.2, 1) * np.sin(places / over * self.number(1, 6) + self.number(0, 6))
            else:
                values = self.number(-1, 1, count)
            if key == "motion":
                values = 0.1 * (values - values[0])
            if key == "gap":
                values = 0.2 + 0.15 * values
            if key == "stiffness":
                values = 3 + 2 * values
            self.series[key] = dict(places=places, values=values, cubic=smooth, scale=float(self.random.choice([1, 2.5])))

    # The scene file.
    def text(self, method, folder):
        lines = [f"[bar]\nlength = {self.length!r}\ndensity = {self.density!r}\nmodulus = {self.modulus!r}\nviscosity = {self.viscosity!r}"]
        named = {key: self.record(key, folder) for key in self.series}
        for name, end in zip(("left", "right"), self.ends):
            lines.append(f'[{name}]\nkind = "{end["kind"]}"')
            moving = dict(gap=named["gap"]) if name == "left" and "gap" in named else {}
            lines += [f"{key} = {moving.get(key, repr(end[key]))}" for key in ("gap", "mass", "stiffness", "dashpot") if key in end]
            if name == "right" and end["kind"] == "obstacle":
                lines.append('side = "above"')
            if end.get("law", "penalty") != "penalty":
                damping = "" if end["law"] == "hertz" else f", damping = {end['damping']!r}"
                lines.append(f'contact = {{ law = "{end["law"]}", stiffness = {end["stiffness_law"]!r}{damping} }}')
            if "force" in end:
                lines.append('force = "%r*(1-cos(%r*t))^3 + %r"' % end["force"])
            if name == "left" and "force" in named and end["kind"] != "fixed":
                lines.append(f"force = {named['force']}")
            if name == "right" and "motion" in named:
                lines.append(f"motion = {named['motion']}")
        if self.side:
            (k0, k1), (c0, c1) = self.side
            lines.append(f'[side]\nstiffness = "{k0!r}+{k1!r}*x"\ndrag = "{c0!r}+{c1!r}*x"')
        if "stiffness" in named:
            lines.append(f"[side]\nstiffness = {named['stiffness']}")
        if self.load is not None:
            lines.append(f"[load]\ndensity = {self.load!r}")
        if "history" in named:
            lines.append(f'[load]\nprofile = "1+0.3*x"\nhistory = {named["history"]}')
        lines.append(f'[initial]\ndisplacement = "{self.slope!r}*x*{self.fixed_factor_text()}"')
        lines.append(f"velocity = {named['velocity']}" if "velocity" in named else f'velocity = "{self.speed!r}*{self.fixed_factor_text(True)}"')
        lines.append(f'[time]\nend = {self.end!r}\n[mesh]\nelements = {self.elements}\nmass = "{self.mass}"')
        if any(end["kind"] == "obstacle" and end["law"] == "penalty" for end in self.ends):
            lines.append(f"[contact]\nepsilon = {self.epsilon!r}")
        lines.append(f'[method]\nname = "{method}"\nrelative_tolerance = {TOLERANCE}\nabsolute_tolerance = {TOLERANCE}')
        lines.append(f"[output]\nevery = {self.every!r}\ngauges = {[float(x) for x in self.gauges]}")
        return "\n".join(lines) + "\n"

    def fixed_factor_text(self, velocity=False):
        left, right = (end["kind"] == "fixed" for end in self.ends)
        return ("x" if left and velocity else "1") + (f"*({self.length!r}-x)" if right else "")

    def record(self, key, folder):
        one = self.series[key]
        over = "x" if key in ("stiffness", "velocity") else "t"
        with open(os.path.join(folder, key + ".csv"), "w") as file:
            file.write(f"{over},value\n")
            for place, value in zip(one["places"], one["values"]):
                file.write(f"{float(place)!r},{float(value / one['scale'])!r}\n")
        kind = "cubic" if one["cubic"] else "linear"
        return f'{{ file = "{key}.csv", column = "value", interpolation = "{kind}", scale = {one["scale"]!r}, outside = "hold" }}'

def table(path):
    with open(path) as file:
        rows = list(csv.reader(file))
    return rows[0], np.array(rows[1:], dtype=float)


def methods_of(scene):
    laws = {end["law"] for end in scene.ends if end["kind"] == "obstacle"}
    methods = [m for m in PENALISED if m != "exponential" or not laws & {"hertz", "hunt_crossley"}]
    return methods if laws else methods + ["rigid"]


def judge(job):
    program, kind, seed = job
    scene = Scene(kind, seed)
    result = dict(seed=seed, changes=0, runs=0, worst={}, failures=[])
    times, truth, impulses, speeds = scene.solve()
    other = scene.solve(1e-8)[1]
    scene.magnifies = max(1.0, max(max(np.max(np.abs(a[k] - b[k])) for k in (0, 1)) for a, b in zip(truth, other)) / 1e-8)
    result["changes"] = len(speeds)
    if scene.magnifies > 30 or (speeds and min(speeds) < 0.02):
        return result | dict(aside=True)
    with tempfile.TemporaryDirectory() as folder:
        for method in methods_of(scene):
            path = os.path.join(folder, "scene.toml")
            with open(path, "w") as file:
                file.write(scene.text(method, folder))
            done = subprocess.run([program, "run", path, "-o", os.path.join(folder, method), "--quiet", "--no-estimate", "--set",
                                   'output.write=["ends","events","energy"]'], capture_output=True, text=True, timeout=120)
            if done.returncode != 0:
                result["failures"].append(f"{method}: {done.stderr.strip()}")
                continue
            result["runs"] += 1
            found = compare(scene, os.path.join(folder, method), times, truth, impulses)
            for key, value in found.items():
                if not value <= result["worst"].get(key, (-1.0, ""))[0]:
                    result["worst"][key] = (float(value), method)
    return result


def compare(scene, directory, times, truth, impulses):
    names, rows = table(os.path.join(directory, "ends.csv"))
    column = {name: rows[:, k] for k, name in enumerate(names)}
    promise = 100 * TOLERANCE * scene.magnifies
    size = 1.0 + max(np.max(np.abs(v)) for _, v, _ in truth)
    if len(rows) != len(times):
        return {"traces": np.inf}
    found = {"traces": max(np.max(np.abs(column[f"{q}_{side}"] - [row[k][i] for row in truth])) for k, q in ((0, "u"), (1, "v"))
                           for i, side in ((0, "left"), (-1, "right"))) / size / promise}
    contact = sum((end["stiffness_law"] + end["damping"] if "stiffness_law" in end else 1 / scene.epsilon)
                  for end in scene.ends if end["kind"] == "obstacle")
    force = size * ((scene.modulus + scene.viscosity) * scene.elements / scene.length + contact)
    found["reactions"] = max(np.max(np.abs(column[f"reaction_{side}"][1:] - [row[2][i] for row in truth[1:]]))
                             for i, side in ((0, "left"), (1, "right"))) / force / promise
    if scene.gauges:
        _, rows = table(os.path.join(directory, "gauges.csv"))
        k = 1
        found["gauges"] = 0.0
        for x in scene.gauges:
            scale = np.array([size, size, size * scene.elements / scene.length, force])
            expected = [np.array([scene.gauge(u, v, x, towards) for u, v, _ in truth]) for towards in (-1, 1)]
            off = min(np.max(np.abs(rows[:, k:k + 4] - one) / scale) for one in expected)
            found["gauges"] = max(found["gauges"], off / promise)
            k += 4
    with open(os.path.join(directory, "summary.json")) as file:
        summary = json.load(file)
    found["impulses"] = max((abs(summary["contact"][side]["impulse"] - impulses[i]) / force / promise
                             for i, side in ((0, "left"), (1, "right")) if scene.ends[i]["kind"] == "obstacle"), default=0.0)
    energy = summary["energy"]
    found["energy"] = abs(energy["balance_error"]) / (size * force) / promise
    return found


def show(kind, seed):
    scene = Scene(kind, seed)
    print(scene.text(methods_of(scene)[0], os.getcwd()))


if __name__ == "__main__":
    random_table.run(__doc__, KINDS, ("traces", "reactions", "gauges", "impulses", "energy"), 300, judge, show)
