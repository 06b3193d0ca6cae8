"""Compiled loops made ahead of the first question: those that know no robot are the same for everybody.

Each question below is the smallest that needs its loops; what it compiles stays in the cache. The types of a call
decide what is compiled, so the questions are put by the names that users call. Questions of one family share loops and
are put one after the other in one process; families are spread over processes, one for each core.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass
from functools import cache
from multiprocessing import get_context
from time import perf_counter
from typing import Any, TypeAlias

import numpy as np

from mafsil import threads

Questions: TypeAlias = dict[str, Callable[[], object]]
MEMORY = 1.5e9
"""What one process that compiles a family may take [bytes]."""


@dataclass(frozen=True)
class Built:
    """One question that was put.

    Attributes:
        name: of the question.
        seconds: that it took.
    """

    name: str
    seconds: float


def families() -> dict[str, Questions]:
    """What is built: the questions that need it, by family; nothing is computed before a question is put."""
    import mafsil as mf

    q = np.array([0.1, -0.4, 0.3, -1.9, 0.2, 1.6, 0.5])
    panda = cache(lambda: mf.load("panda"))
    T = cache(lambda: panda().forward_kinematics(q))
    table = ((0.1, 0.9, 0.3), (0.4, -0.7, 0.1), (0.3, 1.2, -0.1), (0.1, -1.1, 0.3), (0.05, 0.8, 0.1), (0.02, 0.4, 0.1))
    general = cache(lambda: mf.Robot.from_dh([mf.DHRow(a=a, alpha=alpha, d=d) for a, alpha, d in table], "classic"))
    T_general = cache(lambda: general().forward_kinematics(q[:6]))
    corners = ((0.5, 0, 0), (-0.5, 0.1, 0), (0, 0.7, 0.1), (0, -0.7, 0))

    def closure(points: tuple[tuple[float, ...], ...], friction: float) -> object:
        return mf.Grasp([mf.Contact(p, -np.asarray(p), friction) for p in points]).closure()

    limits = cache(lambda: mf.trajectory.MotionLimits.of(2, velocity=1.0, acceleration=1.0, jerk=1.0))
    rest, goal = np.zeros(2), np.ones(2)
    path = cache(lambda: mf.trajectory.JointPath.through([q, q + 0.1]))

    def time_optimal() -> object:
        slow = mf.trajectory.MotionLimits.of(7, velocity=1.0, acceleration=1.0)
        return mf.trajectory.time_optimal(path(), slow)

    def time_optimal_effort() -> object:
        weak = mf.trajectory.MotionLimits.of(7, velocity=1.0, effort=panda().limits.effort)
        return mf.trajectory.time_optimal(path(), weak, robot=panda())

    ball = cache(lambda: mf.collision.Obstacle(mf.collision.Sphere(0.05), T()))
    checker = cache(lambda: mf.collision.Checker(panda(), [ball()], radius=0.05))

    def collision() -> object:
        one = checker()
        return one.free(q), one.check(q), one.distance(q), one.free_segment(q, q + 0.1)

    linkage = cache(mf.mobility.library.four_bar)

    def closed_chain() -> object:
        chain = mf.parallel.ClosedChain(mf.mobility.mechanism_of(linkage()))
        still = np.zeros(chain.n)
        return chain.forward_dynamics(chain.close_loops(still).q, still, still)

    def cables() -> object:
        ends = np.array(corners)
        crane = mf.parallel.CableRobot(2.0 * ends, 0.0 * ends, np.zeros(4), np.full(4, 100.0))
        return mf.parallel.cable_tensions(crane, np.eye(4), np.zeros(6))

    def model_predictive() -> object:
        ahead = mf.control.model_predictive(mf.load("planar2r"), effort_limit=[1.0, 1.0])
        still = mf.trajectory.profiles.rest(goal, 1.0).at(0.0)
        return ahead(0.0, goal, goal, still), ahead.plan(goal, goal, still)

    def monte_carlo() -> object:
        law = mf.control.computed_torque(panda())
        scenario = mf.Scenario(robot=panda(), trajectory=mf.trajectory.quintic(q, q + 0.1, 0.05), law=law)
        return mf.simulation.monte_carlo(scenario, mf.simulation.Variation(payload=(0.0, 1.0)), 2)

    return {
        "planning": {
            "collision": collision,
            "plan": lambda: mf.plan(checker(), None, q, q + np.array([2.0, 0, 0, 0, 0, 0, 0]), shortcut_iterations=5),
        },
        "jerk_limited": {
            "jerk_limited": lambda: mf.trajectory.jerk_limited(rest, goal, limits()),
            "jerk_limited_batch": lambda: mf.trajectory.jerk_limited(np.zeros((3, 2)), goal, limits()).at(0.0),
            "jerk_limited_through": lambda: mf.trajectory.jerk_limited_through([rest, goal, rest], limits()),
            "online": lambda: mf.trajectory.online(rest, limits(), 0.01).step(goal),
        },
        "grasps": {
            "closure": lambda: closure(((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)), 0.5),
            "closure_uneven": lambda: closure(corners, 0.7),
            "closure_refused": lambda: closure(corners[:3], 0.3),
            "closure_planar": lambda: closure(((1, 0), (-1, 0), (0, 1)), 0.5),
        },
        "time_optimal": {"time_optimal": time_optimal, "time_optimal_effort": time_optimal_effort},
        "inverse_kinematics": {
            "solve_ik": lambda: mf.solve_ik(panda(), T()),
            "solve_ik_batch": lambda: mf.solve_ik(panda(), np.stack([T()] * 3)),
            "inverse_kinematics_7r": lambda: mf.inverse_kinematics(panda(), T()),
            "inverse_kinematics_7r_batch": lambda: mf.inverse_kinematics(panda(), np.stack([T()] * 3)),
            "inverse_kinematics_6r": lambda: mf.inverse_kinematics(general(), T_general()),
            "inverse_kinematics_6r_batch": lambda: mf.inverse_kinematics(general(), np.stack([T_general()] * 3)),
        },
        "control": {"model_predictive": model_predictive, "monte_carlo": monte_carlo},
        "mechanisms": {
            "mobilities": lambda: mf.mobility.batch_mobility(linkage(), np.zeros(4)),
            "closed_chain": closed_chain,
            "cables": cables,
        },
    }


def build(say: Callable[[Built, float], None]) -> list[dict[str, Any]]:
    """Put all questions; what is in the cache already costs little.

    Args:
        say: called after each question, with the share of all that is done.

    Returns:
        Name and seconds of each, in the order of the families.
    """
    wanted = [name for questions in families().values() for name in questions]
    found: list[Built] = []

    def done(one: Built) -> None:
        found.append(one)
        say(one, len(found) / len(wanted))

    _over_processes(done) if _workers() > 1 else [_put(family, done) for family in families()]
    return [asdict(one) for one in sorted(found, key=lambda one: wanted.index(one.name))]


def _put(family: str, done: Callable[[Built], None]) -> None:
    """The questions of a family, one after the other."""
    for name, ask in families()[family].items():
        begun = perf_counter()
        ask()
        done(Built(name, round(perf_counter() - begun, 3)))


def _over_processes(done: Callable[[Built], None]) -> None:
    """Fresh processes, not forks, as every system has them; each takes the next family when it is free."""
    context = get_context("spawn")
    queue = context.SimpleQueue()
    with ProcessPoolExecutor(_workers(), context, _report_to, (queue,)) as pool:
        waiting: set[Future[None]] = {pool.submit(_put_and_report, family) for family in families()}
        try:
            while waiting:
                finished, waiting = wait(waiting, 0.2, FIRST_COMPLETED)
                while not queue.empty():
                    done(queue.get())
                for one in finished:
                    one.result()
        finally:
            pool.shutdown(cancel_futures=True)  # after an error or Ctrl-C no further family begins


_report: Any = None
"""Where a process puts the questions that it has finished."""


def _report_to(queue: Any) -> None:
    global _report
    _report = queue


def _put_and_report(family: str) -> None:
    _put(family, _report.put)


def _workers() -> int:
    """As many processes as there are cores, families, and memory for."""
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4e9
    return max(1, min(threads.available(), len(families()), int(memory / MEMORY)))
