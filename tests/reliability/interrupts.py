"""K6: Ctrl-C at random instants: heard within 0.2 s (compiling: 1 s), and the next call gives what it gave before.

`python -m tests.reliability.interrupts --cases 10000 --resume DIR`
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from types import FrameType

import numpy as np

import mafsil as mf
from mafsil.code_store import CACHE_VARIABLE
from mafsil.kernels import compiler
from tests.reliability import figures, specimens

HEARD, HEARD_COMPILING = 0.2, 1.0
"""How long a Ctrl-C may wait [s]."""
ROWS = 400_000


def work(seed: int, cases: int) -> dict[str, int]:
    """Interrupt one call per case, then ask for a known answer."""
    dice = random.Random(seed)
    count: dict[str, int] = dict.fromkeys(("cases", "interrupted", "bad_late", "bad_after", "over_50_ms"), 0)
    calls = _calls(seed)
    before = [known() for _, _, known in calls]
    for case in range(cases):
        which = case % len(calls)
        call, allowed, known = calls[which]
        late = _interrupted(call, dice.uniform(0.001, 0.15))
        count["cases"] += 1
        if late is not None:
            count["interrupted"] += 1
            count["bad_late"] += late > allowed
            count["over_50_ms"] += late > 0.05
        count["bad_after"] += not np.array_equal(known(), before[which], equal_nan=True)
    return count


def _interrupted(call: Callable[[], object], after: float) -> float | None:
    """How long after the signal the call came back [s]; None if it was done before."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    usual = signal.signal(signal.SIGALRM, stop)
    began = time.perf_counter()
    try:
        signal.setitimer(signal.ITIMER_REAL, after)
        call()
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    except KeyboardInterrupt:
        return time.perf_counter() - began - after
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, usual)
    return None


def _calls(seed: int) -> list[tuple[Callable[[], object], float, Callable[[], np.ndarray]]]:
    """What is interrupted, how soon it must be heard, and a call whose answer must not change."""
    rng = np.random.default_rng(seed)
    robot = mf.load("panda")
    q = rng.uniform(robot.limits.lower, robot.limits.upper, size=(ROWS, robot.n))
    few = q[:100]
    poses = robot.forward_kinematics(q[:20_000])
    arm = mf.load("ur5e")
    arm_poses = arm.forward_kinematics(rng.uniform(-3, 3, size=(20_000, arm.n)))
    return [
        (lambda: robot.inverse_dynamics(q, q, q, threads=1), HEARD, lambda: robot.inverse_dynamics(few, few, few)),
        (lambda: robot.forward_kinematics(q), HEARD, lambda: robot.forward_kinematics(few)),
        (lambda: mf.solve_ik(robot, poses, seed=1), HEARD, lambda: mf.solve_ik(robot, poses[:5], seed=1).q),
        (lambda: mf.inverse_kinematics(arm, arm_poses), HEARD, lambda: mf.inverse_kinematics(arm, arm_poses[:5]).q),
        (_compile_again, HEARD_COMPILING, lambda: specimens.kernel(3, 0)(*specimens.states(3, 3))[0]),
    ]


def _compile_again() -> None:
    """From nothing, into a store of its own."""
    usual = os.environ.get(CACHE_VARIABLE)
    with tempfile.TemporaryDirectory(prefix="mafsil-K6-") as folder:
        os.environ[CACHE_VARIABLE] = folder
        try:
            compiler._images.clear()
            for links in (3, 5, 8):
                specimens.kernel(links, 0)(*specimens.states(links, 3))
        finally:
            os.environ[CACHE_VARIABLE] = usual or ""
            if usual is None:
                del os.environ[CACHE_VARIABLE]


if __name__ == "__main__":
    sys.exit(not figures.run("K6", figures.arguments(__doc__ or "", "cases", 100, 1000), work)["passed"])
