"""Derivations a teacher accepts: numbered steps in letters, every line compared with the compiled robot."""

from mafsil.lazy_module import face

__all__ = face(__name__)
