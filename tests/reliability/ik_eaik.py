"""R6 beside EAIK: the same configurations modulo whole turns on random poses of every library arm that EAIK accepts.

python -m tests.reliability.ik_eaik [--poses 20000] [--seed S]

Both lists are judged by forward kinematics. Where they differ: who lacks a configuration that the other proves
by reaching the pose.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.ik import inverse_kinematics
from mafsil.ik.chain import Chain, chain_of
from mafsil.robot import Robot
from tests.reliability.arm_families import forward
from tests.reliability.ik_bounds import apart
from tests.reliability.ik_complete import library

REACHED = 1e-6
"""Miss of a configuration up to which it counts as EAIK's solution."""

SAME = 1e-5
"""Difference up to which configurations are one [rad]."""


def rival(chain: Chain) -> Any | None:
    """EAIK's solver; None where it does not know the arm, or an axis slides."""
    from eaik.IK_HP import HPRobot

    if any(chain.prismatic):
        return None
    offsets = np.diff(np.concatenate([np.zeros((1, 3)), chain.points, chain.home[None, :3, 3]]), axis=0)
    try:
        solver = HPRobot(chain.axes, offsets)
        return solver if solver.hasKnownDecomposition() else None
    except (RuntimeError, ValueError, AttributeError):
        return None


def compared(robot: Robot, solver: Any, rng: np.random.Generator, count: int) -> dict[str, int]:
    """Counts over random poses of one arm."""
    chain = chain_of(robot.mechanism)
    assert chain is not None
    T = forward(chain, rng.uniform(-np.pi, np.pi, (count, robot.n)))
    mine = inverse_kinematics(robot, T)
    asked = T.copy()
    asked[:, :3, :3] = T[:, :3, :3] @ chain.home[:3, :3].T
    found = {"poses": count, "equal": 0, "lacking_here": 0, "lacking_there": 0, "wrong_there": 0}
    for X, Y, q, valid in zip(T, asked, mine.q, mine.valid, strict=True):
        answer = solver.IK(Y)
        # EAIK marks what it only approximates.
        exact = ~np.asarray(answer.is_LS, dtype=np.bool_).reshape(-1)
        theirs = np.asarray(answer.Q, dtype=np.float64).reshape(-1, robot.n)[exact]
        reached = np.abs(forward(chain, theirs) - X).max(axis=(1, 2)) < REACHED
        found["wrong_there"] += int((~reached).sum())
        lacking = _lacking(chain, theirs[reached], q[valid]), _lacking(chain, q[valid], theirs[reached])
        found["lacking_here"] += lacking[0]
        found["lacking_there"] += lacking[1]
        found["equal"] += int(not any(lacking))
    return found


def _lacking(chain: Chain, some: np.ndarray, others: np.ndarray) -> int:
    """How many of some configurations are not among others."""
    if not len(some) or not len(others):
        return len(some)
    return int((apart(some[:, None], others[None], chain.prismatic).min(axis=1) > SAME).sum())


def main() -> int:
    """Compare all arms and write what was found to docs/figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=None)
    options = parser.parse_args()
    arms: dict[str, dict[str, int]] = {}
    for name, robot in library().items():
        chain = chain_of(robot.mechanism)
        solver = None if chain is None else rival(chain)
        if solver is not None:
            arms[name] = compared(robot, solver, np.random.default_rng(options.seed), options.poses)
            print(name, arms[name], flush=True)
    if options.out is not None:
        options.out.write_text(json.dumps({"row": "R6", "rival": "EAIK", "arms": arms}, indent=1))
    return int(any(one["lacking_here"] for one in arms.values()))


if __name__ == "__main__":
    sys.exit(main())
