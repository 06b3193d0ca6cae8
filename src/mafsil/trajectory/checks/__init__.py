"""Checks of a trajectory: continuity, limits by sampling and by proof, requirements."""

from mafsil.lazy_module import face

__all__ = face(__name__)
