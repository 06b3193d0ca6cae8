"""Forward and inverse dynamics over time, of robots and of a single free body."""

from mafsil.lazy_module import face

__all__ = face(__name__)
