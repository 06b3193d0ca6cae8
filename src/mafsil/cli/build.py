"""Compiled loops made ahead of the first question: those that know no robot are the same for everybody.

Each question below is the smallest that needs its loops; what it compiles stays in the cache (`solvers.loop_cache`).
The types of a call decide what is compiled, so the questions are put by the names that users call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter

import numpy as np


def questions() -> Iterator[tuple[str, Callable[[], object]]]:
    """What is built, and the question that needs it."""
    import mafsil as mf

    panda = mf.load("panda")
    q = np.array([0.1, -0.4, 0.3, -1.9, 0.2, 1.6, 0.5])
    T = panda.forward_kinematics(q)
    yield "solve_ik", lambda: mf.solve_ik(panda, T)
    yield "solve_ik_batch", lambda: mf.solve_ik(panda, np.stack([T] * 3))
    yield "inverse_kinematics_7r", lambda: mf.inverse_kinematics(panda, T)
    yield "inverse_kinematics_7r_batch", lambda: mf.inverse_kinematics(panda, np.stack([T] * 3))
    general = mf.Robot.from_dh(
        [
            mf.DHRow(a=0.1, alpha=0.9, d=0.3),
            mf.DHRow(a=0.4, alpha=-0.7, d=0.1),
            mf.DHRow(a=0.3, alpha=1.2, d=-0.1),
            mf.DHRow(a=0.1, alpha=-1.1, d=0.3),
            mf.DHRow(a=0.05, alpha=0.8, d=0.1),
            mf.DHRow(a=0.02, alpha=0.4, d=0.1),
        ],
        "classic",
    )
    T_general = general.forward_kinematics(q[:6])
    yield "inverse_kinematics_6r", lambda: mf.inverse_kinematics(general, T_general)
    yield "inverse_kinematics_6r_batch", lambda: mf.inverse_kinematics(general, np.stack([T_general] * 3))
    spatial = [mf.Contact(p, -np.asarray(p), 0.5) for p in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0.0))]
    yield "closure", lambda: mf.Grasp(spatial).closure()
    corners = ((0.5, 0, 0), (-0.5, 0.1, 0), (0, 0.7, 0.1), (0, -0.7, 0))
    uneven = [mf.Contact(p, -np.asarray(p), 0.7) for p in corners]
    yield "closure_uneven", lambda: mf.Grasp(uneven).closure()
    slipping = [mf.Contact(p, -np.asarray(p), 0.3) for p in corners[:3]]
    yield "closure_refused", lambda: mf.Grasp(slipping).closure()
    planar = [mf.Contact(p, -np.asarray(p), 0.5) for p in ((1, 0), (-1, 0), (0, 1.0))]
    yield "closure_planar", lambda: mf.Grasp(planar).closure()
    limits = mf.trajectory.MotionLimits.of(2, velocity=1.0, acceleration=1.0, jerk=1.0)
    rest, goal = np.zeros(2), np.ones(2)
    yield "jerk_limited", lambda: mf.trajectory.jerk_limited(rest, goal, limits)
    yield "jerk_limited_batch", lambda: mf.trajectory.jerk_limited(np.zeros((3, 2)), goal, limits).at(0.0)
    yield "jerk_limited_through", lambda: mf.trajectory.jerk_limited_through([rest, goal, rest], limits)
    yield "online", lambda: mf.trajectory.online(rest, limits, 0.01).step(goal)
    path = mf.trajectory.JointPath.through([q, q + 0.1])
    slow = mf.trajectory.MotionLimits.of(7, velocity=1.0, acceleration=1.0)
    yield "time_optimal", lambda: mf.trajectory.time_optimal(path, slow)
    checker = mf.collision.Checker(panda, [mf.collision.Obstacle(mf.collision.Sphere(0.05), T)], radius=0.05)
    yield (
        "collision",
        lambda: (checker.free(q), checker.check(q), checker.distance(q), checker.free_segment(q, q + 0.1)),
    )
    yield "plan", lambda: mf.plan(checker, None, q, q + np.array([2.0, 0, 0, 0, 0, 0, 0]), shorten=5)
    linkage = mf.mobility.library.four_bar()
    yield "mobilities", lambda: mf.mobility.mobilities(linkage, np.zeros(4))
    chain = mf.parallel.ClosedChain(mf.mobility.mechanism_of(linkage))
    yield (
        "closed_chain",
        lambda: chain.forward_dynamics(chain.closed(np.zeros(chain.n)).q, np.zeros(chain.n), np.zeros(chain.n)),
    )
    crane = mf.parallel.CableRobot(2.0 * np.array(corners), 0.0 * np.array(corners), np.zeros(4), np.full(4, 100.0))
    yield "cables", lambda: mf.parallel.cable_tensions(crane, np.eye(4), np.zeros(6))
    scenario = mf.Scenario(
        robot=panda, trajectory=mf.trajectory.quintic(q, q + 0.1, 0.05), law=mf.control.computed_torque(panda)
    )
    ahead = mf.control.model_predictive(mf.load("planar2r"), effort_limit=[1.0, 1.0])
    two = np.ones(2)
    still = mf.trajectory.rest(two, 1.0).at(0.0)
    yield "model_predictive", lambda: (ahead(0.0, two, two, still), ahead.plan(two, two, still))
    variation = mf.simulation.Variation(payload=(0.0, 1.0))
    yield "monte_carlo", lambda: mf.simulation.monte_carlo(scenario, variation, 2)
    weak = mf.trajectory.MotionLimits.of(7, velocity=1.0, effort=panda.limits.effort)
    yield "time_optimal_effort", lambda: mf.trajectory.time_optimal(path, weak, robot=panda)


def build(say: Callable[[str], None]) -> list[dict[str, object]]:
    """Put all questions; what is in the cache already costs little.

    Args:
        say: called with each name before its question is put.

    Returns:
        Name and seconds of each.
    """
    found: list[dict[str, object]] = []
    for name, ask in questions():
        say(name)
        begun = perf_counter()
        ask()
        found.append({"name": name, "seconds": round(perf_counter() - begun, 3)})
    return found
