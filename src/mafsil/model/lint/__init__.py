"""Plausibility of robot descriptions: units, mirror images, centres of mass, inertias, limits, each with its repair."""

from mafsil.lazy_module import face

__all__ = face(__name__)
