"""Paths of a frame without time: curves of its origin, orientation laws side by side, blends of corners."""

from mafsil.lazy_module import face

__all__ = face(__name__)
