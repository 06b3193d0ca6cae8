"""Jerk-limited motions in the shortest time: between states, through via points, and anew in every cycle."""

from mafsil.lazy_module import face

__all__ = face(__name__)
