"""Profiles of time, from rest to rest or with given ends: polynomials, trapezoids, double S, other laws."""

from mafsil.lazy_module import face

__all__ = face(__name__)
