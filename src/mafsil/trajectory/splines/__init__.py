"""Curves through points at given times: B-splines, cubic splines, lines with blends, rates at via points."""

from mafsil.lazy_module import face

__all__ = face(__name__)
