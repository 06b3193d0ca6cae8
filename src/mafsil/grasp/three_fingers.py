"""Three contacts with friction in space: the theorem of Li, Liu and Cai, and its proof as an algorithm for forces.

The three points span a plane S. The grasp closes iff every cone cuts S in a plane cone and these three plane cones
close in S.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import acos, asin, cos, sin, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, PoseMatrix, as_batch
from mafsil.errors import InputError, MafsilError
from mafsil.grasp.closure import Closure, closure
from mafsil.grasp.contact import Contact
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.tolerances import COLLINEAR, ROUNDOFF, TYPED
from mafsil.solvers.linear_program import minimise


class Section(Enum):
    """How a cone with its apex on S meets S."""

    CONE = "cone"
    LINE = "line"
    POINT = "point"


@dataclass(frozen=True, eq=False)
class PlaneSection:
    """A friction cone cut by S.

    Attributes:
        kind: a plane cone, one ray, or only the apex.
        tilt: angle phi of the normal from S [rad].
        half_angle: beta = acos(cos alpha / cos phi) of the plane cone [rad]; 0 if none.
        direction: (2,) middle of the plane cone in S; zero if the normal is normal to S.
    """

    kind: Section
    tilt: float
    half_angle: float
    direction: Floats

    @property
    def edges(self) -> Floats:
        """(2, 2) unit edges in rows."""
        c, s = cos(self.half_angle), sin(self.half_angle)
        x, y = self.direction
        return np.array([[c * x + s * y, -s * x + c * y], [c * x - s * y, s * x + c * y]])


class ThreeFingerStatus(Status):
    """Whether three contacts close, and why not."""

    CLOSED = ("grasp.three_closed", True)
    COLLINEAR = ("grasp.three_collinear", False)
    NO_SECTION = ("grasp.three_no_section", False)
    OPEN = ("grasp.three_open", False)


@dataclass(frozen=True, eq=False, repr=False)
class ThreeFingers(Answer, data="force_closure certificate"):
    """Verdict of the theorem, true if the grasp is force closure.

    Attributes:
        collinear: the points lie on one line: never closed.
        pose: (4, 4) of the frame of S in the frame of the body: z normal to S, origin in the middle.
        sections: of the three cones.
        planar: closure of the sections in S, if all three are plane cones.
        certificate: (6,) the wrench (m, f) that is not resisted where a cone does not cut S in a plane cone: a moment
            about the line through the other two contacts; None otherwise.
    """

    collinear: bool
    pose: PoseMatrix | None
    sections: tuple[PlaneSection, ...]
    planar: Closure | None
    certificate: Floats | None = None

    @property
    def force_closure(self) -> bool:
        """Whether the grasp is force closure."""
        return self.planar is not None and self.planar.force_closure

    def explain(self, language: str | None = None) -> str:
        """The verdict with its reason."""
        return self.status.sentence(language, contacts=", ".join(map(str, self._without_section)))

    @property
    def status(self) -> ThreeFingerStatus:
        """Closed, or why not."""
        if self.collinear:
            return ThreeFingerStatus.COLLINEAR
        if self._without_section:
            return ThreeFingerStatus.NO_SECTION
        return ThreeFingerStatus.CLOSED if self.force_closure else ThreeFingerStatus.OPEN

    @property
    def _without_section(self) -> list[int]:
        return [i for i, section in enumerate(self.sections) if section.kind is not Section.CONE]

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"half_angles": [section.half_angle for section in self.sections]}


@dataclass(frozen=True, eq=False)
class ThreeForces:
    """Explicit forces against one external wrench.

    Attributes:
        forces: (3, 3) on the body, in its frame [N].
        normal_part: (3,) forces along the normal of S [N].
        in_plane: (3, 2) particular forces in S, of least norm [N].
        internal: (3, 2) internal forces for a squeeze of 1, strictly inside the sections.
        squeeze: smallest sufficient multiple of the internal forces.
        residual: |sum of wrenches + external|.
    """

    forces: Floats
    normal_part: Floats
    in_plane: Floats
    internal: Floats
    squeeze: float
    residual: float


def cone_section(normal: ArrayLike, alpha: float) -> PlaneSection:
    """A circular cone with its apex in the plane z = 0, cut by that plane.

    Args:
        normal: (3,) unit axis of the cone.
        alpha: its half opening [rad].
    """
    n = as_batch("normal", normal, (3,), finite=True)
    flat = float(np.hypot(n[0], n[1]))
    tilt = asin(min(1.0, abs(float(n[2]))))
    if tilt > alpha + ROUNDOFF or flat == 0.0:
        return PlaneSection(Section.POINT, tilt, 0.0, np.zeros(2))
    if tilt >= alpha - ROUNDOFF:
        return PlaneSection(Section.LINE, tilt, 0.0, n[:2] / flat)
    return PlaneSection(Section.CONE, tilt, acos(min(1.0, cos(alpha) / cos(tilt))), n[:2] / flat)


def three_fingers(contacts: Sequence[Contact]) -> ThreeFingers:
    """The theorem's test of three hard contacts in space.

    Args:
        contacts: three of them.

    Raises:
        InputError: not three, or not in space.

    Reference:
        J.-W. Li, H. Liu, H.-G. Cai, On computing three-finger force-closure grasps of 2-D and 3-D objects, IEEE Trans.
        Robotics and Automation 19(1), 2003.
    """
    if len(contacts) != 3 or contacts[0].dimension != 3:
        raise InputError("grasp.needs_three", got=len(contacts))
    pose = _plane_frame(contacts)
    if pose is None:
        return ThreeFingers(True, None, (), None)
    sections = tuple(cone_section(pose[:3, :3].T @ c.normal, c.alpha) for c in contacts)
    missing = [i for i, section in enumerate(sections) if section.kind is not Section.CONE]
    if missing:
        return ThreeFingers(False, pose, sections, None, _moment_about_the_others(contacts, missing[0]))
    return ThreeFingers(False, pose, sections, closure(_planar_matrix(_flat_points(contacts, pose), sections)))


def three_finger_forces(
    contacts: Sequence[Contact], wrench: ArrayLike, internal: ArrayLike | None = None
) -> ThreeForces:
    """Contact forces against any external wrench, by the constructive proof of the theorem.

    The parts normal to S follow from three equations; parts in S of least norm balance the rest; internal forces
    strictly inside the sections are added until all forces are in their cones.

    Args:
        contacts: three that close.
        wrench: (6,) external (m, f) on the body [N m, N].
        internal: (3, 3) internal forces of the body's frame to squeeze with; those deepest inside the sections if None.

    Raises:
        InputError: the grasp is no force closure, or the internal forces are not internal.
    """
    found = three_fingers(contacts)
    if not found.force_closure or found.pose is None:
        raise InputError("grasp.three_not_closed", reason=found.explain())
    pose = found.pose
    m, f = _in_frame(as_batch("wrench", wrench, (6,), finite=True), pose)
    points = _flat_points(contacts, pose)
    x, y = points.T
    balance = np.array([np.ones(3), y, -x])
    normal_part: Floats = np.asarray(np.linalg.solve(balance, -np.array([f[2], m[0], m[1]])), float)
    planar = np.array([[1.0, 0, 1, 0, 1, 0], [0, 1, 0, 1, 0, 1], np.column_stack([-y, x]).ravel()])
    in_plane = (np.linalg.pinv(planar) @ -np.array([f[0], f[1], m[2]])).reshape(3, 2)
    eta = _deepest_internal(points, found.sections) if internal is None else _given_internal(internal, pose, planar)
    base = np.column_stack([in_plane, normal_part]) @ pose[:3, :3].T
    push = np.column_stack([eta, np.zeros(3)]) @ pose[:3, :3].T
    squeeze = max(_least_squeeze(c, a, b) for c, a, b in zip(contacts, base, push, strict=True))
    forces = base + squeeze * push
    left = np.concatenate([np.sum(np.cross([c.point for c in contacts], forces), axis=0), forces.sum(axis=0)])
    return ThreeForces(
        forces, normal_part, in_plane, eta, squeeze, float(np.linalg.norm(left + np.asarray(wrench, float)))
    )


def _moment_about_the_others(contacts: Sequence[Contact], i: int) -> Floats:
    """Y = +-(u, p_j x u), u along the line through the other two: they have no part in it, contact i has one sense."""
    j, k = (index for index in range(3) if index != i)
    line = contacts[k].point - contacts[j].point
    u = line / np.linalg.norm(line)
    y = np.concatenate([u, np.cross(contacts[j].point, u)])
    return y if float(y @ contacts[i].basis[:, 0]) >= 0 else -y


def planar_slice(contacts: Sequence[Contact]) -> tuple[Grasp, PoseMatrix]:
    """Three contacts in space as a plane grasp on the plane S through them, and the pose of S in the body.

    The points are in the frame of S, normals are their projections, and mu is the tangent of the section's half angle:
    the grasp in space closes if and only if this one does.

    Args:
        contacts: three of them, each of whose cones cuts S in a plane cone.

    Raises:
        InputError: not three in space, on one line, or a cone without a section.
    """
    found = three_fingers(contacts)
    if found.pose is None or any(s.kind is not Section.CONE for s in found.sections):
        raise InputError("grasp.no_slice", reason=found.explain())
    points = _flat_points(contacts, found.pose)
    flat = [
        Contact(p, s.direction, tan(s.half_angle), name=c.name)
        for p, s, c in zip(points, found.sections, contacts, strict=True)
    ]
    return Grasp(flat), found.pose


def _plane_frame(contacts: Sequence[Contact]) -> PoseMatrix | None:
    points = np.array([c.point for c in contacts])
    edges = points[[1, 2, 2]] - points[[0, 0, 1]]
    longest = float(np.linalg.norm(edges, axis=1).max())
    z = np.cross(edges[0], edges[1])
    if not np.linalg.norm(z) > COLLINEAR * longest**2:
        return None
    z /= np.linalg.norm(z)
    helper = np.array([1.0, 0, 0]) if abs(z[0]) < 0.9 else np.array([0, 1.0, 0])
    x = helper - (helper @ z) * z
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = points.mean(axis=0)
    return T


def _flat_points(contacts: Sequence[Contact], pose: PoseMatrix) -> Floats:
    return (np.array([c.point for c in contacts]) - pose[:3, 3]) @ pose[:3, :2]


def _in_frame(wrench: Floats, pose: PoseMatrix) -> tuple[Floats, Floats]:
    """Moment about the origin of the frame, and force, in its axes."""
    m, f = wrench[:3] - np.cross(pose[:3, 3], wrench[3:]), wrench[3:]
    return pose[:3, :3].T @ m, pose[:3, :3].T @ f


def _planar_matrix(points: Floats, sections: Sequence[PlaneSection]) -> Floats:
    """(3, 6) wrenches (m, f_x, f_y) of the edges of the sections."""
    columns = [[p[0] * e[1] - p[1] * e[0], *e] for p, s in zip(points, sections, strict=True) for e in s.edges]
    return np.array(columns).T


def _deepest_internal(points: Floats, sections: Sequence[PlaneSection]) -> Floats:
    """Internal forces whose smallest edge coefficient is greatest, of total 3."""
    A = _planar_matrix(points, sections)
    equal = np.vstack([np.column_stack([A, A.sum(axis=1)]), np.append(np.ones(6), 6.0)])
    best = minimise(np.append(np.zeros(6), -1.0), equal, np.array([0.0, 0, 0, 3.0]))
    assert best is not None, "the plane grasp closes"
    x = (best.x[:6] + best.x[6]).reshape(3, 2)
    return np.array([x[i] @ sections[i].edges for i in range(3)])


def _given_internal(internal: ArrayLike, pose: PoseMatrix, planar: Floats) -> Floats:
    eta = as_batch("internal", internal, (3, 3), finite=True) @ pose[:3, :3]
    size = float(np.abs(eta).max())
    if np.abs(eta[:, 2]).max() > TYPED * size or np.abs(planar @ eta[:, :2].ravel()).max() > TYPED * size:
        raise InputError("grasp.not_internal")
    return eta[:, :2]


def _least_squeeze(contact: Contact, base: Floats, push: Floats) -> float:
    """Smallest s >= 0 from which on base + s push stays in the cone; |t|^2 = mu^2 n^2 is a quadratic in s."""
    n = contact.normal
    a, b = float(base @ n), float(push @ n)
    ta, tb = base - a * n, push - b * n
    mu2 = contact.mu**2
    quadratic = [tb @ tb - mu2 * b * b, 2 * (ta @ tb - mu2 * a * b), ta @ ta - mu2 * a * a]
    if not (quadratic[0] < 0 and b > 0):
        raise MafsilError("grasp.not_internal")
    half, rest = quadratic[1] / 2, quadratic[0] * quadratic[2]
    greatest = (-half - np.sqrt(max(0.0, half * half - rest))) / quadratic[0]
    return max(0.0, float(greatest), -a / b)
