"""The trajectory doctor: what makes a request impossible, and the least change that mends it."""

from mafsil.lazy_module import face

__all__ = face(__name__)
