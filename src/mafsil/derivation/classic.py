"""Classic Denavit-Hartenberg tables in derivations: frame {i} at the far end of link i, on the axis of joint i + 1.

Inside, the angles are added in the modified table that holds the same numbers one row further down; its frames {i},
on the axis of joint i, become those of the classic table by Trans(x, a_i) Rot(x, alpha_i).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.derivation.tolerances import ROUNDOFF
from mafsil.model import JointKind, Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRow
from mafsil.model.dh_from_axes import DHTable, Relation
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.placement import rotation_x, translation


def typed_classic(mechanism: Mechanism) -> DHTable | None:
    """The classic table from which a mechanism was made, as it was typed; None if it was made otherwise.

    `mechanism_from_dh` puts the frame of link i on the axis that moves it, so the first joint stands at the identity
    and every later one at Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha) of the row before. An arm that is a
    modified table as well, such as one in a plane, counts as that.

    Args:
        mechanism: any.
    """
    joints = chain_to_tip(mechanism)
    plain = all(
        joint.kind in (JointKind.REVOLUTE, JointKind.PRISMATIC) and np.array_equal(joint.axis, (0.0, 0.0, 1.0))
        for joint in joints
    )
    if not joints or not plain or not np.array_equal(joints[0].T_pj, np.eye(4)):
        return None
    places = [np.asarray(joint.T_pj) for joint in joints[1:]]
    rows = [_classic_row(T) for T in places]
    if any(row is None for row in rows) or all(_is_modified(T) for T in places):
        return None
    last = _classic_row(np.asarray(mechanism.T_lt))
    tool = np.eye(4) if last is not None else np.asarray(mechanism.T_lt)
    found = [row for row in (*rows, last or DHRow()) if row is not None]
    letters: tuple[Literal["R", "P"], ...] = tuple("R" if joint.kind is JointKind.REVOLUTE else "P" for joint in joints)
    kinds = [replace(row, kind=kind) for row, kind in zip(found, letters, strict=True)]
    relations: tuple[Relation, ...] = ()
    return DHTable(tuple(kinds), Convention.CLASSIC, np.asarray(mechanism.T_sb), tool, relations, 0.0)


def modified_core(table: DHTable) -> DHTable:
    """The modified table of the same frames: lengths and twists one row further down, the last ones in the tool.

    Args:
        table: classic.
    """
    before = (DHRow(), *table.rows[:-1])
    rows = tuple(replace(row, a=b.a, alpha=b.alpha) for row, b in zip(table.rows, before, strict=True))
    last = table.rows[-1]
    tool = translation(last.a, 0.0, 0.0) @ rotation_x(last.alpha) @ table.tool
    return replace(table, rows=rows, tool=tool, convention=Convention.MODIFIED)


def _classic_row(T: PoseMatrix) -> DHRow | None:
    """The four classic parameters of a pose: r_31 = 0, and (p_x, p_y) along (r_11, r_21)."""
    (r11, _, _, x), (r21, _, _, y), (r31, r32, r33, z) = T[:3]
    if abs(r31) > ROUNDOFF or abs(x * r21 - y * r11) > ROUNDOFF:
        return None
    return DHRow(
        a=float(r11 * x + r21 * y), alpha=float(np.arctan2(r32, r33)), d=float(z), theta=float(np.arctan2(r21, r11))
    )


def _is_modified(T: PoseMatrix) -> bool:
    """Whether a pose is a modified link as well: r_13 = 0 and (p_y, p_z) along (r_23, r_33)."""
    return abs(T[0, 2]) <= ROUNDOFF and abs(T[1, 3] * T[2, 2] - T[2, 3] * T[1, 2]) <= ROUNDOFF
