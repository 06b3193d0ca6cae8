"""Dexterity at a configuration: velocity and force ellipsoids, manipulability, directions, isotropy."""

from mafsil.lazy_module import face

__all__ = face(__name__)
