"""Singular configurations: detection, lost motions, causes, and the singularity locus."""

from mafsil.lazy_module import face

__all__ = face(__name__)
