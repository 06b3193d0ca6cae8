"""Planar parallel robots: five-bars, three-legged platforms, parallel cranks, and what their motors do."""

from mafsil.lazy_module import face

__all__ = face(__name__)
