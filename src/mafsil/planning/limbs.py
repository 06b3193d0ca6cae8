"""The limbs of an arm whose tools can go back from where they are, for `retreat_loops`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Truth
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.planning.retreat_loops as retreat_loops
    from mafsil.collision import Checker
    from mafsil.planning.retreat_loops import Limbs
else:
    retreat_loops = lazily("mafsil.planning.retreat_loops")

FEWEST = 2
"""Joints of a limb."""


def limbs_of(checker: Checker) -> Limbs:
    """The limbs of an arm with arrays to work in, for this thread.

    The longest chain of joints to a body is a limb; of the other chains, longest first, each that has more joints of
    its own than it shares with limbs before it. So are both arms of a torso, but not the fingers of a hand.
    """
    motion, mechanism = checker.laid.motion, checker.robot.mechanism
    n, taken = mechanism.n, np.zeros(len(motion.joints), np.bool_)
    parts: list[tuple[int, int, int, int, int]] = []
    own: list[Truth] = []
    reach: list[float] = []
    while (new := motion.moves & ~taken[:, None]).any():
        tool = int(new.sum(axis=0).argmax())
        chain, fresh = motion.moves[:, tool], new[:, tool]
        if fresh.sum() < FEWEST or 2 * fresh.sum() <= chain.sum():
            break
        taken |= chain
        far = _reach(checker, fresh, tool)
        if far == 0.0:
            continue
        parts.append(_parts(checker, chain, fresh, tool))
        own.append(np.isin(np.arange(n), motion.joints[fresh, 1]))
        reach.append(far)
    gravity = np.asarray(mechanism.gravity)
    up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.zeros(3)
    rows, mine = np.array(parts, np.int64).reshape(-1, 5), np.array(own, np.bool_).reshape(len(parts), n)
    kinematics = checker.world().kinematics
    return retreat_loops.room_for(kinematics, motion.joints, rows, mine, np.array(reach, np.float64), up)


def _reach(checker: Checker, fresh: Truth, tool: int) -> float:
    """How far a limb reaches: from the axis of a hinge, and along its sliding joints as far as they have limits [m]."""
    motion, limits = checker.laid.motion, checker.robot.limits
    slides = motion.joints[fresh & (motion.joints[:, 3] == 0.0), 1].astype(np.int64)
    travel = (limits.upper - limits.lower)[np.unique(slides)]
    return float(motion.reach[fresh, tool].max() + travel[np.isfinite(travel)].sum())


def _parts(checker: Checker, chain: Truth, fresh: Truth, tool: int) -> tuple[int, int, int, int, int]:
    """A row of `Limbs.parts`.

    Args:
        checker: the arm.
        chain: (j,) the joints that move the tool.
        fresh: (j,) those of the limb.
        tool: index of its body.
    """
    motion = checker.laid.motion
    columns, hinges = motion.joints[:, 1].astype(np.int64), np.flatnonzero(fresh & (motion.joints[:, 3] == 1.0))
    if not len(hinges):
        return int(motion.last[tool]), tool, -1, -1, -1
    roll = int(hinges[-1])
    before = np.flatnonzero(~motion.moves[roll] & np.isin(motion.last, np.flatnonzero(chain)))
    nearest = int(before[motion.last[before].argmax()]) if len(before) else -1
    return int(motion.last[tool]), tool, nearest, int(columns[roll]), int(columns[hinges[0]])
