"""Descriptions of an arm by its joint axes: its screws, forward kinematics as products of exponentials, and DH tables.

T = exp([S_1] q_1) ... exp([S_k] q_k) home exp([B_k+1] q_k+1) ... exp([B_n] q_n) for every k, the place of the home pose
in the chain: k = n is the space form, k = 0 the body form. T^-1 = exp(-[B_n] q_n) ... exp(-[B_1] q_1) home^-1.

In a Denavit-Hartenberg table found from the axes, frame {i} sits on axis i, x_i along the common normal from axis i to
axis i+1. Where axes are parallel, meet or coincide the normal is not unique; the choices made here are those that zero
the most parameters, and every pair says its `Relation`, so that a reader sees which numbers are forced and which were
chosen.

Reference: Denavit & Hartenberg, J. Applied Mechanics 22, 1955; Lynch & Park, Modern Robotics, app. C.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import Literal, NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, Vector6, as_batch, whole
from mafsil.errors import ModelError
from mafsil.model.denavit_hartenberg import Convention, DHRow, convention_of, dh_parameters, mechanism_from_dh
from mafsil.model.exponentials import ArmParts, Screws, chain_to_tip, mechanism_from_screws
from mafsil.model.joint import JointKind
from mafsil.model.loading import RobotLike, as_mechanism, of_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import adjoint, frame_along, inverse, rotation_x, screw_motion, translation
from mafsil.model.tolerances import PARALLEL, ROUNDED_TURN, WRITTEN


class Relation(Enum):
    """How two neighbouring axes lie, and what that leaves free."""

    SKEW = "skew"
    """One common normal: nothing free."""
    INTERSECTING = "intersecting"
    """x along one of the two directions normal to both axes: the sign of alpha is chosen."""
    PARALLEL = "parallel"
    """Any common normal serves: the one at the foot of the normal before was chosen, so that d is zero."""
    COLLINEAR = "collinear"
    """x and origin free: taken over from the frame before."""


@dataclass(frozen=True, eq=False, slots=True)
class DHTable:
    """A table with the constant poses around it.

    Attributes:
        rows: n rows.
        convention: of the rows.
        base, tool: (4, 4) pose of {0} in {s} and of the tip in {n}.
        relations: n - 1, of axes 1 and 2, 2 and 3, ...
        residual: largest difference between an entry of a screw or of the home pose and what the table gives.
    """

    rows: tuple[DHRow, ...]
    convention: Convention
    base: PoseMatrix
    tool: PoseMatrix
    relations: tuple[Relation, ...]
    residual: float

    def mechanism(self, **parts: Unpack[ArmParts]) -> Mechanism:
        """The arm of the table; `parts` as in `mechanism_from_dh`."""
        return mechanism_from_dh(self.rows, self.convention, base=self.base, tool=self.tool, **parts)


@of_mechanism
def dh_from_mechanism(
    mechanism: Mechanism, convention: Convention | str = "modified", *, flipped: Collection[int] = ()
) -> DHTable:
    """The table of the chain to the tip; see `dh_from_screws`.

    Raises:
        ModelError: a mimic or helical joint on the chain, or no joint at all.
    """
    found = screws(mechanism)
    return dh_from_screws(found.S_s, found.home, convention, flipped=flipped)


def dh_from_screws(
    S_s: ArrayLike, home: ArrayLike, convention: Convention | str = "modified", *, flipped: Collection[int] = ()
) -> DHTable:
    """Base pose, table and tool pose with base T_01(q_1) ... T_n-1,n(q_n) tool = exp([S_1] q_1) ... home.

    {0} is {1} at q = 0; the origin of {n} is the point of axis n nearest to the tip, its x that of the tip if the tip's
    z lies along axis n. A prismatic joint's axis has no place: it is put through the foot of the normal before.

    Args:
        S_s: (n, 6) unit screw axes at q = 0 in the space frame.
        home: (4, 4) pose of the tip at q = 0.
        convention: of the rows returned.
        flipped: numbers i (from 1) of the pairs (i, i+1) of meeting axes whose x_i shall point the other way.

    Raises:
        ModelError: a helical joint, which has no row; a wrong screw or pose; a pair in `flipped` whose axes do not
            meet.
    """
    target = convention_of(convention)
    arm = mechanism_from_screws(S_s, home)
    S, _, T_tip = screws(arm)
    for i, joint in enumerate(arm.joints, start=1):
        if joint.kind is JointKind.HELICAL:
            raise ModelError("dh.helical", index=i, pitch=joint.pitch)
    frames, relations = _frames(S, T_tip, frozenset(flipped))
    rows = [DHRow(kind=_letter(arm, 0))]
    for i, (before, after) in enumerate(pairwise(frames), start=1):
        rows.append(replace(_row(inverse(before) @ after), kind=_letter(arm, i)))
    table = DHTable(tuple(rows), Convention.MODIFIED, frames[0], inverse(frames[-1]) @ T_tip, relations, 0.0)
    table = table if target is Convention.MODIFIED else classic_from_modified(table)
    again = screws(table.mechanism())
    residual = max(float(np.abs(again.S_s - S).max()), float(np.abs(again.home - T_tip).max()))
    return replace(table, residual=residual)


def classic_from_modified(table: DHTable) -> DHTable:
    """The same arm in the classic convention: a and alpha move one row up, the first ones into the base.

    Rot(x, alpha_0) Trans(x, a_0) [Rot(z, theta_1) Trans(z, d_1) Trans(x, a_1) Rot(x, alpha_1)] ...
    """
    first = table.rows[0]
    after = (*table.rows[1:], DHRow())
    rows = tuple(replace(row, a=n.a, alpha=n.alpha) for row, n in zip(table.rows, after, strict=True))
    base = table.base @ rotation_x(first.alpha) @ translation(first.a, 0.0, 0.0)
    return replace(table, rows=rows, base=base, convention=Convention.CLASSIC)


class _Normal(NamedTuple):
    """Common normal of axis i and the next: its feet on both, its direction, and how the axes lie."""

    foot: Vector3
    next_foot: Vector3
    x: Vector3
    relation: Relation


def _frames(S: Floats, T_tip: PoseMatrix, flipped: frozenset[int]) -> tuple[list[PoseMatrix], tuple[Relation, ...]]:
    """Frames {1} .. {n} at q = 0 in {s}, and the relations of neighbouring axes."""
    scale = max(1e-3, float(np.abs(S[:, 3:]).max()), float(np.abs(T_tip[:3, 3]).max()))
    directions = [screw[:3] if screw[:3].any() else screw[3:] for screw in S]
    entry = _point(S[0], np.zeros(3))
    x = frame_along(directions[0])[:, 0]
    frames: list[PoseMatrix] = []
    relations: list[Relation] = []
    for i in range(1, len(S)):
        z, z_next = directions[i - 1], directions[i]
        normal = _common_normal(entry, z, _point(S[i], entry), z_next, x, scale)
        if i in flipped:
            if normal.relation is not Relation.INTERSECTING:
                raise ModelError("dh.flip", index=i, next=i + 1, relation=normal.relation.value)
            normal = normal._replace(x=-normal.x)
        frames.append(_frame(normal.x, z, normal.foot))
        relations.append(normal.relation)
        x, entry = normal.x, normal.next_foot
    z = directions[-1]
    if np.abs(np.cross(T_tip[:3, 2], z)).max() < PARALLEL and T_tip[:3, 2] @ z > 0:
        x = T_tip[:3, 0]
    frames.append(_frame(x, z, entry + z * (z @ (T_tip[:3, 3] - entry))))
    return frames, tuple(relations)


def _point(S: Floats, near: Vector3) -> Vector3:
    """The point of a revolute axis nearest to the origin; for a prismatic one, `near`."""
    return np.cross(S[:3], S[3:]) if S[:3].any() else near


def _common_normal(p: Vector3, z: Vector3, p_next: Vector3, z_next: Vector3, x: Vector3, scale: float) -> _Normal:
    """The normal from the line (p, z) to the next one; `x` is taken over where nothing forces another."""
    across = np.cross(z, z_next)
    sine = float(np.linalg.norm(across))
    between = p_next - p
    if sine < PARALLEL:
        offset = between - z * (z @ between)
        distance = float(np.linalg.norm(offset))
        if distance < WRITTEN * scale:
            return _Normal(p, p, x, Relation.COLLINEAR)
        return _Normal(p, p + offset, offset / distance, Relation.PARALLEL)
    foot = p + z * (np.cross(between, z_next) @ across / sine**2)
    next_foot = p_next + z_next * (np.cross(between, z) @ across / sine**2)
    gap = float(between @ across) / sine
    if abs(gap) < WRITTEN * scale:
        return _Normal(foot, next_foot, across / sine, Relation.INTERSECTING)
    return _Normal(foot, next_foot, np.copysign(1.0, gap) * across / sine, Relation.SKEW)


def _frame(x: Vector3, z: Vector3, origin: Vector3) -> PoseMatrix:
    """(4, 4) frame with this z, and x as near to the given one as possible."""
    x = x - z * (z @ x)
    x = x / np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = origin
    return T


def _row(T: PoseMatrix) -> DHRow:
    """Parameters of a transform that has them by construction, roundoff of quarter turns removed."""
    row = dh_parameters(T, tolerance=np.inf)
    assert row is not None
    return replace(row, alpha=_tidy(row.alpha), theta=_tidy(row.theta))


def _tidy(angle: float) -> float:
    quarter = np.pi / 2
    nearest = round(angle / quarter) * quarter
    return float(nearest) if abs(angle - nearest) < ROUNDED_TURN else angle


def _letter(arm: Mechanism, index: int) -> Literal["R", "P"]:
    return "P" if arm.joints[index].kind is JointKind.PRISMATIC else "R"


def mixed_product(robot: RobotLike, q: ArrayLike, k: int) -> PoseMatrix:
    """(4, 4) tip pose with the home pose after the k-th exponential; the same for every k.

    Args:
        robot: a chain of n joints.
        q: (n,) its coordinates [rad | m].
        k: 0 .. n exponentials in {s} stand before the home pose.

    Raises:
        InputError: not one finite number per joint, or no such k.
        ModelError: a joint of the chain mimics another.
    """
    axes, values = _given(robot, q)
    place = whole("k", k, 0, len(values))
    T = np.eye(4)
    for S, value in zip(axes.S_s[:place], values[:place], strict=True):
        T = T @ screw_motion(S, float(value))
    T = T @ axes.home
    for B, value in zip(axes.S_b[place:], values[place:], strict=True):
        T = T @ screw_motion(B, float(value))
    return T


def inverse_product(robot: RobotLike, q: ArrayLike) -> PoseMatrix:
    """(4, 4) pose T_ts of {s} seen from the tip, as a product: no matrix of a configuration is inverted.

    Args:
        robot: a chain of n joints.
        q: (n,) its coordinates [rad | m].
    """
    axes, values = _given(robot, q)
    T = np.eye(4)
    for B, value in zip(axes.S_b[::-1], values[::-1], strict=True):
        T = T @ screw_motion(B, -float(value))
    return T @ inverse(axes.home)


def _given(robot: RobotLike, q: ArrayLike) -> tuple[Screws, Floats]:
    axes = screws(as_mechanism(robot))
    return axes, as_batch("q", q, (len(axes.S_s),), finite=True)


@of_mechanism
def screws(mechanism: Mechanism) -> Screws:
    """Screw axes of the joints between base and tip, and the home pose.

    Args:
        mechanism: its chain to the tip may have fixed joints; branches beside the chain are left out. The order is
            that of the chain, which for an arm without branches is that of q.

    Raises:
        ModelError: a joint of the chain mimics another: its motion is no screw of its own.
    """
    T_sl = mechanism.T_sb
    columns: list[Vector6] = []
    for joint in chain_to_tip(mechanism):
        if joint.mimic is not None:
            raise ModelError("screws.mimic", joint=joint.name, leader=joint.mimic.leader)
        T_sl = T_sl @ joint.T_pj
        if joint.moves:
            columns.append(adjoint(T_sl) @ joint.screw)
    home = T_sl @ mechanism.T_lt
    S_s = np.reshape(columns, (-1, 6))
    return Screws(S_s, S_s @ adjoint(inverse(home)).T, home)
