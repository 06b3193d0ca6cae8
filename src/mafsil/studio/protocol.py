"""What windows may say to the server: typed messages, read strictly; everything else is refused with a sentence."""

from __future__ import annotations

import typing
from collections.abc import Mapping, Sequence
from inspect import signature
from typing import Annotated, Any, TypeVar

import msgspec

from mafsil.errors import InputError
from mafsil.page.arm import Arm, require_driven, require_free, require_kernel
from mafsil.page.session import ACTIONS, pose_from

MOST_NUMBERS = 256
"""Of one argument."""
MOST_CHANGES = 64
"""Of the journal in one message."""
MOST_TICKS = 10_000_000
"""Of one line of the journal: ten thousand seconds of the closed loop."""
MOST_TEXT = 1_000_000
"""Letters of a job."""

Identifier = Annotated[str, msgspec.Meta(pattern=r"\A[A-Za-z0-9]{1,32}-[0-9]{1,9}\Z")]
Numbers = Annotated[list[float], msgspec.Meta(max_length=MOST_NUMBERS)]
Text = Annotated[str, msgspec.Meta(max_length=MOST_TEXT)]

Message = TypeVar("Message")


class Put(msgspec.Struct, tag_field="kind", tag="put", forbid_unknown_fields=True, frozen=True):
    """A line of the journal: a new one, or that of this name once more.

    Attributes:
        id: name of the line.
        do: name of the action.
        given: its arguments.
    """

    id: Identifier
    do: str
    given: msgspec.Raw = msgspec.field(name="with")


class Drop(msgspec.Struct, tag_field="kind", tag="drop", forbid_unknown_fields=True, frozen=True):
    """A line of the journal is taken back.

    Attributes:
        id: name of the line.
    """

    id: Identifier


Changes = Annotated[list[Put | Drop], msgspec.Meta(min_length=1, max_length=MOST_CHANGES)]


class Pose(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A pose whose configurations are sought.

    Attributes:
        position: (3,) of the tip in {s} [m].
        quaternion: (4,) of any length but zero, (w, x, y, z).
        q: (n,) where the arm is; joints that are free to choose stay there.
    """

    position: Numbers
    quaternion: Numbers
    q: Numbers


class JobText(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A job as it is written in a window.

    Attributes:
        text: TOML.
        window: where it was written.
    """

    text: Text
    window: Annotated[str, msgspec.Meta(max_length=32)]


class Placement(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A thing of the job is wished for somewhere else.

    Attributes:
        thing: its number among those that can be placed.
        position: (3,) of its frame in {s} [m].
        quaternion: (4,) of any length but zero, (w, x, y, z).
    """

    thing: int
    position: Numbers
    quaternion: Numbers


class Pair(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Two recordings to be compared.

    Attributes:
        first, second: their numbers.
    """

    first: int
    second: int


class Number(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A recording.

    Attributes:
        number: under which it is kept.
    """

    number: int


class Nothing(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A request that needs no words."""


def read(kind: type[Message] | Any, body: bytes) -> Any:
    """A message.

    Args:
        kind: what it has to be.
        body: JSON.

    Raises:
        InputError: it is something else.
    """
    try:
        return _decoder(kind).decode(body)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError("studio.message", reason=str(error)) from None


def action(put: Put, arm: Arm) -> dict[str, Any]:
    """What a line of the journal does, checked: every window can do it.

    Args:
        put: the line.
        arm: whose kernels the windows have.

    Returns:
        `{"do": name, "with": {argument: value}}`.

    Raises:
        InputError: no such action, a wrong argument, a number out of range.
    """
    kind = _ARGUMENTS.get(put.do)
    if kind is None:
        raise InputError("studio.action", value=put.do[:40], known=", ".join(ACTIONS))
    given: dict[str, Any] = msgspec.structs.asdict(read(kind, bytes(put.given)))
    _require_kernel(put.do, arm)
    _require_range(given, arm)
    if put.do == "set_joint":
        require_driven(given["joint"], arm)
    if put.do == "swing":
        require_free(given["joint"], arm)
    return {"do": put.do, "with": given}


def _require_kernel(do: str, arm: Arm) -> None:
    kernel = _NEEDS.get(do)
    if kernel is not None:
        require_kernel(kernel, arm)


def _require_range(given: Mapping[str, Any], arm: Arm) -> None:
    """Indices within their counts, lists of the right length, a quaternion that is one."""
    rows = arm.form.pattern.branches if arm.form is not None else 0
    for name, count in (("joint", arm.robot.n), ("branch", rows), ("ticks", MOST_TICKS + 1)):
        if name in given and not 0 <= given[name] < count:
            raise InputError("session.index", value=given[name], most=count - 1)
    for name, count in (("values", arm.robot.n), ("wrench", 6)):
        if name in given and len(given[name]) != count:
            raise InputError("session.count", got=len(given[name]), wanted=count)
    if "quaternion" in given:
        pose_from(given["position"], given["quaternion"])


_NEEDS = {
    "reach": "branches",
    "choose": "branches",
    "swing": "branches",
    "search": "pose_step",
    "loop": "closed_loop",
    "simulate": "closed_loop",
}
"""Kernels without which there is no such action."""


def _arguments() -> dict[str, type[msgspec.Struct]]:
    """Of every action its arguments as a type, from the signature of its method."""
    found: dict[str, type[msgspec.Struct]] = {}
    for name, method in ACTIONS.items():
        hints = typing.get_type_hints(method)
        fields = [(one, _TYPES[hints[one]]) for one in list(signature(method).parameters)[1:]]
        found[name] = msgspec.defstruct(name, fields, forbid_unknown_fields=True, frozen=True)
    return found


_TYPES: dict[Any, Any] = {int: int, float: float, bool: bool, Sequence[float]: Numbers}
_ARGUMENTS = _arguments()
_DECODERS: dict[Any, msgspec.json.Decoder[Any]] = {}


def _decoder(kind: Any) -> msgspec.json.Decoder[Any]:
    if kind not in _DECODERS:
        _DECODERS[kind] = msgspec.json.Decoder(kind)
    return _DECODERS[kind]
