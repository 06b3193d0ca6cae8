"""Corners of a path rounded within what is proved free: the way from straight motions to one without stops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.planning.kept_planning import Kept
from mafsil.trajectory import JointPath
from mafsil.trajectory.splines import PiecewisePolynomial

if TYPE_CHECKING:
    from mafsil.collision import Checker

CHORDS = 8
"""Straight pieces by which a rounded corner is proved free."""
HALVINGS = 6
"""How often a corner is rounded more tightly before it stays sharp."""


def round_corners(checker: Checker, path: JointVector, share: float = 0.5, kept: Kept | None = None) -> JointPath:
    """A path of proved straight motions with its corners rounded; what is rounded is proved free, too.

    1. A corner c between directions d and e becomes, from c - r d to c + r e, the quintic whose control points lie
       on both legs, three on each: direction and curvature are continuous.
    2. Chords of it are proved with a clearance that is larger by how far the arm can move between chord and curve:
       a curve leaves its chord by at most h^2 / 8 times its second derivative, and that is largest at a control point.
    3. A corner that cannot be proved is rounded half as much; after six times it stays, and motions stop there.

    Args:
        checker: the arm in its scene.
        path: (k, n) points; the motions between them are proved.
        share: of the shorter leg that a corner may take, below 1/2 both corners of a leg find their place [0, 0.5].
        kept: what the curve must keep, too.
    """
    points = np.asarray(path, dtype=np.float64)
    ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], ways > 0.0])]
    if len(points) < 3:
        return JointPath.through(points, "lines")
    ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
    directions = np.diff(points, axis=0) / ways[:, None]
    radii = np.zeros(len(points))
    for k in range(1, len(points) - 1):
        radius = share * min(ways[k - 1], ways[k])
        for _ in range(HALVINGS):
            if _is_free(checker, _corner(points[k], directions[k - 1], directions[k], radius), kept):
                radii[k] = radius
                break
            radius /= 2.0
    return JointPath(_join(points, directions, ways, radii))


def _corner(c: Floats, d: Floats, e: Floats, radius: float) -> Floats:
    """(6, n) control points of the quintic over 2 radius whose ends are straight, with unit speed."""
    step = 0.4 * radius
    before = [c - radius * d + j * step * d for j in range(3)]
    after = [c + radius * e - j * step * e for j in (2, 1, 0)]
    return np.stack([*before, *after])


def _is_free(checker: Checker, control: Floats, kept: Kept | None) -> bool:
    """Whether a curve of control points (6, n) over 0..1 is proved free, and to keep what is to be kept."""
    # Second derivatives of a quintic: 20 times second differences of the control points, which bound them.
    second = 20.0 * np.abs(np.diff(control, 2, axis=0)).max(axis=0)
    apart = second / (8.0 * CHORDS**2)
    extra = 2.0 * checker.largest_way(apart, np.abs(control).max(axis=0))
    places = _bernstein(np.linspace(0.0, 1.0, CHORDS + 1)) @ control
    if kept is not None and not kept.on_curve(checker, places, apart):
        return False
    return bool(checker.free_segment(places[:-1], places[1:], extra=extra).all())


def _bernstein(t: Floats) -> Floats:
    """(k, 6) Bernstein polynomials of degree 5."""
    binomial = np.array([1.0, 5.0, 10.0, 10.0, 5.0, 1.0])
    j = np.arange(6)
    return binomial * t[:, None] ** j * (1.0 - t[:, None]) ** (5 - j)


def _join(points: Floats, directions: Floats, ways: Floats, radii: Floats) -> PiecewisePolynomial:
    """Lines and rounded corners with the length of the legs as path parameter; degree 5."""
    lengths: list[float] = []
    rows: list[Floats] = []
    for k, (d, way) in enumerate(zip(directions, ways, strict=True)):
        straight = way - radii[k] - radii[k + 1]
        if straight > 1e-12 * way:
            line = np.zeros((6, points.shape[1]))
            line[0], line[1] = points[k] + radii[k] * d, d
            rows.append(line)
            lengths.append(straight)
        if k + 1 < len(directions) and radii[k + 1] > 0.0:
            radius = float(radii[k + 1])
            control = _corner(points[k + 1], d, directions[k + 1], radius)
            rows.append(_powers(control) / ((2.0 * radius) ** np.arange(6))[:, None])
            lengths.append(2.0 * radius)
    return PiecewisePolynomial.from_pieces(np.array(lengths), np.stack(rows))


def _powers(control: Floats) -> Floats:
    """(6, n) coefficients of powers of t of a quintic over 0..1: forward differences times binomials."""
    binomial = (1.0, 5.0, 10.0, 10.0, 5.0, 1.0)
    return np.stack([binomial[k] * np.diff(control, k, axis=0)[0] for k in range(6)])
