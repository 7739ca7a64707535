"""Random bars in line by the program against an independent code: the nodal equations of docs/bars-in-line.md as dense matrices,
whose motion between two contact changes is a matrix exponential.

python3 tests/measurements/random_chains.py PROGRAM [KIND ...] [--count 200] [--seed 1] [--jobs 2] [--show]

KIND is penalised (contacts that are springs: cvode, ida, arkode, odeint, exponential), laws (hertz and hunt_crossley as well, by
the first four, against SciPy's DOP853; no times of changes), rigid, or scheme ((2.8) with the step T/4000). A row tells how many
chains, contact changes and runs there were. Then the largest difference, with its method and seed, of displacements and velocities
of the ends, displacements at joints, forces, impulses, times of changes, and balance of energy.

The unit is the promise of docs/methods.md, 100 times rtol max|v| + atol, both tolerances 1e-9, times what the chain magnifies a
change of its start by. Of forces it is that times the largest stiffness; of the scheme it is the step times the largest stiffness.
A chain is set aside where roundings decide: it magnifies by more than 30; a contact changes slower than 0.02, together with another,
or by a force that hardly changes.
"""
import csv
import itertools
import json
import os
import subprocess
import tempfile

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import random_table

TOLERANCE = 1e-9
METHODS = {"penalised": ("cvode", "ida", "arkode", "odeint", "exponential"), "laws": ("cvode", "ida", "arkode", "odeint"),
           "rigid": ("rigid",), "scheme": ("fully_discrete",)}


class Undecided(Exception):
    """Roundings decide what happens."""


class Chain:
    """The numbers of a scene, its file, and its motion."""

    def __init__(self, kind, seed):
        random = self.random = np.random.default_rng([["penalised", "rigid", "scheme", "laws"].index(kind), seed])
        self.kind = kind
        self.mass = str(random.choice(["fourth_order", "consistent", "lumped"]))
        self.end = self.number(1.0, 3.0)
        self.members = [self.draw_member(k) for k in range(random.integers(2, 7))]
        for k, member in enumerate(self.members):  # two rigid bodies side by side are rarer
            if k > 0 and "mass" in member and "mass" in self.members[k - 1] and self.sometimes(0.7):
                self.members[k] = self.draw_bar()
        if all("mass" in member for member in self.members):
            self.members[0] = self.draw_bar()
        self.joints = [self.draw_joint() for _ in self.members[1:]]
        self.ends = [self.draw_end(self.members[0]), self.draw_end(self.members[-1])]
        self.epsilon = 1 / self.log(10, 300)
        self.restitution = self.number(0.1, 0.9) if kind in ("rigid", "scheme") and self.sometimes(0.2) else 0.0
        self.number_nodes()

    def number(self, low, high):
        return float(self.random.uniform(low, high))

    def log(self, low, high):
        return float(np.exp(self.number(np.log(low), np.log(high))))

    def sometimes(self, share=0.5):
        return self.random.random() < share

    def springs(self):
        return self.kind in ("penalised", "laws")

    def draw_bar(self):
        bar = {key: self.log(0.5, 2) for key in ("length", "density", "modulus", "section")}
        bar["growth"] = self.number(-1, 1) / bar["length"] if self.sometimes(0.3) else 0.0
        bar["viscosity"] = 0.0 if self.sometimes(0.2) and self.springs() else self.log(0.02, 0.5)
        bar["elements"] = int(self.random.integers(4, 10))
        bar["velocity"] = self.number(-1, 1)
        return bar

    def draw_member(self, k):
        return dict(mass=self.log(0.2, 3), velocity=self.number(-1, 1)) if self.sometimes(0.25) else self.draw_bar()

    def draw_joint(self):
        kind = str(self.random.choice(["bonded", "contact", "contact", "spring"]))
        joint = dict(kind=kind)
        if kind == "contact":
            joint["gap"] = 0.0 if self.sometimes(0.2) else self.number(0.01, 0.2)
            if self.kind == "laws" and self.sometimes(0.7):
                joint |= dict(law="hertz", stiffness=self.log(5, 300))
                if self.sometimes():
                    joint |= dict(law="hunt_crossley", damping=self.log(0.01, 1))
            elif self.kind in ("penalised", "laws") and self.sometimes(0.4):
                joint |= dict(law="spring_damper", stiffness=self.log(5, 300), damping=self.log(0.01, 2))
        if kind == "spring":
            joint |= dict(stiffness=self.log(0.5, 100), damping=self.log(0.01, 1) if self.sometimes() else 0.0)
        return joint

    def draw_end(self, member):
        end = dict(kind=str(self.random.choice(["free", "obstacle", "fixed"])))
        if "mass" in member and end["kind"] == "fixed":
            end = dict(kind="free")
        if end["kind"] == "obstacle":
            end["gap"] = self.number(0.02, 0.2)
        elif end["kind"] == "free":
            if self.sometimes(0.3):
                end |= dict(stiffness=self.log(0.1, 10), dashpot=self.log(0.01, 1))
            if self.sometimes(0.3):
                end["force"] = self.number(-0.5, 0.5)
        return end

    # A member has nodes of its own; bonded ones share a node.
    def number_nodes(self):
        self.nodes, count = [], 0
        for k, member in enumerate(self.members):
            size = 1 if "mass" in member else member["elements"] + 1
            first = count - 1 if k > 0 and self.joints[k - 1]["kind"] == "bonded" else count
            self.nodes.append(range(first, first + size))
            count = first + size
        self.count = count
        n = count
        self.M, self.K, self.C, self.F, self.v0 = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros(n), np.zeros(n)
        momentum = np.zeros(n)
        for member, nodes in zip(self.members, self.nodes):
            at = np.ix_(nodes, nodes)
            if "mass" in member:
                own = np.array([[member["mass"]]])
            else:
                e = member["elements"]
                own, stretch = mass_of(self.mass, member)
                own = member["density"] * own
                stiffness = np.zeros((e + 1, e + 1))
                for i in range(e):
                    stiffness[i:i + 2, i:i + 2] += np.array([[1, -1], [-1, 1]]) / (stretch[i + 1] - stretch[i])
                self.K[at] += member["modulus"] * stiffness
                self.C[at] += member["viscosity"] * stiffness
            self.M[at] += own
            momentum[nodes] += own @ np.full(len(nodes), member["velocity"])
        for k, joint in enumerate(self.joints):
            if joint["kind"] == "spring":
                apart = self.apart(k)
                self.K += joint["stiffness"] * np.outer(apart, apart)
                self.C += joint["damping"] * np.outer(apart, apart)
        for end, node in zip(self.ends, (0, n - 1)):
            self.K[node, node] += end.get("stiffness", 0)
            self.C[node, node] += end.get("dashpot", 0)
            self.F[node] += end.get("force", 0)
        self.fixed = [node for end, node in zip(self.ends, (0, n - 1)) if end["kind"] == "fixed"]
        # On one bar a consistent or lumped mass takes the velocity at the nodes; what has breaks in x enters by moments.
        free = np.setdiff1d(np.arange(n), self.fixed)
        bonded = any(joint["kind"] == "bonded" for joint in self.joints)
        bars = sum("length" in member for member in self.members)
        if self.mass == "fourth_order" or bars > 1 or bonded:
            self.v0[free] = np.linalg.solve(self.M[np.ix_(free, free)], momentum[free])
        else:
            for member, nodes in zip(self.members, self.nodes):
                self.v0[nodes] = member["velocity"]
            self.v0[self.fixed] = 0.0
        self.contacts = []  # normal, gap, stiffness, damping, name
        if self.ends[0]["kind"] == "obstacle":
            self.contacts.append((unit(n, 0), self.ends[0]["gap"], 1 / self.epsilon, 0.0, "left"))
        for k, joint in enumerate(self.joints):
            if joint["kind"] == "contact":
                law = joint.get("stiffness", 1 / self.epsilon), joint.get("damping", 0.0)
                self.contacts.append((self.apart(k), joint["gap"], *law, f"joint:{k + 1}"))
        if self.ends[1]["kind"] == "obstacle":
            self.contacts.append((-unit(n, n - 1), self.ends[1]["gap"], 1 / self.epsilon, 0.0, "right"))

    def apart(self, k):
        return unit(self.count, self.nodes[k + 1][0]) - unit(self.count, self.nodes[k][-1])

    # The motion: y = (u, v, 1), y' = A y while the same contacts are closed.
    def generator(self, closed):
        n = self.count
        M, K, C = self.M, self.K.copy(), self.C.copy()
        F = self.F.copy()
        basis = np.eye(n)
        if self.springs():
            for c in closed:
                normal, gap, k, d, _ = self.contacts[c]
                K, C = K + k * np.outer(normal, normal), C + d * np.outer(normal, normal)
                F = F - k * gap * normal
        else:
            for c in sorted(closed, reverse=True):  # a node between two of them moves with the one to its left
                normal = self.contacts[c][0]
                a, b = np.flatnonzero(normal)[0], np.flatnonzero(normal)[-1]
                if a != b:
                    basis[:, a] += basis[:, b]
                basis[:, b] = 0.0
        basis[:, self.fixed] = 0.0
        keep = np.flatnonzero(np.any(basis != 0, axis=0))
        Z = basis[:, keep]
        inverse = Z @ np.linalg.solve(Z.T @ M @ Z, Z.T)
        A = np.zeros((2 * n + 1, 2 * n + 1))
        A[:n, n:2 * n] = np.eye(n)
        A[n:2 * n, :n], A[n:2 * n, n:2 * n], A[n:2 * n, 2 * n] = -inverse @ K, -inverse @ C, inverse @ F
        return A, inverse

    def forces(self, closed, y, A):
        """Of each contact, in the direction that pushes its sides apart."""
        n = self.count
        if self.springs():
            out = np.zeros(len(self.contacts))
            for c in closed:
                normal, gap, k, d, _ = self.contacts[c]
                out[c] = -k * (normal @ y[:n] + gap * y[-1]) - d * (normal @ y[n:2 * n])
            return out
        residual = self.M @ (A @ y)[n:2 * n] + self.K @ y[:n] + self.C @ y[n:2 * n] - self.F * y[-1]
        residual[self.fixed] = 0.0
        out = np.zeros(len(self.contacts))
        for c in closed:  # from the left: a node between two closed contacts hands on what is left of its row
            normal = self.contacts[c][0]
            a, b = np.flatnonzero(normal)[0], np.flatnonzero(normal)[-1]
            if a == b:
                out[c] = residual[a] * normal[a]
            else:
                out[c] = -residual[a]
                residual[b] += residual[a]
                residual[a] = 0.0
        return out

    def gaps(self, y):
        return np.array([normal @ y[:self.count] + gap for normal, gap, *_ in self.contacts])

    def rates(self, y):
        return np.array([normal @ y[self.count:-1] for normal, *_ in self.contacts])

    def impact(self, y, touching):
        """Velocities after, by the subset of touching contacts whose impulses push and whose others part (restitution e)."""
        n, e = self.count, self.restitution
        inverse = self.generator([])[1]
        before = self.rates(y)
        found = []
        for size in range(len(touching) + 1):
            for some in itertools.combinations(touching, size):
                N = np.array([self.contacts[c][0] for c in some]).reshape(size, n)
                impulse = np.linalg.solve(N @ inverse @ N.T, -(1 + e) * before[list(some)]) if size else np.zeros(0)
                after = y.copy()
                after[n:2 * n] += inverse @ N.T @ impulse
                rest = [c for c in touching if c not in some]
                if np.all(impulse >= -1e-12) and np.all((self.rates(after) + e * before)[rest] >= -1e-12):
                    found.append((some, after, impulse))
        if not found:
            raise Undecided
        some, after, impulse = max(found, key=lambda one: len(one[0]))
        if any(np.max(np.abs(one[1] - after)) > 1e-9 for one in found):
            raise Undecided
        return some, after, dict(zip(some, impulse))

    def push(self, c, depth, rate):
        _, _, k, d, name = self.contacts[c]
        law = self.joints[int(name[6:]) - 1].get("law") if name.startswith("joint") else None
        if depth <= 0:
            return 0.0
        if law in ("hertz", "hunt_crossley"):
            return max(k * depth ** 1.5 * (1 + d * rate), 0.0)
        return max(k * depth + d * rate, 0.0)

    def solve_laws(self, y, times):
        n, inverse = self.count, self.generator([])[1]

        def pushes(y):
            return np.array([self.push(c, -gap, -rate) for c, (gap, rate) in enumerate(zip(self.gaps(y), self.rates(y)))])

        def rates(t, z):
            y = z[:2 * n + 1]
            force = pushes(y)
            total = self.F - self.K @ y[:n] - self.C @ y[n:2 * n] + sum(f * c[0] for f, c in zip(force, self.contacts))
            return np.concatenate([y[n:2 * n], inverse @ total, [0.0], force])

        z, rows, changes, touching = np.concatenate([y, np.zeros(len(self.contacts))]), [], [], pushes(y) > 0
        for a, b in zip([0.0, *times], times):
            if b > a:
                done = solve_ivp(rates, (a, b), z, method="DOP853", rtol=3e-13, atol=1e-13, max_step=0.02)
                for at, column in zip(done.t, done.y.T):
                    now = pushes(column[:2 * n + 1]) > 0
                    speed = self.rates(column[:2 * n + 1])
                    changes += [(at, self.contacts[c][4], "closing" if now[c] else "opening", speed[c])
                                for c in np.flatnonzero(now != touching)]
                    touching = now
                z = done.y[:, -1]
            rows.append((z[:n].copy(), z[n:2 * n].copy(), pushes(z[:2 * n + 1])))
        if any(abs(change[3]) < 0.02 for change in changes):
            raise Undecided
        return times, rows, z[2 * n + 1:], changes

    def solve(self, disturbed=0.0):
        n = self.count
        y = np.concatenate([np.zeros(n), self.v0 + disturbed, [1.0]])
        y[n + np.array(self.fixed, dtype=int)] = 0.0
        times = self.every() * np.arange(17)
        if self.kind == "laws":
            return self.solve_laws(y, times)
        impulses, changes = np.zeros(len(self.contacts)), []
        closed, y = self.begin(y, impulses, changes)
        t, rows = 0.0, []
        for stop in [0.0, *times[1:]]:
            while t < stop:
                closed, y, t, done = self.advance(closed, y, t, stop, impulses, changes)
                if len(changes) > 60:
                    raise Undecided
            A, _ = self.generator(closed)
            rows.append((y[:n].copy(), y[n:2 * n].copy(), self.forces(closed, y, A)))
        for one, other in itertools.combinations(changes, 2):
            if abs(one[0] - other[0]) < 1e-4 and other[0] > 0 and one[1] != other[1]:
                raise Undecided
        return times, rows, impulses, changes

    def begin(self, y, impulses, changes):
        rates = self.rates(y)
        touching = [c for c, gap in enumerate(self.gaps(y)) if gap <= 1e-12]
        closed = []
        if not self.springs():
            if touching:
                some, y, given = self.impact(y, touching)
                for c, impulse in given.items():
                    impulses[c] += impulse
                closed = list(some) if self.restitution == 0 else []
        else:
            closed = [c for c in touching if self.rates(y)[c] < 0]
        if any(abs(self.rates(y)[c]) < 0.02 for c in touching if c not in closed):
            raise Undecided
        changes += [(0.0, self.contacts[c][4], "closing", rates[c]) for c in closed]
        if self.restitution > 0:
            for c in (c for c in touching if rates[c] < 0):
                changes += [(0.0, self.contacts[c][4], "closing", rates[c]), (0.0, self.contacts[c][4], "opening", self.rates(y)[c])]
        return closed, y

    def every(self):
        return self.end / 16

    def advance(self, closed, y, t, stop, impulses, changes):
        """To `stop` or the first change."""
        A, _ = self.generator(closed)
        highest = np.sqrt(np.max(np.abs(np.linalg.eigvals(np.linalg.solve(self.M, self.K + sum(
            (c[2] * np.outer(c[0], c[0]) for c in self.contacts), np.zeros_like(self.K)))))))
        step = min(0.05 / highest, stop - t)
        pieces = max(1, int(np.ceil((stop - t) / step)))
        step = (stop - t) / pieces
        weights, pushes = np.zeros((len(self.contacts), len(y))), np.zeros((len(self.contacts), len(y)))
        for j, column in enumerate(np.eye(len(y))):
            weights[:, j] = self.forces(closed, column, A)
            if self.springs():
                pushes[:, j] = self.forces(range(len(self.contacts)), column, A) / [c[2] for c in self.contacts]
        open_ones = [c for c in range(len(self.contacts)) if c not in closed]

        def watched(y):
            # A stop with a damper pushes again where its force is positive, without a touch before.
            gaps = np.maximum(self.gaps(y), -(pushes @ y)) if self.springs() else self.gaps(y)
            return np.array([*gaps[open_ones], *(weights @ y)[closed]])

        E = expm(A * step)
        # Impulses are integrals of what is linear in y: those of y itself, by one more exponential.
        wide = np.zeros((2 * len(y), 2 * len(y)))
        wide[:len(y), :len(y)], wide[len(y):, :len(y)] = A, np.eye(len(y))
        whole = expm(wide * step)[len(y):, :len(y)]
        names = [*open_ones, *closed]
        before = watched(y)
        for k in range(pieces):
            after = E @ y
            now = watched(after)
            crossed = [i for i in range(len(names)) if now[i] < 0 and before[i] >= -1e-11]
            if crossed:
                low, high = 0.0, step
                while high - low > 1e-15 + 1e-14 * abs(t):
                    middle = (low + high) / 2
                    if middle in (low, high):
                        break
                    there = watched(expm(A * middle) @ y)
                    if any(there[i] < 0 for i in crossed):
                        high = middle
                    else:
                        low = middle
                at = expm(A * high) @ y
                there = watched(at)
                which = [i for i in crossed if there[i] < 0]
                impulses += weights @ (expm(wide * high)[len(y):, :len(y)] @ y)
                return self.change([names[i] for i in which], closed, at, t + high, A, weights, impulses, changes)
            impulses += weights @ (whole @ y)
            before, y, t = now, after, (stop if k == pieces - 1 else t + step)
        return closed, y, stop, None

    def change(self, which, closed, y, t, A, weights, impulses, changes):
        closing = [c for c in which if c not in closed]
        if len(which) > 1:
            raise Undecided
        c = which[0]
        if closing:
            speed = self.rates(y)[c]
            if abs(speed) < 0.02 and self.gaps(y)[c] > -1e-9:
                raise Undecided
            changes.append((t, self.contacts[c][4], "closing", speed))
            if self.springs():
                return [*closed, c], y, t, None
            touching = sorted([*closed, c])
            some, y, given = self.impact(y, touching)
            for one, impulse in given.items():
                impulses[one] += impulse
            if self.restitution > 0:
                closed = []
                changes += [(t, self.contacts[one][4], "opening", self.rates(y)[one]) for one in some]
                if any(abs(rate) < 0.02 for rate in self.rates(y)[touching]):
                    raise Undecided
            else:
                if set(some) != set(touching) and any(abs(self.rates(y)[one]) < 0.02 for one in touching if one not in some):
                    raise Undecided
                for one in touching:
                    if one not in some and one in closed:
                        changes.append((t, self.contacts[one][4], "opening", self.rates(y)[one]))
                closed = list(some)
                force = self.forces(closed, y, self.generator(closed)[0])
                if any(force[one] <= 1e-9 for one in closed):
                    raise Undecided
            return closed, y, t, None
        rate = (weights @ (A @ y))[c]
        if abs(rate) < 1e-3:
            raise Undecided
        changes.append((t, self.contacts[c][4], "opening", self.rates(y)[c]))
        return [one for one in closed if one != c], y, t, None

    def text(self, method):
        lines = []
        for member in self.members:
            lines.append("[[bar]]")
            lines += [f"{key} = {value!r}" for key, value in member.items() if key not in ("section", "growth")]
            if "growth" in member:
                lines.append(f'section = "{member["section"]!r}*exp({member["growth"]!r}*x)"')
        for joint in self.joints:
            lines.append("[[joint]]")
            lines += [f"{key} = {value!r}".replace("'", '"') for key, value in joint.items()]
        for name, end in zip(("left", "right"), self.ends):
            lines.append(f"[{name}]")
            lines += [f"{key} = {value!r}".replace("'", '"') for key, value in end.items()]
            if name == "right" and end["kind"] == "obstacle":
                lines.append('side = "above"')
        lines.append(f'[time]\nend = {self.end!r}\n[mesh]\nmass = "{self.mass}"')
        contact = [f"restitution = {self.restitution!r}"] if self.restitution else []
        if self.springs():
            contact.append(f"epsilon = {self.epsilon!r}")
        if self.contacts and contact:
            lines.append("[contact]\n" + "\n".join(contact))
        lines.append(f'[method]\nname = "{method}"')
        if method == "fully_discrete":
            lines.append(f"step = {self.end / 4000!r}")
        else:
            lines.append(f"relative_tolerance = {TOLERANCE}\nabsolute_tolerance = {TOLERANCE}")
        lines.append(f"[output]\nevery = {self.every()!r}")
        return "\n".join(lines) + "\n"


def unit(n, i):
    e = np.zeros(n)
    e[i] = 1.0
    return e


def mass_of(name, bar):
    """Of density 1, by Gauss' rule, and s = int dx / A at the nodes; A = section exp(growth x)."""
    x = np.linspace(0, bar["length"], bar["elements"] + 1)
    rate = bar["growth"]
    area = lambda at: bar["section"] * np.exp(rate * at)
    stretch = lambda at: at / bar["section"] if rate == 0 else (1 - np.exp(-rate * at)) / (bar["section"] * rate)
    s, n = stretch(x), len(x)
    node, weight = np.polynomial.legendre.leggauss(20)
    M = np.zeros((n, n))
    for e in range(n - 1):
        at = (x[e] + x[e + 1]) / 2 + (x[e + 1] - x[e]) / 2 * node
        w, here = (x[e + 1] - x[e]) / 2 * weight * area(at), stretch(at)
        hat = np.array([s[e + 1] - here, here - s[e]]) / (s[e + 1] - s[e])
        for k, i in enumerate((e, e + 1)):
            if name == "lumped":
                M[i, i] += np.sum(w * hat[k])
            elif name == "consistent":
                M[i, e:e + 2] += np.sum(w * hat[k] * hat, axis=1)
            else:  # the acceleration by the parabola in s through the node and its neighbours, at an end the next two
                first = min(max(i - 1, 0), n - 3)
                three = s[first:first + 3]
                for l in range(3):
                    others = np.delete(three, l)
                    M[i, first + l] += np.sum(w * hat[k] * np.prod([(here - o) / (three[l] - o) for o in others], axis=0))
    return M, s


def table(path):
    with open(path) as file:
        rows = list(csv.reader(file))
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]], dtype=float)
    return dict(zip(rows[0], values.T))


def judge(job):
    program, kind, seed = job
    chain = Chain(kind, seed)
    result = dict(seed=seed, changes=0, runs=0, worst={}, failures=[])
    try:
        times, truth, impulses, changes = chain.solve()
        other = chain.solve(1e-8)
    except Undecided:
        return result | dict(aside=True)
    far = [max(np.max(np.abs(a[k] - b[k])) for k in (0, 1)) for a, b in zip(truth, other[1])]
    chain.magnifies = max(1.0, max(far) / 1e-8)
    if chain.magnifies > 30 or len(other[3]) != len(changes) or any(abs(at - t) < 1e-4 for at, *_ in changes for t in times[1:]):
        return result | dict(aside=True)
    result["changes"] = len(changes)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.toml")
        for method in METHODS[kind]:
            with open(path, "w") as file:
                file.write(chain.text(method))
            try:
                done = subprocess.run([program, "run", path, "-o", os.path.join(folder, method), "--quiet", "--no-estimate", "--set",
                                       'output.write=["ends","events","energy"]'], capture_output=True, text=True, timeout=120)
            except subprocess.TimeoutExpired:
                result["failures"].append(f"{method}: no end in 120 s")
                continue
            if done.returncode != 0:
                result["failures"].append(f"{method}: {done.stderr.strip()}")
                continue
            result["runs"] += 1
            for key, value in compare(chain, os.path.join(folder, method), times, truth, impulses, changes).items():
                if not value <= result["worst"].get(key, (-1.0, ""))[0]:
                    result["worst"][key] = (float(value), method)
    return result


def compare(chain, directory, times, truth, impulses, changes):
    ends = table(os.path.join(directory, "ends.csv"))
    size = 1.0 + max(np.max(np.abs(v)) for _, v, _ in truth)
    unit = 100 * TOLERANCE * chain.magnifies * size
    stiffness = max(np.max(chain.K), max((c[2] + c[3] for c in chain.contacts), default=0.0) if chain.springs() else 0.0)
    stiffness += np.max(chain.C)
    if chain.kind == "scheme":
        unit = chain.end / 4000 * chain.magnifies * size * stiffness
    if len(ends["t"]) != len(times):
        return {"ends": np.inf}
    found = {"ends": max(np.max(np.abs(ends[f"{q}_{side}"] - [row[k][i] for row in truth]))
                         for k, q in ((0, "u"), (1, "v")) for side, i in (("left", 0), ("right", -1))) / unit}
    force_unit = unit * stiffness
    tell_force = chain.kind != "scheme"
    names = {name: c for c, (*_, name) in enumerate(chain.contacts)}
    forces = []
    if tell_force:
        for side, sign in (("left", 1), ("right", -1)):
            if side in names:
                forces.append(sign * ends[f"reaction_{side}"][1:] - [row[2][names[side]] for row in truth[1:]])
    parted = [k for k, joint in enumerate(chain.joints) if joint["kind"] != "bonded"]
    if parted:
        joints = table(os.path.join(directory, "joints.csv"))
        found["joints"] = 0.0
        for k in parted:
            for side, node in (("left", chain.nodes[k][-1]), ("right", chain.nodes[k + 1][0])):
                off = np.max(np.abs(joints[f"u_{side}:{k + 1}"] - [row[0][node] for row in truth]))
                found["joints"] = max(found["joints"], off / unit)
            if not tell_force:
                continue
            told = joints[f"force:{k + 1}"][1:]
            joint = chain.joints[k]
            if joint["kind"] == "spring":
                apart = chain.apart(k)
                forces.append(told - [-joint["stiffness"] * apart @ u - joint["damping"] * apart @ v for u, v, _ in truth[1:]])
            else:
                forces.append(told - [row[2][names[f"joint:{k + 1}"]] for row in truth[1:]])
    if tell_force:
        found["forces"] = max((np.max(np.abs(one)) for one in forces), default=0.0) / force_unit
    with open(os.path.join(directory, "summary.json")) as file:
        summary = json.load(file)
    sign = {name: -1 if name == "right" else 1 for name in names}
    found["impulses"] = max((abs(sign[name] * summary["contact"].get(name, {}).get("impulse", 0.0) - impulses[c])
                             for name, c in names.items()), default=0.0) / force_unit
    found["energy"] = abs(summary["energy"]["balance_error"]) / (size * (force_unit if tell_force else unit))
    if chain.kind in ("penalised", "rigid"):
        with open(os.path.join(directory, "events.csv")) as file:
            told = [row for row in csv.DictReader(file) if row["change"] in ("closing", "opening")]
        same = len(told) == len(changes) and all((row["where"], row["change"]) == change[1:3] for row, change in zip(told, changes))
        found["events"] = max((abs(float(row["t"]) - change[0]) for row, change in zip(told, changes)), default=0.0) / unit if same else np.inf
    return found


def show(kind, seed):
    chain = Chain(kind, seed)
    print(chain.text(METHODS[kind][0]))
    try:
        for change in chain.solve()[3]:
            print("#", *change)
    except Undecided:
        print("# set aside")


if __name__ == "__main__":
    random_table.run(__doc__, METHODS, ("ends", "joints", "forces", "impulses", "events", "energy"), 200, judge, show)
