"""Rigid motions as values and as functions of arrays, any batch, thin over compiled `mafsil.algebra`.

Modules of array functions: rotation, quaternion, euler, pose, screw, twist, wrench, planar, points, logarithms,
matrix_exponential. Values: Rotation, Pose, Twist, Wrench, ScrewAxis, Point, Vector.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
