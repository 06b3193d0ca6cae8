"""What arms are made of: tubes and drives as bodies; catalogues of motors with gears from CSV, TOML or plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import inf, pi
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, Vector3, frozen, not_negative, number, positive
from mafsil.csv_table import read_csv_table
from mafsil.errors import FileError, InputError
from mafsil.fields import check_fields, finite
from mafsil.mechanics.inertial_parameters import parameters_of
from mafsil.model import Inertial
from mafsil.model.placement import frame_along, turned_tensor
from mafsil.toml_source import read_toml


@dataclass(frozen=True, slots=True)
class Material:
    """What a tube is made of.

    Attributes:
        density: [kg/m^3].
        young, shear: moduli [Pa].
        expansion: of a length, per kelvin [1/K].
    """

    density: float
    young: float
    shear: float
    expansion: float
    __post_init__ = check_fields(density=positive, young=positive, shear=positive, expansion=number)


MATERIALS = {
    "aluminium": Material(2700.0, 69e9, 26e9, 23.1e-6),
    "steel": Material(7850.0, 206e9, 80e9, 12.0e-6),
    "titanium": Material(4430.0, 114e9, 44e9, 8.6e-6),
    "carbon": Material(1600.0, 70e9, 5e9, 1.0e-6),
}
"""Handbook values: EN AW-6082, structural steel, Ti-6Al-4V; carbon fibre of mostly axial lay in epoxy, which varies."""


@dataclass(frozen=True, slots=True)
class Tube:
    """A round tube as section of a link.

    Attributes:
        outer, wall: diameter and thickness [m].
        material: what it is made of.
    """

    outer: float
    wall: float
    material: Material = MATERIALS["aluminium"]
    _numbers = check_fields(outer=positive, wall=positive)

    def __post_init__(self) -> None:
        self._numbers()
        if 2.0 * self.wall > self.outer:
            raise InputError("input.range", name="wall", value=self.wall, low=0.0, high=self.outer / 2.0)

    @property
    def area(self) -> float:
        """Of the section [m^2]."""
        return pi * self.wall * (self.outer - self.wall)

    @property
    def section(self) -> str:
        """Outer diameter and wall as drawings give them."""
        return f"{1e3 * self.outer:.4g} x {1e3 * self.wall:.4g} mm"

    @property
    def second_moment(self) -> float:
        """Of the area about a diameter [m^4]; the polar one is twice as large."""
        return pi / 64.0 * (self.outer**4 - (self.outer - 2.0 * self.wall) ** 4)

    def inertial(self, end: Vector3) -> Inertial:
        """Mass properties of the tube from the origin to `end` (3,)."""
        length = float(np.linalg.norm(end))
        mass, polar = self.material.density * self.area * length, 2.0 * self.second_moment / self.area
        across = mass * (polar / 2.0 + length**2 / 12.0)
        R = frame_along(end / length)
        return Inertial(mass, frozen(end / 2.0), turned_tensor(np.diag([across, across, mass * polar]), R))


@dataclass(frozen=True, slots=True)
class Drive:
    """Motor, gear and bearing of a joint as a body.

    Attributes:
        mass: [kg].
        radius, length: of the cylinder about the joint's axis [m].
        stiffness: of the gear, seen at the joint; infinite for a rigid one [N m/rad | N/m].
    """

    mass: float = 0.0
    radius: float = 0.0
    length: float = 0.0
    stiffness: float = inf
    __post_init__ = check_fields(
        mass=not_negative, radius=not_negative, length=not_negative,
        stiffness=lambda name, value: inf if value == inf else positive(name, value),
    )  # fmt: skip

    def parameters(self, R: Floats, p: Vector3, axis: Vector3) -> Floats:
        """(10,) inertial parameters in the frame in which the joint's frame has the pose (R, p)."""
        across = self.mass * (self.radius**2 / 4.0 + self.length**2 / 12.0)
        own = np.diag([across, across, self.mass * self.radius**2 / 2.0])
        turned = turned_tensor(own, R @ frame_along(axis))
        return parameters_of(Inertial(self.mass, frozen(p), turned))


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
