"""Arms of textbooks: the worked examples of product of exponentials, Jacobians and inverse kinematics, and planar arms.

Lengths are parameters, masses are invented (`with_rods`), and so are the slim tubes that stand for the links. Figure
numbers are those of F. C. Park and K. M. Lynch, Introduction to Robotics: Mechanics, Planning, and Control (draft of
Modern Robotics), with the errata applied. Planar arms move in the x-y plane: joint axes along z, gravity along -y as on
the page of a book. One SCARA arm is a maker's.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.exponentials import mechanism_from_screws
from mafsil.model.library.outline import Drum, Outline, Tube, housing, with_outline, with_rods, with_slim_tubes
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import translation

_OUTLINE: Outline = {
    "base": [housing(0.09, (0, 0, 0), (0, 0, 0.26))],
    "link1": [Tube(0.06, (0, 0, 0.325), (0.325, 0, 0.325))],
    "link2": [Tube(0.06, (0, 0, 0.105), (0.275, 0, 0.105)), housing(0.06, (0.2, 0, 0.12), (0.2, 0, 0.28))],
    "link3": [Drum(0.012, (0, 0, -0.3), (0, 0, -0.02))],
    "link4": [Drum(0.0315, (0, 0, -0.02), (0, 0, 0))],
}
_OUTLINE_SOURCE = (
    "capsules along the published lengths, radii 90 mm (column), 60 mm (arms), 12 mm (quill), user flange a flat drum"
    " of 63 mm across:"
    " estimated, not read off a drawing and not compared with a model of the maker"
)
PAGE_GRAVITY = (0.0, -9.81, 0.0)
SLIM = 0.02
"""Radius of the tubes that stand for the rods, as share of the longest one."""
RADIUS = 0.03
"""Of the tubes [m]."""
_BOOK = "Park and Lynch, Introduction to Robotics"


def spatial3r(L1: float = 1.0, L2: float = 1.0) -> Mechanism:
    """Spatial 3R arm, fig. 5.5: axis 1 up, axis 2 across, axis 3 along the base's x at zero.

    Args:
        L1, L2: distances between the axes [m].
    """
    rows = (DHRow(), DHRow(alpha=pi / 2, a=L1, theta=-pi / 2), DHRow(alpha=-pi / 2, a=L2))
    return _from_dh(
        "spatial3r", rows, "fig. 5.5", "the book prints v3 = (0, +L2, 0); (0, -L2, 0) agrees with its table"
    )


def rrrp(L2: float = 1.0) -> Mechanism:
    """Spatial RRRP arm, fig. 5.6: the prismatic joint along x at zero.

    Args:
        L2: distance between the parallel axes 2 and 3 [m].
    """
    rows = (
        DHRow(),
        DHRow(alpha=pi / 2),
        DHRow(a=L2, theta=pi / 2),
        DHRow(alpha=pi / 2, kind="P"),
    )
    return _from_dh("rrrp", rows, "fig. 5.6")


def elbow6r(L1: float = 1.0, L2: float = 1.0) -> Mechanism:
    """6R elbow arm with a ZYZ wrist, fig. 5.7: a PUMA without offsets.

    Args:
        L1, L2: upper arm and forearm [m].
    """
    rows = (
        DHRow(),
        DHRow(alpha=pi / 2),
        DHRow(a=L1, theta=pi / 2),
        DHRow(alpha=pi / 2, d=L2, theta=pi),
        DHRow(alpha=pi / 2, theta=pi),
        DHRow(alpha=pi / 2),
    )
    return _from_dh("elbow6r", rows, "fig. 5.7", "R_36 = Rot(x, 90 deg) Rot(z, q4) Rot(y, q5) Rot(z, q6)")


def arm6r(L: float = 1.0) -> Mechanism:
    """6R arm, fig. 5.9: three axes through the base's origin, then 4 and 5 parallel to 3, 6 along the arm.

    Args:
        L: distance between the parallel axes [m].
    """
    S = [
        (0, 0, 1, 0, 0, 0),
        (0, 1, 0, 0, 0, 0),
        (-1, 0, 0, 0, 0, 0),
        (-1, 0, 0, 0, 0, L),
        (-1, 0, 0, 0, 0, 2 * L),
        (0, 1, 0, 0, 0, 0),
    ]
    return _from_screws("arm6r", S, (0, 3 * L, 0), "fig. 5.9", "the book prints v4, v5 with a minus sign")


def rrprrr(L1: float = 1.0, L2: float = 1.0) -> Mechanism:
    """RRPRRR arm, fig. 5.10: prismatic joint along y at zero, first wrist axis along it.

    Args:
        L1: from the base to the wrist centre at q3 = 0 [m].
        L2: from the wrist centre to the tip [m].
    """
    S = [
        (0, 0, 1, 0, 0, 0),
        (1, 0, 0, 0, 0, 0),
        (0, 0, 0, 0, 1, 0),
        (0, 1, 0, 0, 0, 0),
        (1, 0, 0, 0, 0, -L1),
        (0, 1, 0, 0, 0, 0),
    ]
    return _from_screws("rrprrr", S, (0, L1 + L2, 0), "fig. 5.10")


def scara_rrrp(L1: float = 1.0, L2: float = 1.0, L3: float = 1.0) -> Mechanism:
    """SCARA-like RRRP arm, fig. 6.2: three vertical axes, then a prismatic joint pointing down.

    Args:
        L1: height of the column [m].
        L2, L3: lengths of the two arms [m].
    """
    S = [(0, 0, 1, 0, 0, 0), (0, 0, 1, 0, -L2, 0), (0, 0, 1, 0, -(L2 + L3), 0), (0, 0, 0, 0, 0, -1)]
    return _from_screws(
        "scara_rrrp", S, (L2 + L3, 0, L1), "fig. 6.2", "the tip frame is not given: parallel to {s} at zero"
    )


def rrprrr_upright(L1: float = 1.0, L2: float = 1.0) -> Mechanism:
    """RRPRRR arm, fig. 6.3: prismatic joint along y at zero, first wrist axis up.

    Args:
        L1: height of the shoulder [m].
        L2: from the shoulder to the wrist centre at q3 = 0 [m].
    """
    S = [
        (0, 0, 1, 0, 0, 0),
        (-1, 0, 0, 0, -L1, 0),
        (0, 0, 0, 0, 1, 0),
        (0, 0, 1, L2, 0, 0),
        (-1, 0, 0, 0, -L1, L2),
        (0, 1, 0, -L1, 0, 0),
    ]
    return _from_screws(
        "rrprrr_upright",
        S,
        (0, L2, L1),
        "fig. 6.3",
        "the tip is the wrist centre, its axes parallel to {s} at zero",
    )


def offset_puma(
    a1: float = 0.5, a2: float = 0.4, base_height: float = 0.6, shoulder_offset: float = 0.15, tool: float = 0.1
) -> Mechanism:
    """6R PUMA-class arm with a shoulder offset; zero pose: arm stretched along x, wrist z, y, x.

    Args:
        a1, a2: upper arm and forearm [m].
        base_height: of the shoulder above {s} [m].
        shoulder_offset: of the arm plane to the left of its heading [m]; 0 for a PUMA without offset.
        tool: from the wrist centre to the tip [m].

    Reference: R. P. Paul, Robot manipulators, 1981; Lynch & Park, Modern Robotics, sec. 6.1.1.
    """
    d, h, wrist = shoulder_offset, base_height, a1 + a2
    S = [
        _axis((0, 0, 1), (0, 0, 0)),
        _axis((0, -1, 0), (0, d, h)),
        _axis((0, -1, 0), (a1, d, h)),
        _axis((1, 0, 0), (wrist, d, h)),
        _axis((0, -1, 0), (wrist, d, h)),
        _axis((1, 0, 0), (wrist, d, h)),
    ]
    return _from_screws("offset_puma", S, (wrist + tool, d, h), "PUMA class with offset", source="Paul; Lynch and Park")


def offset_stanford(d1: float = 0.7, a1: float = 0.2, offset: float = 0.1, tool: float = 0.1) -> Mechanism:
    """RRPRRR Stanford-class arm with a shoulder offset; zero pose: boom along x.

    Args:
        d1: height of the shoulder above {s} [m].
        a1: length of the boom at q3 = 0 [m].
        offset: of the boom to the left of its heading [m]; 0 for a Stanford arm without offset.
        tool: from the wrist centre to the tip [m].

    Reference: Lynch & Park, Modern Robotics, sec. 6.1.2.
    """
    S = [
        _axis((0, 0, 1), (0, 0, 0)),
        _axis((0, -1, 0), (0, offset, d1)),
        (0, 0, 0, 1, 0, 0),
        _axis((1, 0, 0), (a1, offset, d1)),
        _axis((0, -1, 0), (a1, offset, d1)),
        _axis((1, 0, 0), (a1, offset, d1)),
    ]
    return _from_screws(
        "offset_stanford", S, (a1 + tool, offset, d1), "Stanford class with offset", source="Lynch and Park"
    )


def generalized_puma() -> Mechanism:
    """6R arm of the generalised PUMA class: axes 1, 2 meet, 4, 5, 6 meet, nothing else is special."""
    S = [
        (0, 0, 1, 0, 0, 0),
        (0, 1, 0, 0, 0, 0),
        (0, 1, 0, -0.1, 0, 0.5),
        (0, 0, 1, 0.05, -0.9, 0),
        (0, 1, 0, -0.1, 0, 0.9),
        (1, 0, 0, 0, 0.1, -0.05),
    ]
    return _from_screws("generalized_puma", S, (1.05, 0.05, 0.1), "generalised PUMA", source="Lynch and Park")


def _axis(omega: Sequence[float], point: Sequence[float]) -> tuple[float, ...]:
    """Screw of a revolute axis through a point."""
    v = -np.cross(np.asarray(omega, float), np.asarray(point, float))
    return (*omega, *v.tolist())


def _from_dh(name: str, rows: tuple[DHRow, ...], figure: str, *notes: str) -> Mechanism:
    provenance = Provenance(source=f"{_BOOK}, {figure}", notes=notes)
    return _with_bodies(mechanism_from_dh(rows, "modified", name=name, provenance=provenance))


def _from_screws(
    name: str,
    S: Sequence[Sequence[float]],
    tip: tuple[float, float, float],
    figure: str,
    *notes: str,
    source: str = _BOOK,
) -> Mechanism:
    """Tip frame parallel to {s} at zero."""
    provenance = Provenance(source=f"{source}, {figure}", notes=notes)
    return _with_bodies(mechanism_from_screws(S, translation(*tip), name=name, provenance=provenance))


def _with_bodies(mechanism: Mechanism) -> Mechanism:
    """With invented masses and slim tubes."""
    return with_slim_tubes(with_rods(mechanism), RADIUS)


def planar2r(lengths: Sequence[float] = (1.0, 1.0), masses: Sequence[float] = (1.0, 1.0)) -> Mechanism:
    """Planar 2R arm of uniform thin rods (Lynch & Park fig. 6.9; spec part 05-06).

    Args:
        lengths: (2,) of the links [m].
        masses: (2,) of the links [kg].
    """
    return _planar("planar2r", lengths, [_rod(m, L) for m, L in zip(masses, lengths, strict=True)], "uniform thin rods")


def planar3r(lengths: Sequence[float] = (1.0, 0.8, 0.5), masses: Sequence[float] = (1.0, 0.8, 0.5)) -> Mechanism:
    """Planar 3R arm of uniform thin rods.

    Args:
        lengths: (3,) of the links [m].
        masses: (3,) of the links [kg].
    """
    return _planar("planar3r", lengths, [_rod(m, L) for m, L in zip(masses, lengths, strict=True)], "uniform thin rods")


def planar2r_point_masses(lengths: Sequence[float] = (1.0, 1.0), masses: Sequence[float] = (1.0, 1.0)) -> Mechanism:
    """Planar 2R arm with all mass of a link in a point at its far end: the textbook example of dynamics.

    Args:
        lengths: (2,) of the links [m].
        masses: (2,) at the ends of the links [kg].

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.1.
    """
    points = [Inertial(m, frozen([L, 0.0, 0.0])) for m, L in zip(masses, lengths, strict=True)]
    return _planar("planar2r_point_masses", lengths, points, "point masses at the far ends of the links")


def _planar(name: str, lengths: Sequence[float], inertials: Sequence[Inertial], masses: str) -> Mechanism:
    """Frame {i} at the near end of link i, x along the link."""
    before = (0.0, *lengths[:-1])
    bare = mechanism_from_dh(
        [DHRow(a=a) for a in before],
        "modified",
        name=name,
        tool=translation(lengths[-1], 0.0, 0.0),
        inertials=inertials,
        gravity=PAGE_GRAVITY,
        provenance=Provenance(
            source="textbook arm; lengths and masses are parameters",
            notes=(f"masses: {masses}", "gravity along -y of the space frame, 9.81 m/s^2", "no joint limits"),
        ),
    )
    return with_slim_tubes(bare, SLIM * max(lengths))


def _rod(mass: float, length: float) -> Inertial:
    """Uniform thin rod along x from the origin: no inertia about its own axis."""
    across = mass * length**2 / 12
    return Inertial(mass, frozen([length / 2, 0.0, 0.0]), frozen(np.diag([0.0, across, across])))


def cobra600() -> Mechanism:
    """Adept Cobra 600: RRPR, quill pointing down.

    Reference: Adept Technology, Cobra 600 data sheet; kinematics as in the Robotics Toolbox (model cobra600).
    """
    bare = with_rods(
        mechanism_from_dh(
            (DHRow(d=0.387, a=0.325), DHRow(a=0.275, alpha=pi), DHRow(kind="P"), DHRow()),
            "classic",
            name="cobra600",
            limits=[
                Limits(radians(-50), radians(50)),
                Limits(radians(-88), radians(88)),
                Limits(0.0, 0.210),
                Limits(),
            ],
            provenance=Provenance(
                source="Adept Cobra 600 data sheet, as collected in the Robotics Toolbox",
                notes=("range of joint 4 and all speeds and torques unknown",),
            ),
        ),
        radius=0.06,
    )
    return with_outline(bare, _OUTLINE, _OUTLINE_SOURCE)
