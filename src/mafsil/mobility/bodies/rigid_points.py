"""Freedoms of a body counted by its points: distances as constraints, how many depend on others, and coordinates.

Two bodies of the plane by points A, B and C, D: what a joint between them asks, and where it lets the second stand.

Coordinates (xA, yA, phi_AB, xC, yC, phi_CD); B = A + d_AB u(phi_AB), D = C + d_CD u(phi_CD).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, number, positive, real_array, require_finite, single
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.spaces.motion_group import cross
from mafsil.mobility.tolerances import RANK, TYPED
from mafsil.solvers.decompositions import ranks


class PointsStatus(Status):
    """Whether the distances between points fix their shape to first order."""

    RIGID = ("mobility.points_rigid", True)
    SHAKY = ("mobility.points_shaky", True)
    FIX_NO_BODY = ("mobility.points_collinear", False)


@dataclass(frozen=True, eq=False, repr=False)
class PointCount(Answer, data="constraints rank nullity redundant body_dof"):
    """Points of a body with all distances between them fixed; true if they determine where the body is.

    Attributes:
        dimension: d, 2 or 3.
        points: n.
        constraints: n (n - 1)/2 distances.
        rank: how many of them are independent to first order here.
        body_dof: freedoms of a body with these points: of the points up to congruence.
    """

    dimension: int
    points: int
    constraints: int
    rank: int
    body_dof: int

    @property
    def nullity(self) -> int:
        """d n - rank: freedoms counted as point freedoms minus independent constraints."""
        return self.dimension * self.points - self.rank

    @property
    def redundant(self) -> int:
        """Distances that follow from the others to first order."""
        return self.constraints - self.rank

    @property
    def status(self) -> PointsStatus:
        """By nullity against the freedoms of a body."""
        full = self.dimension * (self.dimension + 1) // 2
        if self.body_dof < full:
            return PointsStatus.FIX_NO_BODY
        return PointsStatus.RIGID if self.nullity == full else PointsStatus.SHAKY

    def explain(self, language: str | None = None) -> str:
        """The count with its terms."""
        return self.status.sentence(
            language, freedoms=self.dimension * self.points, rank=self.rank, nullity=self.nullity,
            redundant=self.redundant, dof=self.body_dof,
        )  # fmt: skip


def distance_matrix(points: ArrayLike) -> Floats:
    """(n (n - 1)/2, d n) derivatives of the distances of points (n, d): +-(P_i - P_j)/|P_i - P_j|.

    Raises:
        InputError: points that coincide, not in the plane or in space.
    """
    P = real_array("points", points)
    if P.ndim != 2 or P.shape[1] not in (2, 3) or not len(P):
        raise InputError("input.shape", name="points", expected="(n, 2) or (n, 3)", got=P.shape, hint="")
    n, d = require_finite("points", P).shape
    rows = np.zeros((n * (n - 1) // 2, n, d))
    for row, (i, j) in zip(rows, combinations(range(n), 2), strict=True):
        apart = P[i] - P[j]
        distance = float(np.linalg.norm(apart))
        if not distance > 0:
            raise InputError("mobility.same_point", first=i, second=j)
        row[i], row[j] = apart / distance, -apart / distance
    return rows.reshape(len(rows), n * d)


def count_points(points: ArrayLike) -> PointCount:
    """Freedoms of points of one body: point freedoms minus independent distances, against what a body really has.

    The rank may be smaller than that of a body: points of space in one plane, or on one line in the plane, are rigid
    but shaky. Points of space on one line do not determine a body: it can rotate about the line.

    Args:
        points: (n, 2) or (n, 3) [m].
    """
    A = distance_matrix(points)
    P = real_array("points", points)
    n, d = P.shape
    rank = int(ranks(A, RANK))
    spread = np.linalg.svd(P - P.mean(axis=0), compute_uv=False)
    spanned = int((spread > TYPED * max(float(spread[0]), LEAST_DIVISOR)).sum()) if n > 1 else 0
    # A body of the plane is fixed by two points, one of space by three that are not on one line.
    body = d * (d + 1) // 2 - (d - spanned) * (d - spanned - 1) // 2
    return PointCount(d, n, len(A), rank, body)


@dataclass(frozen=True, eq=False)
class BodyPoints:
    """A body in space by six parameters: A, direction of B (lon, lat), angle psi of C about AB.

    Attributes:
        A, B, C: (*batch, 3) points [m].
        lon, lat, psi: (*batch,) [rad]; lon is 0 where AB is vertical, psi counts from e1 = (-sin lon, cos lon, 0)
            towards e2 = u x e1.
        R_body: (*batch, 3, 3) axes: x along AB, y towards C, z = x x y.
        free_lon: (*batch,) whether AB is vertical, so that lon is free.
        a, h: (*batch,) coordinates of C along AB and across it [m].
    """

    A: Floats
    B: Floats
    C: Floats
    lon: Floats
    lat: Floats
    psi: Floats
    R_body: Floats
    free_lon: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    a: Floats
    h: Floats


def _directions(lon: Floats, lat: Floats) -> tuple[Floats, Floats, Floats]:
    u = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)
    e1 = np.stack([-np.sin(lon), np.cos(lon), np.zeros_like(lon)], axis=-1)
    return u, e1, cross(u, e1)


def triangle(d_AB: float, d_AC: float, d_BC: float) -> tuple[float, float]:
    """Place (a, h) of C along AB and across it by its distances [m].

    Raises:
        InputError: distances that make no triangle.
    """
    AB, AC, BC = positive("d_AB", d_AB), positive("d_AC", d_AC), positive("d_BC", d_BC)
    a = (AC**2 - BC**2 + AB**2) / (2 * AB)
    h2 = (AC - a) * (AC + a)
    if h2 < -TYPED * AC**2:
        raise InputError("mobility.no_triangle", first=AB, second=AC, third=BC)
    return a, float(np.sqrt(max(h2, 0.0)))


def points_of_body(
    A: ArrayLike, lon: ArrayLike, lat: ArrayLike, psi: ArrayLike, d_AB: float, d_AC: float, d_BC: float
) -> BodyPoints:
    """Three points of a body in space from its six parameters: A, B on a sphere about A, C on a circle about AB.

    Args:
        A: (*batch, 3) [m].
        lon, lat: (*batch,) direction from A to B [rad].
        psi: (*batch,) angle of C about AB [rad].
        d_AB, d_AC, d_BC: distances [m].

    Raises:
        InputError: distances that make no triangle.
    """
    a, h = triangle(d_AB, d_AC, d_BC)
    start = as_batch("A", A, (3,))
    angles = np.broadcast_arrays(real_array("lon", lon), real_array("lat", lat), real_array("psi", psi))
    u, e1, e2 = _directions(angles[0], angles[1])
    across = np.cos(angles[2])[..., None] * e1 + np.sin(angles[2])[..., None] * e2
    return body_of_points(start, start + d_AB * u, start + a * u + h * across)


def body_of_points(A: ArrayLike, B: ArrayLike, C: ArrayLike) -> BodyPoints:
    """Six parameters and axes of a body from three of its points: the way back from `points_of_body`.

    Args:
        A, B, C: (*batch, 3) not on one line [m].

    Raises:
        InputError: points on one line, which do not determine the body.
    """
    p, q, r = np.broadcast_arrays(as_batch("A", A, (3,)), as_batch("B", B, (3,)), as_batch("C", C, (3,)))
    w = r - p
    length = np.linalg.norm(q - p, axis=-1, keepdims=True)
    if not (length > 0).all():
        raise InputError("mobility.collinear")
    u = (q - p) / length
    a = np.sum(w * u, axis=-1)
    out = w - a[..., None] * u
    h = np.linalg.norm(out, axis=-1)
    if not (h > TYPED * np.linalg.norm(w, axis=-1)).all():
        raise InputError("mobility.collinear")
    level = np.hypot(u[..., 0], u[..., 1])
    vertical = level < TYPED
    lon = np.where(vertical, 0.0, np.arctan2(u[..., 1], u[..., 0]))
    lat = np.arctan2(u[..., 2], level)
    _, e1, e2 = _directions(lon, lat)
    psi = np.arctan2(np.sum(w * e2, axis=-1), np.sum(w * e1, axis=-1))
    v = out / h[..., None]
    return BodyPoints(
        p, q, r, lon, lat, psi, np.stack([u, v, cross(u, v)], axis=-1), np.asarray(vertical, dtype=np.bool_), a, h
    )


def planar_body(A: ArrayLike, phi: ArrayLike, d_AB: float) -> Floats:
    """(*batch, 2) point B = A + d (cos phi, sin phi) of a body of the plane."""
    d_AB = number("d_AB", d_AB)
    angle = real_array("phi", phi)
    return as_batch("A", A, (2,)) + d_AB * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def planar_angle(A: ArrayLike, B: ArrayLike) -> Floats:
    """(*batch,) direction phi of B from A in (-pi, pi] [rad]: the way back from `planar_body`."""
    apart = as_batch("B", B, (2,)) - as_batch("A", A, (2,))
    return np.arctan2(apart[..., 1], apart[..., 0])


def planar_residual(x: ArrayLike, d_AB: float) -> Floats:
    """(*batch,) |A - B| - d of implicit coordinates (*batch, 4) (xA, yA, xB, yB) of a body of the plane [m]."""
    d_AB = number("d_AB", d_AB)
    v = as_batch("x", x, (4,))
    return np.hypot(v[..., 0] - v[..., 2], v[..., 1] - v[..., 3]) - d_AB


def implicit_body(explicit: ArrayLike, d_AB: float) -> Floats:
    """(*batch, 4) implicit coordinates (xA, yA, xB, yB) of a body of the plane from explicit ones (xA, yA, phi)."""
    v = as_batch("explicit", explicit, (3,))
    return np.concatenate([v[..., :2], planar_body(v[..., :2], v[..., 2], d_AB)], axis=-1)


def explicit_body(implicit: ArrayLike, d_AB: float) -> Floats:
    """(*batch, 3) explicit coordinates (xA, yA, phi) of a body of the plane from implicit ones (xA, yA, xB, yB).

    Raises:
        InputError: points that are not d apart.
    """
    v = as_batch("implicit", implicit, (4,), finite=True)
    gap = float(np.max(np.abs(planar_residual(v, d_AB)), initial=0.0))
    if gap > TYPED * d_AB:
        raise InputError("mobility.off_body", gap=gap, distance=d_AB)
    return np.concatenate([v[..., :2], planar_angle(v[..., :2], v[..., 2:])[..., None]], axis=-1)


def third_point(A: ArrayLike, B: ArrayLike, d_AC: float, d_BC: float, *, face_up: bool = True) -> Floats:
    """(2,) third point of a body of the plane: ABC counterclockwise if the face is up.

    Raises:
        InputError: distances that make no triangle.
    """
    start, end = single("A", A, (2,)), single("B", B, (2,))
    d = float(np.linalg.norm(end - start))
    a, h = triangle(d, d_AC, d_BC)
    u = (end - start) / d
    return start + a * u + (h if face_up else -h) * np.array([-u[1], u[0]])


KINDS = ("R", "P", "RP", "PR")


@dataclass(frozen=True, eq=False)
class SecondBody:
    """Where the second body stands.

    Attributes:
        B, C, D: (*batch, 2) points [m].
        phi_CD: (*batch,) its direction [rad].
    """

    B: Floats
    C: Floats
    D: Floats
    phi_CD: Floats


def _unit(angle: Floats) -> Floats:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def second_body(
    kind: str, A: ArrayLike, phi_AB: ArrayLike, d_AB: float, d_CD: float, *, theta: ArrayLike = 0.0, d: ArrayLike = 0.0,
    slot: float = 0.0,
) -> SecondBody:  # fmt: skip
    """Points of the second body from independent coordinates.

    R: C = B, phi_CD = phi_AB + theta. P: C = B + d u(phi_AB + slot), phi_CD = phi_AB + theta with theta constant.
    RP (slot in the second body): C = B + d u(phi_CD + slot). PR (slot in the first): C = B + d u(phi_AB + slot).

    Args:
        kind: R, P, RP or PR.
        A: (*batch, 2) [m].
        phi_AB: (*batch,) [rad].
        d_AB, d_CD: lengths of the bodies [m].
        theta: (*batch,) angle from the first body to the second [rad].
        d: (*batch,) displacement along the slot [m].
        slot: angle of the slot in its body [rad].

    Raises:
        InputError: another kind.
    """
    d_AB, d_CD, slot = number("d_AB", d_AB), number("d_CD", d_CD), number("slot", slot)
    if kind not in KINDS:
        raise InputError("mobility.planar_kind", kind=kind, known=", ".join(KINDS))
    phi = real_array("phi_AB", phi_AB)
    B = planar_body(A, phi, d_AB)
    other = phi + real_array("theta", theta)
    along = other + slot if kind == "RP" else phi + slot
    C = B if kind == "R" else B + real_array("d", d)[..., None] * _unit(along)
    return SecondBody(B, C, planar_body(C, other, d_CD), other)


def joint_residual(kind: str, x: ArrayLike, d_AB: float, *, theta: float = 0.0, slot: float = 0.0) -> Floats:
    """(*batch, k) what the joint asks of coordinates (*batch, 6): 2 for R and P, 1 for RP and PR; zero when it holds.

    Args:
        kind: R, P, RP or PR.
        x: (*batch, 6) (xA, yA, phi_AB, xC, yC, phi_CD) [m, rad].
        d_AB: length of the first body [m].
        theta: constant angle between the bodies of P [rad].
        slot: angle of the slot in its body [rad].
    """
    d_AB, theta, slot = number("d_AB", d_AB), number("theta", theta), number("slot", slot)
    if kind not in KINDS:
        raise InputError("mobility.planar_kind", kind=kind, known=", ".join(KINDS))
    v = as_batch("x", x, (6,))
    B, C = planar_body(v[..., :2], v[..., 2], d_AB), v[..., 3:5]
    if kind == "R":
        return C - B
    along = v[..., 5] + slot if kind == "RP" else v[..., 2] + slot
    off = np.sum(_unit(along + np.pi / 2) * (C - B), axis=-1)
    if kind == "P":
        return np.stack([off, v[..., 5] - v[..., 2] - theta], axis=-1)
    return off[..., None]
