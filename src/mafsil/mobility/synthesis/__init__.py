"""Dimensional synthesis of planar four-bars and slider-cranks: for poses, for paths with timing, for functions."""

from mafsil.lazy_module import face

__all__ = face(__name__)
