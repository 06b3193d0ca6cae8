"""Mass, centre of mass and inertia of bodies: from particles, shapes, densities, voxels and closed surfaces.

Every function returns an `Inertial`: the inertia about the centre of mass, in axes parallel to the frame in which the
body was given, products with the minus sign inside, Ixy = - integral of x y dm.

Reference: Lynch & Park, Modern Robotics, sec. 8.2.1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch, frozen, real_array
from mafsil.errors import InputError, ModelError
from mafsil.model.link import Inertial, moved_inertial
from mafsil.model.tolerances import PRINTED

Density = Callable[[Floats], ArrayLike]
"""Points (k, 3) [m] -> densities (k,) [kg/m^3]."""
GAUSS_POINTS = 4
"""Points of the Gauss rule per cell and direction: exact for polynomials of degree 7."""


def particles(masses: ArrayLike, points: ArrayLike) -> Inertial:
    """A set of point masses: I = sum of m (|r|^2 E - r r'), r from the centre of mass.

    Args:
        masses: (k,) [kg].
        points: (k, 3) positions [m].

    Raises:
        InputError: wrong shapes, NaN or infinity.
        ModelError: no mass at all.

    Reference: Lynch & Park, Modern Robotics, eq. 8.25.
    """
    r = as_batch("points", points, (3,), finite=True).reshape(-1, 3)
    m = as_batch("masses", masses, (len(r),), finite=True)
    return _from_moments(float(m.sum()), m @ r, (r * m[:, None]).T @ r)


def box(mass: float, size: ArrayLike) -> Inertial:
    """A uniform box centred on the frame; m/12 (b^2 + c^2) about x and so on.

    Args:
        mass: [kg].
        size: (3,) edge lengths along x, y, z [m].
    """
    return _solid(mass, _lengths("size", size, 3) ** 2 / 12)


def ellipsoid(mass: float, semi_axes: ArrayLike) -> Inertial:
    """A uniform ellipsoid centred on the frame; m/5 (b^2 + c^2) about x and so on.

    Args:
        mass: [kg].
        semi_axes: (3,) along x, y, z [m].
    """
    return _solid(mass, _lengths("semi_axes", semi_axes, 3) ** 2 / 5)


def sphere(mass: float, radius: float) -> Inertial:
    """A uniform ball: 2/5 m r^2; `mass` [kg], `radius` [m]."""
    return ellipsoid(mass, [radius] * 3)


def shell(mass: float, radius: float) -> Inertial:
    """A thin hollow ball: 2/3 m r^2; `mass` [kg], `radius` [m]."""
    return _solid(mass, np.repeat(_lengths("radius", radius, 1) ** 2 / 3, 3))


def tube(mass: float, inner: float, outer: float, length: float) -> Inertial:
    """A uniform hollow cylinder about z, centred: m/2 (r1^2 + r2^2) about z, m/12 (3 r1^2 + 3 r2^2 + h^2) across.

    Args:
        mass: [kg].
        inner, outer: radii [m].
        length: along z [m].

    Raises:
        ModelError: the inner radius exceeds the outer.
    """
    r1, r2, h = (float(_lengths(name, x, 1)[0]) for name, x in (("inner", inner), ("outer", outer), ("length", length)))
    if r1 > r2:
        raise ModelError("dynamics.radii", inner=r1, outer=r2)
    across = (r1 * r1 + r2 * r2) / 4
    return _solid(mass, np.array([across, across, h * h / 12]))


def cylinder(mass: float, radius: float, length: float) -> Inertial:
    """A uniform cylinder about z, centred: m r^2/2 about z; `mass` [kg], `radius`, `length` [m]."""
    return tube(mass, 0.0, radius, length)


def capsule(mass: float, radius: float, length: float) -> Inertial:
    """A uniform cylinder of that length about z with half a ball on each end, centred; `radius`, `length` [m]."""
    r, h = (float(_lengths(name, x, 1)[0]) for name, x in (("radius", radius), ("length", length)))
    ball = 4 * r / (4 * r + 3 * h)
    along = ball * (r * r / 5 + h * h / 4 + 3 / 8 * r * h) + (1 - ball) * h * h / 12
    across = ball * r * r / 5 + (1 - ball) * r * r / 4
    return _solid(mass, np.array([across, across, along]))


def rod(mass: float, length: float) -> Inertial:
    """A thin rod along z, centred: m l^2/12 across, nothing along; `mass` [kg], `length` [m]."""
    return tube(mass, 0.0, 0.0, length)


def density(rho: Density, lower: ArrayLike, upper: ArrayLike, cells: int = 8) -> Inertial:
    """A body of any density, by Gauss quadrature over a box that holds it.

    Smooth densities come out to machine precision; where the density jumps, the error falls with the cell size.

    Args:
        rho: density [kg/m^3] at points (k, 3).
        lower, upper: (3,) corners of the box [m].
        cells: how many cells along each direction, 4 points in each.

    Raises:
        ModelError: the density holds no mass.
        InputError: the density returns another shape, NaN or infinity.
    """
    low, high = as_batch("lower", lower, (3,), finite=True), as_batch("upper", upper, (3,), finite=True)
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    x = ((np.arange(cells)[:, None] + (nodes + 1) / 2) / cells).ravel()
    w = np.tile(weights / 2 / cells, cells)
    grid = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
    points = low + grid * (high - low)
    volume = np.einsum("i,j,k->ijk", w, w, w).ravel() * float(np.prod(high - low))
    m = as_batch("density", rho(points), (len(points),), finite=True) * volume
    return _from_moments(float(m.sum()), m @ points, (points * m[:, None]).T @ points)


def voxels(densities: ArrayLike, lower: ArrayLike, spacing: ArrayLike) -> Inertial:
    """A grid of uniform cells, each counted as the small box it is.

    Args:
        densities: (a, b, c) [kg/m^3], first index along x.
        lower: (3,) the grid's lower corner [m].
        spacing: (3,) size of a cell [m].

    Raises:
        InputError: not three dimensions, NaN or infinity.
        ModelError: the cells hold no mass.
    """
    rho = real_array("densities", densities)
    if rho.ndim != 3:
        raise InputError("input.shape", name="densities", expected="(a, b, c)", got=rho.shape, hint="")
    corner, size = as_batch("lower", lower, (3,), finite=True), _lengths("spacing", spacing, 3)
    axes: list[Floats] = [corner[k] + size[k] * (np.arange(rho.shape[k]) + 0.5) for k in range(3)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    m = as_batch("densities", rho.ravel(), (rho.size,), finite=True) * float(np.prod(size))
    second = (centres * m[:, None]).T @ centres + m.sum() * np.diag(size**2 / 12)
    return _from_moments(float(m.sum()), m @ centres, second)


def surface(vertices: ArrayLike, faces: ArrayLike, *, density: float = 1000.0, mass: float | None = None) -> Inertial:
    """A uniform solid inside a closed surface of triangles, by the divergence theorem.

    Every triangle spans a tetrahedron with the origin; signed, they add up to the solid.

    Args:
        vertices: (v, 3) [m].
        faces: (f, 3) indices, counter-clockwise seen from outside.
        density: [kg/m^3].
        mass: total mass [kg] if that is known instead of the density.

    Raises:
        ModelError: the surface has open edges, or is turned inside out.

    Reference: Mirtich, Fast and accurate computation of polyhedral mass properties, 1996.
    """
    points = as_batch("vertices", vertices, (3,), finite=True)
    corners = as_batch("faces", faces, (3,), finite=True).astype(np.int64)
    _require_closed(points, corners)
    centre = points.mean(axis=0)
    a, b, c = ((points - centre)[corners[:, k]] for k in range(3))
    volumes = np.einsum("fi,fi->f", a, np.cross(b, c)) / 6
    total = float(volumes.sum())
    if total <= 0:
        raise ModelError("dynamics.inside_out", volume=total)
    rho = density if mass is None else mass / total
    s = a + b + c
    products = sum(np.einsum("f,fi,fj->ij", volumes, x, x) for x in (a, b, c, s)) / 20
    body = _from_moments(rho * total, rho * volumes @ s / 4, rho * np.asarray(products))
    return Inertial(body.mass, frozen(body.com + centre), body.inertia)


def combine_bodies(parts: Sequence[tuple[Inertial, PoseMatrix]]) -> Inertial:
    """Several bodies fixed to each other as one.

    Args:
        parts: each body and the pose (4, 4) of its frame in the common frame.

    Raises:
        ModelError: no mass at all.

    Reference: Lynch & Park, Modern Robotics, eq. 8.26 (change of axes).
    """
    whole = unite_bodies(*(moved_inertial(body, as_batch("pose", pose, (4, 4), finite=True)) for body, pose in parts))
    if whole is None or not whole.mass > 0:
        raise ModelError("dynamics.mass", mass=0.0)
    return whole


def unite_bodies(*bodies: Inertial | None) -> Inertial | None:
    """Bodies fixed to each other, all given in one frame, as one; some of them, or all, may be without mass.

    I = sum of I_i + m_i (|d_i|^2 E - d_i d_i'), d_i from the common centre of mass

    Args:
        bodies: their mass properties; None for no body.

    Returns:
        The whole, or None if there is no body. Without mass the inertias add up, at the centre of the first.

    Reference: Lynch & Park, Modern Robotics, eq. 8.27 (Steiner).
    """
    parts = [body for body in bodies if body is not None]
    if len(parts) < 2:
        return parts[0] if parts else None
    mass = sum(body.mass for body in parts)
    com = parts[0].com if not mass else sum((body.mass * body.com for body in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for body in parts:
        d = body.com - com
        inertia += body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Inertial(mass, frozen(com), frozen((inertia + inertia.T) / 2))


def require_physical(body: Inertial) -> Inertial:
    """The body itself, if some distribution of matter has these properties.

    Mass positive, moments not negative, the largest at most the sum of the others. A point mass or a thin rod passes:
    their inertia is only semi-definite.

    Raises:
        ModelError: what is wrong, with the numbers.
    """
    least, middle, largest = np.linalg.eigvalsh(body.inertia)
    if not body.mass > 0:
        raise ModelError("dynamics.mass", mass=body.mass)
    if least < -PRINTED * abs(largest) or largest - middle - least > PRINTED * abs(largest):
        raise ModelError("dynamics.moments", moments=tuple(float(x) for x in (least, middle, largest)))
    return body


def _from_moments(mass: float, first: Floats, second: Floats) -> Inertial:
    """From mass, the integral of r dm and that of r r' dm, about the origin."""
    if not mass > 0:
        raise ModelError("dynamics.mass", mass=mass)
    com = first / mass
    about_com = second - mass * np.outer(com, com)
    inertia = np.trace(about_com) * np.eye(3) - about_com
    return Inertial(mass, frozen(com), frozen((inertia + inertia.T) / 2))


def _solid(mass: float, second_per_mass: Floats) -> Inertial:
    """A centred body from the diagonal of its second moments."""
    checked = float(as_batch("mass", mass, (), finite=True))
    return _from_moments(checked, np.zeros(3), np.diag(checked * second_per_mass))


def _lengths(name: str, value: ArrayLike, count: int) -> Floats:
    x = np.atleast_1d(as_batch(name, value, () if count == 1 else (count,), finite=True))
    if x.shape != (count,) or (x < 0).any():
        raise ModelError("dynamics.length", name=name, value=tuple(float(v) for v in x.ravel()))
    return x


def _require_closed(points: Floats, faces: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> None:
    """Every edge is run through once in each direction; equal points count as one."""
    if not len(faces):
        raise ModelError("dynamics.open_surface", edges=0)
    if faces.min() < 0 or faces.max() >= len(points):
        raise ModelError("dynamics.face_index", index=int(faces.max()), count=len(points))
    _, same = np.unique(points, axis=0, return_inverse=True)
    corners = same.ravel()[faces]
    ways = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    ways = ways[ways[:, 0] != ways[:, 1]]
    count = len(points)
    there, back = ways[:, 0] * count + ways[:, 1], ways[:, 1] * count + ways[:, 0]
    open_edges = int((np.sort(there) != np.sort(back)).sum())
    if open_edges:
        raise ModelError("dynamics.open_surface", edges=len(np.setxor1d(there, back)) or open_edges)
