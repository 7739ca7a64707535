"""Bars of examples/scenes by SciPy: differences in space, a spring of compliance epsilon as the obstacle, solve_ivp in
time, as one writes it in an afternoon. Prints a CSV.

Needs Debian's python3-scipy. Usage: scipy_bar.py unit-left-end|nonsmooth-mode METHOD ELEMENTS EPSILON TOLERANCE
"""
import sys

import numpy
from scipy.integrate import solve_ivp
from scipy.sparse import bmat, diags, identity

# viscosity, right end held, u_0(x), u_1(x), end
BARS = {"unit-left-end": (1.0, False, lambda x: x * (1.0 - x), lambda x: -x * (1.0 - x), 6.0),
        "nonsmooth-mode": (0.0, True, lambda x: numpy.where(x < 0.25, -0.1 - 0.2 * x, -0.2 + 0.2 * x), lambda x: 0.0 * x,
                           35.0)}
viscosity, held, displacement, velocity, end = BARS[sys.argv[1]]
method, elements, epsilon, tolerance = sys.argv[2], int(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5])
gap = 0.1

h = 1.0 / elements
x = numpy.linspace(0.0, 1.0, elements + 1)
n = elements + 1
# a = A (u + viscosity v) inside; half a cell belongs to an end.
below, middle, above = numpy.ones(n - 1), numpy.full(n, -2.0), numpy.ones(n - 1)
above[0] = 2.0
below[-1] = 2.0
A = diags([below, middle, above], [-1, 0, 1], format="lil") / h**2
if held:
    A[-1, :] = 0.0
A = A.tocsr()


def reaction(u):
    return max(0.0, -(u + gap)) / epsilon


def rates(t, y):
    u, v = y[:n], y[n:]
    a = A @ (u + viscosity * v)
    a[0] += reaction(u[0]) / (h / 2.0)
    return numpy.concatenate([v, a])


free = bmat([[None, identity(n)], [A, viscosity * A]], format="lil")
closed = free.copy()
closed[n, 0] -= 1.0 / (epsilon * h / 2.0)
free, closed = free.tocsc(), closed.tocsc()
implicit = {"jac": lambda t, y: closed if y[0] < -gap else free} if method in ("Radau", "BDF") else {}
t = numpy.linspace(0.0, end, 151 if end < 10.0 else 281)
start = numpy.concatenate([displacement(x), velocity(x)])
y = solve_ivp(rates, (0.0, end), start, method, t, rtol=tolerance, atol=1e-3 * tolerance, **implicit).y
print("t,u_left,v_left,reaction_left,u_right,v_right" if not held else "t,u_left,v_left,reaction_left")
for k in range(len(t)):
    row = [t[k], y[0, k], y[n, k], reaction(y[0, k])] + ([] if held else [y[n - 1, k], y[2 * n - 1, k]])
    print(",".join(f"{value:.7g}" for value in row))
