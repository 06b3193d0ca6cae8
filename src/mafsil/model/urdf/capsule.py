"""Capsules in URDF, which has none: a shaft and two caps, which are read back as the capsule that they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from mafsil.model.placement import translation
from mafsil.model.shape import Capsule, Cylinder, Shape, Sphere
from mafsil.model.tolerances import WRITTEN

PARTS = ("/shaft", "/cap1", "/cap2")
"""Endings of the names of the three shapes."""


def without_capsules(shapes: Iterable[Shape]) -> Iterator[Shape]:
    """The shapes, each capsule as a cylinder and two balls."""
    for shape in shapes:
        if not isinstance(shape.geometry, Capsule):
            yield shape
            continue
        radius, length = shape.geometry.radius, shape.geometry.length
        solids = (Cylinder(radius, length), Sphere(radius), Sphere(radius))
        for part, solid, z in zip(PARTS, solids, (0.0, length / 2, -length / 2), strict=True):
            yield replace(shape, geometry=solid, T_lg=shape.T_lg @ translation(0, 0, z), name=shape.name + part)


def with_capsules(shapes: Iterable[Shape]) -> tuple[Shape, ...]:
    """The shapes, a shaft with its two caps as the capsule that they were."""
    found: list[Shape] = []
    for shape in shapes:
        found.append(shape)
        capsule = _capsule(found[-3:])
        if capsule is not None:
            found[-3:] = [capsule]
    return tuple(found)


def _capsule(three: list[Shape]) -> Shape | None:
    """The capsule of three shapes that are named and placed as its parts."""
    if len(three) < 3 or not all(shape.name.endswith(part) for shape, part in zip(three, PARTS, strict=True)):
        return None
    shaft, *caps = three
    names = {shape.name.removesuffix(part) for shape, part in zip(three, PARTS, strict=True)}
    if not isinstance(shaft.geometry, Cylinder) or len(names) > 1 or any(cap.colour != shaft.colour for cap in caps):
        return None
    radius, length = shaft.geometry.radius, shaft.geometry.length
    for cap, z in zip(caps, (length / 2, -length / 2), strict=True):
        gap = np.abs((shaft.T_lg @ translation(0, 0, z))[:3, 3] - cap.T_lg[:3, 3]).max()
        if cap.geometry != Sphere(radius) or gap > WRITTEN * (radius + length):
            return None
    return replace(shaft, geometry=Capsule(radius, length), name=names.pop())
