"""Closed loops in time: plant, law, disturbances, and the recording they leave."""

from mafsil.lazy_module import face

__all__ = face(__name__)
