"""Velocity kinematics, statics, singularities, dexterity and workspace of arms: five packages, every name here too."""

from mafsil.lazy_module import face

__all__ = face(__name__)
