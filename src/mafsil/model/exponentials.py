"""Screws and home pose: the product-of-exponentials description of an arm, turned into a mechanism.

Space form: T(q) = exp([S_1] q_1) ... exp([S_n] q_n) home. Body form: T(q) = home exp([B_1] q_1) ... exp([B_n] q_n),
B_i = Ad(home^-1) S_i. A screw is (omega, v): revolute (w, -w x p), helical (w, -w x p + pitch w), prismatic (0, v).
For reading: the table of omega and v, the matrices [S_i], and how many numbers each description needs.

`serial_arm` makes an arm of one joint after the other from lists of parts: what screws and other tables turn into.

Reference: Lynch & Park, Modern Robotics, ch. 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypedDict, TypeVar, Unpack

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, Vector6, as_batch, frozen
from mafsil.errors import InputError, ModelError
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Actuator, Friction, Limits
from mafsil.model.link import Inertial, Link, moved_inertial
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism, Provenance
from mafsil.model.placement import adjoint, checked_pose, frame_along, inverse, skew
from mafsil.model.tolerances import PRINTED, SHOWN_AS_ZERO

_Part = TypeVar("_Part")


class Screws(NamedTuple):
    """Product-of-exponentials parameters of a chain of n joints.

    Attributes:
        S_s: (n, 6) screw axes at q = 0 in the space frame.
        S_b: (n, 6) the same in the tip frame.
        home: (4, 4) pose of the tip at q = 0 in the space frame.
    """

    S_s: Floats
    S_b: Floats
    home: PoseMatrix


def mechanism_from_screws(
    screws: ArrayLike,
    home: ArrayLike,
    *,
    form: Literal["space", "body"] = "space",
    normalise: bool = False,
    inertial_frames: Sequence[PoseMatrix] | None = None,
    **parts: Unpack[ArmParts],
) -> Mechanism:
    """The serial arm of a product of exponentials.

    A link's frame sits on the axis of its joint, z along it, at the point nearest to the frame of the link before
    (for the first, to the origin of {s}; a prismatic joint, which has no point, keeps the origin before it). The
    base link is {s}.

    Args:
        screws: (n, 6) screw axes (omega, v) at q = 0: unit omega, or omega = 0 and unit v.
        home: (4, 4) pose of the tip at q = 0 in the space frame.
        form: `space` if the screws are given in {s}, `body` if in the tip frame.
        normalise: scale every screw to unit length. This changes what q_i means, so it has to be requested.
        inertial_frames: n poses (4, 4) at q = 0 in {s} of the frames in which `inertials` are given; the links' own
            frames by default.
        **parts: name, inertials, limits, actuators, frictions, joint_names, link_names, gravity, provenance: see
            `ArmParts`.

    Raises:
        ModelError: a screw is zero or not of unit length, home is no pose, an unknown form, a list of another length.
        InputError: wrong shapes, NaN or infinite numbers.
    """
    home_pose = checked_pose("home", home)
    given = np.atleast_2d(as_batch("screws", screws, (6,), finite=True))
    if form not in ("space", "body"):
        raise ModelError("screws.form", value=form)
    if given.ndim != 2:
        raise InputError("input.shape", name="screws", expected="(n, 6)", got=given.shape, hint="")
    if not len(given):
        raise ModelError("screws.none")
    axes = [_unit_screw(S, i, normalise) for i, S in enumerate(given, start=1)]
    if form == "body":
        axes = [adjoint(home_pose) @ S for S in axes]
    if inertial_frames is not None and len(inertial_frames) != len(axes):
        raise ModelError("serial.length", name="inertial_frames", got=len(inertial_frames), expected=len(axes))
    places: list[JointPlace] = []
    T_sp = np.eye(4)
    for i, S in enumerate(axes):
        kind, direction, pitch = kind_of_screw(S)
        T_sj = frame_on_screw(S, kind, direction, pitch, T_sp[:3, 3])
        frame = T_sj if inertial_frames is None else checked_pose("inertial_frames", inertial_frames[i])
        places.append(JointPlace(kind, inverse(T_sp) @ T_sj, inverse(T_sj) @ frame, pitch))
        T_sp = T_sj
    return serial_arm(places, base=None, T_lt=inverse(T_sp) @ home_pose, **parts)


def chain_to_tip(mechanism: Mechanism) -> tuple[Joint, ...]:
    """The joints between the base and the tip link, base first."""
    carrying = {joint.child: joint for joint in mechanism.joints}
    chain: list[Joint] = []
    link = mechanism.tip
    while link in carrying:
        chain.append(carrying[link])
        link = carrying[link].parent
    return tuple(reversed(chain))


def kind_of_screw(S: Vector6) -> tuple[JointKind, Vector3, float]:
    """Joint kind, unit direction (3,) and pitch [m/rad] of a unit screw (omega, v).

    Six decimals leave a pitch omega . v of up to 5e-7 (|omega|_1 + |v|_1), which no machine screw has: it is none.
    """
    omega, v = S[:3], S[3:]
    if not omega.any():
        return JointKind.PRISMATIC, v, 0.0
    pitch = float(omega @ v)
    if abs(pitch) <= PRINTED * (1.0 + float(np.linalg.norm(v))):
        return JointKind.REVOLUTE, omega, 0.0
    return JointKind.HELICAL, omega, pitch


def _unit_screw(S: Vector6, index: int, normalise: bool) -> Vector6:
    """The screw with omega, or v if there is no rotation, of length exactly one."""
    rotation = float(np.linalg.norm(S[:3]))
    prismatic = rotation <= PRINTED
    length = float(np.linalg.norm(S[3:])) if prismatic else rotation
    if length == 0.0:
        raise ModelError("screws.zero", index=index)
    if abs(length - 1.0) > PRINTED and not normalise:
        raise ModelError("screws.unit", index=index, length=length)
    return np.concatenate([np.zeros(3) if prismatic else S[:3], S[3:]]) / length


def frame_on_screw(S: Vector6, kind: JointKind, direction: Vector3, pitch: float, near: Vector3) -> PoseMatrix:
    """(4, 4) frame with z along the axis of a screw, at the point of it nearest to `near`."""
    T = np.eye(4)
    T[:3, :3] = frame_along(direction)
    T[:3, 3] = near
    if kind is not JointKind.PRISMATIC:
        foot = np.cross(direction, S[3:] - pitch * direction)
        T[:3, 3] = foot + direction * (direction @ (near - foot))
    return T


def screw_matrices(S: ArrayLike) -> Floats:
    """(n, 4, 4) matrices [S] = [[ [omega], v ], [0, 0]] of screws (n, 6); the last row is zero.

    Args:
        S: (n, 6) screws (omega, v).
    """
    axes = np.atleast_2d(as_batch("S", S, (6,), finite=True))
    matrices = np.zeros((len(axes), 4, 4))
    for matrix, axis in zip(matrices, axes, strict=True):
        matrix[:3, :3], matrix[:3, 3] = skew(axis[:3]), axis[3:]
    return matrices


def screw_table(screws: Screws, form: str = "space") -> str:
    """The table i, omega_i, v_i as text, then every [S_i] (or [B_i]).

    Args:
        screws: of an arm.
        form: `space` or `body`.
    """
    axes, letter = (screws.S_b, "B") if form == "body" else (screws.S_s, "S")
    rows = [f"{'i':>3}  {'omega_i':^27}  {'v_i':^27}"]
    rows += [f"{i:>3}  {_triple(S[:3])}  {_triple(S[3:])}" for i, S in enumerate(axes, 1)]
    for i, matrix in enumerate(screw_matrices(axes), 1):
        rows += ["", f"[{letter}_{i}] ="]
        rows += ["  [" + " ".join(_number(x) for x in line) + " ]" for line in matrix]
    return "\n".join(rows) + "\n"


class Representation(NamedTuple):
    """One way to describe an arm of n joints.

    Attributes:
        name: `denavit_hartenberg`, `free_frames`, `exponentials` or `local_exponentials`.
        numbers: parameters written down, joint coordinates not counted.
        independent: how many constants the arm has with fixed and tip frame prescribed, however it is described.
        needs_link_frames: whether a frame has to be put on every link.
    """

    name: str
    numbers: int
    independent: int
    needs_link_frames: bool


def representations(revolute: int, prismatic: int = 0) -> tuple[Representation, ...]:
    """How many numbers each description of an arm takes.

    A table has four per joint, the zero of the joint's own coordinate among them, and covers only the fixed and tip
    frames that its rules choose; base and tool poses add six each when others are prescribed. A revolute axis is a
    line, four independent numbers; a prismatic axis is a direction, two; prescribed frames at both ends add six.

    Args:
        revolute, prismatic: numbers of joints.

    Returns:
        One entry per description.
    """
    n = revolute + prismatic
    independent = 4 * revolute + 2 * prismatic + 6
    return (
        Representation("denavit_hartenberg", 4 * n, independent, True),
        Representation("free_frames", 6 * n, independent, True),
        Representation("exponentials", 6 * n + 6, independent, False),
        Representation("local_exponentials", 12 * n, independent, True),
    )


def _triple(x: Floats) -> str:
    return "(" + " ".join(_number(value) for value in x) + ")"


def _number(value: float) -> str:
    return f"{0.0 if abs(value) < SHOWN_AS_ZERO else value:8.4g}"


class ArmParts(TypedDict, total=False):
    """What an arm has besides its kinematics; every key may be left out.

    Attributes:
        name: of the robot.
        inertials: n mass properties, or None for a massless link.
        limits, actuators, frictions: n each.
        joint_names: n names; `joint1`, `joint2` ... by default.
        link_names: n + 1 names, the base first; `base`, `link1` ... by default.
        gravity: (3,) acceleration in the space frame [m/s^2].
        provenance: where the numbers come from.
    """

    name: str
    inertials: Sequence[Inertial | None] | None
    limits: Sequence[Limits] | None
    actuators: Sequence[Actuator | None] | None
    frictions: Sequence[Friction | None] | None
    joint_names: Sequence[str] | None
    link_names: Sequence[str] | None
    gravity: Vector3 | tuple[float, float, float]
    provenance: Provenance


@dataclass(frozen=True, eq=False, slots=True)
class JointPlace:
    """Kinematics of one joint of an arm.

    Attributes:
        kind: revolute, prismatic or helical.
        T_pj: (4, 4) joint frame in the link before.
        T_li: (4, 4) frame of the link in which the user gives its mass properties, in the joint frame.
        pitch: of a helical joint [m/rad].
        axis: (3,) unit direction in the joint frame.
    """

    kind: JointKind
    T_pj: PoseMatrix
    T_li: PoseMatrix
    pitch: float = 0.0
    axis: Vector3 = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))


def serial_arm(
    places: Sequence[JointPlace],
    *,
    base: ArrayLike | None,
    T_lt: PoseMatrix,
    name: str = "robot",
    inertials: Sequence[Inertial | None] | None = None,
    limits: Sequence[Limits] | None = None,
    actuators: Sequence[Actuator | None] | None = None,
    frictions: Sequence[Friction | None] | None = None,
    joint_names: Sequence[str] | None = None,
    link_names: Sequence[str] | None = None,
    gravity: Vector3 | tuple[float, float, float] = STANDARD_GRAVITY,
    provenance: Provenance = Provenance(),
) -> Mechanism:
    """Joints in a row, from the base to the tip.

    Args:
        places: n joints.
        base: (4, 4) pose of the base link in the space frame; identity if None.
        T_lt: (4, 4) pose of the tip in the last link.
        name, inertials, limits, actuators, frictions, joint_names, link_names, gravity, provenance: see `ArmParts`.

    Raises:
        ModelError: a list has another length than it should, or a name is used twice.
        InputError: `base` or `gravity` has another shape or is not finite.
    """
    n = len(places)
    chain = _list("link_names", link_names, ["base", *(f"link{i + 1}" for i in range(n))])
    names = _list("joint_names", joint_names, [f"joint{i + 1}" for i in range(n)])
    bounds = _list("limits", limits, [Limits()] * n)
    motors: list[Actuator | None] = _list("actuators", actuators, [None] * n)
    brakes: list[Friction | None] = _list("frictions", frictions, [None] * n)
    masses: list[Inertial | None] = _list("inertials", inertials, [None] * n)
    return Mechanism.assemble(
        name,
        (Link(chain[0]), *(Link(chain[i + 1], _move(masses[i], places[i].T_li)) for i in range(n))),
        (
            Joint(
                name=names[i],
                kind=place.kind,
                parent=chain[i],
                child=chain[i + 1],
                T_pj=frozen(place.T_pj),
                pitch=place.pitch,
                axis=frozen(place.axis),
                limits=bounds[i],
                actuator=motors[i],
                friction=brakes[i],
            )
            for i, place in enumerate(places)
        ),
        tip=chain[-1],
        T_lt=T_lt,
        T_sb=np.eye(4) if base is None else checked_pose("base", base),
        gravity=as_batch("gravity", gravity, (3,), finite=True),
        provenance=provenance,
    )


def _move(inertial: Inertial | None, T_li: PoseMatrix) -> Inertial | None:
    return None if inertial is None else moved_inertial(inertial, T_li)


def _list(what: str, parts: Sequence[_Part] | None, default: list[_Part]) -> list[_Part]:
    """The parts given, as many as the default has, or the default."""
    if parts is None:
        return default
    if len(parts) != len(default):
        raise ModelError("serial.length", name=what, got=len(parts), expected=len(default))
    return list(parts)
