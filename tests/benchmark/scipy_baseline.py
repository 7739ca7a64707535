"""SciPy's solve_ivp on the semi-discrete system of throw.toml (lumped mass), beside viscobar's own run of it.

Usage: scipy_baseline.py build/release/viscobar results.json
"""
import json
import sys
import time

import numpy
import scipy
from scipy.integrate import solve_ivp
from scipy.sparse import bmat, diags, identity

import viscobar

J, ALPHA, GAP, EPSILON = 400, 0.1, 0.1, 1e-5
TIMES = numpy.linspace(0.0, 2.0, 201)


def system():
    """Rates and Jacobian of y = (u, v)."""
    h = 1.0 / J
    mass = numpy.full(J + 1, h)
    mass[[0, -1]] = h / 2
    stiffness = diags([numpy.r_[1.0, numpy.full(J - 1, 2.0), 1.0] / h, numpy.full(J, -1.0 / h),
                       numpy.full(J, -1.0 / h)], [0, 1, -1], format="csr")
    scaled = diags(1.0 / mass) @ stiffness
    ends = numpy.zeros(J + 1, bool)
    ends[[0, -1]] = True

    def rates(_, y):
        u, v = y[:J + 1], y[J + 1:]
        acceleration = -(scaled @ (u + ALPHA * v)) - 1.0
        acceleration[ends] += numpy.maximum(-(u[ends] + GAP), 0.0) / (EPSILON * mass[ends])
        return numpy.concatenate([v, acceleration])

    def jacobian(_, y):
        penalty = numpy.where(ends & (y[:J + 1] < -GAP), 1.0 / (EPSILON * mass), 0.0)
        return bmat([[None, identity(J + 1)], [-scaled - diags(penalty), -ALPHA * scaled]], format="csc")

    # The same for y = (u_0, v_0, u_1, v_1, ...): a band of 3 on either side, as LSODA takes it, row i - j + 3 of column j.
    scaled_rows = scaled.todia()
    below, diagonal, above = (scaled_rows.diagonal(k) for k in (-1, 0, 1))
    band = numpy.zeros((10, 2 * (J + 1)))  # three rows more, for what LSODA makes of it
    band[2, 1::2] = 1.0
    band[3, 1::2], band[4, 0::2] = -ALPHA * diagonal, -diagonal
    band[5, 1:-2:2], band[6, 0:-2:2] = -ALPHA * below, -below
    band[1, 3::2], band[2, 2::2] = -ALPHA * above, -above

    def interleaved_rates(_, y):
        u, v = y[0::2], y[1::2]
        stress = numpy.diff(u + ALPHA * v) / h
        acceleration = numpy.empty(J + 1)
        acceleration[1:-1] = numpy.diff(stress)
        acceleration[0], acceleration[-1] = stress[0], -stress[-1]
        acceleration /= mass
        acceleration -= 1.0
        for end in (0, -1):
            acceleration[end] += max(-(u[end] + GAP), 0.0) / (EPSILON * mass[end])
        rate = numpy.empty_like(y)
        rate[0::2], rate[1::2] = v, acceleration
        return rate

    def interleaved_jacobian(_, y):
        now = band.copy()
        for end in (0, J):
            if y[2 * end] < -GAP:
                now[4, 2 * end] -= 1.0 / (EPSILON * mass[end])
        return now

    return rates, jacobian, interleaved_rates, interleaved_jacobian


def main(program, results):
    rates, jacobian, interleaved_rates, interleaved_jacobian = system()
    x = numpy.linspace(0.0, 1.0, J + 1)
    start = numpy.concatenate([x * (1 - x), -x * (1 - x)])
    reference = numpy.array(viscobar.run(program, "throw.toml", method__relative_tolerance=1e-11,
                                         method__absolute_tolerance=1e-14)["left"])
    rows = []

    def add(name, tolerance, seconds, steps, left):
        rows.append({"name": name, "tolerance": tolerance, "seconds": seconds, "steps": steps,
                     "error": float(numpy.abs(numpy.array(left) - reference).max())})

    for tolerance in (1e-4, 1e-5, 1e-6):
        for control in ("local", "global"):
            for method in ("cvode", "ida"):
                run = viscobar.run(program, "throw.toml", 25, method__name=method, method__error_control=control,
                                   method__relative_tolerance=tolerance, method__absolute_tolerance=1e-3 * tolerance)
                add(f"{method}, {control}", tolerance, run["integration"], run["steps"], run["left"])
        for method in ("BDF", "Radau", "LSODA"):
            of_band = method == "LSODA"
            seconds = []
            for _ in range(3):
                begin = time.process_time()
                solution = solve_ivp(interleaved_rates if of_band else rates, (0.0, 2.0),
                                     start.reshape(2, -1).T.ravel() if of_band else start, method=method, t_eval=TIMES,
                                     jac=interleaved_jacobian if of_band else jacobian, rtol=tolerance,
                                     atol=1e-3 * tolerance, **({"lband": 3, "uband": 3} if of_band else {}))
                seconds.append(time.process_time() - begin)
            add(f"SciPy {method}{', banded' * of_band}", tolerance, min(seconds), None, solution.y[0])
    with open(results, "w") as file:
        json.dump({"scipy": scipy.__version__, "rows": rows}, file, indent=1)


if __name__ == "__main__":
    main(*sys.argv[1:])
