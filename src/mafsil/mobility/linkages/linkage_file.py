"""Linkages in files: bodies and joints in TOML, one table [[joint]] for each joint.

    name = "four-bar"
    planar = true
    ground = "ground"
    output = "coupler"

    [[joint]]
    name = "A"
    kind = "revolute"          # or R; prismatic P, helical H, cylindrical C, universal U, spherical S, planar E, ...
    bodies = ["ground", "crank"]
    at = [0, 0]
    actuated = true
    child_at = [1, 2]          # where the child is drawn apart: the place on it that belongs in the joint

    [[coupling]]               # a gear, belt or cam
    follower = "D"
    leader = "A"
    ratio = -2.0               # or, of a cam, table = [[0, 0], [1, 0.02], ... [6.283185307179586, 0]]

    [[body]]                   # only `turn_crank` takes masses, loads and gravity: see `linkage_loads`
    name = "coupler"
    mass = 2.0

A pin through more than two bodies stands as one joint: it becomes coincident joints of neighbours.

Masses of the bodies of a linkage, forces on them, gravity; in its file the tables [[body]] and [[load]].

gravity = [0, -9.81]

[[body]]
name = "coupler"
mass = 2.0
center = [2.5, 2.5]        # of mass, where the body is drawn
inertia = 0.8              # about it: of the plane, or three or six numbers xx, yy, zz, xy, xz, yz

[[load]]
body = "rocker"
at = [4, 3]
force = [0, -100]          # and moment = [0, 0, 5]
follows = true             # the force turns with the body; else it keeps its direction
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, not_negative, real_array, single
from mafsil.errors import FileError, InputError, MafsilError, ModelError
from mafsil.fields import check_fields
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import Coupling, LinkageJoint, coincident_joints
from mafsil.toml_source import read_toml

GRAVITY = (0.0, 0.0, -9.81)
SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Rows and columns of the six numbers of an inertia."""
NOT_REAL = 1e-9
"""Share of its largest eigenvalue by which an inertia may be negative or break the triangle inequality: rounding."""
_KEYS = {"name", "planar", "ground", "output", "bodies", "joint", "coupling", "body", "load", "gravity"}
Made = TypeVar("Made")
_JOINT_KEYS = {"name", "kind", "bodies", "at", "axis", "second", "pitch", "actuated", "limits", "child_at"}


def read_linkage(path: str | Path) -> Linkage:
    """The linkage in a TOML file.

    Raises:
        FileError: missing, unreadable, malformed, unknown or missing keys; the sentence names the joint and the key.
        ModelError: joints that make no linkage.
    """
    data = read_toml(path)
    return parse_linkage(data, Path(path).name)


def is_linkage(data: object) -> bool:
    """Whether plain data describe a linkage: tables [[joint]] that name bodies."""
    table = _table(data)
    joints = None if table is None else table.get("joint")
    if not isinstance(joints, list):
        return False
    tables = [_table(entry) for entry in cast("list[object]", joints)]
    return any(entry is not None and "bodies" in entry for entry in tables)


def parse_linkage(data: object, source: str) -> Linkage:
    """The linkage in plain data; errors name the joint by its place.

    Args:
        data: as read from TOML.
        source: name for errors.
    """
    table = _table(data)
    entries = None if table is None else table.get("joint")
    if table is None or not isinstance(entries, list) or not entries:
        raise FileError("mobility.file_no_joints", path=source)
    _known(table, _KEYS, source, "")
    joints = [one for k, entry in enumerate(cast("list[Any]", entries)) for one in _joints(entry, k, source)]
    for key, kind in (("planar", bool), ("ground", str), ("output", str), ("name", str), ("bodies", list)):
        if key in table and not isinstance(table[key], kind):
            raise FileError("mobility.file_value", path=source, place=key, expected=kind.__name__)
    return Linkage.of(
        joints, name=table.get("name", Path(source).stem), ground=table.get("ground", "ground"),
        output=table.get("output"), planar=table.get("planar", False), bodies=table.get("bodies"),
        couplings=_values(
            table.get("coupling", []), "coupling", {"follower": str, "leader": str}, ("ratio", "table"), Coupling,
            source,
        ),
    )  # fmt: skip


def read_loads(path: str | PathLike[str]) -> LinkageLoads:
    """Masses, loads and gravity in the TOML file of a linkage; none in other files.

    Raises:
        FileError: as `read_linkage`; the sentence names the body and the key.
    """
    data = read_toml(path)
    return parse_loads(data, Path(path).name)


def parse_loads(data: dict[str, Any], source: str) -> LinkageLoads:
    """Masses, loads and gravity in plain data.

    Args:
        data: as read from TOML.
        source: name for errors.
    """
    masses = _values(
        data.get("body", []), "body", {"name": str, "mass": object}, ("center", "inertia"), BodyMass, source
    )
    loads = _values(data.get("load", []), "load", {"body": str}, ("at", "force", "moment", "follows"), BodyLoad, source)
    gravity = {"gravity": data["gravity"]} if "gravity" in data else {}
    try:
        return LinkageLoads(masses, loads, **gravity)
    except MafsilError as error:
        raise FileError("mobility.file_joint", path=source, place="gravity", reason=_Reason(error)) from None


def _values(
    given: object, title: str, needed: dict[str, type], more: tuple[str, ...], make: Callable[..., Made], source: str
) -> list[Made]:
    """What tables [[title]] describe, each made of its keys.

    Args:
        given: list of tables.
        title: of the tables.
        needed: keys that must be there, and their kinds.
        more: other keys.
        make: takes the values, in the order of `needed`, and the others by name.
        source: name for errors.
    """
    found: list[Made] = []
    for k, entry in enumerate(cast("list[object]", given) if isinstance(given, list) else [None]):
        table, place = _table(entry), f"{title} {k + 1}"
        if table is None:
            raise FileError("mobility.file_value", path=source, place=place, expected="table")
        _known(table, {*needed, *more}, source, place)
        for key, kind in needed.items():
            if key not in table:
                raise FileError("mobility.file_missing", path=source, place=place, name=key)
            if not isinstance(table[key], kind):
                raise FileError("mobility.file_value", path=source, place=f"{place}: {key}", expected="name")
        if not isinstance(table.get("follows", False), bool):
            raise FileError("mobility.file_value", path=source, place=f"{place}: follows", expected="true or false")
        try:
            found.append(make(*(table[key] for key in needed), **{key: table[key] for key in more if key in table}))
        except MafsilError as error:
            raise FileError("mobility.file_joint", path=source, place=place, reason=_Reason(error)) from None
    return found


def _joints(entry: object, index: int, source: str) -> list[LinkageJoint]:
    table = _table(entry)
    place = f"joint {index + 1}"
    if table is None:
        raise FileError("mobility.file_value", path=source, place=place, expected="table")
    if isinstance(table.get("name"), str):
        place = f"{place} ({table['name']})"
    _known(table, _JOINT_KEYS, source, place)
    for key in ("kind", "bodies"):
        if key not in table:
            raise FileError("mobility.file_missing", path=source, place=place, name=key)
    bodies = table["bodies"]
    if not isinstance(bodies, list) or not all(isinstance(body, str) for body in cast("list[object]", bodies)):
        raise FileError("mobility.file_value", path=source, place=f"{place}: bodies", expected="list of names")
    for key, kinds, words in (
        ("actuated", bool, "true or false"),
        ("kind", str, "name"),
        ("pitch", (int, float), "number"),
    ):
        if key in table and not isinstance(table[key], kinds):
            raise FileError("mobility.file_value", path=source, place=f"{place}: {key}", expected=words)
    names = cast("list[str]", bodies)
    given = {key: table[key] for key in _JOINT_KEYS - {"name", "kind", "bodies"} if key in table}
    name = str(table.get("name", f"J{index + 1}"))
    if "limits" in given:
        given["limits"] = _two_numbers(given["limits"], source, f"{place}: limits")
    try:
        return list(coincident_joints(name, table["kind"], names, **given))
    except FileError:
        raise
    except MafsilError as error:
        raise FileError("mobility.file_joint", path=source, place=place, reason=_Reason(error)) from None


class _Reason:
    """The sentence of another error, in the language in which it is wanted."""

    def __init__(self, error: MafsilError) -> None:
        self.error = error

    def spoken(self, language: str | None = None) -> str:
        return self.error.message(language)


def _two_numbers(value: object, source: str, place: str) -> tuple[float, float]:
    pair = cast("list[object]", value) if isinstance(value, list) else []
    if len(pair) != 2 or any(isinstance(v, bool) or not isinstance(v, int | float) for v in pair):
        raise FileError("mobility.file_value", path=source, place=place, expected="[least, greatest]")
    low, high = cast("list[float]", pair)
    return float(low), float(high)


def _table(data: object) -> dict[str, Any] | None:
    return cast("dict[str, Any]", data) if isinstance(data, dict) else None


def _known(table: dict[str, Any], keys: set[str], source: str, place: str) -> None:
    for key in table:
        if key not in keys:
            where = f"{place}: " if place else ""
            raise FileError("mobility.file_key", path=source, place=where, name=key, known=", ".join(sorted(keys)))


def in_space(name: str, value: ArrayLike) -> Floats:
    """(3,) of two or three numbers, the third being zero."""
    given = real_array(name, value)
    return frozen(single(name, np.append(given, 0.0) if given.shape == (2,) else given, (3,)))


def _inertia(name: str, value: ArrayLike) -> Floats:
    """(3, 3) of one number about z, three principal ones, six, or all."""
    given = real_array(name, value)
    I = np.zeros((3, 3))
    if given.shape == (3, 3):
        I = given
    elif given.ndim == 0:
        # A lamina of the plane: no torque about x and y is asked for where it stays in it.
        I = np.diag([given / 2, given / 2, given]).astype(np.float64)
    elif given.shape in ((3,), (6,)):
        for (i, j), each in zip(SYMMETRIC, given.tolist(), strict=False):
            I[i, j] = I[j, i] = each
    else:
        raise InputError("input.shape", name=name, expected="(), (3,), (6,) or (3, 3)", got=given.shape, hint="")
    J = single(name, I, (3, 3))
    a, b, c = np.linalg.eigvalsh(J).tolist()
    if np.abs(J - J.T).max() > NOT_REAL * abs(c) or min(a, a + b - c) < -NOT_REAL * abs(c):
        raise InputError("mobility.inertia", name=name, principal=f"{a:.6g}, {b:.6g}, {c:.6g}")
    return frozen(J)


@dataclass(frozen=True, eq=False)
class BodyMass:
    """Mass of a body.

    Attributes:
        body: its name.
        mass: [kg].
        center: (3,) of mass, where the body is drawn; two numbers in the plane [m].
        inertia: (3, 3) about the center of mass, in the axes of the drawing [kg m^2]; one number is that about z.
    """

    body: str
    mass: float
    center: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: Floats = field(default_factory=lambda: frozen(np.zeros((3, 3))))
    __post_init__ = check_fields(mass=not_negative, center=in_space, inertia=_inertia)


@dataclass(frozen=True, eq=False)
class BodyLoad:
    """A force and a moment from outside on a body.

    Attributes:
        body: its name.
        force, moment: (3,) [N], [N m].
        at: (3,) point of the body at which the force acts, where it is drawn [m].
        follows: whether both turn with the body; else they keep their directions.
    """

    body: str
    force: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    at: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    moment: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    follows: bool = False
    __post_init__ = check_fields(force=in_space, at=in_space, moment=in_space)


@dataclass(frozen=True, eq=False)
class LinkageLoads:
    """What bears on a linkage.

    Attributes:
        masses, loads: of its bodies.
        gravity: (3,) acceleration [m/s^2].
    """

    masses: Sequence[BodyMass] = ()
    loads: Sequence[BodyLoad] = ()
    gravity: Floats = field(default_factory=lambda: frozen(GRAVITY))
    __post_init__ = check_fields(gravity=in_space)

    def __bool__(self) -> bool:
        return bool(len(self.masses) or len(self.loads))

    def require_bodies(self, linkage: Linkage) -> None:
        """Refuse masses and loads of bodies that a linkage has not.

        Raises:
            ModelError: the sentence names the body.
        """
        for each in (*self.masses, *self.loads):
            if each.body not in linkage.bodies:
                raise ModelError("mobility.no_such_body", body=each.body, known=", ".join(linkage.bodies))

    def displace(self, bodies: Sequence[str], T: Floats) -> LinkageLoads:
        """The same of bodies that are drawn elsewhere, displaced by T (N, 4, 4)."""

        def of(body: str) -> Floats:
            return T[bodies.index(body)]

        masses = [
            replace(
                each, center=of(each.body)[:3, :3] @ each.center + of(each.body)[:3, 3],
                inertia=of(each.body)[:3, :3] @ each.inertia @ of(each.body)[:3, :3].T,
            )
            for each in self.masses
        ]  # fmt: skip
        loads = [replace(each, at=of(each.body)[:3, :3] @ each.at + of(each.body)[:3, 3]) for each in self.loads]
        return replace(self, masses=masses, loads=loads)
