"""Rigid motions as values and as functions of arrays, any batch, thin over compiled `mafsil.algebra`.

Modules of array functions: rotation, quaternion, euler, pose, screw, twist, wrench, planar, points, logarithms,
matrix_exponential. Values: Rotation, Pose, Twist, Wrench, ScrewAxis, Point, Vector.

call      Pose, Rotation, Twist, Wrench; functions of arrays such as mf.geometry.euler
computed  `membership` makes the functions from `mafsil.algebra`; `values.pose`, `values.twist`
          hold values with frames
tested    tests/geometry, tests/reliability/lie_groups.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
