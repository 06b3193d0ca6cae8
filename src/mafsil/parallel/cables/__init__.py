"""Robots on cables: tensions, poses, closure by forces, workspace."""

from mafsil.lazy_module import face

__all__ = face(__name__)
