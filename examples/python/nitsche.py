"""A scheme of one's own: Nitsche's method, which needs no penalty [Chouly, Hild and Renard 2015, semi-discrete].

With the stress s = (E (u_1 - u_0) + eta (v_1 - v_0)) / h at the obstacle the law of contact, R >= 0, u_0 + gap >= 0,
R (u_0 + gap) = 0, R = -s, is one equation for any r > 0, and that is what is put into the equation of motion:

    M a + C v + K u = R e_0,   R = (-s - r (u_0 + gap))_+,   r = 10 E / h        (its variant theta = 0)

It is consistent: the exact solution satisfies it. In time it is Newmark's method, as in newmark.py. R is linear in u and v while the contact stays as it is, so a step tries the two states.

Run: examples/python/compare_schemes.py
"""
import numpy as np
from newmark import p1_matrices


def nitsche(case, alpha=0.05, r=10.0):
    M, K = p1_matrices(case)
    n, dt, h, eta = len(M), case.step, case.h, case.viscosity / case.modulus
    gamma, beta = 0.5 + alpha, (1 + alpha) ** 2 / 4
    r *= case.modulus / h
    stress = np.zeros(n)
    stress[:2] = -case.modulus / h, case.modulus / h
    gap = np.zeros(n)
    gap[0] = r
    # R = -(stress + gap) u - eta stress v - r gap while the contact is closed.
    Ks = [K, K + np.outer(np.eye(n)[0], stress + gap)]
    Cs = [eta * K, eta * (K + np.outer(np.eye(n)[0], stress))]
    inverse = [np.linalg.inv(M + gamma * dt * C + beta * dt**2 * K) for C, K in zip(Cs, Ks)]

    def pressure(u, v):
        return -stress @ (u + eta * v) - r * (u[0] + case.left_gap)

    u, v = case.displacement[:n].copy(), case.velocity[:n].copy()
    if u[0] + case.left_gap <= 0 and v[0] < 0:
        v[0] = 0.0  # the impact of a node that begins on the obstacle takes its velocity
    closed, rest = int(pressure(u, v) > 0), case.displacement[n:]
    push = np.eye(n)[0] * r * case.left_gap
    a = np.linalg.solve(M, -Cs[closed] @ v - Ks[closed] @ u - closed * push)
    steps = [(0.0, u, v, max(0.0, pressure(u, v)))]
    while steps[-1][0] < case.end * (1 - 1e-12):
        u_known = u + dt * v + dt**2 * (0.5 - beta) * a
        v_known = v + dt * (1 - gamma) * a
        for closed in (0, 1):
            a = inverse[closed] @ (-Cs[closed] @ v_known - Ks[closed] @ u_known - closed * push)
            u, v = u_known + beta * dt**2 * a, v_known + gamma * dt * a
            if (pressure(u, v) > 0) == bool(closed):
                break
        steps.append((len(steps) * dt, u, v, max(0.0, pressure(u, v))))
    t, u, v, R = (np.array(column) for column in zip(*steps))
    fixed = np.tile(rest, (len(t), 1))
    return {"t": t, "reaction_left": R}, (np.hstack([u, fixed]), np.hstack([v, 0 * fixed]))
