"""The shortest time along a path as a nonlinear program in time, for IPOPT: slow, and independent of all our methods.

Controls are the third derivatives of the path parameter (or the second ones, without limits of jerk), constant on equal
intervals of time; states follow exactly. Limits hold at both ends of each interval, so the optimum is that of the grid.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from mafsil.trajectory import JointPath, MotionLimits


def _splines(path: JointPath) -> list[ca.Function]:
    """Position and its first three derivatives by s, as functions of CasADi."""
    knots, rows = path.curve.knots, path.curve.coefficients
    s = ca.MX.sym("s")
    # Clamped to the path: the index of the piece must exist.
    place = ca.fmin(ca.fmax(s, knots[0]), knots[-1] * (1 - 1e-12))
    k = ca.low(ca.DM(knots), place)
    local = s - ca.MX(ca.DM(knots))[k]
    found = []
    for order in range(4):
        value = ca.MX.zeros(path.n)
        for power in range(rows.shape[1] - 1, order - 1, -1):
            factor = float(np.prod(np.arange(power - order + 1, power + 1)))
            value = value * local + factor * ca.MX(ca.DM(rows[:, power].T))[:, k]
        found.append(ca.Function(f"d{order}", [s], [value]))
    return found


def shortest_time(path: JointPath, limits: MotionLimits, duration: float, intervals: int = 150) -> float:
    """The duration that IPOPT finds [s].

    Args:
        path: cubic pieces without stops inside.
        limits: of velocity, acceleration and perhaps jerk.
        duration: to begin with.
        intervals: of the grid.
    """
    derivatives, smooth = _splines(path), bool(np.isfinite(limits.jerk).any())
    problem = ca.Opti()
    T, control = problem.variable(), problem.variable(intervals)
    s, v, a = (problem.variable(intervals + 1) for _ in range(3))
    h = T / intervals
    for k in range(intervals):
        j = control[k] if smooth else 0.0
        begin = a[k] if smooth else control[k]
        problem.subject_to(s[k + 1] == s[k] + h * v[k] + h**2 / 2 * begin + h**3 / 6 * j)
        problem.subject_to(v[k + 1] == v[k] + h * begin + h**2 / 2 * j)
        problem.subject_to(a[k + 1] == begin + h * j)
        for end in (0, 1):
            at, rate = s[k + end], v[k + end]
            growth = a[k + end] if smooth else control[k]
            q1, q2, q3 = (derivatives[order](at) for order in (1, 2, 3))
            problem.subject_to(problem.bounded(limits.velocity[0], q1 * rate, limits.velocity[1]))
            problem.subject_to(
                problem.bounded(limits.acceleration[0], q2 * rate**2 + q1 * growth, limits.acceleration[1])
            )
            if smooth:
                jerk = q3 * rate**3 + 3 * q2 * rate * growth + q1 * j
                problem.subject_to(problem.bounded(limits.jerk[0], jerk, limits.jerk[1]))
    problem.subject_to([s[0] == 0, s[-1] == path.end, v[0] == 0, v[-1] == 0, T > 0, v >= 0])
    if smooth:
        problem.subject_to([a[0] == 0, a[-1] == 0])
    share = np.linspace(0.0, 1.0, intervals + 1)
    problem.set_initial(T, 1.5 * duration)
    problem.set_initial(s, path.end * (10 * share**3 - 15 * share**4 + 6 * share**5))
    problem.set_initial(v, path.end * 30 * share**2 * (1 - share) ** 2 / (1.5 * duration))
    problem.minimize(T)
    problem.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes", "max_iter": 2000, "tol": 1e-7})
    return float(problem.solve().value(T))
