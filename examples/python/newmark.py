"""A scheme of one's own: Newmark's method on the penalised bar.

    M a + C v + K u = R e_0,   R = (-(u_0 + gap))_+ / epsilon,   C = eta K / E

    u' = u + dt v + dt^2 ((1/2 - beta) a + beta a'),   v' = v + dt ((1 - gamma) a + gamma a')

gamma = 1/2 + alpha and beta = (1 + alpha)^2 / 4: of order 2 for alpha = 0, which rings after an impact, and damped for
alpha > 0. The penalty is linear while the contact stays as it is, so a step tries the two states, open and closed.

Run: examples/python/compare_schemes.py
"""
import numpy as np


def p1_matrices(case):
    """Consistent mass and stiffness over the nodes that are not fixed (here: all, or all but the last)."""
    n, h = case.elements + 1, case.h
    M, K = np.zeros((n, n)), np.zeros((n, n))
    for j in range(n - 1):
        M[j : j + 2, j : j + 2] += case.density * h / 6 * np.array([[2, 1], [1, 2]])
        K[j : j + 2, j : j + 2] += case.modulus / h * np.array([[1, -1], [-1, 1]])
    free = n - (case.right == "fixed")
    return M[:free, :free], K[:free, :free]


def newmark(case, alpha=0.05):
    M, K = p1_matrices(case)
    C = case.viscosity / case.modulus * K
    n, dt = len(M), case.step
    gamma, beta = 0.5 + alpha, (1 + alpha) ** 2 / 4
    spring = np.zeros((n, n))
    spring[0, 0] = 1 / case.epsilon
    inverse = [np.linalg.inv(M + gamma * dt * C + beta * dt**2 * (K + closed * spring)) for closed in (0, 1)]

    def reaction(u):
        return max(0.0, -(u[0] + case.left_gap)) / case.epsilon

    u, v = case.displacement[:n].copy(), case.velocity[:n].copy()
    if u[0] + case.left_gap <= 0 and v[0] < 0:
        v[0] = 0.0  # the impact of a node that begins on the obstacle takes its velocity
    a, rest = np.linalg.solve(M, -C @ v - K @ u), case.displacement[n:]
    a[0] += np.linalg.inv(M)[0, 0] * reaction(u)
    steps = [(0.0, u, v, reaction(u))]
    while steps[-1][0] < case.end * (1 - 1e-12):
        u_known = u + dt * v + dt**2 * (0.5 - beta) * a
        v_known = v + dt * (1 - gamma) * a
        for closed in (0, 1):
            force = -C @ v_known - K @ u_known
            force[0] -= closed * (u_known[0] + case.left_gap) / case.epsilon
            a_new = inverse[closed] @ force
            u_new = u_known + beta * dt**2 * a_new
            if (u_new[0] + case.left_gap < 0) == bool(closed):
                break
        u, v, a = u_new, v_known + gamma * dt * a_new, a_new
        steps.append((len(steps) * dt, u, v, reaction(u)))
    t, u, v, R = (np.array(column) for column in zip(*steps))
    fixed = np.tile(rest, (len(t), 1))
    return {"t": t, "reaction_left": R}, (np.hstack([u, fixed]), np.hstack([v, 0 * fixed]))
