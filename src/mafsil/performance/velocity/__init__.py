"""Velocities of the tip from rates of the joints: Jacobians of frames, points and tasks, with units and without."""

from mafsil.lazy_module import face

__all__ = face(__name__)
