"""Every routine of a robot compared with independent methods for the same numbers, in one call."""

from mafsil.lazy_module import face

__all__ = face(__name__)
