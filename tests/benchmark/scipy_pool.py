"""Bars a second and core by a pool of processes, each with SciPy's LSODA on the bars of tests/measurements/ensemble.cpp.

Lumped mass, penalty error / 10, tolerance error / 10, banded Jacobian; no contact change is located. Rows of Markdown.
"""
import itertools
import multiprocessing
import os
import time

os.environ["OMP_NUM_THREADS"] = "1"
import numpy
from scipy.integrate import solve_ivp


def bar(task):
    """u(0, t) every 0.1 and the seconds that it took, of y = (u_0, v_0, u_1, v_1, ...)."""
    elements, end, error, viscosity, gap = task
    h, stiffness, n = 1.0 / elements, 10.0 / error, elements + 1
    mass = numpy.full(n, h)
    mass[[0, -1]] /= 2

    def rates(_, y):
        u, v = y[0::2], y[1::2]
        stress = numpy.diff(u + viscosity * v) / h
        force = numpy.append(stress, 0.0)
        force[1:] -= stress
        force[0] += stiffness * max(-(u[0] + gap), 0.0)
        force[-1] -= stiffness * max(u[-1] - 0.1, 0.0)
        out = numpy.empty_like(y)
        out[0::2], out[1::2] = v, force / mass
        return out

    begin = time.process_time()
    y = numpy.zeros(2 * n)
    y[1::2] = -1.0
    times = numpy.append(numpy.arange(0.0, end - 1e-9, 0.1), end)
    solution = solve_ivp(rates, (0.0, end), y, "LSODA", times, rtol=error / 10, atol=error / 10, lband=3, uband=3)
    return solution.y[0], time.process_time() - begin


if __name__ == "__main__":
    random = numpy.random.default_rng(7)
    print("| J | T | error | bars a second and core, a pool of SciPy's LSODA |\n|---|---|---|---|")
    with multiprocessing.Pool() as pool:
        for end, elements, error in itertools.product((2.0, 6.0), (10, 16, 24, 32, 50), (1e-2, 1e-3, 1e-4, 1e-6)):
            count = 8 if error > 1e-5 else 2  # one takes seconds
            bars = [(elements, end, error, 10 ** random.uniform(-2, 0), random.uniform(0.05, 0.3)) for _ in range(count)]
            seconds = sum(seconds for _, seconds in pool.map(bar, bars, chunksize=1))
            print(f"| {elements} | {end:g} | {error:.0e} | {count / seconds:.1f} |", flush=True)
