"""Parametric arms: a robot table whose numbers may be formulas of parameters, tubes as links, drives at the joints.

    convention = "modified"

    [parameters]
    upper = { value = 0.4, low = 0.2, high = 0.6 }   # free: it may be chosen between the bounds [m]
    payload_arm = 0.1                                # fixed

    [[joint]]
    alpha = 0.0
    tube = { outer = 0.1, wall = 0.005, material = "aluminium" }
    drive = { mass = 3.0, radius = 0.06, length = 0.1, stiffness = 2e4 }

    [[joint]]
    a = "2 * upper - 0.05"

Keys are those of robot tables (`mafsil.model.table`), and two more for each joint. The law of masses: the link behind a
joint is a straight tube from that joint's origin to the next one's, at the last joint to the tip; the drive of a joint
is a solid cylinder about its axis, centred at its origin, that the link before it carries. An `inertial` given too
is added: a casting by its own formula. Tubes and drives are in SI units whatever those of the table are.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from math import inf, isfinite, pi
from os import PathLike
from typing import Any, Protocol, cast

import numpy as np

from mafsil.arrays import Floats, frozen, number
from mafsil.design.parts import MATERIALS, Drive, Tube
from mafsil.errors import FileError, InputError
from mafsil.fields import check_fields
from mafsil.mechanics.inertial_parameters import inertial_of, parameters_of
from mafsil.model import Link, Mechanism
from mafsil.model.link import OUTLINE, Capsule, Shape
from mafsil.model.loading import RobotLike
from mafsil.model.placement import frame_along
from mafsil.model.table.building import mechanism_of
from mafsil.model.table.reading import table_of
from mafsil.robot import Robot, as_robot
from mafsil.toml_source import read_toml

NAMES = ("name", "link", "kind", "material")
"""Keys of a joint whose texts are no formulas."""
SHORTEST = 1e-9
"""Length [m] below which a link has no tube."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that a design may choose: its usual value and its bounds, in the units of the table."""

    value: float
    low: float
    high: float
    _numbers = check_fields(value=number, low=number, high=number)

    def __post_init__(self) -> None:
        self._numbers()
        if not self.low <= self.value <= self.high:
            raise InputError("input.range", name="value", value=self.value, low=self.low, high=self.high)


class Design(Protocol):
    """One robot of a family: what its evaluation has to know of it."""

    @property
    def robot(self) -> Any:
        """The robot itself."""
        ...

    @property
    def values(self) -> Mapping[str, float]:
        """Of the parameters."""
        ...

    @property
    def effort(self) -> Floats:
        """(n,) limits of the joints or motors; infinite where there are none [N m | N]."""
        ...

    @property
    def mass(self) -> float:
        """Of all its parts [kg]."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class ArmDesign:
    """One arm of the family: a robot, and what its links and joints are made of.

    Attributes:
        robot: with masses.
        values: of the parameters.
        tubes: of the link behind each joint, None for a rigid one.
        drives: of the joints, None where nothing is said.
    """

    robot: Robot
    values: Mapping[str, float]
    tubes: tuple[Tube | None, ...]
    drives: tuple[Drive | None, ...]

    @classmethod
    def of(cls, arm: ArmDesign | RobotLike) -> ArmDesign:
        """A design as it is; any robot as one: rigid links, rigid gears, masses as they are.

        Raises:
            ModelError: a robot with loops.
        """
        if isinstance(arm, ArmDesign):
            return arm
        robot = as_robot(arm)
        nothing = (None,) * len(robot.mechanism.joints)
        return cls(robot, {}, nothing, nothing)

    @property
    def stiffness(self) -> Floats:
        """(n,) of the joints; infinite for rigid ones [N m/rad | N/m]."""
        return np.array([inf if drive is None else drive.stiffness for drive in self.drives])

    @property
    def effort(self) -> Floats:
        """(n,) limits of the joints; infinite where there are none [N m | N]."""
        return np.asarray(self.robot.limits.effort)

    @property
    def mass(self) -> float:
        """Of all links, the base's too [kg]."""
        return sum((link.inertial.mass for link in self.robot.mechanism.links if link.inertial is not None), 0.0)


@dataclass(frozen=True, eq=False)
class Family:
    """Robots that differ in the values of parameters.

    Attributes:
        table: plain data with formulas.
        parameters: by name; those with bounds are free.
        name: of the file, for sentences.
    """

    table: Mapping[str, Any]
    parameters: Mapping[str, Parameter]
    name: str = "<table>"

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the parameters that have a range."""
        return tuple(name for name, each in self.parameters.items() if each.low < each.high)

    def choose(self, values: Mapping[str, float]) -> dict[str, float]:
        """All values, those that are not given being the usual ones.

        Raises:
            InputError: an unknown parameter, a value that is no number or out of its bounds.
        """
        chosen = {name: each.value for name, each in self.parameters.items()}
        for name, value in values.items():
            if name not in chosen:
                known = ", ".join(chosen) or "-"
                raise InputError("input.choice", name="parameter", value=name, known=known)
            chosen[name], bounds = number(name, value), self.parameters[name]
            if not bounds.low <= chosen[name] <= bounds.high:
                raise InputError("input.range", name=name, value=value, low=bounds.low, high=bounds.high)
        return chosen


def read_family(
    source: Mapping[str, Any] | str | PathLike[str], part: str
) -> tuple[dict[str, Any], dict[str, Parameter], str]:
    """Table, parameters and name of a family in a TOML file, there under `part` if it has that, or in a dictionary."""
    name = "<table>" if isinstance(source, Mapping) else str(source)
    table = dict(source if isinstance(source, Mapping) else read_toml(source))
    inner = table.get(part, table)
    if not isinstance(inner, Mapping):
        raise FileError("design.no_part", path=name, name=part)
    table = dict(cast("Mapping[str, Any]", inner))
    given = table.pop("parameters", {})
    if not isinstance(given, Mapping):
        raise FileError("design.parameters", path=name)
    return table, {key: _parameter(name, key, value) for key, value in cast("Mapping[str, Any]", given).items()}, name


@dataclass(frozen=True, eq=False)
class ParametricArm(Family):
    """A family of arms; its table is a robot table with formulas."""

    @classmethod
    def of(cls, source: Mapping[str, Any] | str | PathLike[str]) -> ParametricArm:
        """The arm of a TOML file, or of the same keys in a dictionary.

        Args:
            source: with `parameters`, `convention` and `joint` (in a file of a design: under `arm`).

        Raises:
            FileError: no such file, an unknown key, a value of the wrong kind, a formula that is none.
            ModelError: the numbers make no arm.
        """
        arm = cls(*read_family(source, "arm"))
        arm.at()
        return arm

    def at(self, **values: float) -> ArmDesign:
        """The design with these values; the others have their usual ones.

        Raises:
            InputError: an unknown parameter, a value that is no number or out of its bounds.
        """
        return self._build(self.choose(values))

    def robot(self, **values: float) -> Robot:
        """The robot with these values of the parameters; the others have their usual ones."""
        return self.at(**values).robot

    def _build(self, values: Mapping[str, float]) -> ArmDesign:
        table = cast("dict[str, Any]", numbers_in(dict(self.table), values, self.name))
        joints = table.get("joint", [])
        joints = cast("list[Any]", joints) if isinstance(joints, list) else []
        parts = [
            (_part(Tube, joint, "tube", k, self.name), _part(Drive, joint, "drive", k, self.name))
            for k, joint in enumerate(cast("list[dict[str, Any]]", [one for one in joints if isinstance(one, dict)]))
        ]
        bare = mechanism_of(table_of(table, "", self.name))
        tubes, drives = (tuple(pair[k] for pair in parts) for k in range(2))
        robot = Robot(_with_masses(bare, tubes, drives))
        return ArmDesign(robot, values, tubes, drives)


def _with_masses(arm: Mechanism, tubes: Sequence[Tube | None], drives: Sequence[Drive | None]) -> Mechanism:
    """The arm with its tubes and drives as mass properties and outlines."""
    ends = [*(joint.T_pj for joint in arm.joints), arm.T_lt]
    links = list[Link]()
    for k, link in enumerate(arm.links):
        total, shapes = parameters_of(link.inertial), list[Shape]()
        tube, end = tubes[k - 1] if k else None, np.asarray(ends[k][:3, 3])
        length = float(np.linalg.norm(end))
        if tube is not None and length > SHORTEST:
            total = total + parameters_of(tube.inertial(end))
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = frame_along(end / length), end / 2.0
            shapes.append(Shape(Capsule(tube.outer / 2.0, length), frozen(T), OUTLINE))
        if k < len(drives) and (drive := drives[k]) is not None:
            total = total + drive.parameters(ends[k][:3, :3], end, np.asarray(arm.joints[k].axis))
        inertial = inertial_of(total) if total[0] else link.inertial
        links.append(replace(link, inertial=inertial, collisions=(*link.collisions, *shapes)))
    return replace(arm, links=tuple(links))


def _parameter(path: str, name: str, given: Any) -> Parameter:
    place = f"parameters.{name}"
    if not isinstance(given, Mapping):
        value = _real(path, place, given)
        return Parameter(value, value, value)
    entries = cast("Mapping[str, Any]", given)
    require_keys(path, place, entries, ("value", "low", "high"), ("value",))
    value = _real(path, place, entries["value"])
    return Parameter(value, *(_real(path, place, entries.get(end, value)) for end in ("low", "high")))


def _part(kind: type[Any], joint: dict[str, Any], key: str, k: int, path: str) -> Any:
    """A tube or drive of a joint, taken out of its table; None if it has none."""
    given = joint.pop(key, None)
    if given is None:
        return None
    place, names = f"joint[{k}].{key}", tuple(field.name for field in fields(kind))
    if not isinstance(given, dict):
        raise FileError("design.no_table", path=path, place=place)
    entries = cast("dict[str, Any]", given)
    require_keys(path, place, entries, names, ("outer", "wall") if kind is Tube else ())
    material = entries.pop("material", None)
    if material is not None and material not in MATERIALS:
        raise FileError("design.material", path=path, place=place, value=material, known=", ".join(MATERIALS))
    found: dict[str, Any] = {name: _real(path, f"{place}.{name}", value) for name, value in entries.items()}
    if material is not None:
        found["material"] = MATERIALS[material]
    return kind(**found)


def require_keys(path: str, place: str, given: Mapping[str, Any], known: Sequence[str], needed: Sequence[str]) -> None:
    """Refuse tables with unknown keys, or without some that are needed.

    Raises:
        FileError: such a table.
    """
    for name in given:
        if name not in known:
            raise FileError("design.unknown_key", path=path, place=f"{place}.{name}", known=", ".join(known))
    for name in needed:
        if name not in given:
            raise FileError("design.missing_key", path=path, place=place, name=name)


def _real(path: str, place: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
        raise FileError("design.no_number", path=path, place=place, value=str(value)[:40])
    return float(value)


def numbers_in(value: Any, names: Mapping[str, float], path: str, place: str = "") -> Any:
    """Plain data with formulas replaced by their values: texts of joints, base, tool and home, but for names."""
    if isinstance(value, dict):
        entries = cast("dict[str, Any]", value)
        return {
            key: inner if key in NAMES or (not place and key not in ("joint", "base", "tool", "home"))
            else numbers_in(inner, names, path, f"{place}.{key}" if place else key)
            for key, inner in entries.items()
        }  # fmt: skip
    if isinstance(value, list):
        return [numbers_in(inner, names, path, f"{place}[{k}]") for k, inner in enumerate(cast("list[Any]", value))]
    if not isinstance(value, str):
        return value
    try:
        result = float(_value(_tree(value), names))
    except KeyError as unknown:
        raise FileError(
            "design.unknown_parameter", path=path, place=place, name=unknown.args[0], known=", ".join(names) or "-"
        ) from None
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError, MemoryError):
        raise FileError("design.formula", path=path, place=place, formula=value[:60]) from None
    if not isfinite(result):
        raise FileError("design.formula", path=path, place=place, formula=value[:60])
    return result


@lru_cache(maxsize=1024)
def _tree(formula: str) -> ast.expr:
    if len(formula) > 200:
        raise ValueError
    return ast.parse(formula.strip(), mode="eval").body


_SIGNS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: float.__add__, ast.Sub: float.__sub__, ast.Mult: float.__mul__, ast.Div: float.__truediv__,
    ast.Pow: float.__pow__, ast.USub: float.__neg__, ast.UAdd: float.__pos__,
}  # fmt: skip


def _value(node: ast.expr, names: Mapping[str, float]) -> Any:
    """Of a formula of numbers, names, signs and parentheses; nothing else is evaluated."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case ast.Name(id=name):
            return pi if name == "pi" and name not in names else float(names[name])
        case ast.UnaryOp(op=sign, operand=inner) if type(sign) in _SIGNS:
            return _SIGNS[type(sign)](_value(inner, names))
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in _SIGNS:
            return _SIGNS[type(sign)](_value(left, names), _value(right, names))
        case _:
            raise ValueError
