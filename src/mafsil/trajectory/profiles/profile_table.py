"""The table of time laws: what each costs in velocity, acceleration and jerk, and how smooth it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from mafsil.messages import say
from mafsil.messages.tables import in_notebook, number, table
from mafsil.trajectory.checks.continuity import continuity
from mafsil.trajectory.profiles.laws import LAWS

COLUMNS = ("profile", "velocity", "acceleration", "jerk", "continuous")


@dataclass(frozen=True, slots=True)
class Profile:
    """One law from rest to rest.

    Attributes:
        name: in `LAWS`.
        velocity, acceleration, jerk: peaks of the motion over the distance 1 within 1 s: times D/T, D/T^2, D/T^3.
        order: of the highest derivative that is continuous, ends included: 0 if the velocity jumps, 1 if the
            acceleration does, 2 if the jerk does.
    """

    name: str
    velocity: float
    acceleration: float
    jerk: float
    order: int


@dataclass(frozen=True, slots=True, repr=False)
class ProfileTable:
    """All laws; iterable, printed as a table.

    Attributes:
        rows: one for each.
    """

    rows: tuple[Profile, ...]

    def __iter__(self) -> Iterator[Profile]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Profile:
        return {row.name: row for row in self.rows}[name]

    def __repr__(self) -> str:
        return self.explain()

    def explain(self, language: str | None = None) -> str:
        """The table."""
        head = [say(f"trajectory.column_{name}", language=language) for name in COLUMNS]
        rows = [[row.name, *map(number, (row.velocity, row.acceleration, row.jerk)), str(row.order)] for row in self]
        return "\n".join([say("trajectory.profiles", language=language), *table(head, rows, language)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {row.name: asdict(row) for row in self.rows}

    def _repr_html_(self) -> str:
        return in_notebook(self.explain())


def profiles() -> ProfileTable:
    """Peaks and smoothness of all laws of `LAWS`, for distance 1 and duration 1."""
    found: list[Profile] = []
    for name, law in LAWS.items():
        found.append(Profile(name, *law.peaks, continuity(law.unit()).order))
    return ProfileTable(tuple(found))
