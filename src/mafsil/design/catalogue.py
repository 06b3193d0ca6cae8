"""Catalogues of drives: motors with their gears as a table, from CSV, TOML or plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.csv_table import read_csv_table
from mafsil.errors import FileError, InputError
from mafsil.fields import check_fields, finite
from mafsil.toml_source import read_toml

NUMBERS = ("peak_torque", "continuous_torque", "speed", "rotor_inertia", "ratio", "efficiency", "mass")


def _texts(name: str, value: Sequence[object]) -> tuple[str, ...]:
    return tuple(map(str, value))


_POSITIVE = finite(1, low=1e-40)
_AMOUNT = finite(1, low=0.0)


@dataclass(frozen=True, eq=False, slots=True)
class Catalogue:
    """Motors with their gears, K of them.

    Attributes:
        name: of each.
        peak_torque, continuous_torque, speed, rotor_inertia: of the motor [N m, N m, rad/s, kg m^2].
        ratio: turns of the motor for one of the joint.
        efficiency: of the gear.
        mass: of the whole drive [kg].
        backlash: at the joint [rad].
        cost: in any currency.
    """

    name: tuple[str, ...]
    peak_torque: Floats
    continuous_torque: Floats
    speed: Floats
    rotor_inertia: Floats
    ratio: Floats
    efficiency: Floats
    mass: Floats
    backlash: Floats
    cost: Floats
    _numbers = check_fields(
        name=_texts, peak_torque=_POSITIVE, continuous_torque=_POSITIVE, speed=_POSITIVE, rotor_inertia=_AMOUNT,
        ratio=_POSITIVE, efficiency=finite(1, low=1e-3, high=1.0), mass=_AMOUNT, backlash=_AMOUNT, cost=_AMOUNT,
    )  # fmt: skip

    def __post_init__(self) -> None:
        self._numbers()
        for field in fields(self)[1:]:
            if len(getattr(self, field.name)) != len(self.name) or not self.name:
                shape = getattr(self, field.name).shape
                raise InputError("input.shape", name=field.name, expected=(len(self.name),), got=shape, hint="")

    def __len__(self) -> int:
        return len(self.name)

    @classmethod
    def of(cls, source: str | PathLike[str] | Sequence[Mapping[str, Any]]) -> Catalogue:
        """From a CSV file with a heading, a TOML file of `[[drive]]` tables, or such tables themselves.

        Raises:
            FileError: no such file, a missing column or key, a cell that is no number.
            InputError: numbers out of range.
        """
        if isinstance(source, str | PathLike):
            path = Path(source)
            if path.suffix.lower() != ".toml":
                return cls._of_csv(path)
            rows, label = read_toml(path).get("drive", []), str(path)
        else:
            rows, label = source, "<table>"
        table = cast("Sequence[Mapping[str, Any]]", rows)
        for k, row in enumerate(table):
            for name in ("name", *NUMBERS):
                if name not in row:
                    raise FileError("design.missing_key", path=label, place=f"drive[{k}]", name=name)
        return cls(
            [row["name"] for row in table],  # type: ignore[arg-type]
            *([row[name] for row in table] for name in NUMBERS),  # type: ignore[arg-type]
            *([row.get(name, 0.0) for row in table] for name in ("backlash", "cost")),  # type: ignore[arg-type]
        )

    @classmethod
    def _of_csv(cls, path: Path) -> Catalogue:
        table = read_csv_table(path, fewest=1)
        places = {name: table.column(name) for name in ("name", *NUMBERS)}
        for name, place in places.items():
            if place is None:
                raise table.no_column(name)
        named = [cast("int", places[name]) for name in NUMBERS]
        columns = list(table.numbers(named).T)
        for name in ("backlash", "cost"):
            place = table.column(name)
            columns.append(np.zeros(len(table.rows)) if place is None else table.numbers([place])[:, 0])
        return cls(tuple(row[cast("int", places["name"])].strip() for row in table.rows), *columns)
