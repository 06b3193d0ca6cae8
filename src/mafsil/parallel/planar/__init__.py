"""Planar parallel robots: five-bars, three-legged platforms, parallel cranks, motor angles."""

from mafsil.lazy_module import face

__all__ = face(__name__)
