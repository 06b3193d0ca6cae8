"""Motions in time: polynomials, trapezoids, Cartesian lines, sequences, and their checks."""

from mafsil.lazy_module import face

__all__ = face(__name__)
