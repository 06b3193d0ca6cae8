"""Singular configurations: whether, what is lost, why, and where all of them lie."""

from mafsil.lazy_module import face

__all__ = face(__name__)
