"""Rules about links: mass against volume, centre of mass, inertia, units, copies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.faults import ZERO_MASS
from mafsil.model.inertia_check import inertia_fault, mass_fault
from mafsil.model.link import Inertial, Link
from mafsil.model.lint.finding import (
    ABOUT_FRAME,
    COM_MIRRORED,
    COM_OUTSIDE,
    COPIED,
    GRAMS,
    INERTIA_TOO_LARGE,
    INERTIA_TOO_SMALL,
    INERTIA_UNIT,
    MASS_RATIO,
    MILLIMETRES,
    NO_COLLISION,
    PLACEHOLDER,
    TOO_HEAVY,
    TOO_LIGHT,
    Finding,
    Put,
)
from mafsil.model.lint.solids import Solid, solids
from mafsil.model.mechanism import Mechanism
from mafsil.model.reading import written

LIGHTEST, HEAVIEST = 50.0, 25_000.0
"""Densities [kg/m^3] of foam and of tungsten-like metal: what links are made of lies between."""
MARGIN = 0.05
"""Share of a link's size by which its centre of mass may lie outside the shapes: covers and cables are left out."""
LARGE = 1.5
"""Share of the largest possible inertia beyond which it is said: shapes leave out cables and covers."""
SMALL = 2e-3
"""Share of the inertia of evenly spread matter below which a link would be a point."""
RATIO = 2e3
"""Masses of neighbours whose ratio makes the mass matrix ill-conditioned."""
UNIT_FACTORS = (1e3, 1e6, 1e9)
"""From kg mm^2 (1e6), g m^2 (1e3), g mm^2 (1e9) to kg m^2."""
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_ALL_MOMENTS = tuple(Put(("inertial", "inertia"), key) for key in MOMENTS)


def bodies(mechanism: Mechanism, *, from_file: bool) -> Iterator[Finding]:
    """All remarks about links.

    Args:
        mechanism: the robot.
        from_file: the reader has judged mass and moments already.
    """
    shapes = solids(mechanism)
    unit = _common_unit(mechanism, shapes)
    for link in mechanism.links:
        if link.inertial is None:
            continue
        if not from_file:
            yield from _impossible(link, link.inertial)
        yield from _placeholder(link, link.inertial)
        if link.name in shapes and link.inertial.mass > 0:
            yield from _against_shapes(link, link.inertial, shapes[link.name], unit)
    yield from _copies(mechanism)
    yield from _ratios(mechanism)
    yield from _collisions(mechanism)


def _impossible(link: Link, inertial: Inertial) -> Iterator[Finding]:
    """The readers' judgement, for links made by hand."""
    moments = np.asarray(inertial.inertia)
    details: dict[str, object] = {"link": link.name, "mass": inertial.mass}
    fault = mass_fault(inertial.mass, moments)
    if fault is not None and fault is not ZERO_MASS:
        yield Finding(fault, "link", link.name, details)
    fault = inertia_fault(inertial.mass, moments)
    if fault is not None:
        numbers = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(moments))
        yield Finding(fault, "link", link.name, {"link": link.name, "moments": numbers})


def _placeholder(link: Link, inertial: Inertial) -> Iterator[Finding]:
    """Mass 1 and unit inertia: what editors write before anybody has filled in numbers."""
    if inertial.mass == 1.0 and np.array_equal(inertial.inertia, np.eye(3)):
        yield Finding(PLACEHOLDER, "link", link.name, {"link": link.name}, ("inertial",))


def _against_shapes(link: Link, inertial: Inertial, solid: Solid, unit: float | None) -> Iterator[Finding]:
    """Rules that need the shapes; where the size of the shapes is wrong, nothing else is said."""
    too_large = _shapes_in_millimetres(link, inertial, solid)
    if too_large is not None:
        yield too_large
        return
    yield from _density(link, inertial, solid)
    yield from _centre(link, inertial, solid)
    yield from _inertia(link, inertial, solid, unit)


def _shapes_in_millimetres(link: Link, inertial: Inertial, solid: Solid) -> Finding | None:
    """Meshes a thousand times too large: metres were meant where millimetres stand."""
    density = inertial.mass / max(solid.box_volume, LEAST_DIVISOR)
    if not solid.meshes or solid.size < 20.0 or not LIGHTEST / 100 < density * 1e9 < HEAVIEST:
        return None
    puts = tuple(Put((tag, "geometry", "mesh"), "scale", factor=1e-3) for tag in ("visual", "collision"))
    details: dict[str, object] = {"link": link.name, "size": f"{solid.size:.4g}", "density": f"{density:.2g}"}
    return Finding(MILLIMETRES, "link", link.name, details, ("visual",), None, puts, "lint.scale_meshes")


def _density(link: Link, inertial: Inertial, solid: Solid) -> Iterator[Finding]:
    """Mass over the volume there is at most, and over the solids themselves."""
    least = inertial.mass / max(solid.box_volume, LEAST_DIVISOR)
    details: dict[str, object] = {"link": link.name, "mass": f"{inertial.mass:.4g}", "most": f"{HEAVIEST:.0f}"}
    place = ("inertial", "mass")
    if least > HEAVIEST:
        details |= {"volume": f"{solid.box_volume:.3g}", "density": f"{least:.3g}"}
        if LIGHTEST < least / 1e3 < HEAVIEST / 2 and inertial.mass > 50.0:
            puts = (Put(place, "value", factor=1e-3), *(Put(p.path, p.attribute, factor=1e-3) for p in _ALL_MOMENTS))
            yield Finding(GRAMS, "link", link.name, details, place, "value", puts, "lint.divide_mass")
        else:
            yield Finding(TOO_HEAVY, "link", link.name, details, place, "value")
    elif least < LIGHTEST and (volume := solid.volume) is not None and inertial.mass < LIGHTEST * volume:
        density = inertial.mass / volume
        details |= {"volume": f"{volume:.3g}", "density": f"{density:.3g}", "least": f"{LIGHTEST:.0f}"}
        yield Finding(TOO_LIGHT, "link", link.name, details, place, "value")


def _centre(link: Link, inertial: Inertial, solid: Solid) -> Iterator[Finding]:
    """The centre of mass of matter lies inside the hull of the matter."""
    com, limit = np.asarray(inertial.com), MARGIN * solid.size
    distance = solid.outside(com)
    if distance <= limit:
        return
    details: dict[str, object] = {
        "link": link.name,
        "com": ", ".join(f"{x:.4g}" for x in com),
        "distance": f"{distance:.3g}",
        "size": f"{solid.size:.3g}",
    }
    place = ("inertial", "origin")
    inside = [axis for axis in range(3) if solid.outside(com * np.where(np.arange(3) == axis, -1.0, 1.0)) == 0.0]
    if len(inside) == 1:
        mirrored = com * np.where(np.arange(3) == inside[0], -1.0, 1.0)
        puts = (Put(place, "xyz", " ".join(written(float(x)) for x in mirrored)),)
        details["axis"] = "xyz"[inside[0]]
        yield Finding(COM_MIRRORED, "link", link.name, details, place, "xyz", puts, "lint.mirror_com")
        return
    yield Finding(COM_OUTSIDE, "link", link.name, details, place, "xyz")


def _inertia(link: Link, inertial: Inertial, solid: Solid, unit: float | None) -> Iterator[Finding]:
    """Trace of the inertia, twice the second moment of matter, against what the shapes allow.

    A repair is offered only where the numbers leave no choice: an inertia that is impossible as it stands but right
    about the other point, or the same factor on most links.
    """
    mass, com, I = inertial.mass, np.asarray(inertial.com), np.asarray(inertial.inertia)
    trace, even = float(np.trace(I)), mass * solid.gyration
    if trace <= 0 or even <= 0:
        return
    impossible = _is_impossible(inertial, solid)
    details: dict[str, object] = {"link": link.name, "ratio": f"{trace / even:.3g}", "inertia": f"{trace / 3:.3g}"}
    place = ("inertial", "inertia")
    shifted = I - mass * (com @ com * np.eye(3) - np.outer(com, com))
    if trace > 2 * even and 0.2 < np.trace(shifted) / even < 2 and inertia_fault(mass, shifted) is None:
        puts = _written(shifted) if impossible else ()
        yield Finding(ABOUT_FRAME, "link", link.name, details, place, None, puts, "lint.shift_inertia")
    elif impossible and unit is not None and 0.1 < trace * unit / even < 3:
        details["factor"] = f"{unit:g}"
        puts = tuple(Put(p.path, p.attribute, factor=unit) for p in _ALL_MOMENTS)
        yield Finding(INERTIA_UNIT, "link", link.name, details, place, None, puts, "lint.scale_inertia")
    elif impossible:
        kind = INERTIA_TOO_LARGE if trace > even else INERTIA_TOO_SMALL
        yield Finding(kind, "link", link.name, details, place)


def _is_impossible(inertial: Inertial, solid: Solid) -> bool:
    """More inertia than all mass at the farthest point would have, or as little as one point."""
    trace = float(np.trace(inertial.inertia))
    most = 2 * inertial.mass * solid.reach_from(np.asarray(inertial.com)) ** 2
    return trace > LARGE * most or trace < SMALL * inertial.mass * solid.gyration


def _common_unit(mechanism: Mechanism, shapes: dict[str, Solid]) -> float | None:
    """The factor that most links' inertias lack, as when a drawing program wrote kg mm^2; None if there is none.

    A number that was copied from link to link has one vote: it is a stand-in, not a unit.
    """
    factors: dict[float, float | None] = {}
    for link in mechanism.links:
        inertial, solid = link.inertial, shapes.get(link.name)
        if inertial is None or solid is None or inertial.mass <= 0 or not np.trace(inertial.inertia) > 0:
            continue
        trace = float(np.trace(inertial.inertia))
        ratio = trace / max(inertial.mass * solid.gyration, LEAST_DIVISOR)
        factors[trace] = next((f for u in UNIT_FACTORS for f in (1 / u, u) if 0.1 < ratio * f < 3), None)
    votes = [factor for factor in factors.values() if factor is not None]
    best = max(set(votes), key=votes.count, default=None)
    return best if best is not None and 2 * votes.count(best) > len(factors) else None


def _written(inertia: Floats) -> tuple[Put, ...]:
    """An inertia in the axes of the link, and the rotation of its frame taken out."""
    i, j = np.triu_indices(3)
    moments = tuple(
        Put(("inertial", "inertia"), key, written(float(inertia[a, b])))
        for key, a, b in zip(MOMENTS, i, j, strict=True)
    )
    return (Put(("inertial", "origin"), "rpy", "0 0 0"), *moments)


def _copies(mechanism: Mechanism) -> Iterator[Finding]:
    """A link with its parent's mass properties, but other shapes: pasted and forgotten."""
    by_name = {link.name: link for link in mechanism.links}
    for joint in mechanism.joints:
        one, two = by_name[joint.parent], by_name[joint.child]
        if one.inertial is None or two.inertial is None or not (one.visuals and two.visuals):
            continue
        same = (
            one.inertial.mass == two.inertial.mass
            and np.array_equal(one.inertial.com, two.inertial.com)
            and np.array_equal(one.inertial.inertia, two.inertial.inertia)
        )
        looks = [[repr(shape.geometry) for shape in link.visuals] for link in (one, two)]
        if same and looks[0] != looks[1]:
            yield Finding(COPIED, "link", two.name, {"link": two.name, "other": one.name}, ("inertial",))


def _ratios(mechanism: Mechanism) -> Iterator[Finding]:
    by_name = {link.name: link for link in mechanism.links}
    for joint in mechanism.joints:
        one, two = by_name[joint.parent].inertial, by_name[joint.child].inertial
        if joint.moves and one is not None and two is not None and min(one.mass, two.mass) > 0:
            ratio = max(one.mass / two.mass, two.mass / one.mass)
            if ratio > RATIO:
                details: dict[str, object] = {"link": joint.child, "other": joint.parent, "ratio": f"{ratio:.3g}"}
                yield Finding(MASS_RATIO, "link", joint.child, details, ("inertial", "mass"))


def _collisions(mechanism: Mechanism) -> Iterator[Finding]:
    """Shapes to be seen on the links, but none to collide on any."""
    if any(link.collisions for link in mechanism.links) or not any(link.visuals for link in mechanism.links):
        return
    yield Finding(NO_COLLISION, "robot", mechanism.name, {"robot": mechanism.name})
