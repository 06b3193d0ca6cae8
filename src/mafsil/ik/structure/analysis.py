"""What an arm was recognised as for a task, found once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, islice
from typing import TYPE_CHECKING, Literal

import numpy as np

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.geometry import pose
from mafsil.ik.chain import Chain, chain_of
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.structure.recognise import (
    patterns_with_orientation,
    point_patterns,
    recognise,
)
from mafsil.ik.tolerances import DEFECT
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern, Family, LockedJoint, PositioningMethod
from mafsil.model import Mechanism
from mafsil.robot import Robot, of_robot

if TYPE_CHECKING:
    import mafsil.ik.general as general_six
    from mafsil.ik.general import GeneralSix
else:
    general_six = lazily("mafsil.ik.general")

MOST_SETS = 100
"""Choices of locked joints that are looked at: each takes some milliseconds."""

Task = Literal["pose", "position", "axis"]


@dataclass(frozen=True, eq=False)
class Analysis:
    """What an arm was recognised as, for a task.

    Attributes:
        chain: of the arm; None if it is none of revolute and prismatic joints.
        form: its closed form, if it has one.
        general: elimination for the general six-joint arm, where there is no exact closed form.
        locked: coordinates whose values are chosen, because the arm has more joints than the task needs.
    """

    chain: Chain | None
    form: ClosedForm | None
    general: GeneralSix | None
    locked: tuple[int, ...]

    @property
    def exact(self) -> bool:
        """Whether the closed form is the arm's own."""
        return self.form is not None and self.form.pattern.defect <= DEFECT


@lru_cache(maxsize=256)
def analysis(mechanism: Mechanism, task: Task = "pose") -> Analysis:
    """How the tip of a mechanism can be solved; found once.

    Args:
        mechanism: with its tip.
        task: `pose`, `position`, or `axis` (position and direction of the tip's z axis).
    """
    chain = chain_of(mechanism)
    if chain is None or not len(chain):
        return Analysis(None, None, None, ())
    n, orientation, seen = mechanism.n, task != "position", _seen(chain, task)
    excess = max(0, len(seen) - _equations(seen, orientation))
    quartic: tuple[ArmPattern, tuple[int, ...]] | None = None
    for locked in _locked_sets(seen, excess):
        pattern = recognise_locked(seen, n, locked, orientation=orientation)
        if pattern is not None and locked and pattern.quartic:
            # Another choice may do without an equation of fourth degree.
            quartic = quartic or (pattern, locked)
        elif pattern is not None:
            return _recognise(chain, seen, pattern, locked, task)
    if quartic is not None:
        return _recognise(chain, seen, *quartic, task)
    general = general_six.GeneralSix(seen) if task == "pose" and 3 <= len(seen) <= 6 else None
    return Analysis(chain, None, general, ())


@of_robot
def structure_in_doubt(robot: Robot, task: Task = "pose") -> bool:
    """Whether an arm differs from a simpler structure by no more than a description of six digits leaves open.

    Its closed form is then another, or refined, or missing, where that of the arm that was meant may be simple.

    Args:
        robot: any arm.
        task: as for `inverse_kinematics`.
    """
    return _in_doubt(robot.mechanism, task)


@lru_cache(maxsize=256)
def _in_doubt(mechanism: Mechanism, task: Task) -> bool:
    chain = chain_of(mechanism)
    if chain is None or not len(chain):
        return False
    orientation, seen = task != "position", _seen(chain, task)
    excess = max(0, len(seen) - _equations(seen, orientation))
    for locked in _locked_sets(seen, excess):
        simpler = simpler_within_rounding(seen, mechanism.n, locked, orientation=orientation)
        if simpler is not None:
            return simpler
    return False


def _seen(chain: Chain, task: Task) -> Chain:
    """The chain with the joint that a task adds."""
    return chain.with_joint(chain.home[:3, 2], chain.home[:3, 3], joint=-2) if task == "axis" else chain


def _recognise(chain: Chain, seen: Chain, pattern: ArmPattern, locked: tuple[int, ...], task: Task) -> Analysis:
    """An arm with a closed form.

    Args:
        chain: of the arm.
        seen: the same with the joint that a task adds.
        pattern: the closed form's.
        locked: places of the locked joints in the chain.
        task: as for `analysis`.
    """
    # Of almost ideal arms it finds what the ideal arm lacks; of quartic equations, roots lost in merging.
    incomplete = (pattern.defect > DEFECT or pattern.quartic) and task == "pose" and not locked
    general = general_six.GeneralSix(seen) if incomplete and 3 <= len(seen) <= 6 else None
    return Analysis(chain, ClosedForm(pattern), general, tuple(seen.joints[k] for k in locked))


def _equations(chain: Chain, orientation: bool) -> int:
    """How many equations a task has: in space, or in the plane of an arm whose joints all turn about parallel axes."""
    along = np.linalg.norm(np.cross(chain.axes, chain.axes[0]), axis=1)
    if not any(chain.prismatic) and (along <= DEFECT).all():
        return 3 if orientation else 2
    return 6 if orientation else 3


@of_robot
def elimination(robot: Robot) -> GeneralSix | None:
    """The elimination of a robot's tip, for whole batches of poses; None where it has another number of joints.

    Args:
        robot: with three to six revolute or prismatic joints, of any shape.
    """
    chain = chain_of(robot.mechanism)
    return None if chain is None or not 3 <= len(chain) <= 6 else _elimination(robot.mechanism)


@lru_cache(maxsize=64)
def _elimination(mechanism: Mechanism) -> GeneralSix:
    chain = chain_of(mechanism)
    assert chain is not None
    return general_six.GeneralSix(chain)


@of_robot
def closed_form(robot: Robot, task: Task = "pose") -> ClosedForm | None:
    """The closed form of a robot's tip, for whole batches of poses; None if the arm has none.

    Args:
        robot: any arm.
        task: as for `inverse_kinematics`.
    """
    return analysis(robot.mechanism, task).form


def _locked_sets(chain: Chain, excess: int) -> Iterator[tuple[int, ...]]:
    """Which joints to lock, by position: the last ones first for wrists, else any; of very many the first."""
    real = [k for k in range(len(chain)) if chain.joints[k] >= 0]
    for locked in islice(combinations(reversed(real), excess), MOST_SETS):
        yield tuple(sorted(locked))


def recognise_locked(chain: Chain, n: int, locked: tuple[int, ...], *, orientation: bool = True) -> ArmPattern | None:
    """The closed form of the other joints, whatever values the locked ones take; None without.

    Args:
        chain: of the robot, base first.
        n: number of its coordinates.
        locked: positions in the chain, increasing.
        orientation: as for `recognise`.
    """
    if not locked:
        return recognise(chain, n, orientation=orientation)
    generic, seen = 0.4567 * chain.size, _lock(chain, locked)
    candidates = patterns_with_orientation(seen, n) if orientation else point_patterns(seen, n)
    for pattern in candidates:
        if pattern.shifted:
            continue
        if pattern.defect <= DEFECT and not _split(pattern, chain, locked):
            return _release(pattern, chain, locked, generic)
    return None


def simpler_within_rounding(chain: Chain, n: int, locked: tuple[int, ...], *, orientation: bool = True) -> bool | None:
    """Whether a description of six digits leaves open that the arm has a simpler closed form than its exact one.

    Args:
        chain, n, locked, orientation: as for `recognise_locked`.

    Returns:
        None where there is neither an exact closed form nor one within rounding.
    """
    seen = _lock(chain, locked)
    for pattern in patterns_with_orientation(seen, n) if orientation else point_patterns(seen, n):
        if locked and pattern.shifted:
            continue
        if pattern.defect <= DESCRIBED and not (locked and _split(pattern, chain, locked)):
            return pattern.defect > DEFECT
    return None


def _lock(chain: Chain, locked: tuple[int, ...]) -> Chain:
    """The chain without the locked joints, at generic values of these."""
    generic, seen = 0.4567 * chain.size, chain
    for k in reversed(locked):
        seen = seen.lock_joint(k, generic if chain.prismatic[k] else 0.4567)
    return seen


def _split(pattern: ArmPattern, chain: Chain, locked: tuple[int, ...]) -> bool:
    """Whether a locked joint moves parts of the pattern that must not move against each other."""
    groups: list[tuple[int, ...]] = []
    if pattern.family is Family.PLANAR:
        groups.append((0, 1, 2))
    if pattern.family is Family.SPHERICAL_WRIST:
        groups.append((3, 4, 5))
    if pattern.family is Family.THREE_PARALLEL:
        groups.extend([(1, 2, 3), (4, 5)])
    elif pattern.family is Family.LINKED:
        groups.append((1, 2, 3))
    elif pattern.positioning is not PositioningMethod.QUARTIC:
        pair = (0, 1) if (pattern.positioning is PositioningMethod.MEET) != pattern.positioning_reversed else (1, 2)
        groups.append(pair)
    added = any(j < 0 for j in pattern.joints) and pattern.family not in (Family.POINT, Family.PLANAR)
    places = [[j for i in group if (j := pattern.joints[i]) >= 0] for group in groups]
    return added or any(min(place) < chain.joints[k] < max(place) for place in places if place for k in locked)


def _release(pattern: ArmPattern, chain: Chain, locked: tuple[int, ...], generic: float) -> ArmPattern:
    """The pattern at q = 0 of the locked joints, which are then given by their values."""
    axes, points = pattern.axes.copy(), pattern.points.copy()
    centre, meeting = pattern.centre, pattern.meeting
    owners = [j if j >= 0 else len(chain) for j in pattern.joints]
    tip_last = len(chain) if pattern.family is Family.POINT else owners[2 if pattern.family is Family.PLANAR else 5]
    for k in locked:
        E = pose.exp(chain.screws[k] * -(generic if chain.prismatic[k] else 0.4567))
        for i in (i for i, owner in enumerate(owners) if owner > k):
            axes[i], points[i] = E[:3, :3] @ axes[i], E[:3, :3] @ points[i] + E[:3, 3]
        centre = E[:3, :3] @ centre + E[:3, 3] if tip_last > k else centre
        meeting = E[:3, :3] @ meeting + E[:3, 3] if owners[1] > k else meeting
    sense = -1.0 if pattern.reversed else 1.0
    order = locked[::-1] if pattern.reversed else locked
    given = tuple(
        LockedJoint(
            sum((owner < k) != pattern.reversed for owner in owners),
            sense * chain.axes[k],
            chain.points[k],
            chain.prismatic[k],
            chain.joints[k],
        )
        for k in order
    )
    return replace(pattern, axes=axes, points=points, centre=centre, meeting=meeting, locked=given, home=chain.home)
