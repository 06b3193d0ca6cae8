"""Between mechanisms (trees of joints of one freedom, loops closed by further joints) and linkages.

Coordinates of chains and trees with their topology: angles that wrap, orientations of balls, bounds of the others.

A ball has three angles, R = rot_x(q_1) rot_y(q_2) rot_z(q_3), which no difference may be taken of: differences of
orientations are rotation vectors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from os import PathLike
from os.path import exists
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, as_batch, frozen, single, whole
from mafsil.errors import InputError, ModelError
from mafsil.geometry import pose, rotation
from mafsil.geometry.euler import from_euler, to_euler
from mafsil.mobility.assembly_existence import closed_beside_drawing, least_gap
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.library import linkage
from mafsil.mobility.linkages.drawing import draw_at, split_joints, without
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.linkage_file import is_linkage, read_linkage
from mafsil.mobility.linkages.linkage_joint import Coupling, Kind, LinkageJoint, across
from mafsil.mobility.linkages.loop_closure import largest_gap
from mafsil.mobility.spaces.configuration_space import SpaceFactor, configuration_space
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.tolerances import CLOSED
from mafsil.mobility.torus import chart
from mafsil.model import Joint, JointKind, Limits, Link, Mechanism, Mimic
from mafsil.model.joint import require_lines
from mafsil.model.library import library_name
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.regular_file import is_file, whole_text
from mafsil.toml_source import LARGEST_FILE, parsed_toml

BALL = "XYZ"
"""Sequence of the angles of a ball, about axes that move with it."""
LinkageLike: TypeAlias = Linkage | FourBar | RobotLike
"""A Linkage, the name of one of the library, whatever names a robot, a TOML file of bodies and joints."""
_KINDS = {
    JointKind.REVOLUTE: Kind.REVOLUTE,
    JointKind.PRISMATIC: Kind.PRISMATIC,
    JointKind.HELICAL: Kind.HELICAL,
    JointKind.FIXED: Kind.FIXED,
    JointKind.CYLINDRICAL: Kind.CYLINDRICAL,
    JointKind.UNIVERSAL: Kind.UNIVERSAL,
    JointKind.SPHERICAL: Kind.SPHERICAL,
    JointKind.PLANAR: Kind.PLANAR,
}
_BACK = {kind: joint_kind for joint_kind, kind in _KINDS.items()}


def as_linkage(source: LinkageLike, q: ArrayLike | None = None) -> Linkage:
    """The linkage behind whatever names one.

    Args:
        source: see LinkageLike.
        q: (n,) coordinates of a mechanism at which it is drawn; zero if None. Linkages are taken as drawn.

    Raises:
        FileError, ModelError: no such name or file, a malformed one, loops that Newton's method could not close.
    """
    if isinstance(source, FourBar):
        source = source.linkage(float(np.mean(source.input_range or 0.0)))
    if isinstance(source, Linkage):
        return source if q is None else draw_at(source, q)
    if isinstance(source, str) and not Path(source).suffix and library_name(source) is None and not exists(source):
        drawn = linkage(source)
        return drawn if q is None else draw_at(drawn, q)
    if isinstance(source, str | PathLike):
        path = Path(source)
        if path.suffix.lower() == ".toml" and is_file(path) and _describes_linkage(path):
            return read_linkage(path)
    return linkage_of(as_mechanism(source, keeps_loops=True), q)


def _describes_linkage(path: Path) -> bool:
    try:
        return is_linkage(parsed_toml(whole_text(path, LARGEST_FILE)))
    except (OSError, ValueError):
        return False


def linkage_of(mechanism: Mechanism, q: ArrayLike | None = None) -> Linkage:
    """A mechanism as a linkage drawn at coordinates; links that are fixed to each other become one body.

    Loops that gape there are closed by Newton's method first, the other coordinates giving way as little as possible.

    Args:
        mechanism: open or with loops.
        q: (n,) coordinates of its tree [rad | m]; zero if None.

    Raises:
        ModelError: nothing moves, or the loops could not be closed.
    """
    if not any(each.moves for each in (*mechanism.coordinates, *mechanism.loops)):
        raise ModelError("mobility.nothing_moves", name=mechanism.name or "-")
    require_lines(mechanism.joints)
    given, T = _place(mechanism, np.zeros(mechanism.n) if q is None else single("q", q, (mechanism.n,)))
    joints = [_drawn(each, T[each.parent] @ each.T_pj, given.get(each.name, 0.0)) for each in mechanism.joints]
    apart: dict[str, Floats] = {}
    for each in mechanism.loops:
        drawn, gap = _drawn_loop(each, T)
        joints.append(drawn)
        if np.abs(gap - np.eye(4)).max() > CLOSED / 100:
            apart[each.name] = frozen(gap)
    couplings = tuple(
        Coupling(each.name, each.mimic.leader, each.mimic.multiplier)
        for each in mechanism.joints
        if each.mimic is not None and each.mimic.multiplier
    )
    whole = Linkage(
        mechanism.name, mechanism.link_names, tuple(joints), mechanism.tip, couplings=couplings, apart=apart
    )  # fmt: skip
    assert whole.ground == mechanism.links[0].name, "assemble puts the base first"
    closed = _close(whole)
    return without(closed, {k for k, each in enumerate(closed.joints) if each.kind is Kind.FIXED})


def _place(mechanism: Mechanism, q: Floats) -> tuple[dict[str, float], dict[str, Floats]]:
    """Coordinates of the joints, followers too, and poses (4, 4) of the links in {s}, at coordinates (n,)."""
    given = {each.name: float(v) for each, v in zip(mechanism.coordinates, q, strict=True)}
    given |= {
        each.name: each.mimic.value(given[each.mimic.leader]) for each in mechanism.joints if each.mimic is not None
    }
    T: dict[str, Floats] = {mechanism.links[0].name: np.asarray(mechanism.T_sb)}
    for each in mechanism.joints:
        T[each.child] = T[each.parent] @ each.T_pj @ pose.exp(each.screw * given.get(each.name, 0.0))
    return given, T


def _drawn_loop(each: Joint, T: dict[str, Floats]) -> tuple[LinkageJoint, Floats]:
    """A joint that closes a loop, at the coordinates that come nearest, and the displacement (4, 4) that it misses."""
    T_p = T[each.parent] @ each.T_pj
    T_pc = pose.inverse(T_p) @ T[each.child]
    at = _coordinate(each, T_pc)
    drawn = _drawn(each, T_p, at, about=_first_angle(each, T_pc[:3, :3]))
    return drawn, T_p @ _allow(each, T_pc, at) @ pose.inverse(T[each.child])


def _close(whole: Linkage) -> Linkage:
    """A linkage drawn where its loops close, near where it was drawn.

    Raises:
        ModelError: they could not be closed; the sentence says by how much they miss.
    """
    if float(largest_gap(whole)) <= CLOSED:
        return draw_at(whole, np.zeros(whole.coordinates)) if whole.apart else whole
    theta = closed_beside_drawing(whole)
    if theta is None:
        joint, distance, angle = least_gap(whole)
        raise ModelError("mobility.cannot_close", name=whole.name or "-", joint=joint, distance=distance, angle=angle)
    return draw_at(whole, theta)


def _coordinate(each: Joint, T_pc: Floats) -> float:
    """Coordinate of a joint of one freedom that comes nearest to a displacement [rad | m]; zero for others."""
    along = float(each.axis @ T_pc[:3, 3])
    match each.kind:
        case JointKind.REVOLUTE:
            return _angle(each.axis, T_pc[:3, :3])
        case JointKind.PRISMATIC:
            return along
        case JointKind.HELICAL:
            angle = _angle(each.axis, T_pc[:3, :3])
            return angle + 2 * np.pi * round((along / each.pitch - angle) / (2 * np.pi))
        case _:
            return 0.0


def _allow(each: Joint, T_pc: Floats, at: float) -> Floats:
    """(4, 4) the displacement from {p} to {c} that a joint allows, the nearest; `at` its coordinate if it has one."""
    X, R, along = np.eye(4), T_pc[:3, :3], each.axis * float(each.axis @ T_pc[:3, 3])
    match each.kind:
        case JointKind.SPHERICAL:
            X[:3, :3] = R
        case JointKind.UNIVERSAL:
            first = _rotation(each.axis, _first_angle(each, R))
            X[:3, :3] = first @ _rotation(each.second, _angle(each.second, first.T @ R))
        case JointKind.CYLINDRICAL:
            X[:3, :3], X[:3, 3] = _rotation(each.axis, _angle(each.axis, R)), along
        case JointKind.PLANAR:
            X[:3, :3], X[:3, 3] = _rotation(each.axis, _angle(each.axis, R)), T_pc[:3, 3] - along
        case _:
            X = np.asarray(pose.exp(each.screw * at), dtype=np.float64)
    return X


def _first_angle(each: Joint, R_pc: Floats) -> float:
    """Angle of a universal joint about its axis on the parent [rad]; zero for other joints."""
    if each.kind is not JointKind.UNIVERSAL:
        return 0.0
    seen = R_pc @ each.second
    return float(np.arctan2(np.cross(each.axis, each.second) @ seen, each.second @ seen))


def _angle(axis: Floats, R: Floats) -> float:
    """Angle about an axis that comes nearest to a rotation [rad]."""
    first, second = across(axis)
    return float(np.arctan2(second @ R @ first - first @ R @ second, first @ R @ first + second @ R @ second))


def _rotation(axis: Floats, angle: float) -> Floats:
    return pose.exp(np.concatenate([axis * angle, np.zeros(3)]))[:3, :3]


def _drawn(each: Joint, T: Floats, at: float, about: float = 0.0) -> LinkageJoint:
    """A joint where its frame stands, at its coordinate; a universal joint about the axis on its parent."""
    axis = T[:3, :3] @ each.axis
    second = T[:3, :3] @ _rotation(each.axis, about) @ each.second
    point = T[:3, 3] + (axis * at if each.kind is JointKind.PRISMATIC else 0.0)
    still = each.mimic is not None and not each.mimic.multiplier
    kind = Kind.FIXED if still else _KINDS[each.kind]
    return LinkageJoint(
        each.name, kind, each.parent, each.child, frozen(point), frozen(axis / np.linalg.norm(axis)),
        second=frozen(second / np.linalg.norm(second)), pitch=each.pitch, actuated=each.actuated and each.mimic is None,
        lower=each.limits.lower - at, upper=each.limits.upper - at,
    )  # fmt: skip


@on_linkage
def mechanism_of(linkage: Linkage) -> Mechanism:
    """A linkage as a mechanism: a tree of joints of one freedom, and loops closed by the joints left over.

    The home configuration is the drawing. Frames of links stand in the joint that carries them; a loop ends in a
    massless link fixed to its child, in the joint that closes it. Coordinates are those of the tree.

    Args:
        linkage: closed where it is drawn.

    Raises:
        ModelError: it gapes there, is drawn apart, couples a joint that closes a loop, or has a cam.
    """
    gap = float(largest_gap(linkage))
    if gap > CLOSED:
        raise ModelError("mobility.gapes", name=linkage.name or "-", gap=gap)
    fine = split_joints(linkage)
    closing = {fine.joints[k].name for k in fine.closing}
    for each in fine.couplings:
        if each.table or {each.follower, each.leader} & closing:
            raise ModelError("mobility.coupled_closing", follower=each.follower, leader=each.leader)
    mimics = {each.follower: Mimic(each.leader, each.ratio) for each in fine.couplings}
    origins = {fine.ground: np.zeros(3)}
    joints: list[Joint] = []
    for k, forward in fine.tree:
        each = fine.joints[k]
        parent, child = (each.parent, each.child) if forward else (each.child, each.parent)
        origins[child] = np.asarray(each.point)
        drawn = _model_joint(each, parent, child, origins[parent], 1.0 if forward else -1.0)
        joints.append(replace(drawn, mimic=mimics.get(each.name)))
    links = [Link(body) for body in fine.bodies]
    loops: list[Joint] = []
    for k in fine.closing:
        each, end = fine.joints[k], f"{fine.joints[k].name}.end"
        links.append(Link(end))
        T = pose.from_translation(each.point - origins[each.child])
        joints.append(Joint(f"{end}.fixed", JointKind.FIXED, each.child, end, T))
        loops.append(_model_joint(each, each.parent, end, origins[each.parent], 1.0))
    return Mechanism.assemble(fine.name or "linkage", links, joints, loops=loops, tip=fine.output)


def _model_joint(each: LinkageJoint, parent: str, child: str, origin: Floats, sense: float) -> Joint:
    return Joint(
        each.name, _BACK[each.kind], parent, child, pose.from_translation(each.point - origin), sense * each.axis,
        pitch=each.pitch, limits=Limits(each.lower, each.upper), actuated=each.actuated,
    )  # fmt: skip


def theta_of_tree(linkage: Linkage, theta: ArrayLike) -> Floats:
    """(*batch, n) coordinates of `mechanism_of(linkage)`, of coordinates (*batch, F) of the linkage."""
    value = as_batch("theta", theta, (linkage.coordinates,))
    fine = split_joints(linkage)
    order = [k for k, _ in fine.tree]
    first = np.concatenate([[0], np.cumsum([each.freedoms for each in fine.joints])])
    mechanism = mechanism_of(linkage)
    where = {fine.joints[k].name: int(first[k]) for k in order}
    return value[..., [where[name] for name in mechanism.joint_names]]


@dataclass(frozen=True, eq=False)
class JointCoordinates:
    """Coordinates of a chain: free angles wrap, balls have orientations, the others have bounds.

    Attributes:
        wraps: (n,) which coordinates are angles that go round.
        lower, upper: (n,) bounds of the others; infinite where there are none.
        balls: indices of the first of three angles of each orientation.
    """

    wraps: Booleans
    lower: Floats
    upper: Floats
    balls: tuple[int, ...] = ()

    @classmethod
    def of(cls, linkage: Linkage) -> JointCoordinates:
        """Those of a chain or tree.

        Raises:
            InputError: it has loops, or joints that follow others.
        """
        return _of(linkage)

    def difference(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """(*batch, n) b - a, the short way round where coordinates wrap; of balls the rotation vector from a to b."""
        n = len(self.wraps)
        first, last = as_batch("a", a, (n,)), as_batch("b", b, (n,))
        step = np.where(self.wraps, wrap_angle(last - first), last - first)
        for k in self.balls:
            R_a, R_b = (from_euler(q[..., k : k + 3], BALL) for q in (first, last))
            step[..., k : k + 3] = rotation.log(np.swapaxes(R_a, -1, -2) @ R_b)
        return step

    def distance(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """(*batch,) Euclidean length of the difference."""
        return np.linalg.norm(self.difference(a, b), axis=-1)

    def inside(self, q: ArrayLike) -> Booleans:
        """(*batch,) whether coordinates keep their bounds; angles that wrap always do."""
        value = as_batch("q", q, (len(self.wraps),))
        good = self.wraps | ((value >= self.lower) & (value <= self.upper))
        return np.asarray(good.all(axis=-1), dtype=np.bool_)

    def wrap_angles(self, q: ArrayLike) -> Floats:
        """(*batch, n) with angles that wrap in [0, 2 pi)."""
        value = as_batch("q", q, (len(self.wraps),))
        return np.where(self.wraps, chart(value), value)

    def sample(self, count: int, seed: int = 0) -> Floats:
        """(count, n) uniform samples; orientations too are uniform.

        Raises:
            InputError: a coordinate has no bounds, so that there is no uniform distribution.
        """
        if not np.isfinite(self.upper - self.lower).all():
            raise InputError("mobility.unbounded", index=int(np.argmin(np.isfinite(self.upper - self.lower))))
        rng, rows = np.random.default_rng(seed), whole("count", count, 0)
        q: Floats = rng.uniform(self.lower, self.upper, (rows, len(self.wraps)))
        for k in self.balls:
            q[:, k : k + 3] = chart(to_euler(rotation.random(rng, rows), BALL))
        return q


@on_linkage
def _of(linkage: Linkage) -> JointCoordinates:
    space = configuration_space(linkage)
    if linkage.couplings:
        raise InputError("mobility.followers", name=linkage.name or "-")
    wraps, balls = list[bool](), list[int]()
    for factor in space.factors:
        if factor is SpaceFactor.ROTATIONS:
            balls.append(len(wraps))
        wraps += [factor in (SpaceFactor.CIRCLE, SpaceFactor.ROTATIONS)] * factor.dimension
    bounds = np.array([(each.lower, each.upper) for each in linkage.joints for _ in range(each.freedoms)])
    low, high = bounds.reshape(-1, 2).T
    around = np.array(wraps, dtype=np.bool_)
    return JointCoordinates(around, np.where(around, 0.0, low), np.where(around, 2 * np.pi, high), tuple(balls))
