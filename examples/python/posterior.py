"""Viscosity and gap of a thrown bar from a noisy trace of its end: best of many starts, posterior by a Markov chain, and
profile likelihood.

The trace d_k = u(0, t_k) + noise has independent normal errors of deviation s. With flat priors between bounds the posterior
is exp(-S/2), S = sum_k (u(0, t_k; viscosity, gap) - d_k)^2 / s^2. All three ask for many bars at once, which run side by side.

Run: PYTHONPATH=build/release/python /usr/bin/python3 examples/python/posterior.py
"""
import numpy as np
import viscobar

scene = viscobar.Scene(
    bar={"length": 1.0, "viscosity": 0.1},
    left={"kind": "obstacle", "gap": 0.15},
    initial={"velocity": -1.0},
    mesh={"elements": 24},
    time={"end": 3.0},
)
keys, truth = ("bar.viscosity", "left.gap"), np.array([0.1, 0.15])
low, high = np.array([0.01, 0.05]), np.array([1.0, 0.3])
deviation = 0.01


def traces(values):
    """u(0, t) of bars, for values of shape (..., 2); its error is far below the noise."""
    return viscobar.ensemble(scene, dict(zip(keys, np.moveaxis(values, -1, 0))), ["u_left@0.05"], error=1e-3)["u_left@0.05"]


def misfit(values):
    """S, infinite outside of the bounds."""
    inside = np.all((values > low) & (values < high), axis=-1)
    total = np.full(inside.shape, np.inf)
    if inside.any():
        total[inside] = np.sum((traces(values[inside]) - data) ** 2, axis=-1) / deviation**2
    return total


def fitted(count=64):
    """The fit that begins at the lowest of count^2 starts between the bounds."""
    starts = np.stack(np.meshgrid(*np.geomspace(low, high, count + 2)[1:-1].T, indexing="ij"), -1).reshape(-1, 2)
    best = dict(zip(keys, starts[misfit(starts).argmin()]))
    times = viscobar.ensemble(scene, {}, ["u_left@0.05"], error=1e-3).times["u_left@0.05"]
    return viscobar.fit(scene, keys, data={"t": times, "u_left": data}, deviations={"u_left": deviation}, set=best)


def chain(centre, walkers, steps):
    """Goodman's and Weare's stretch moves (2010): half of the walkers moves at once, along lines to the other half."""
    at = centre * random.uniform(0.8, 1.2, (2, walkers // 2, 2))
    now, kept, taken = misfit(at), [], 0
    for _ in range(steps):
        for half in (0, 1):
            stretch = (1 + random.uniform(size=walkers // 2)) ** 2 / 2
            towards = at[1 - half][random.integers(walkers // 2, size=walkers // 2)]
            moved = towards + stretch[:, None] * (at[half] - towards)
            proposed = misfit(moved)
            accept = np.log(random.uniform(size=walkers // 2)) < np.log(stretch) + (now[half] - proposed) / 2
            at[half][accept], now[half][accept] = moved[accept], proposed[accept]
            taken += accept.sum()
        kept.append(at.reshape(-1, 2).copy())
    return np.concatenate(kept[steps // 4 :]), taken / (walkers * steps)


def profile(centre, spread, count=41):
    """min S over the other parameter, for values of each, by the parabola through the three lowest of a grid."""
    axes = [np.linspace(*np.clip(m + 4 * s * np.array([-1, 1]), a, b), count) for m, s, a, b in zip(centre, spread, low, high)]
    grid = misfit(np.stack(np.meshgrid(*axes, indexing="ij"), -1))
    for k, (key, values) in enumerate(zip(keys, axes)):
        table = grid if k == 0 else grid.T
        lowest = np.clip(table.argmin(axis=1), 1, count - 2)
        before, least, behind = (table[np.arange(count), lowest + d] for d in (-1, 0, 1))
        least = least - (behind - before) ** 2 / (8 * (before - 2 * least + behind))
        within = values[least < least.min() + 1]
        yield key, within[0], within[-1]


if __name__ == "__main__":
    random = np.random.default_rng(2010)
    exact = traces(truth[None])[0]
    data = exact + deviation * random.normal(size=exact.shape)
    fit = fitted()
    found = np.array([fit.estimates[key] for key in keys])
    print(f"fit from the best of 4096 starts: {found.round(4)}, {fit.runs} runs, converged: {fit.converged}")
    samples, accepted = chain(found, walkers=64, steps=100)
    mean, spread = samples.mean(axis=0), samples.std(axis=0)
    print(f"posterior of {len(samples)} samples, {accepted:.0%} of the moves taken, correlation {np.corrcoef(samples.T)[0, 1]:.2f}")
    for (key, first, last), m, s, t in zip(profile(mean, spread), mean, spread, truth):
        print(f"{key}: {m:.4f} +- {s:.4f}, profile likelihood {first:.4f} to {last:.4f}, truth {t}")
        # Of so many walks the deviation is known to some 10 %, of the grid to a spacing, a fifth of it.
        assert abs(fit.estimates[key] - m) < s
        assert abs((last - first) / 2 - s) < 0.35 * s and abs(m - t) < 4 * s
