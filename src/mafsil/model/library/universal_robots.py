"""Arms of Universal Robots: the maker's Denavit-Hartenberg tables, masses and tensors; tip at the flange."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, radians

from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.outline import Drum, Outline, Tube, housing, inertial, with_outline
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism, Provenance

JOINT_NAMES = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
LINK_NAMES = ("base", "shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")

_SOURCE = (
    "Universal Robots, DH parameters for calculations of kinematics and dynamics (support article); joint ranges and"
    " speeds: e-Series user manuals; torques: support article on maximum joint torques"
)
_FRAMES = "space frame = the controller's `base` frame; ROS `base_link` is turned against it by half a turn about z"
_ELBOW = "all joints turn +-360 degrees by the data sheet, the elbow too; in practice the upper arm stops it near 180"
_TENSORS = (
    "tensors from the maker's description package (CAD), about the centres of mass in the axes of the table's frames;"
    " the support article calls them negligible for the small models and prints none"
)

PLUG, BACK = 0.0055, 0.009
"""Radius of the cable's plug at the base, and what the lids on the backs of the wrist's housings stand out [m]."""


@dataclass(frozen=True, slots=True)
class _Housings:
    """Sizes of a model's joints and tubes [m].

    Attributes:
        foot: radius and height of the base.
        shoulder: radius of the two drums at the shoulder.
        face: how far from axis 1 shoulder and upper arm meet.
        upper, fore: radius of the tube, and how far from axis 1 it lies.
        elbow: radius of the drums at the elbow.
        elbow_face, wrist_face: how far from axis 1 upper arm and forearm, forearm and wrist 1 meet.
        wrist: radius of the drums of the wrist.
        neck: how far from its axis each housing of the wrist ends and the next one begins.
    """

    foot: tuple[float, float]
    shoulder: float
    face: float
    upper: tuple[float, float]
    fore: tuple[float, float]
    elbow: float
    elbow_face: float
    wrist_face: float
    wrist: float
    neck: float

    @property
    def source(self) -> str:
        """Where the numbers come from."""
        shoulder, upper, fore, wrist = (1e3 * r for r in (self.shoulder, self.upper[0], self.fore[0], self.wrist))
        return (
            f"capsules, radii {shoulder:.0f} (shoulder), {upper:.0f} and {fore:.0f} (tubes), {wrist:.0f} mm (wrist),"
            " fitted to the meshes of the UR3, UR5 and UR10 as example-robot-data has them; of the e-Series the same"
            " radii along its own lengths, its base and the places where housings meet estimated"
        )

    def outline(self, d1: float, a2: float, a3: float, d4: float, d5: float, d6: float) -> Outline:
        """Of an arm with these lengths: a drum at each joint, tubes between."""
        R, E, W, neck = self.shoulder, self.elbow, self.wrist, self.neck
        (upper, s), (fore, e), (foot, far), back = self.upper, self.fore, self.foot, self.neck + BACK
        return {
            "base": [Drum(foot, (0, 0, 0), (0, 0, far)), Tube(PLUG, (0, foot, PLUG), (0, foot + 6 * PLUG, PLUG))],
            "shoulder": [housing(R, (0, 0, far), (0, 0, d1 + R)), housing(R, (0, R, d1), (0, -self.face, d1))],
            "upper_arm": [
                housing(R, (0, 0, self.face), (0, 0, 2 * s - self.face)),
                Tube(upper, (0, 0, s), (a2, 0, s)),
                housing(E, (a2, 0, self.elbow_face), (a2, 0, 2 * s - self.elbow_face)),
            ],
            "forearm": [
                housing(E, (0, 0, e - fore), (0, 0, self.elbow_face)),
                Tube(fore, (0, 0, e), (a3, 0, e)),
                housing(W, (a3, 0, 2 * e - self.wrist_face), (a3, 0, self.wrist_face)),
            ],
            "wrist_1": [housing(W, (0, 0, self.wrist_face), (0, 0, d4 + W)), housing(W, (0, back, d4), (0, -neck, d4))],
            "wrist_2": [housing(W, (0, 0, neck), (0, 0, d5 + W)), housing(W, (0, -back, d5), (0, neck, d5))],
            "wrist_3": [Drum(W, (0, 0, neck), (0, 0, d6))],
        }  # fmt: skip


_SIZE_3 = _Housings((0.064, 0.086), 0.046, 0.054, (0.034, 0.12), (0.029, 0.027), 0.038, 0.074, 0.067, 0.032, 0.042)
_SIZE_5 = _Housings((0.074, 0.021), 0.060, 0.0705, (0.050, 0.1358), (0.038, 0.0161), 0.058, 0.0705, 0.064, 0.039, 0.048)
_SIZE_5E = _Housings((0.075, 0.099), 0.060, 0.0705, (0.050, 0.138), (0.038, 0.007), 0.058, 0.0675, 0.055, 0.039, 0.048)
_SIZE_10 = _Housings((0.095, 0.092), 0.076, 0.086, (0.055, 0.1762), (0.044, 0.0393), 0.061, 0.110, 0.100, 0.046, 0.060)


def ur3e() -> Mechanism:
    """Universal Robots UR3e, 6R with offset wrist.

    Reference: Universal Robots, DH parameters for calculations of kinematics and dynamics.
    """
    return _arm(
        "ur3e",
        (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
        (
            inertial(1.98, (0, -0.02, 0), (0.0027657, 0.0021501, 0.0025626, 0.0000096, -0.0000149, 0.0001873)),
            inertial(3.4445, (0.13, 0, 0.1157), (0.0042623, 0.0460284, 0.0448947, -0.0000409, -0.001496, -0.0000129)),
            inertial(1.437, (0.05, 0, 0.0238), (0.0010511, 0.0113396, 0.0110895, 0.0, -0.0000331, 0.0000022)),
            inertial(0.871, (0, 0, 0.01), (0.0008174, 0.0006844, 0.0005497, -0.0000005, 0.0000021, 0.0000617)),
            inertial(0.805, (0, 0, 0.01), (0.0006059, 0.0005837, 0.0003831, -0.0000006, -0.0000006, -0.0000271)),
            inertial(0.261, (0, 0, -0.02), (0.000108, 0.0001086, 0.0001371, -0.0000001, -0.0000001, -0.0000002)),
        ),
        _limits((180, 180, 180, 360, 360, 360), (56, 56, 28, 12, 12, 12), endless_last=True),
        (_FRAMES, _ELBOW, _TENSORS, "the last joint turns without end; its range is infinite"),
        _SIZE_3,
    )


def ur5e() -> Mechanism:
    """Universal Robots UR5e, 6R with offset wrist.

    Reference: Universal Robots, DH parameters for calculations of kinematics and dynamics.
    """
    return _arm(
        "ur5e",
        (0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
        (
            inertial(
                3.761,
                (0, -0.02561, 0.00193),
                (0.0070021, 0.00648091, 0.00657286, 0.00000073, -0.00001053, 0.00049994),
            ),
            inertial(
                8.058,
                (0.2125, 0, 0.11336),
                (0.01505885, 0.33388086, 0.33247207, -0.000054, 0.00000563, -0.00000181),
            ),
            inertial(
                2.846, (0.15, 0, 0.0265), (0.00399632, 0.07879254, 0.0784851, -0.00001365, 0.00137272, -0.0000066)
            ),
            inertial(
                1.37,
                (0, -0.0018, 0.01634),
                (0.00165491, 0.00135962, 0.00126279, -0.00000282, -0.00000438, 0.00010157),
            ),
            inertial(
                1.3,
                (0, 0.0018, 0.01634),
                (0.00135617, 0.00127827, 0.00096614, -0.00000274, 0.00000444, -0.00005048),
            ),
            inertial(
                0.365,
                (0, 0, -0.001159),
                (0.00018694, 0.00018908, 0.00025756, 0.00000006, -0.00000017, -0.00000092),
            ),
        ),
        _limits((180,) * 6, (150, 150, 150, 28, 28, 28)),
        (_FRAMES, _ELBOW, _TENSORS),
        _SIZE_5E,
    )


def ur10e() -> Mechanism:
    """Universal Robots UR10e, 6R with offset wrist.

    Reference: Universal Robots, DH parameters for calculations of kinematics and dynamics.
    """
    return _arm(
        "ur10e",
        (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
        (
            inertial(7.369, (0.021, 0, 0.027), (0.03408, 0.03529, 0.02156, 0.00002, -0.00425, 0.00008)),
            inertial(13.051, (0.38, 0, 0.158), (0.02814, 0.77068, 0.76943, 0.00005, -0.01561, 0.00002)),
            inertial(3.989, (0.24, 0, 0.068), (0.01014, 0.30928, 0.30646, 0.00008, 0.00916, 0.0)),
            inertial(2.1, (0, 0.007, 0.018), (0.00296, 0.00222, 0.00258, -0.00001, 0.0, -0.00024)),
            inertial(1.98, (0, 0.007, 0.018), (0.00296, 0.00222, 0.00258, -0.00001, 0.0, -0.00024)),
            inertial(0.615, (0, 0, -0.026), (0.0004, 0.00041, 0.00034)),
        ),
        _limits((120, 120, 180, 180, 180, 180), (330, 330, 150, 56, 56, 56)),
        (_FRAMES, _ELBOW, _TENSORS),
        _SIZE_10,
    )


def ur5() -> Mechanism:
    """Universal Robots UR5 (CB3 series), 6R with offset wrist.

    Reference: Universal Robots, DH parameters for calculations of kinematics and dynamics.
    """
    return _arm(
        "ur5",
        (0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
        (
            inertial(3.7, (0, -0.02561, 0.00193), (0.0149724, 0.0104063, 0.0149724)),
            inertial(8.393, (0.2125, 0, 0.11336), (0.0151074, 0.1338858, 0.1338858)),
            inertial(2.33, (0.15, 0, 0.0265), (0.004095, 0.0312168, 0.0312168)),
            inertial(1.219, (0, -0.0018, 0.01634), (0.0020139, 0.0021942, 0.0020139)),
            inertial(1.219, (0, 0.0018, 0.01634), (0.001831, 0.0021942, 0.001831)),
            inertial(0.1879, (0, 0, -0.001159), (0.0000806, 0.0000806, 0.0001321)),
        ),
        _limits((180,) * 6, (150, 150, 150, 28, 28, 28)),
        (
            _FRAMES,
            _ELBOW,
            "tensors are those of solid cylinders with the links' masses, as in the maker's description package",
            "centre of mass of wrist 2: some copies of the maker's table print y = -0.0018; the sign here is the"
            " description package's, opposite to wrist 1 like the axes",
        ),
        _SIZE_5,
    )


def _arm(
    name: str,
    dimensions: tuple[float, float, float, float, float, float],
    inertials: tuple[Inertial, ...],
    limits: list[Limits],
    notes: tuple[str, ...],
    housings: _Housings,
) -> Mechanism:
    """The table that all models share, with the dimensions d1, a2, a3, d4, d5, d6."""
    d1, a2, a3, d4, d5, d6 = dimensions
    bare = mechanism_from_dh(
        (
            DHRow(d=d1, alpha=pi / 2),
            DHRow(a=a2),
            DHRow(a=a3),
            DHRow(d=d4, alpha=pi / 2),
            DHRow(d=d5, alpha=-pi / 2),
            DHRow(d=d6),
        ),
        "classic",
        name=name,
        inertials=inertials,
        limits=limits,
        joint_names=JOINT_NAMES,
        link_names=LINK_NAMES,
        provenance=Provenance(source=_SOURCE, notes=notes),
    )
    return with_outline(bare, housings.outline(*dimensions), housings.source)


def _limits(speeds: tuple[float, ...], torques: tuple[float, ...], endless_last: bool = False) -> list[Limits]:
    """Speeds in degrees per second, as in the data sheets."""
    each = [Limits(-2 * pi, 2 * pi, radians(v), effort=t) for v, t in zip(speeds, torques, strict=True)]
    if endless_last:
        each[-1] = Limits(-inf, inf, radians(speeds[-1]), effort=torques[-1])
    return each
