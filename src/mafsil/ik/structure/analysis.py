"""What an arm was recognised as for a task, found once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, islice
from typing import TYPE_CHECKING, Literal

import numpy as np

from mafsil.ik.chain import Chain, chain_of
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.structure.recognise import recognise_locked, simpler_within_rounding
from mafsil.ik.tolerances import DEFECT
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern
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
