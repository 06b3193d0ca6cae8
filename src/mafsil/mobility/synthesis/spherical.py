"""Spherical four-bars, all of whose axes pass one point: for orientations (motion) and for angles (function).

A dyad leads a body from a fixed axis p by a moving axis q if the arc between them stays: p . R_j q = p . q, which is
p^T (R_j - 1) q = 0 with the displacements R_j from the first orientation: bilinear forms as in the plane, without its
circular points. Five orientations have at most six dyads, and pairs of them are at most fifteen four-bars; four have a
cone of fixed and a cone of moving axes; three take any axis.

With arcs a (crank), b (coupler), c (rocker), g (ground) and angles theta, phi about the fixed axes, cos b = B . C says

    K1 cos phi - K2 cos theta + K3 = cos g cos theta cos phi + sin theta sin phi,  K1 = sin g cot a,  K2 = sin g cot c,

and K3 = cos b/(sin a sin c) - cos g cot a cot c: Freudenstein's equation, which is that of the plane for g = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, positive, single, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import rotation
from mafsil.mobility.library import spherical_four_bar
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.synthesis.assessment import NO_LIMITS, LinkageLimits
from mafsil.mobility.synthesis.crank_chain import ChainSynthesis, Placed, rank_chains
from mafsil.mobility.synthesis.five_poses import curve_pairs, five_pose_pairs
from mafsil.mobility.synthesis.function_task import angle_pairs, freudenstein_ratios, is_free, rocker_lines
from mafsil.mobility.tolerances import NO_LENGTH, SAME_GROUND, SAME_POSE, TYPED, UNDETERMINED


@dataclass(frozen=True, eq=False)
class SphericalFourBar:
    """A spherical four-bar by its arcs, and where it stands.

    Attributes:
        crank, coupler, rocker, ground: arcs between its axes [rad].
        A, D: (3,) unit vectors along the fixed axes of crank and rocker.
    """

    crank: float
    coupler: float
    rocker: float
    ground: float
    A: Floats
    D: Floats

    def __post_init__(self) -> None:
        for name in ("crank", "coupler", "rocker", "ground"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
            if getattr(self, name) >= np.pi:
                raise InputError("synthesis.arc", value=getattr(self, name))
        A, D = (single(name, getattr(self, name), (3,)) for name in "AD")
        if abs(A @ A - 1) + abs(D @ D - 1) + abs(A @ D - np.cos(self.ground)) > TYPED:
            raise InputError("synthesis.fixed_axes", ground=self.ground)
        object.__setattr__(self, "A", frozen(A))
        object.__setattr__(self, "D", frozen(D))

    @classmethod
    def of(cls, crank: float, coupler: float, rocker: float, ground: float) -> SphericalFourBar:
        """With the axis of the crank along z and that of the rocker in the plane of x and z.

        Raises:
            InputError: an arc that is not between 0 and half a turn.
        """
        g = positive("ground", ground)
        return cls(crank, coupler, rocker, g, np.array([0.0, 0.0, 1.0]), np.array([np.sin(g), 0.0, np.cos(g)]))

    @property
    def kind(self) -> str:
        """Key of its sentence."""
        return "spherical_four_bar"

    @property
    def dyads(self) -> int:
        """Coupler and rocker."""
        return 1

    @property
    def pivots(self) -> Floats:
        """(2, 3) unit vectors along the fixed axes."""
        return np.stack([self.A, self.D])

    @property
    def lengths(self) -> dict[str, float]:
        """Arcs of the links [rad]."""
        return {"AB": self.crank, "BC": self.coupler, "CD": self.rocker, "AD": self.ground}

    def cosines(self, theta: Floats, modes: Sequence[int]) -> Floats:
        """(k, 1) cosines of the angle between coupler and rocker: the law of cosines of the triangle B, C, D."""
        del modes
        way = np.cos(self.crank) * np.cos(self.ground) + np.sin(self.crank) * np.sin(self.ground) * np.cos(theta)
        b, c = self.coupler, self.rocker
        return ((way - np.cos(b) * np.cos(c)) / (np.sin(b) * np.sin(c)))[:, None]

    def axes(self, theta: ArrayLike, mode: int = 1) -> tuple[Floats, Floats]:
        """(*batch, 3) unit vectors along the moving axes B and C at crank angles (*batch,); NaN where it is open.

        Args:
            theta: angles of the crank, from the arc from A to D, about A [rad].
            mode: 1 for C to the left of the arc from B to D, seen from outside, -1 for the other side.
        """
        angle = np.asarray(theta, dtype=np.float64)
        x = _unit(self.D - self.A * (self.A @ self.D))
        y = np.cross(self.A, x)
        turn = np.cos(angle)[..., None] * x + np.sin(angle)[..., None] * y
        B = np.cos(self.crank) * self.A + np.sin(self.crank) * turn
        way = B @ self.D
        b, c, square = np.cos(self.coupler), np.cos(self.rocker), np.maximum(1.0 - way**2, LEAST_DIVISOR)
        u, v = (b - way * c) / square, (c - way * b) / square
        with np.errstate(invalid="ignore"):
            height = np.sqrt((1.0 - u * b - v * c) / square)
        C = u[..., None] * B + v[..., None] * self.D + mode * height[..., None] * np.cross(B, self.D)
        return B, C

    def coupler_orientations(self, theta: ArrayLike, mode: int = 1) -> Floats:
        """(*batch, 3, 3) frames of the coupler: x along B, z across the arc from B to C."""
        B, C = self.axes(theta, mode)
        z = _unit(np.cross(B, C))
        return np.stack([B, np.cross(z, B), z], axis=-1)

    def output_angle(self, theta: ArrayLike, modes: Sequence[int] = (1,)) -> Floats:
        """(*batch,) angle of the rocker about D, from the arc that goes on from A beyond D [rad]."""
        _, C = self.axes(theta, modes[0])
        x = _unit(self.D * (self.A @ self.D) - self.A)
        return np.arctan2(C @ np.cross(self.D, x), C @ x)

    def drawn(self, theta: float) -> Linkage:
        """The linkage at an angle of the crank in its first mode, for `mf.mobility` and `turn_crank`."""
        return spherical_four_bar([each.tolist() for each in (self.A, *self.axes(theta), self.D)])


def synthesise_spherical_motion(
    orientations: ArrayLike, *, samples: int = 24, limits: LinkageLimits = NO_LIMITS
) -> ChainSynthesis:
    """Spherical four-bars whose coupler takes orientations, in their order.

    Five orientations have at most six dyads: all are found, and all pairs of them. Four have a cone of dyads, which is
    sampled, as are those of three. Each four-bar is driven by the side link that does it better.

    Args:
        orientations: (N, 3, 3) of the coupler, N from 3 to 5.
        samples: of four orientations planes through the cone, of three moving axes.
        limits: box of the fixed axes as unit vectors, least transmission angle, longest arc.

    Raises:
        InputError: another number, no rotations, two that coincide, all about one axis.
    """
    R = as_batch("orientations", orientations, (3, 3), finite=True)
    if R.ndim != 3 or not 3 <= len(R) <= 5:
        raise InputError("synthesis.orientation_count", got=R.shape)
    if not np.all(rotation.is_rotation(R)):
        raise InputError("synthesis.no_rotation", index=int(np.argmin(np.asarray(rotation.is_rotation(R)))) + 1)
    steps = R @ R[0].T
    for k in range(len(R)):
        near = np.abs(R[:k] - R[k]).max(axis=(1, 2), initial=0.0) <= SAME_POSE
        if near.any():
            raise InputError("synthesis.same_pose", first=int(near.argmax()) + 1, second=k + 1)
    forms = steps[1:] - np.eye(3)
    if np.linalg.svd(forms.reshape(-1, 3), compute_uv=False)[-1] < SAME_POSE:
        raise InputError("synthesis.one_axis")
    p, q = _pairs(forms, whole("samples", samples, 4, 400))
    kept = np.isfinite(p).all(axis=1) & np.isfinite(q).all(axis=1)
    places = [np.stack([step @ axis for step in steps]) for axis in q[kept]]
    placed: list[list[Placed]] = []
    for i, j in combinations(range(len(places)), 2):
        ends = p[kept][i], p[kept][j] * np.copysign(1.0, p[kept][i] @ p[kept][j])
        sides = ((ends[0], places[i], places[j], ends[1]), (ends[1], places[j], places[i], ends[0]))
        placed.append([one for side in sides if (one := _place_axes(*side)) is not None])
    method = {3: "spherical_by_grid", 4: "spherical_by_cone", 5: "spherical_by_five"}[len(R)]
    return rank_chains(
        placed, limits, "motion", R, method, complete=len(R) == 5, details={"real": int(kept.sum())}
    )  # fmt: skip


def _pairs(forms: Floats, samples: int) -> tuple[Floats, Floats]:
    """Fixed and moving axes (k, 3), (k, 3) of the dyads of forms (N - 1, 3, 3); NaN where there is none."""
    if len(forms) == 4:
        pairs = five_pose_pairs(forms)
        return pairs.p, pairs.q
    if len(forms) == 3:
        return curve_pairs(forms, samples)
    # Directions spread evenly over the half sphere: the golden angle about z, equal steps of height.
    k = np.arange(samples)
    height, around = (k + 0.5) / samples, np.pi * (3.0 - np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - height**2)
    q = np.stack([flat * np.cos(around), flat * np.sin(around), height], axis=1)
    p = np.cross(q @ forms[0].T, q @ forms[1].T)
    size = np.linalg.norm(p, axis=1, keepdims=True)
    return np.where(size > UNDETERMINED, p / np.maximum(size, LEAST_DIVISOR), np.nan), q


def _place_axes(A: Floats, B: Floats, C: Floats, D: Floats) -> Placed | None:
    """The four-bar of axes in N positions, with its crank angles, modes and residual; None if an arc has no length.

    Args:
        A, D: (3,) fixed axes.
        B, C: (N, 3) moving axes.
    """
    # Of the two senses of an axis that is taken which makes the arcs shorter.
    B = B * np.copysign(1.0, A @ B[0])
    C = C * np.copysign(1.0, D @ C[0])
    arcs = np.stack([_arc(A, B), _arc(B, C), _arc(C, D), np.full(len(B), _arc(A, D))])
    if arcs.min() < NO_LENGTH or np.pi - arcs.max() < NO_LENGTH:
        return None
    crank, coupler, rocker, ground = arcs.mean(axis=1).tolist()
    linkage = SphericalFourBar(crank, coupler, rocker, ground, A, D)
    x = _unit(D - A * (A @ D))
    theta = np.arctan2(B @ np.cross(A, x), B @ x)
    modes = np.where(np.sum(np.cross(B, D) * C, axis=1) >= 0, 1, -1)
    residual = float((arcs.max(axis=1) - arcs.min(axis=1)).max())
    return Placed(linkage, theta, modes[:, None], residual)


def _arc(u: Floats, v: Floats) -> Floats:
    """(*batch,) angle between unit vectors [rad]."""
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=-1), np.sum(u * v, axis=-1))


def _unit(v: Floats) -> Floats:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), LEAST_DIVISOR)


def synthesise_spherical_function(
    inputs: ArrayLike, outputs: ArrayLike, *, ground: float, limits: LinkageLimits = NO_LIMITS
) -> ChainSynthesis:
    """Spherical four-bars that coordinate angles of crank and rocker about axes at a given arc: all there are.

    The axis of the crank is z, that of the rocker lies in the plane of x and z. Of three pairs both angles count from
    that plane; of four the rocker's count from any plane through its axis; of five both do.

    Args:
        inputs: (N,) angles of the crank, N from 3 to 5 [rad].
        outputs: (N,) angles of the rocker, from the arc that goes on beyond its axis [rad].
        ground: arc between the fixed axes, below half a turn [rad].
        limits: least transmission angle, longest arc.

    Raises:
        InputError: another number of angles, two equal angles of the crank, an arc that is not between 0 and pi.
    """
    theta, phi = angle_pairs(inputs, outputs)
    g = positive("ground", ground)
    if g >= np.pi:
        raise InputError("synthesis.arc", value=g)
    task, arcs = np.column_stack([theta, phi]), np.array([[0.0, 0.0, 1.0], [np.sin(g), 0.0, np.cos(g)]])
    if len(theta) == 5:
        placed = _five(theta, phi, arcs)
    else:
        shifts = [0.0] if len(theta) == 3 else rocker_lines(theta, phi, np.cos(g))
        free = any(is_free(theta, phi + shift, np.cos(g)) for shift in shifts or [0.0])
        found = [(K, s) for s in shifts for K in freudenstein_ratios(theta, phi + s, np.cos(g))] if not free else []
        placed = [one for K, s in found if (one := _of_ratios(K, theta, phi + s, g, arcs)) is not None]
    method = f"spherical_function_{len(theta)}"
    return rank_chains(
        [[one] for one in placed], limits, "function", task, method, complete=True, details={"real": len(placed)}
    )


def _about(axis: Floats, angle: Floats) -> Floats:
    """(N, 3, 3) rotations about an axis by angles (N,)."""
    return np.asarray(rotation.exp(axis * angle[:, None]), dtype=np.float64)


def _of_ratios(K: Floats, theta: Floats, phi: Floats, ground: float, arcs: Floats) -> Placed | None:
    """The four-bar of Freudenstein's ratios; None if its coupler's arc is not real.

    Args:
        K: (3,) ratios.
        theta, phi: (N,) angles from the plane of the fixed axes [rad].
        ground: arc between them [rad].
        arcs: (2, 3) the fixed axes.
    """
    a, c = (float(np.arctan2(np.sin(ground), k)) for k in K[:2])
    b = (K[2] + np.cos(ground) / np.tan(a) / np.tan(c)) * np.sin(a) * np.sin(c)
    if abs(b) >= 1.0:
        return None
    y = np.array([0.0, 1.0, 0.0])
    B = _about(arcs[0], theta) @ np.array([np.sin(a), 0.0, np.cos(a)])
    C = _about(arcs[1], phi) @ (_about(y, np.array([ground]))[0] @ np.array([np.sin(c), 0.0, np.cos(c)]))
    return _place_axes(arcs[0], B, C, arcs[1])


def _five(theta: Floats, phi: Floats, axes: Floats) -> list[Placed]:
    """Four-bars through five pairs: dyads of the rocker's orientations as seen from the crank, without the ground."""
    cranks = _about(axes[0], theta)
    seen = np.swapaxes(cranks, 1, 2) @ _about(axes[1], phi)
    steps = seen @ seen[0].T
    pairs = five_pose_pairs(steps[1:] - np.eye(3))
    placed: list[Placed] = []
    for p, q, real in zip(pairs.p, pairs.q, pairs.real, strict=True):
        if real and _arc(p, axes[0]) > SAME_GROUND and np.pi - _arc(p, axes[0]) > SAME_GROUND:
            C = np.einsum("kij,kjl,l->ki", cranks, steps, q)
            one = _place_axes(axes[0], cranks @ p, C, axes[1])
            placed += [] if one is None else [one]
    return placed
