"""What tables of a job file have in common: unknown keys are refused, numbers have ranges, signals have conditions.

Signals pass between an arm and its cell: outputs that the job sets, inputs that the cell gives. Field names are the
keys of the file.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

Positive: TypeAlias = Annotated[float, msgspec.Meta(ge=1e-9)]
NotNegative: TypeAlias = Annotated[float, msgspec.Meta(ge=0)]
Share: TypeAlias = Annotated[float, msgspec.Meta(ge=1e-6, le=1)]
Three: TypeAlias = tuple[float, float, float]
Four: TypeAlias = tuple[float, float, float, float]
Six: TypeAlias = tuple[float, float, float, float, float, float]


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of the job file; unknown keys are refused."""


def keys_of(kind: type[Part]) -> dict[str, str]:
    """The keys of a table as they are typed -> the names of its fields; they differ where Python keeps a word."""
    return dict(zip(kind.__struct_encode_fields__, kind.__struct_fields__, strict=True))


class Pose(Part, frozen=True, kw_only=True):
    """A pose of the tip in {s}: position [m] and one of rpy [rad, or degrees] and quaternion (w, x, y, z)."""

    position: Three
    rpy: Three | None = None
    quaternion: Four | None = None


SHORTEST_EVERY = 0.01
"""Least time after which an input begins again [s]."""
SignalValue: TypeAlias = bool | float
"""Of a digital signal, or of an analogue one or a group."""


class Between(Part, frozen=True, kw_only=True):
    """A condition on a number: above and below, or one of them; the bounds do not count."""

    above: float | None = None
    below: float | None = None

    def holds(self, value: float) -> bool:
        """Whether a number is between them."""
        return (self.above is None or value > self.above) and (self.below is None or value < self.below)


Condition: TypeAlias = bool | float | Between
"""What is waited for: a value, or bounds."""
Test: TypeAlias = bool | float | Between | str
"""What is asked of a signal or a variable before moves are made; texts of variables alone."""


class Fork(msgspec.Struct, frozen=True, kw_only=True):
    """Where the way through the moves of a job divides.

    Attributes:
        tests: of signals and variables, all of them.
        skip: moves that are passed over where they do not all hold; the next one follows where they do.
        other: whether there are moves of the other way.
        loop: whether it is the round of a loop that begins here.
    """

    tests: dict[str, Test]
    skip: int
    other: bool = False
    loop: bool = False


class Input(Part, frozen=True, kw_only=True):
    """What the cell gives to the controller, as the simulation knows it: a table over time, or an answer to an output.

    Attributes:
        start: value at the beginning.
        changes: times [s] and new values, in order.
        every: after which the table begins again [s]; never if None.
        follows: an output of which it has the value.
        after: so much later [s].
    """

    start: SignalValue = False
    changes: tuple[tuple[NotNegative, SignalValue], ...] = ()
    every: Annotated[float, msgspec.Meta(ge=SHORTEST_EVERY)] | None = None
    follows: str | None = None
    after: NotNegative = 0.0


class PathOutput(Part, frozen=True, kw_only=True):
    """Outputs that take values while a move is under way: at exactly one of share, distance and after.

    Attributes:
        share: of the length of the tip's path.
        distance: along that path from its start; from its end if negative [m].
        after: the start of the move [s].
        set: values that outputs take.
    """

    share: Annotated[float, msgspec.Meta(ge=0, le=1)] | None = None
    distance: float | None = None
    after: NotNegative | None = None
    set: dict[str, SignalValue]
