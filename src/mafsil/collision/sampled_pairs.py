"""Pairs of an arm's bodies that meet in too many samples to be meant, or are always near; in words, what is checked."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, Truth
from mafsil.collision import clearance_loops, layout
from mafsil.collision.pairs import Body, SkippedPair, SkipReason, joined_by_hinges
from mafsil.messages import say
from mafsil.robot import Robot

ALWAYS = 0.95
"""Share of sampled configurations in which two bodies meet that always meet."""
OFTEN = 0.4
"""Share above which the shapes of two bodies are thicker than the robot if they also meet at the zero configuration, or
if hinges at one point join them."""
SELDOM = 0.1
"""Share of the configurations in which two bodies are apart that a clearance between them may take away."""
LESS = 0.9
"""What two bodies keep that are always near, as share of the distance that they seldom come below."""
LISTED = (SkipReason.REST, SkipReason.ALWAYS, SkipReason.OFTEN, SkipReason.UNSEEN)
"""Reasons whose pairs are named: they follow from samples and not from the structure or the user."""
MOST_NAMED = 20


def skipped_by_samples(
    robot: Robot, bodies: tuple[Body, ...], pairs: list[tuple[int, int]], q: JointVector, *, skip_never_colliding: bool,
    unlisted: bool,
) -> dict[tuple[int, int], SkipReason]:  # fmt: skip
    """Pairs that meet in nearly all samples; in many, and at the zero configuration or a ball joint; if asked, in none.

    Args:
        robot: the arm.
        bodies: of it.
        pairs: of indices, those that are looked at.
        q: (k + 1, n) the zero configuration, then the samples.
        skip_never_colliding: whether those that meet in none count.
        unlisted: whether those that meet in many count: no semantic description says which matter.
    """
    at_zero = meetings(robot, bodies, pairs, q[:1]).tolist()
    shares = (meetings(robot, bodies, pairs, q[1:]) / (len(q) - 1)).tolist()
    found, joined = dict[tuple[int, int], SkipReason](), joined_by_hinges(robot.mechanism, bodies)
    for pair, share, zero in zip(pairs, shares, at_zero, strict=True):
        if share >= ALWAYS:
            found[pair] = SkipReason.ALWAYS
        elif unlisted and (zero or pair in joined) and share >= OFTEN:
            found[pair] = SkipReason.OFTEN
        elif share == 0.0 and skip_never_colliding:
            found[pair] = SkipReason.UNSEEN
    return found


def met_always(met: Truth) -> bool:
    """Whether something holds for nearly all samples (k,)."""
    return float(met.mean()) >= ALWAYS


def meetings(
    robot: Robot, bodies: tuple[Body, ...], pairs: list[tuple[int, int]], q: JointVector
) -> NDArray[np.int64]:  # fmt: skip
    """(m,) at how many of the configurations (k, n) each pair of bodies meets."""
    counts = np.zeros(len(pairs), np.int64)
    if pairs:
        arm = layout.arm_of(bodies, pairs)
        for _, poses in layout.poses_in_parts(robot, q):
            clearance_loops.count_meetings(arm, poses, counts)
    return counts


def kept_by_pairs(
    robot: Robot, bodies: tuple[Body, ...], pairs: list[tuple[int, int]], q: JointVector, clearance: float
) -> Floats:  # fmt: skip
    """(m,) clearances that pairs keep of each other: less than the clearance where they are always near.

    A wrist's housings are nearer to each other than they should come to anything else. A clearance that more than a few
    of the configurations of two bodies that are apart lack is none that their maker left.

    Args:
        robot, bodies, pairs: as for `meetings`.
        q: (k, n) configurations.
        clearance: the clearance that is asked for [m].
    """
    kept = np.full(len(pairs), clearance)
    if not pairs:
        return kept
    gaps, arm = np.empty((len(q), len(pairs))), layout.arm_of(bodies, pairs)
    for begin, poses in layout.poses_in_parts(robot, q):
        clearance_loops.measure_gaps(arm, poses, clearance / LESS, gaps[begin : begin + len(poses)])
    for k in range(len(pairs)):
        apart = gaps[gaps[:, k] > 0.0, k]
        if len(apart):
            kept[k] = min(clearance, LESS * float(np.quantile(apart, SELDOM)))
    return kept


def explain_skipped(skipped: Iterable[SkippedPair], language: str | None = None) -> list[str]:
    """What is not checked of an arm, and why: a sentence a reason.

    Args:
        skipped: pairs of bodies.
        language: of the sentences.
    """
    named = defaultdict[SkipReason, list[str]](list)
    for pair in skipped:
        named[pair.reason].append(str(pair))
    lines: list[str] = []
    for reason, pairs in named.items():
        shown = pairs[:MOST_NAMED] + ["..."] * (len(pairs) > MOST_NAMED)
        names = " (" + ", ".join(shown) + ")" if reason in LISTED else ""
        lines.append(say(f"collision.skipped_{reason.value}", language=language, count=len(pairs), names=names))
    return lines
