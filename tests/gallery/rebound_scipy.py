"""The rebound B3 of docs/gallery.md as one would write it with SciPy: hat functions, consistent mass, the contact
released by an event of solve_ivp."""
import time

import numpy
from scipy.integrate import solve_ivp
from scipy.sparse import bmat, diags, identity
from scipy.sparse.linalg import splu

EXACT = {1.0: (1.3692116746, 0.1503140958), 0.1: (1.9124710098, 0.6507936369)}


def rebound(viscosity, elements, tolerance):
    """Contact time and speed of rebound: node 0 stands still, so the rows of the others are the system."""
    h = 1.0 / elements
    mass = diags([numpy.r_[numpy.full(elements - 1, 4.0), 2.0] * h / 6, numpy.full(elements - 1, h / 6),
                  numpy.full(elements - 1, h / 6)], [0, 1, -1], format="csc")
    stiffness = diags([numpy.r_[numpy.full(elements - 1, 2.0), 1.0] / h, numpy.full(elements - 1, -1.0 / h),
                       numpy.full(elements - 1, -1.0 / h)], [0, 1, -1], format="csc")
    solve = splu(mass).solve
    n = elements
    minus = -splu(mass).solve(stiffness.toarray())
    jacobian = bmat([[None, identity(n)], [minus, viscosity * minus]], format="csc")

    def rates(_, y):
        return numpy.concatenate([y[n:], -solve(stiffness @ (y[:n] + viscosity * y[n:]))])

    def reaction(t, y):
        # Of row 0: its inertia is that of the neighbour.
        return -(y[0] + viscosity * y[n]) / h + h / 6 * rates(t, y)[n]

    reaction.terminal, reaction.direction = True, -1
    start = numpy.zeros(2 * n)
    # The impact stops node 0; the other rows keep their momentum.
    start[n:] = solve(mass @ numpy.full(n, -1.0) + numpy.r_[-h / 6, numpy.zeros(n - 1)])
    begun = time.process_time()
    end = solve_ivp(rates, (0.0, 2.5), start, "Radau", events=reaction, jac=jacobian, rtol=tolerance,
                    atol=1e-3 * tolerance)
    seconds = time.process_time() - begun
    opening, v = end.t_events[0][0], end.y_events[0][0][n:]
    speed = (mass @ v).sum() + h / 6 * v[0]
    return opening, speed, seconds


for b, (opening, speed) in EXACT.items():
    for J in (30, 120):
        t, e, took = rebound(b, J, 1e-8)
        print(f"SciPy's Radau, rtol 1e-8, consistent mass, viscosity {b}, {J} elements: errors {abs(t - opening):.1e} / "
              f"{abs(e - speed):.1e}, {took:.2g} s")
