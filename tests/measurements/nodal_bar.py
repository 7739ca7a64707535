"""The independent code of random_scenes.py: the nodal equations of docs/model.md, contact-laws.md, side.md and ends.md as
dense matrices, integrated by SciPy's DOP853 from kink to kink."""
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline


class NodalBar:
    """What moves a scene of random_scenes.py, whose numbers it reads."""

    def fixed_factor(self, x, velocity=False):
        left, right = (end["kind"] == "fixed" for end in self.ends)
        return (x if left and velocity else 1) * ((self.length - x) if right else 1)

    def function(self, key):
        one = self.series[key]
        s, y = one["places"], one["values"]
        if not one["cubic"]:
            return lambda at: np.interp(at, s, y)
        slopes = [np.polyder(np.poly1d(np.polyfit(part_s - part_s[0], part_y, 3)))(at)
                  for part_s, part_y, at in ((s[:4], y[:4], 0.0), (s[-4:], y[-4:], s[-1] - s[-4]))]
        return CubicSpline(s, y, bc_type=((1, slopes[0]), (1, slopes[1])))

    def matrices(self):
        n, h = self.elements + 1, self.length / self.elements
        M, K = np.zeros((n, n)), np.zeros((n, n))
        for e in range(n - 1):
            K[e:e + 2, e:e + 2] += np.array([[1, -1], [-1, 1]]) / h
            M[e:e + 2, e:e + 2] += h * (np.eye(2) / 2 if self.mass == "lumped" else np.array([[2, 1], [1, 2]]) / 6)
        if self.mass == "fourth_order":
            M[:] = 0
            for i in range(1, n - 1):
                M[i, i - 1:i + 2] = np.array([1, 10, 1]) * h / 12
            M[0, :3] = np.array([7, 6, -1]) * h / 24
            M[-1, -3:] = np.array([-1, 6, 7]) * h / 24
        return M, K

    def push(self, end, depth, rate):
        if depth <= 0:
            return 0.0
        if end["law"] == "penalty":
            return depth / self.epsilon
        k, c = end["stiffness_law"], end["damping"]
        if end["law"] == "spring_damper":
            return max(k * depth + c * rate, 0.0)
        return max(k * depth ** 1.5 * (1 + c * rate), 0.0)

    def solve(self, disturbed=0.0):
        """u, v, reactions at the output times, impulses, and velocities at contact changes."""
        M, K = self.matrices()
        n = self.elements + 1
        x = np.linspace(0, self.length, n)
        stiffness, damping = self.modulus * K, self.viscosity * K
        if self.side:
            (k0, k1), (c0, c1) = self.side
            stiffness = stiffness + M * (k0 + k1 * x)
            damping = damping + M * (c0 + c1 * x)
        if "stiffness" in self.series:
            at_nodes = self.function("stiffness")(x)
            if not self.series["stiffness"]["cubic"]:  # springs with kinks have their means over hat functions
                at_nodes = self.moments("stiffness", x) * self.elements / self.length
                at_nodes[[0, -1]] *= 2
            stiffness = stiffness + M * at_nodes
        load = M @ np.full(n, self.load or 0.0)
        inertia = self.density * M
        for i, end in ((0, self.ends[0]), (n - 1, self.ends[1])):
            inertia[i, i] += end.get("mass", 0)
            stiffness[i, i] += end.get("stiffness", 0)
            damping[i, i] += end.get("dashpot", 0)
        free = [i for i in range(n) if not (i == 0 and self.ends[0]["kind"] == "fixed") and not (i == n - 1 and self.ends[1]["kind"] == "fixed")]
        inverse = np.linalg.inv(inertia[np.ix_(free, free)])
        profile = M @ (1 + 0.3 * x)
        force = self.function("force") if "force" in self.series and self.ends[0]["kind"] != "fixed" else None
        history = self.function("history") if "history" in self.series else None
        motion = self.function("motion") if "motion" in self.series else None
        gap = self.function("gap") if "gap" in self.series else None

        def outer(t):
            f = load.copy()
            if history:
                f += profile * history(t)
            for i, end in ((0, self.ends[0]), (n - 1, self.ends[1])):
                if "force" in end:
                    f[i] += end["force"][0] * (1 - np.cos(end["force"][1] * t)) ** 3 + end["force"][2]
            if force:
                f[0] += force(t)
            return f

        def full(t, y):
            u, v = y[:n].copy(), y[n:2 * n].copy()
            if motion:
                u[-1], v[-1] = self.u_end + motion(t) - motion(0.0), motion(t, 1)
            return u, v

        def pushes(t, u, v):
            left, right = self.ends
            moved, moves = (gap(t), gap(t, 1)) if gap else (left.get("gap"), 0.0)
            return [self.push(left, -u[0] - moved, -v[0] - moves) if left["kind"] == "obstacle" else 0.0,
                    -self.push(right, u[-1] - right["gap"], v[-1]) if right["kind"] == "obstacle" else 0.0]

        def rates(t, y):
            u, v = full(t, y)
            reaction = pushes(t, u, v)
            f = outer(t) - stiffness @ u - damping @ v
            f[0] += reaction[0]
            f[-1] += reaction[1]
            a = np.zeros(n)
            if motion:
                a[-1] = motion(t, 2)
                f -= inertia[:, -1] * a[-1]
            a[free] = inverse @ f[free]
            return np.concatenate([v, a, reaction])

        u0 = self.slope * x * self.fixed_factor(x)
        v0 = self.speed * self.fixed_factor(x, True) * np.ones(n)
        if "velocity" in self.series:
            v0 = self.start_velocity(M, x)
        for i, end in ((0, self.ends[0]), (n - 1, self.ends[1])):
            if end["kind"] == "fixed":
                v0[i] = 0.0
        self.u_end = u0[-1]
        y = np.concatenate([u0, v0 + disturbed * self.fixed_factor(x, True), [0, 0]])
        times = np.minimum(self.every * np.arange(17), self.end)
        kinks = {float(s) for one in self.series.values() for s in one["places"] if 0 < s < self.end and np.min(np.abs(times - s)) > 1e-9}
        stops = sorted(kinks | {float(t) for t in times[1:]})
        rows, changes, t = [y], [], 0.0
        if self.mass == "fourth_order" and self.elements >= 8:
            y = self.settled_start(y, inertia, stiffness, damping, outer(0.0), free)
        touching = [r != 0 for r in pushes(0.0, *full(0.0, y))]
        for stop in stops:
            done = solve_ivp(rates, (t, stop), y, method="DOP853", rtol=3e-13, atol=1e-13, max_step=0.05)
            for k in range(1, len(done.t)):
                u, v = full(done.t[k], done.y[:, k])
                now = [r != 0 for r in pushes(done.t[k], u, v)]
                for i in (0, 1):
                    if now[i] != touching[i]:
                        changes.append(abs(v[-i] + (gap(done.t[k], 1) if gap and i == 0 else 0.0)))
                touching = now
            t, y = stop, done.y[:, -1]
            if np.any(np.isclose(times, stop, rtol=0, atol=1e-12)):
                rows.append(y)
        out = []
        for at, y in zip(times, rows):
            u, v = full(at, y)
            a = rates(at, y)[n:2 * n]
            reaction = pushes(at, u, v)
            held = inertia @ a + stiffness @ u + damping @ v - outer(at)
            for i in (0, 1):
                if self.ends[i]["kind"] == "fixed":
                    reaction[i] = held[-i]
            out.append((u, v, reaction))
        return times, out, y[2 * n:], changes

    def settled_start(self, y, inertia, stiffness, damping, force, free):
        """High modes at their equilibrium, docs/fourth-order.md, for loads that do not change at once: the shift by all
        eigenvectors of A, G being the polynomial through as many of Chebyshev's points as the program's."""
        n, h, impedance = self.elements + 1, self.length / self.elements, np.sqrt(self.density * self.modulus)
        deaf = [end.get("dashpot", 0) >= impedance / 2 for end in self.ends]
        theta = 0.0 if all(deaf) else max(0.0, 1 - 2 * (self.viscosity / (h * impedance)) ** 2) ** 4
        if self.side and h * h * max(self.side[0][0], self.side[0][0] + self.side[0][1] * self.length) > self.modulus / 10:
            return y
        M, K, C = (full[np.ix_(free, free)] for full in (inertia, stiffness, damping))
        scale = h * h * self.density / self.modulus
        mu, modes = np.linalg.eig(scale * np.linalg.solve(M, K))
        step = np.polynomial.Polynomial([35, -84, 70, -20])
        G = np.polynomial.Chebyshev.interpolate(
            lambda m: (x := np.clip((m - 1) / 5, 0, 1)) ** 4 * step(x) / m, 49, domain=[0, 8.2])
        window = np.cos(np.pi / 100 * np.arange(50)) ** 2 / np.where(np.arange(50) == 0, 2, 1)
        G -= G(0.0) / np.sum(window) * np.polynomial.Chebyshev((-1.0) ** np.arange(50) * window, domain=[0, 8.2])

        def settled(b):
            shift = modes @ (G(mu) * np.linalg.solve(modes, theta * scale * np.linalg.solve(M, b)))
            half = len(free) // 2
            shift[:half] *= not deaf[0]
            shift[len(free) - half:] *= not deaf[1]
            return shift.real

        u, v = y[:n][free], y[n:2 * n][free]
        by_rate = settled(-K @ v)
        by_force = settled(force[free] - K @ u - C @ (v + by_rate))
        dashpots = np.zeros(n)
        dashpots[[0, -1]] = [end.get("dashpot", 0) for end in self.ends]
        answer = np.linalg.solve(M, -dashpots[free] * by_force)
        y = y.copy()
        y[free] += by_force
        y[n + np.array(free)] += by_rate + answer - settled(K @ answer)
        return y

    def start_velocity(self, M, x):
        """At the nodes; of a function with kinks M v_0 are its moments."""
        return self.function("velocity")(x) if self.series["velocity"]["cubic"] else np.linalg.solve(M, self.moments("velocity", x))

    def moments(self, key, x):
        """int phi_i f dx, by Gauss' rule between nodes and samples."""
        f, cuts = self.function(key), np.union1d(x, self.series[key]["places"])
        node, weight = np.polynomial.legendre.leggauss(4)
        at = (cuts[:-1, None] + cuts[1:, None] + np.diff(cuts)[:, None] * node) / 2
        hats = np.maximum(0, 1 - np.abs(at - x[:, None, None]) * self.elements / self.length)
        return np.sum(hats * f(at) * weight * np.diff(cuts)[:, None] / 2, axis=(1, 2))

    def gauge(self, u, v, x, towards):
        """u, v, strain, stress by the polynomial of degree 5 through the six nodes around x; at a node those on the side
        `towards`, -1 or 1."""
        nodes = np.linspace(0, self.length, self.elements + 1)
        count = min(6, len(nodes))
        first = int(np.clip(np.searchsorted(nodes, x + 1e-9 * towards * self.length) - count // 2, 0, len(nodes) - count))
        s = nodes[first:first + count] - x
        vandermonde = np.vander(s, increasing=True)
        of_u, of_v = np.linalg.solve(vandermonde, u[first:first + count]), np.linalg.solve(vandermonde, v[first:first + count])
        return of_u[0], of_v[0], of_u[1], self.modulus * of_u[1] + self.viscosity * of_v[1]
