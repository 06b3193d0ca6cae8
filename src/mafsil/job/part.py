"""What all tables of a job file have in common: unknown keys are refused, numbers have ranges."""

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
