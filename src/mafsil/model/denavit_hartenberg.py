"""Denavit-Hartenberg tables as data, in the two usual conventions, and the mechanism they describe.

Modified (proximal; Craig, Lynch & Park app. C): frame {i} sits on the axis of joint i,
    T_i-1,i = Rot(x, alpha_i-1) Trans(x, a_i-1) Trans(z, d_i) Rot(z, theta_i);
    row i holds alpha_i-1, a_i-1, d_i, theta_i.
Classic (distal; Paul, Corke, Spong): frame {i} sits at the far end of link i, on the axis of joint i+1,
    T_i-1,i = Rot(z, theta_i) Trans(z, d_i) Trans(x, a_i) Rot(x, alpha_i).

Hayati's parameters for neighbouring axes that are nearly parallel, where Denavit-Hartenberg numbers run away.

T_i-1,i = Rot(z, theta) Trans(x, a) Rot(x, alpha) Rot(y, beta): the origin of {i} stays in the x-y plane of {i-1}, and
small tilts of the axis give small alpha and beta. Useless where the axes are at right angles.

Reference: S. Hayati, M. Mirmirani, Improving the absolute positioning accuracy of robot manipulators, J. Robotic
Systems 2(4), 1985.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import radians
from typing import Any, Literal, TypeAlias, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, as_batch, number
from mafsil.errors import InputError, InputWarning, ModelError, warn
from mafsil.fields import check_fields
from mafsil.model.diagnostics import Diagnostic
from mafsil.model.exponentials import ArmParts, JointPlace, serial_arm
from mafsil.model.faults import DH_DEGREES
from mafsil.model.joint import JointKind
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import checked_pose, inverse, rotation_x, rotation_y, rotation_z, translation
from mafsil.model.tolerances import WRITTEN

STEEPEST = 0.1
"""Smallest cosine of the angle between the axes for which the parameters are offered."""
TURN, MOST_DEGREES = 6.3, 720.0
"""Angles [rad] between which a whole number is taken for degrees."""


class Convention(Enum):
    """Where a Denavit-Hartenberg table puts its frames."""

    MODIFIED = "modified"
    CLASSIC = "classic"


@dataclass(frozen=True, slots=True)
class DHRow:
    """One joint of a table.

    Attributes:
        a, alpha: link length [m] and twist [rad]; in the modified convention those of the link before.
        d, theta: link offset [m] and joint angle [rad] at q = 0.
        kind: `R` (q adds to theta) or `P` (q adds to d).
        offset: added to q: theta + offset + q, or d + offset + q.
    """

    a: float = 0.0
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    kind: Literal["R", "P"] = "R"
    offset: float = 0.0
    __post_init__ = check_fields(a=number, alpha=number, d=number, theta=number, offset=number)

    def transform(self, convention: Convention | str, q: float = 0.0) -> PoseMatrix:
        """(4, 4) link transform T_i-1,i at the joint coordinate q [rad | m]."""
        turn = self.theta + (self.offset + q if self.kind == "R" else 0.0)
        length = self.d + (self.offset + q if self.kind == "P" else 0.0)
        along_x = rotation_x(self.alpha) @ translation(self.a, 0.0, 0.0)
        along_z = rotation_z(turn) @ translation(0.0, 0.0, length)
        return along_x @ along_z if convention_of(convention) is Convention.MODIFIED else along_z @ along_x


DHRowLike: TypeAlias = DHRow | Sequence[float | str] | Mapping[str, float | str]
"""A row of a table: itself, plain numbers in the order of the columns, or numbers by name."""
COLUMNS = ("a", "alpha", "d", "theta", "kind", "offset")
"""What the numbers of a plain row are, in the order of `DHRow`; those at the end may be left out."""


def dh_rows(
    rows: Sequence[DHRowLike], *, columns: Sequence[str] | None = None, degrees: bool = False
) -> tuple[DHRow, ...]:
    """The rows of a table as people write them.

    Args:
        rows: one per joint: a `DHRow`, plain numbers such as `[0.3, 0, 0, 0]`, or a mapping such as `{"a": 0.3}`.
        columns: what the plain numbers are, such as `("theta", "d", "a", "alpha")`; `COLUMNS` if None.
        degrees: alpha and theta, and the offset of a revolute joint, are degrees.

    Warns:
        InputWarning: an angle beyond a whole turn although radians are meant.

    Raises:
        InputError: a row that is none of these, too long or too short, or with an unknown name.
        ModelError: a row that is neither R nor P, or not finite.
    """
    if isinstance(cast(object, rows), str | Mapping) or not hasattr(rows, "__len__"):
        raise InputError("dh.rows", got=type(rows).__name__)
    names = tuple(COLUMNS if columns is None else columns)
    if set(names) - set(COLUMNS) or len(set(names)) < len(names):
        raise InputError("input.choice", name="columns", value=", ".join(map(str, names)), known=", ".join(COLUMNS))
    found = tuple(_row(i, row, names) for i, row in enumerate(rows, start=1))
    _require_rows(found)
    if degrees:
        found = tuple(_from_degrees(row) for row in found)
    else:
        _remark_degrees(found)
    return found


def _row(i: int, row: DHRowLike, names: tuple[str, ...]) -> DHRow:
    if isinstance(row, DHRow):
        return row
    given: dict[str, Any] = {}
    if isinstance(row, Mapping):
        given = dict(row)
    elif hasattr(cast(object, row), "__len__") and not isinstance(cast(object, row), str):
        least = min(4, len(names))
        if not least <= len(row) <= len(names):
            raise InputError("dh.row_length", row=i, got=len(row), columns=", ".join(names))
        given = dict(zip(names, row, strict=False))
    else:
        raise InputError("dh.row", row=i, got=type(row).__name__)
    for name, value in given.items():
        if name not in COLUMNS:
            raise InputError("dh.row_name", row=i, name=name, known=", ".join(COLUMNS))
        if name != "kind":
            given[name] = number(f"rows[{i - 1}].{name}", value)
    if isinstance(kind := given.get("kind"), str):
        given["kind"] = _LETTERS.get(kind.lower(), kind)
    return DHRow(**given)


def _from_degrees(row: DHRow) -> DHRow:
    offset = radians(row.offset) if row.kind == "R" else row.offset
    return replace(row, alpha=radians(row.alpha), theta=radians(row.theta), offset=offset)


def _remark_degrees(rows: Sequence[DHRow]) -> None:
    """One warning about angles that look like degrees."""
    remark = next(_in_degrees(rows), None)
    if remark is not None:
        row, entry, value = (remark.details[name] for name in ("row", "entry", "value"))
        warn(InputWarning("dh.degrees", row=row, field=entry, value=value))


def mechanism_from_dh(
    rows: Sequence[DHRowLike],
    convention: Convention | str,
    *,
    columns: Sequence[str] | None = None,
    degrees: bool = False,
    base: ArrayLike | None = None,
    tool: ArrayLike | None = None,
    **parts: Unpack[ArmParts],
) -> Mechanism:
    """The serial arm T_s,tip(q) = base T_01(q_1) ... T_n-1,n(q_n) tool.

    Frames of the links: modified tables, frame {i} of the table. Classic tables, frame {i-1} moving with link i,
    because the frame of a link lies on the axis that moves it; `frames_in_links` gives the table's {i} in it.

    Args:
        rows: n of them, from the base: `DHRow`, plain numbers or mappings, see `dh_rows`.
        convention: `modified` or `classic`.
        columns, degrees: of plain rows, see `dh_rows`.
        base: (4, 4) pose of {0} in the space frame; identity by default.
        tool: (4, 4) pose of the tip in {n}; identity by default.
        **parts: name, inertials (those of link i in frame {i} of the table, in either convention), limits,
            actuators, frictions, joint_names, link_names, gravity, provenance: see `ArmParts`.

    Raises:
        ModelError: no rows, a row that is neither R nor P or is not finite, an unknown convention, a list of another
            length, a base or tool that is no pose.
        InputError: base, tool or gravity has another shape or is not finite.
    """
    table = dh_rows(rows, columns=columns, degrees=degrees)
    homes, within = _place(table, convention_of(convention))
    provenance = parts.get("provenance") or Provenance()
    parts["provenance"] = replace(provenance, remarks=(*provenance.remarks, *_in_degrees(table)))
    return serial_arm(
        [JointPlace(_KINDS[row.kind], T_pj, T_li) for row, T_pj, T_li in zip(table, homes, within, strict=True)],
        base=base,
        T_lt=within[-1] if tool is None else within[-1] @ checked_pose("tool", tool),
        **parts,
    )


def _in_degrees(rows: Sequence[DHRow]) -> Iterator[Diagnostic]:
    """Remarks about angles that are whole degrees and more than a turn: radians are hardly ever typed so."""
    for k, row in enumerate(rows, start=1):
        angles = {"alpha": row.alpha, "theta": row.theta, **({"offset": row.offset} if row.kind == "R" else {})}
        for entry, value in angles.items():
            if TURN < abs(value) <= MOST_DEGREES and 2 * value == round(2 * value):
                yield Diagnostic(DH_DEGREES, 0, 0, {"row": k, "entry": entry, "value": value})


def frames_in_links(rows: Sequence[DHRow], convention: Convention | str) -> tuple[PoseMatrix, ...]:
    """The n poses (4, 4) of the table's frame {i} in the frame of link i of the mechanism, constant.

    Identity for modified tables; Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha) at q = 0 for classic ones.
    """
    return tuple(_place(rows, convention_of(convention))[1])


def convention_of(convention: Convention | str) -> Convention:
    """The convention of that name; Corke calls the classic one standard.

    Raises:
        ModelError: there is none; the sentence lists them.
    """
    try:
        return Convention.CLASSIC if convention == "standard" else Convention(convention)
    except ValueError:
        known = ", ".join(each.value for each in Convention)
        raise ModelError("dh.convention", value=convention, known=known) from None


def dh_parameters(T: PoseMatrix, tolerance: float = WRITTEN) -> DHRow | None:
    """The four modified parameters of a link transform, or None if it has none.

    A pose is a modified Denavit-Hartenberg link iff r_13 = 0 and (p_y, p_z) is parallel to (r_23, r_33).

    Args:
        T: (4, 4) pose of {i} in {i-1}.
        tolerance: of r_13 and of the distance that the parameters would leave [m].

    Reference: Denavit & Hartenberg, J. Applied Mechanics 22, 1955; Lynch & Park, Modern Robotics, app. C.
    """
    (r11, r12, r13, a), (_, _, r23, y), (_, _, r33, z) = as_batch("T", T, (4, 4), finite=True)[:3]
    if abs(r13) > tolerance or abs(y * r33 - z * r23) > tolerance:
        return None
    return DHRow(
        a=float(a),
        alpha=float(np.arctan2(-r23, r33)),
        d=float(r23 * y + r33 * z),
        theta=float(np.arctan2(-r12, r11)),
    )


_LETTERS: dict[str, str] = {"revolute": "R", "prismatic": "P", "r": "R", "p": "P"}
_KINDS = {"R": JointKind.REVOLUTE, "P": JointKind.PRISMATIC}


def _place(rows: Sequence[DHRow], convention: Convention) -> tuple[list[PoseMatrix], list[PoseMatrix]]:
    """For each joint the pose of its link frame in the link before, and of the table's {i} in its link, at q = 0."""
    transforms = [row.transform(convention) for row in rows]
    identity = np.eye(4)
    if convention is Convention.MODIFIED:
        return transforms, [identity] * len(rows)
    return [identity, *transforms[:-1]], transforms


def _require_rows(rows: Sequence[DHRow]) -> None:
    """At least one row, every one R or P."""
    if not rows:
        raise ModelError("dh.no_rows")
    for i, row in enumerate(rows, start=1):
        if row.kind not in _KINDS:
            raise ModelError("dh.kind", row=i, value=row.kind)


@dataclass(frozen=True, slots=True)
class HayatiRow:
    """One link between nearly parallel axes.

    Attributes:
        theta, alpha, beta: rotations about z, x and y [rad].
        a: length along x [m].
    """

    theta: float
    a: float
    alpha: float
    beta: float

    def transform(self, q: float = 0.0) -> PoseMatrix:
        """(4, 4) Rot(z, theta + q) Trans(x, a) Rot(x, alpha) Rot(y, beta)."""
        return (
            rotation_z(self.theta + q) @ translation(self.a, 0.0, 0.0) @ rotation_x(self.alpha) @ rotation_y(self.beta)
        )


def hayati_parameters(T: ArrayLike) -> tuple[HayatiRow, PoseMatrix]:
    """Hayati's row of a pose between two axes, and the motion about and along the second axis that is left.

    T = row.transform() Trans(z, d) Rot(z, phi), the rest being a change of frame on the second axis.

    Args:
        T: (4, 4) pose of a frame on the second axis in one on the first, z along the axes.

    Returns:
        The row and the (4, 4) rest.

    Raises:
        ModelError: the axes are too far from parallel, or T is no pose.
    """
    pose = checked_pose("T", T)
    z, p = pose[:3, 2], pose[:3, 3]
    if abs(z[2]) < STEEPEST:
        raise ModelError("dh.hayati", angle=float(np.degrees(np.arccos(np.clip(z[2], -1.0, 1.0)))))
    foot = p - z * (p[2] / z[2])
    a = float(np.hypot(foot[0], foot[1]))
    theta = float(np.arctan2(foot[1], foot[0])) if a > 0.0 else 0.0
    seen = rotation_z(theta)[:3, :3].T @ z
    beta = float(np.arcsin(np.clip(seen[0], -1.0, 1.0)))
    row = HayatiRow(theta, a, float(np.arctan2(-seen[1], seen[2])), beta)
    return row, inverse(row.transform()) @ pose
