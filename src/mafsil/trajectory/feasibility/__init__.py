"""What makes a request impossible, and the least change that makes it possible."""

from mafsil.lazy_module import face

__all__ = face(__name__)
