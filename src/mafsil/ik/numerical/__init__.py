"""Numerical inverse kinematics: compiled searches over batches of poses, tasks of many kinds, null-space goals."""

from mafsil.lazy_module import face

__all__ = face(__name__)
