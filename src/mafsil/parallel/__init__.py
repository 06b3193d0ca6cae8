"""Parallel robots: platforms on legs, their poses, forces and singularities."""

from mafsil.lazy_module import face

__all__ = face(__name__)
