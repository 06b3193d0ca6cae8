"""Robots by name or file, and the argument check of functions that want a robot or its open tree.

The tree of a robot with loops is for packages that close the loops by themselves: its routines refuse nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from os import PathLike
from typing import Concatenate, ParamSpec, TypeVar

from numpy.typing import ArrayLike

from mafsil.model import Mechanism
from mafsil.model.loading import RobotLike, as_mechanism, load_mechanism, require_no_loops
from mafsil.robot.compiled_robot import CompiledTree
from mafsil.robot.robot import Robot

P = ParamSpec("P")
Result = TypeVar("Result")


def load(
    source: str | PathLike[str],
    *,
    tip: str | None = None,
    xacro_args: Mapping[str, object] | None = None,
    model: str | None = None,
    **dimensions: ArrayLike,
) -> Robot:
    """A robot from the library or a file.

    Args:
        source: a name of the library in any spelling (`UR5e`), or a path: of a URDF, xacro, MJCF or SDFormat file,
            recognised by their root elements, or of a .toml file (DH or screws); where the package
            `robot_descriptions` is installed, a name of its robots (`panda_description`).
        tip: name of the link that carries the tip frame, if another than the description's default.
        xacro_args: arguments of a xacro file, by name, such as `{"prefix": "left_"}`.
        model: name of the one that is meant of an SDFormat world with several robots.
        **dimensions: of an arm of the library that takes some, such as `lengths=(0.4, 0.3)` of `planar2r`.

    Warns:
        ModelWarning: the description leaves the tip open, or the file was changed or looks wrong in places.

    Raises:
        InputError: arguments for something other than a file, dimensions that the arm does not have.
        FileError: no such file or name, or a malformed file; the sentence says where and what to do.
        ModelError: the file describes something that is no robot.
    """
    return Robot(load_mechanism(source, tip=tip, xacro_args=xacro_args, model=model, **dimensions))


def as_robot(robot: RobotLike) -> Robot:
    """The robot itself, or the one that a Mechanism, a name of the library or the path of a file stands for.

    The Mechanisms used last (64 of them) keep their Robots, so that a loop of calls loads their kernels once.

    Raises:
        InputError: something else.
        ModelError: it has loops, of which functions of open chains would make wrong numbers.
        FileError, ModelError: no such name or file, or a malformed one.
    """
    if isinstance(robot, Robot):
        require_no_loops(robot.mechanism)
        return robot
    return _robot_of(as_mechanism(robot))


def of_robot(function: Callable[Concatenate[Robot, P], Result]) -> Callable[Concatenate[RobotLike, P], Result]:
    """The function of a Robot as one of whatever names a robot without loops."""

    @wraps(function)
    def call(robot: RobotLike, *args: P.args, **named: P.kwargs) -> Result:
        return function(as_robot(robot), *args, **named)

    return call


@lru_cache(maxsize=64)
def _robot_of(mechanism: Mechanism) -> Robot:
    return Robot(mechanism)


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
