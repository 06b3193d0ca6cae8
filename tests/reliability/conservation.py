"""R10: free motion of random trees keeps its energy and its momenta; every integrator has its nominal order.

`python -m tests.reliability.conservation --cases 1000 --seed 0 --resume DIR`

Each tree (one to six joints of all kinds, branches, followers, massless links) moves for 100 s without efforts, half
of them without gravity. The method is Dormand and Prince's of order 8 at the step that the error estimate chooses: in
rates under gravity, in coordinates and momenta without. Energy counts relative to the largest kinetic energy.
Momentum: without gravity, that of every coordinate whose joint alone carries its whole tree from the ground; relative
to the largest momentum of the tree. Trees that fall ever faster may need more than 100,000 steps: these are counted as
unfinished, and judged as far as they came.

Orders up to six: every fourth tree (up to four joints), by halving the step against a solution of tolerance 1e-14 where
the order has settled before the errors drown in rounding. A higher order than the nominal one, as symmetries make, is
counted apart. Orders above six drown too early; `tests/solvers` and `tests/simulation` have them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from mafsil.errors import ModelError
from mafsil.model import Mechanism
from mafsil.robot import Robot
from mafsil.simulation import ForwardMotion, forward_dynamics_trajectory
from mafsil.simulation.motion.fixed_step import COMPOSITIONS, Clock, fixed_step_solution
from mafsil.simulation.motion.system import DrivenRobot
from mafsil.solvers import METHODS, Tableau, Tolerance, first_order, integrate, integrate_adaptively, pair
from mafsil.solvers.embedded import PAIRS
from mafsil.solvers.solution import IntegrationStatus
from tests.oracles.random_tree import random_tree
from tests.reliability import figures

DURATION, TOLERANCE = 100.0, 1e-13
SETTLED = 0.04
ENERGY_LIMIT, MOMENTUM_LIMIT, ORDER_LIMIT = 1e-9, 1e-12, 0.1
MOST_STEPS = 100_000
ORDERS = {name: m.order for name, m in METHODS.items()} | {
    name: order for name, (_, order) in COMPOSITIONS.items() if order < 8
}
"""Nominal orders of the methods with a fixed step."""


def tree(number: int) -> Mechanism:
    """The random mechanism of that number; odd ones are free of gravity."""
    rng = np.random.default_rng([10, number])
    mechanism = random_tree(rng, most_joints=int(rng.integers(1, 7)))
    return replace(mechanism, gravity=np.zeros(3)) if is_free(number) else mechanism


def is_free(number: int) -> bool:
    """Whether the tree of that number has no gravity."""
    return number % 2 == 1


def cyclic(mechanism: Mechanism) -> list[int]:
    """Coordinates whose joint stands on the ground and moves alone: their momentum is that of a symmetry."""
    grounded = {mechanism.links[0].name}
    names = [joint.name for joint in mechanism.coordinates]
    leaders = {joint.mimic.leader for joint in mechanism.joints if joint.mimic is not None}
    found: list[int] = []
    for joint in mechanism.joints:
        if joint.parent not in grounded:
            continue
        if not joint.moves:
            grounded.add(joint.child)
        elif joint.mimic is None and joint.name not in leaders:
            found.append(names.index(joint.name))
    return found


def start(number: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Initial coordinates and rates."""
    rng = np.random.default_rng([11, number])
    return rng.uniform(-2.0, 2.0, n), rng.uniform(-1.0, 1.0, n)


def motion(number: int, duration: float = DURATION) -> ForwardMotion:
    """The free motion of a tree; ModelError if some joint moves no inertia."""
    robot = Robot(tree(number))
    return forward_dynamics_trajectory(
        robot,
        *start(number, robot.n),
        duration=duration,
        friction=False,
        tolerance=TOLERANCE,
        momenta=is_free(number),
        most_steps=MOST_STEPS,
    )


def judged(number: int, duration: float = DURATION) -> dict[str, int]:
    """Counts of one tree."""
    try:
        moved = motion(number, duration)
    except ModelError:
        return {"singular": 1}
    unfinished = moved.outcome.status is IntegrationStatus.BUDGET_SPENT
    if not (moved.succeeded or unfinished):
        return {"bad_end": 1}
    energy = moved.energy_drift
    counts = {"joints": moved.n, "steps": len(moved.t), "unfinished": int(unfinished), **_decade("energy", energy)}
    counts["bad_energy"] = int(not energy <= ENERGY_LIMIT)
    chosen = cyclic(moved.robot.mechanism) if is_free(number) else []
    if chosen:
        p = moved.outcome.value.y[:, moved.n :]
        drift = float(np.abs(p - p[0])[:, chosen].max() / np.abs(p).max())
        counts |= {"momenta": len(chosen), **_decade("momentum", drift)}
        counts["bad_momentum"] = int(not drift <= MOMENTUM_LIMIT)
    return counts


def _decade(name: str, value: float) -> dict[str, int]:
    """Counted in the power of ten below which the value lies."""
    power = int(np.clip(np.floor(-np.log10(max(value, 1e-18))), 0, 17))
    return {f"{name}_below_1e-{power:02d}": 1}


def orders(number: int) -> dict[str, float]:
    """Measured minus nominal order of every integrator on a short motion of a tree; NaN where it cannot be seen."""
    robot = Robot(tree(number))
    system = DrivenRobot(robot, None, None, False)
    q, qd = start(number, robot.n)
    y = np.concatenate([q, qd])
    pace = 1.0 / max(1.0, float(np.abs(system.acceleration(0.0, q, qd)).max()) ** 0.5)
    nominal = ORDERS | {"bs23": pair("bs23").order}
    gaps: dict[str, float] = {}
    for name, wanted in nominal.items():
        # Methods of high order need room: their errors pass through few halvings before they drown in rounding.
        span = pace * 0.2 * max(1.0, wanted / 2.0)
        exact = integrate_adaptively(pair("dop853"), system.rates, y, (0.0, span), tolerance=Tolerance(1e-14, 1e-14))
        errors = partial(_error, system, name, y, exact.value.y[-1], span)
        gaps[name] = _order(errors) - wanted
    return gaps


def _error(system: DrivenRobot, name: str, y: np.ndarray, target: np.ndarray, span: float, count: int) -> float:
    """Error at the end of a motion in `count` equal steps."""
    q, qd = y[: system.n], y[system.n :]
    if name in PAIRS:
        found = integrate(first_order(_fixed(name), system.rates), (y,), span / count, count).value[0][-1]
    else:
        found = fixed_step_solution(system, name, (q, qd), Clock(span / count, count), ()).value.y[-1]
    return float(np.abs(found - target).max()) / float(np.abs(target).max())


def _fixed(name: str) -> Tableau:
    """An adaptive pair without its error estimate."""
    p = pair(name)
    last = p.steps - 1
    rows = tuple(tuple(map(float, p.a[i, :i])) for i in range(last))
    return Tableau(p.name, rows, tuple(map(float, p.b)), tuple(map(float, p.c[:last])), p.order)


def _order(error: Callable[[int], float]) -> float:
    """Log2 of the ratio of errors at the finest halvings at which it has settled; NaN if it never does.

    It has settled where two halvings in a row agree to 0.04; errors below 1e-13 are rounding.
    """
    count, before, last, settled = 1, error(1), np.inf, np.nan
    while count < 2048:
        count *= 2
        now = error(count)
        if not now > 1e-13:
            break
        order = float(np.log2(before / now))
        settled = order if abs(order - last) < SETTLED else settled
        before, last = now, order
    return settled


def work(seed: int, count: int) -> dict[str, int]:
    """Trees seed, seed + 1, ..., counted by what became of them."""
    total = {"trees": count, "singular": 0, "unfinished": 0, "bad_end": 0, "bad_energy": 0, "bad_momentum": 0}
    total |= {"momenta": 0, "orders": 0, "orders_unsettled": 0, "orders_above": 0, "bad_order": 0}
    for number in range(seed * 1000, seed * 1000 + count):
        counts = judged(number)
        for name, value in counts.items():
            total[name] = total.get(name, 0) + value
        if any(value for name, value in counts.items() if name.startswith("bad_")):
            print(f"tree {number}: {counts}", file=sys.stderr)
        if number % 4 == 0 and Robot(tree(number)).n <= 4:
            try:
                measured = orders(number)
            except ModelError:
                continue
            known = {name: gap for name, gap in measured.items() if np.isfinite(gap)}
            total["orders"] += len(known)
            total["orders_unsettled"] += len(measured) - len(known)
            total["orders_above"] += sum(gap > ORDER_LIMIT for gap in known.values())
            wrong = {name: gap for name, gap in known.items() if gap < -ORDER_LIMIT}
            total["bad_order"] += len(wrong)
            if wrong:
                print(f"tree {number}: orders {wrong}", file=sys.stderr)
    return total


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "cases", 1000, 10)
    sys.exit(not figures.run("R10", options, work)["passed"])
