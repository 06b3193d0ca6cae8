"""Pairs of an arm's bodies that meet in too many samples to be meant; and in words, what is checked and what not."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector, Truth
from mafsil.collision import laid_arm, layout, pair_counts_loops
from mafsil.collision.bodies import Body
from mafsil.collision.pairs import Reason, joined_by_hinges
from mafsil.messages import clauses, say
from mafsil.robot import Robot

if TYPE_CHECKING:
    from mafsil.collision.checker import Checker

ALWAYS = 0.95
"""Share of sampled configurations in which two bodies meet that always meet."""
OFTEN = 0.4
"""Share above which the shapes of two bodies are thicker than the robot if they also meet at the zero configuration, or
if hinges at one point join them."""
LISTED = (Reason.REST, Reason.ALWAYS, Reason.OFTEN, Reason.UNSEEN)
"""Reasons whose pairs are named: they follow from samples and not from the structure or the user."""
MOST_NAMED = 20


def skipped_by_samples(
    robot: Robot, bodies: tuple[Body, ...], pairs: list[tuple[int, int]], q: JointVector, *, drop_unseen: bool,
    unlisted: bool,
) -> dict[tuple[int, int], Reason]:  # fmt: skip
    """Pairs that meet in nearly all samples; in many, and at the zero configuration or a ball joint; if asked, in none.

    Args:
        robot: the arm.
        bodies: of it.
        pairs: of indices, those that are looked at.
        q: (k + 1, n) the zero configuration, then the samples.
        drop_unseen: whether those that meet in none count.
        unlisted: whether those that meet in many count: no semantic description says which matter.
    """
    at_zero = meetings(robot, bodies, pairs, q[:1]).tolist()
    shares = (meetings(robot, bodies, pairs, q[1:]) / (len(q) - 1)).tolist()
    found, joined = dict[tuple[int, int], Reason](), joined_by_hinges(robot.mechanism, bodies)
    for pair, share, zero in zip(pairs, shares, at_zero, strict=True):
        if share >= ALWAYS:
            found[pair] = Reason.ALWAYS
        elif unlisted and (zero or pair in joined) and share >= OFTEN:
            found[pair] = Reason.OFTEN
        elif share == 0.0 and drop_unseen:
            found[pair] = Reason.UNSEEN
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
        for _, poses in laid_arm.poses_in_parts(robot, q):
            pair_counts_loops.count_meetings(arm, poses, counts)
    return counts


def explained(checker: Checker, pairs: list[tuple[int, int]], language: str | None = None) -> str:
    """What is checked of an arm, what is not and why, and how many random configurations are free of itself.

    Args:
        checker: of the arm.
        pairs: of bodies, those that are checked.
        language: of the sentences.
    """
    bodies = checker.bodies
    lines = [say("collision.checked", language=language, bodies=len(bodies), pairs=len(pairs))]
    named = defaultdict[Reason, list[str]](list)
    for each in checker.skipped:
        named[each.reason].append(str(each))
    for reason, found in named.items():
        shown = found[:MOST_NAMED] + ["..."] * (len(found) > MOST_NAMED)
        names = " (" + ", ".join(shown) + ")" if reason in LISTED else ""
        lines.append(say(f"collision.skipped_{reason.value}", language=language, count=len(found), names=names))
    if pairs and checker.samples and checker.robot.n:
        alone = checker.with_scene(())
        rows = alone.random_configurations(checker.samples)
        free = int(alone.free(rows).sum())
        lines.append(say("collision.free_of_itself", language=language, free=free, samples=checker.samples))
        if not alone.free(checker.zero):
            met = alone.check(checker.zero).contacts[:MOST_NAMED]
            meets = clauses((each.sentence(language) for each in met), language)
            lines.append(say("collision.zero_meets", language=language, contacts=meets))
        if not free:
            near = alone.distance(rows)
            most = Counter(zip(near.first.tolist(), near.second.tolist(), strict=True)).most_common(3)
            names = ", ".join(f"{first} - {second}" for (first, second), _ in most)
            lines.append(say("collision.never_free", language=language, names=names))
    return "\n".join(lines)
