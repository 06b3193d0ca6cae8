"""Descriptions of robots by name or file, and the check for functions that take one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import wraps
from os import PathLike, fspath
from typing import TYPE_CHECKING, Concatenate, ParamSpec, Protocol, TypeAlias, TypeVar, cast

from numpy.typing import ArrayLike

from mafsil.errors import InputError, ModelError
from mafsil.lazy_module import lazily
from mafsil.model.mechanism import Mechanism

if TYPE_CHECKING:
    import mafsil.model.robot_source as robot_source
else:
    robot_source = lazily("mafsil.model.robot_source")

P = ParamSpec("P")
Result = TypeVar("Result")


class Described(Protocol):
    """What carries the description of a robot: a Robot does."""

    @property
    def mechanism(self) -> Mechanism:
        """The description."""
        ...


RobotLike: TypeAlias = Described | Mechanism | str | PathLike[str]
"""Whatever names a robot: a Robot, a Mechanism, a name of the library, the path of a file."""


def as_mechanism(robot: RobotLike, *, keeps_loops: bool = False) -> Mechanism:
    """The description behind whatever names a robot.

    Args:
        robot: a Robot, a Mechanism, a name of the library or the path of a file.
        keeps_loops: whether the caller keeps loops closed, or their description; a robot with loops is refused if not.

    Raises:
        InputError: something else.
        ModelError: it has loops.
        FileError, ModelError: no such name or file, a malformed one; as `load_mechanism` says.
    """
    mechanism = _describe(robot)
    return mechanism if keeps_loops else require_no_loops(mechanism)


def require_no_loops(mechanism: Mechanism) -> Mechanism:
    """A mechanism for what computes open chains: one with loops is refused, and the names that know loops are said.

    Args:
        mechanism: any.

    Raises:
        ModelError: it has loops.
    """
    if mechanism.loops:
        raise ModelError("robot.loops", robot=mechanism.name)
    return mechanism


def _describe(robot: RobotLike) -> Mechanism:
    if isinstance(robot, Mechanism):
        return robot
    described = getattr(cast(object, robot), "mechanism", None)
    if isinstance(described, Mechanism) and not isinstance(robot, type):
        return described
    return load_mechanism(cast("str | PathLike[str]", robot))


@dataclass(frozen=True, slots=True)
class RobotFile(PathLike[str]):
    """A robot as requested: its file or name, the arguments of its xacro, what it carries; stands where a path may.

    Attributes:
        path: of the file, or a name of the library.
        xacro_args: values by name; numbers and booleans are written as xacro writes them.
        equip: applied to what was read, after the tip was chosen.
        model: the one of an SDFormat world, if it holds several robots.
    """

    path: str
    xacro_args: Mapping[str, object]
    equip: Callable[[Mechanism], Mechanism] | None = None
    model: str | None = None

    @property
    def texts(self) -> dict[str, str]:
        """The arguments as xacro takes them; True and False as it writes them."""
        words = {True: "true", False: "false"}
        return {
            str(key): words[value] if isinstance(value, bool) else str(value) for key, value in self.xacro_args.items()
        }

    def __fspath__(self) -> str:
        return self.path

    def __str__(self) -> str:
        return self.path


def of_mechanism(function: Callable[Concatenate[Mechanism, P], Result]) -> Callable[Concatenate[RobotLike, P], Result]:
    """The function of a Mechanism as one of whatever names a robot without loops."""

    @wraps(function)
    def call(mechanism: RobotLike, *args: P.args, **named: P.kwargs) -> Result:
        return function(as_mechanism(mechanism), *args, **named)

    return call


def of_any_mechanism(
    function: Callable[Concatenate[Mechanism, P], Result],
) -> Callable[Concatenate[RobotLike, P], Result]:
    """As `of_mechanism`, for a function that keeps loops closed, or their description."""

    @wraps(function)
    def call(mechanism: RobotLike, *args: P.args, **named: P.kwargs) -> Result:
        return function(as_mechanism(mechanism, keeps_loops=True), *args, **named)

    return call


def load_mechanism(
    source: str | PathLike[str],
    *,
    tip: str | None = None,
    xacro_args: Mapping[str, object] | None = None,
    model: str | None = None,
    **dimensions: ArrayLike,
) -> Mechanism:
    """The description of a robot from the library or a file; a tip that had to be chosen among several is said.

    Args:
        source: a name of the library, or a path: of a URDF, xacro, MJCF or SDFormat file, distinguished by their root
            elements, or of a .toml file (DH or screws). Loops that the format cannot say stand beside it in a file
            called like it with the ending .loops.toml.
        tip: name of the link that carries the tip frame; that of the description, or the chosen one, if None.
        xacro_args: arguments of a xacro file, by name.
        model: name of the one that is meant of an SDFormat world with several robots.
        **dimensions: of an arm of the library that takes some, such as `lengths=(0.4, 0.3)` of `planar2r`.

    Warns:
        ModelWarning: the description leaves the tip open, or the file was changed or looks wrong in places.

    Raises:
        InputError: neither a name nor a path, arguments for something other than a file, dimensions it does not have.
        FileError: no such file or name, or a malformed file; the sentence says where and what to do.
        ModelError: the file describes something that is no robot, or has no link of that name.
    """
    if not isinstance(cast(object, source), str | PathLike) or isinstance(cast(object, fspath(source)), bytes):
        raise InputError("robot.source", got=type(source).__name__)
    requested = source if isinstance(source, RobotFile) else RobotFile(str(source), {})
    model = requested.model if model is None else model
    arguments = (requested if xacro_args is None else RobotFile(requested.path, xacro_args)).texts
    mechanism, from_file = robot_source.read_source(source, arguments, dimensions, model)
    origin = mechanism.provenance
    if origin.choice is not None and tip is not None:
        notes = tuple(note for note in origin.notes if note != origin.choice.sentence("en"))
        mechanism = replace(mechanism, provenance=replace(origin, notes=notes, choice=None))
    if from_file:
        robot_source.warn_of_file(mechanism, mechanism.provenance.choice)
    mechanism = mechanism if tip is None else mechanism.with_tip(tip)
    return mechanism if requested.equip is None else requested.equip(mechanism)
