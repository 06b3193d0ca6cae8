"""The tree of a robot with loops, for packages that close the loops by themselves: its routines refuse nothing."""

from __future__ import annotations

from functools import lru_cache

from mafsil.model import Mechanism
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.robot.compiled_robot import CompiledTree
from mafsil.robot.loading import as_robot
from mafsil.robot.robot import Robot


class OpenTree(Robot, CompiledTree):
    """A robot with loops whose routines are those of its tree, at any coordinates.

    Its mechanism keeps the loops, so functions of open chains refuse it as they refuse every robot with loops; the tree
    for them is `robot.without_loops()`.
    """


def as_open_tree(robot: RobotLike) -> Robot:
    """The robot, or the tree of a robot with loops: as `as_robot`, for a caller that keeps the loops closed.

    Args:
        robot: a Robot, a Mechanism, a name of the library or the path of a file.

    Raises:
        InputError: something else.
        FileError, ModelError: no such name or file, or a malformed one.
    """
    if isinstance(robot, OpenTree):
        return robot
    mechanism = as_mechanism(robot, keeps_loops=True)
    if mechanism.loops:
        return _tree_of(mechanism)
    return as_robot(robot if isinstance(robot, Robot) else mechanism)


@lru_cache(maxsize=64)
def _tree_of(mechanism: Mechanism) -> OpenTree:
    return OpenTree(mechanism)
