"""Contacts of fingers and fixtures with a rigid body: where, which normal, and what forces they can give.

The normal points INTO the body: the direction in which the finger pushes. Wrenches are (m, f): in the plane
(m, f_x, f_y), m counter-clockwise; in space (m_x, m_y, m_z, f_x, f_y, f_z), moments about the origin of the frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import atan, cos, hypot, isfinite, pi
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import LARGEST, SMALLEST, Floats, PoseMatrix, as_batch, calculable, frozen, real_array
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.grasp.tolerances import TYPED

Model: TypeAlias = Literal["frictionless", "hard", "soft"]
MOST_FACETS = 4096
"""Of a polyhedral cone; more say nothing that the round one does not."""
POINTED = float("inf")
"""Curvature of a pointed finger [1/m]."""
MODELS: tuple[Model, ...] = ("frictionless", "hard", "soft")


@dataclass(frozen=True, eq=False)
class Contact:
    """One point contact.

    Attributes:
        point: (d,) position in the frame of the body [m]; d = 2 or 3.
        direction: (d,) normal as given, of any length.
        mu: friction coefficient; 0 is frictionless.
        gamma: torsional coefficient of a soft finger [m], in space only.
        curvature: of the body's boundary at the contact [1/m], positive where it bulges: one number, or in space the
            symmetric (3, 3) tensor across the normal. Second order asks for it; flat if it was not given.
        finger_curvature: of the finger [1/m], in the same way; infinite for a pointed one.
        name: for reports.
        curvature_given: whether the curvature of the body was given.
    """

    point: Floats
    direction: Floats
    mu: float = 0.0
    gamma: float = 0.0
    curvature: float | Floats = 0.0
    finger_curvature: float | Floats = POINTED
    name: str = field(default="")
    curvature_given: bool = False

    def __init__(
        self,
        point: ArrayLike,
        normal: ArrayLike,
        mu: float = 0.0,
        gamma: float = 0.0,
        *,
        curvature: float | ArrayLike | None = None,
        finger_curvature: float | ArrayLike = POINTED,
        name: str = "",
    ) -> None:
        r, n = _vectors(point, normal, name)
        size = len(r)
        if not hypot(*n.tolist()) > 0.0:
            raise InputError("grasp.zero_normal", name=name or "contact", point=_shown(r))
        mu, gamma = _number("mu", mu), _number("gamma", gamma)
        for what, value in (("mu", mu), ("gamma", gamma)):
            if not (isfinite(value) and value >= 0):
                raise InputError("grasp.negative_coefficient", name=what, value=value)
            if value and not SMALLEST <= value <= LARGEST:
                calculable(what, np.asarray(value))
        bend = 0.0 if curvature is None else _curvature("curvature", curvature, n)
        finger = finger_curvature
        if type(finger) is not float or finger != POINTED:
            finger = _curvature("finger_curvature", finger, n, pointed=True)
        if gamma > 0 and size == 2:
            raise InputError("grasp.soft_in_plane", name=name or "contact")
        vars(self).update(
            point=r, direction=n, mu=mu, gamma=gamma, curvature=bend, finger_curvature=finger, name=name,
            curvature_given=curvature is not None,
        )  # fmt: skip

    def __repr__(self) -> str:
        friction = f", mu={self.mu:g}" if self.mu else ""
        soft = f", gamma={self.gamma:g}" if self.gamma else ""
        return f"Contact({_shown(self.point)}, {_shown(self.normal)}{friction}{soft})"

    @cached_property
    def row(self) -> tuple[float, ...]:
        """Point, direction, mu and gamma one after the other: 2 d + 2 numbers."""
        return (*self.point.tolist(), *self.direction.tolist(), self.mu, self.gamma)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.point)

    @property
    def model(self) -> Model:
        """`frictionless`, `hard` (with friction) or `soft` (with friction and torsion)."""
        return "soft" if self.gamma > 0 else "hard" if self.mu > 0 else "frictionless"

    @cached_property
    def normal(self) -> Floats:
        """(d,) unit normal into the body."""
        given: list[float] = self.direction.tolist()
        longest = max(map(abs, given))
        n = [v / longest for v in given]
        length = hypot(*n)
        return frozen([v / length for v in n])

    @property
    def shape(self) -> Floats:
        """(d - 1, d - 1) curvature of the body along `tangents` [1/m]."""
        return _along(self.curvature, self.tangents)

    @property
    def finger_shape(self) -> Floats | None:
        """(d - 1, d - 1) curvature of the finger along `tangents` [1/m]; None for a pointed one."""
        pointed = isinstance(self.finger_curvature, float) and self.finger_curvature == POINTED
        return None if pointed else _along(self.finger_curvature, self.tangents)

    @property
    def alpha(self) -> float:
        """Friction angle [rad]."""
        return atan(self.mu)

    @cached_property
    def tangents(self) -> Floats:
        """(d - 1, d) unit vectors: the normal turned by +90 degrees, or two that complete a right-handed frame."""
        n: list[float] = self.normal.tolist()
        if self.dimension == 2:
            return frozen([[-n[1], n[0]]])
        least = min(range(3), key=lambda i: abs(n[i]))
        p, q = (least + 1) % 3, (least + 2) % 3
        length = hypot(n[p], n[q])
        a = [0.0, 0.0, 0.0]
        a[p], a[q] = -n[q] / length, n[p] / length
        return frozen([a, _cross(n, a)])

    @cached_property
    def frame(self) -> PoseMatrix:
        """(4, 4) pose of the contact frame in the body frame (space): z along the inward normal, x and y tangents."""
        if self.dimension != 3:
            raise InputError("grasp.needs_space", what="frame")
        T = np.eye(4)
        T[:3, :3] = np.column_stack([*self.tangents, self.normal])
        T[:3, 3] = self.point
        return frozen(T)

    @cached_property
    def basis(self) -> Floats:
        """(m, k) wrench of a unit of each component: push, one or two tangential forces, torsion about the normal."""
        forces = [self.normal] if self.model == "frictionless" else [self.normal, *self.tangents]
        columns = [force_wrench(self.point, f) for f in forces]
        if self.model == "soft":
            columns.append(np.concatenate([self.normal, np.zeros(3)]))
        return frozen(np.column_stack(columns))

    def edges(self, facets: int = 16, *, outer: bool = False, unit: bool = False) -> Floats:
        """Edges of the cone in components of `basis`: every force of the (polyhedral) cone is their sum, none negative.

        e_k = n + mu (cos(2 pi k/K) a + sin(2 pi k/K) b); outer: mu/cos(pi/K)

        Args:
            facets: K in space; the plane's cone has exactly two edges.
            outer: circumscribe the circular cone instead of inscribing.
            unit: edges of length 1 instead of a push of 1.

        Returns:
            (edges, components of basis).
        """
        if self.model == "frictionless":
            return np.ones((1, 1))
        if self.dimension == 2:
            rays = np.array([[1.0, -self.mu], [1.0, self.mu]])
        else:
            rays = self._facet_rays(facets, outer)
        if unit:
            rays = rays / np.hypot(1.0, self.mu / (cos(pi / facets) if outer and self.dimension == 3 else 1.0))
        if self.model != "soft":
            return rays
        twist = self.gamma * rays[:, :1]
        return np.vstack([np.hstack([rays, twist]), np.hstack([rays, -twist])])

    def _facet_rays(self, facets: int, outer: bool) -> Floats:
        if not 3 <= facets <= MOST_FACETS:
            raise InputError("grasp.few_facets", got=facets, limit=MOST_FACETS)
        if self.mu == 0:
            return np.array([[1.0, 0.0, 0.0]])
        angles = 2 * pi * np.arange(facets) / facets
        mu = self.mu / cos(pi / facets) if outer else self.mu
        return np.column_stack([np.ones(facets), mu * np.cos(angles), mu * np.sin(angles)])

    def wrenches(self, facets: int = 16, *, outer: bool = False, unit: bool = False) -> Floats:
        """(m, edges) the columns of the grasp matrix that belong to this contact; arguments as `edges`."""
        return self.basis @ self.edges(facets, outer=outer, unit=unit).T

    def margin(self, components: Floats) -> float:
        """How far contact forces in components of `basis` are inside the true cone [N]; negative outside."""
        push = float(components[0])
        if self.model == "frictionless":
            return push
        sideways = self.mu * push - hypot(*(float(v) for v in components[1 : self.dimension]))
        return sideways if self.model != "soft" else min(sideways, self.gamma * push - abs(float(components[3])))

    def to_body(self, components: ArrayLike) -> Floats:
        """(d,) force in the axes of the body.

        Args:
            components: (d,) tangential parts along `tangents`, then the push, as in `frame`: z along the normal.
        """
        return single("components", components, (self.dimension,)) @ np.vstack([self.tangents, self.normal])

    def to_contact(self, force: ArrayLike) -> Floats:
        """(d,) tangential parts along `tangents`, then the push, of a force in the axes of the body.

        Args:
            force: (d,) [N].
        """
        return np.vstack([self.tangents, self.normal]) @ single("force", force, (self.dimension,))

    def with_friction(self, mu: float, gamma: float = 0.0) -> Contact:
        """The same contact with other coefficients.

        Args:
            mu, gamma: of friction and torsion.
        """
        return Contact(
            self.point, self.direction, mu, gamma, curvature=self.curvature if self.curvature_given else None,
            finger_curvature=self.finger_curvature, name=self.name,
        )  # fmt: skip

    def in_frame(self, T: ArrayLike) -> Contact:
        """The same contact in another frame.

        Args:
            T: (d + 1, d + 1) pose of the old frame in the new one.
        """
        pose, d = np.asarray(T, float), self.dimension
        R = pose[:d, :d]
        return Contact(
            R @ self.point + pose[:d, d],
            R @ self.direction,
            self.mu,
            self.gamma,
            curvature=_turn(self.curvature, R) if self.curvature_given else None,
            finger_curvature=_turn(self.finger_curvature, R),
            name=self.name,
        )


def force_wrench(point: ArrayLike, force: ArrayLike) -> Floats:
    """Wrench (m, f) of a force at a point about the origin; (3,) in the plane, (6,) in space.

    Args:
        point: (d,) point of attack [m].
        force: (d,) force [N].
    """
    r, f = np.asarray(point, float).tolist(), np.asarray(force, float).tolist()
    if len(r) == 2:
        return np.array([r[0] * f[1] - r[1] * f[0], *f])
    return np.array([*_cross(r, f), *f])


def _cross(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """A x b of three numbers each, at the cost of six products."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def require_one_dimension(contacts: Sequence[Contact]) -> None:
    """Refuse contacts of which some are in the plane and others in space.

    Args:
        contacts: at least one.

    Raises:
        InputError: of mixed dimension.
    """
    first = contacts[0].dimension
    for index, contact in enumerate(contacts):
        if contact.dimension != first:
            raise InputError("grasp.mixed_dimensions", index=index, got=contact.dimension, expected=first)


def line_contact(start: ArrayLike, end: ArrayLike, normal: ArrayLike, mu: float = 0.0, name: str = "") -> list[Contact]:
    """A straight line contact as its two end points: the same wrenches, because pressure along it is a mean of them.

    Args:
        start, end: (d,) ends [m].
        normal: (d,) into the body.
        mu: friction coefficient.
        name: for reports.
    """
    return patch_contact([start, end], normal, mu, name)


def patch_contact(
    corners: Sequence[ArrayLike], normal: ArrayLike, mu: float = 0.0, name: str = "", *, gamma: float = 0.0
) -> list[Contact]:
    """A flat patch as the corners of its outline: the same wrenches, coefficients being the same all over it.

    Args:
        corners: at least one point (d,) [m], all in one plane normal to `normal`.
        normal: (d,) into the body.
        mu: friction coefficient.
        name: for reports.
        gamma: torsional coefficient of soft material at every point of it [m], in space.

    Raises:
        InputError: no corner, or corners that do not lie in one plane normal to `normal`.
    """
    if not len(corners):
        raise InputError("grasp.no_contacts")
    contacts = [Contact(p, normal, mu, gamma, name=f"{name or 'patch'}.{k}") for k, p in enumerate(corners)]
    points = np.array([c.point for c in contacts])
    heights = (points - points[0]) @ contacts[0].normal
    size = float(np.abs(points - points[0]).max())
    if np.abs(heights).max() > TYPED * max(size, LEAST_DIVISOR):
        raise InputError(
            "grasp.patch_not_flat", index=int(np.argmax(np.abs(heights))), off=float(np.abs(heights).max())
        )
    return contacts


def corner_contact(point: ArrayLike, normals: Sequence[ArrayLike], mu: float = 0.0, name: str = "") -> list[Contact]:
    """A finger in a concave corner: one contact for each face that meets there.

    Args:
        point: (d,) the corner [m].
        normals: of the faces, into the body.
        mu: friction coefficient.
        name: for reports.
    """
    return [Contact(point, n, mu, name=f"{name or 'corner'}.{k}") for k, n in enumerate(normals)]


def single(name: str, value: ArrayLike, core: tuple[int, ...]) -> Floats:
    """One finite array of exactly this shape, no batch of them.

    Args:
        name: for the error.
        value: numbers.
        core: the shape.
    """
    array = as_batch(name, value, core, finite=True)
    if array.shape != core:
        raise InputError("input.shape", name=name, expected=core, got=array.shape, hint="")
    return array


def _vectors(point: ArrayLike, normal: ArrayLike, name: str) -> tuple[Floats, Floats]:
    """Point and normal as read-only arrays of their own; `as_batch` judges what is not plainly two or three numbers."""
    r, n = _plain(point), _plain(normal)
    if r is not None and n is not None and r.shape == n.shape:
        return r, n
    size = real_array("point", point).size
    if size not in (2, 3):
        raise InputError("grasp.dimension", name=name or "point", got=size)
    return frozen(single("point", point, (size,))), frozen(single("normal", normal, (size,)))


def _plain(value: ArrayLike) -> Floats | None:
    """A read-only copy of two or three finite float64 numbers in an array; None of anything else."""
    if type(value) is not np.ndarray or value.dtype.char != "d" or value.shape not in ((2,), (3,)):
        return None
    copy: Floats = value.copy()
    copy.setflags(write=False)
    return copy if all(map(isfinite, copy.tolist())) else None


def _curvature(name: str, value: float | ArrayLike, n: Floats, pointed: bool = False) -> float | Floats:
    """One number, or a symmetric tensor across the normal."""
    if not real_array(name, value).ndim:
        number = _number(name, value)  # type: ignore[arg-type]
        if not isfinite(number) and not (pointed and number == POINTED):
            raise InputError("input.finite_alone", name=name, value=number)
        return number
    K = single(name, value, (3, 3)) if len(n) == 3 else single(name, value, ())
    size = float(np.abs(K).max())
    along = float(np.abs(K @ n).max() / np.linalg.norm(n))
    if np.abs(K - K.T).max() > TYPED * size or along > TYPED * size:
        raise InputError("grasp.curvature_tensor", name=name, along=along)
    return frozen(K)


def _along(curvature: float | Floats, tangents: Floats) -> Floats:
    if isinstance(curvature, float):
        return curvature * np.eye(len(tangents))
    return tangents @ curvature @ tangents.T


def _turn(curvature: float | Floats, R: Floats) -> float | Floats:
    return curvature if isinstance(curvature, float) else R @ curvature @ R.T


def _number(name: str, value: float) -> float:
    """One number, whatever type holds it."""
    if type(value) is float:
        return value
    array = real_array(name, value)
    if array.ndim:
        raise InputError("input.shape", name=name, expected=(), got=array.shape, hint="")
    return float(array)


def _shown(vector: Floats) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in vector) + ")"
