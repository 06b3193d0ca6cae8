"""A job file, solved end to end: reading, planning the moves, driving the robot through them."""

from mafsil.lazy_module import face

__all__ = face(__name__)
