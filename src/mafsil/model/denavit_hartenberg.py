"""Denavit-Hartenberg tables as data, in the two usual conventions, and the mechanism they describe.

Modified (proximal; Craig, Lynch & Park app. C): frame {i} sits on the axis of joint i,
    T_i-1,i = Rot(x, alpha_i-1) Trans(x, a_i-1) Trans(z, d_i) Rot(z, theta_i);
    row i holds alpha_i-1, a_i-1, d_i, theta_i.
Classic (distal; Paul, Corke, Spong): frame {i} sits at the far end of link i, on the axis of joint i+1,
    T_i-1,i = Rot(z, theta_i) Trans(z, d_i) Trans(x, a_i) Rot(x, alpha_i).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Literal, Unpack

import numpy as np

from mafsil.arrays import PoseMatrix, gate
from mafsil.errors import ModelError
from mafsil.model.diagnostics import Diagnostic
from mafsil.model.faults import DH_DEGREES
from mafsil.model.joint import JointKind
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import checked_pose, rotation_x, rotation_z, translation
from mafsil.model.serial import ArmParts, JointPlace, serial_arm

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

    def transform(self, convention: Convention | str, q: float = 0.0) -> PoseMatrix:
        """(4, 4) link transform T_i-1,i at the joint coordinate q [rad | m]."""
        turn = self.theta + (self.offset + q if self.kind == "R" else 0.0)
        slide = self.d + (self.offset + q if self.kind == "P" else 0.0)
        along_x = rotation_x(self.alpha) @ translation(self.a, 0.0, 0.0)
        along_z = rotation_z(turn) @ translation(0.0, 0.0, slide)
        return along_x @ along_z if convention_of(convention) is Convention.MODIFIED else along_z @ along_x


def mechanism_from_dh(
    rows: Sequence[DHRow],
    convention: Convention | str,
    *,
    base: PoseMatrix | None = None,
    tool: PoseMatrix | None = None,
    **parts: Unpack[ArmParts],
) -> Mechanism:
    """The serial arm T_s,tip(q) = base T_01(q_1) ... T_n-1,n(q_n) tool.

    Frames of the links: modified tables, frame {i} of the table. Classic tables, frame {i-1} moving with link i,
    because the frame of a link lies on the axis that moves it; `frames_in_links` gives the table's {i} in it.

    Args:
        rows: n rows, from the base.
        convention: `modified` or `classic`.
        base: (4, 4) pose of {0} in the space frame; identity by default.
        tool: (4, 4) pose of the tip in {n}; identity by default.
        **parts: name, inertials (those of link i in frame {i} of the table, in either convention), limits,
            actuators, frictions, joint_names, link_names, gravity, provenance: see `ArmParts`.

    Raises:
        ModelError: no rows, a row that is neither R nor P or is not finite, an unknown convention, a list of another
            length, a base or tool that is no pose.
        InputError: base, tool or gravity has another shape or is not finite.
    """
    _require_rows(rows)
    homes, within = _placed(rows, convention_of(convention))
    provenance = parts.get("provenance") or Provenance()
    parts["provenance"] = replace(provenance, remarks=(*provenance.remarks, *_in_degrees(rows)))
    return serial_arm(
        [JointPlace(_KINDS[row.kind], T_pj, T_li) for row, T_pj, T_li in zip(rows, homes, within, strict=True)],
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
    return tuple(_placed(rows, convention_of(convention))[1])


def convention_of(convention: Convention | str) -> Convention:
    """The convention of that name.

    Raises:
        ModelError: there is none; the sentence lists them.
    """
    try:
        return Convention(convention)
    except ValueError:
        known = ", ".join(each.value for each in Convention)
        raise ModelError("dh.convention", value=convention, known=known) from None


def dh_parameters(T: PoseMatrix, tolerance: float = 1e-9) -> DHRow | None:
    """The four modified parameters of a link transform, or None if it has none.

    A pose is a modified Denavit-Hartenberg link iff r_13 = 0 and (p_y, p_z) is parallel to (r_23, r_33).

    Args:
        T: (4, 4) pose of {i} in {i-1}.
        tolerance: of r_13 and of the distance that the parameters would miss [m].

    Reference: Denavit & Hartenberg, J. Applied Mechanics 22, 1955; Lynch & Park, Modern Robotics, app. C.
    """
    (r11, r12, r13, a), (_, _, r23, y), (_, _, r33, z) = gate("T", T, (4, 4), finite=True)[:3]
    if abs(r13) > tolerance or abs(y * r33 - z * r23) > tolerance:
        return None
    return DHRow(
        a=float(a),
        alpha=float(np.arctan2(-r23, r33)),
        d=float(r23 * y + r33 * z),
        theta=float(np.arctan2(-r12, r11)),
    )


_KINDS = {"R": JointKind.REVOLUTE, "P": JointKind.PRISMATIC}


def _placed(rows: Sequence[DHRow], convention: Convention) -> tuple[list[PoseMatrix], list[PoseMatrix]]:
    """For each joint the pose of its link frame in the link before, and of the table's {i} in its link, at q = 0."""
    transforms = [row.transform(convention) for row in rows]
    identity = np.eye(4)
    if convention is Convention.MODIFIED:
        return transforms, [identity] * len(rows)
    return [identity, *transforms[:-1]], transforms


def _require_rows(rows: Sequence[DHRow]) -> None:
    """At least one row, every one R or P with finite numbers."""
    if not rows:
        raise ModelError("dh.no_rows")
    for i, row in enumerate(rows, start=1):
        if row.kind not in _KINDS:
            raise ModelError("dh.kind", row=i, value=row.kind)
        for field in ("a", "alpha", "d", "theta", "offset"):
            if not np.isfinite(getattr(row, field)):
                raise ModelError("dh.finite", row=i, field=field, value=getattr(row, field))
