"""Forward dynamics where the mass matrix can be singular at single positions: the reason instead of NaN."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.model.moved_matter import joints_that_move_matter

if TYPE_CHECKING:
    from mafsil.robot.robot import Robot


NO_FINITE_ANSWER = ("call.overflow", "call.undefined")
"""Keys of the errors of a kernel that finds no finite number."""


def dividing(robot: Robot, name: str, rank: int) -> Any:
    """A routine that divides by the mass matrix; where that may be singular at some position, an answering one.

    Args:
        robot: whose routine.
        name: of the routine.
        rank: dimensions of its result for one state.
    """
    mechanism = robot.mechanism
    moving = {joint.name for joint in mechanism.joints if joint.moves}
    if moving <= joints_that_move_matter(mechanism):
        return robot._routine(name)  # pyright: ignore[reportPrivateUsage]
    return Answered(robot, name, rank)


class Answered:
    """A routine that divides by the mass matrix: a single call that has no finite answer raises, with the reason.

    In batches such rows stay NaN, and the others keep their numbers.
    """

    def __init__(self, robot: Robot, name: str, rank: int) -> None:
        self.robot, self.name, self.rank = robot, name, rank
        self.routine: Any = robot._routine(name)  # pyright: ignore[reportPrivateUsage]
        self.__doc__ = self.routine.__doc__

    def __call__(self, *arrays: Any, **named: Any) -> Floats:
        """As the routine.

        Raises:
            ModelError: the mass matrix is singular at this position; the joints and their motion are named.
            InputError: as the routine.
        """
        try:
            found: Floats = self.routine(*arrays, **named)
        except InputError as error:
            if error.key in NO_FINITE_ANSWER:
                self.robot.degeneracy(arrays[0] if arrays else named["q"]).require_regular()
            raise
        if found.ndim == self.rank and not np.isfinite(found).all():
            self.robot.degeneracy(arrays[0] if arrays else named["q"]).require_regular()
        return found

    def __reduce__(self) -> tuple[type[Answered], tuple[Robot, str, int]]:
        return Answered, (self.robot, self.name, self.rank)
