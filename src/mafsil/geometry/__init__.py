"""Rigid motions as values and as functions of arrays, any batch, thin over compiled `mafsil.algebra`.

Modules of array functions: rotation, quaternion, euler, pose, screw, twist, wrench, planar, points, logarithms,
matrix_exponential. Values: Rotation, Pose, Twist, Wrench, ScrewAxis, Point, Vector.
"""

from mafsil.geometry.values import Point as Point
from mafsil.geometry.values import Pose as Pose
from mafsil.geometry.values import Rotation as Rotation
from mafsil.geometry.values import ScrewAxis as ScrewAxis
from mafsil.geometry.values import Twist as Twist
from mafsil.geometry.values import Vector as Vector
from mafsil.geometry.values import Wrench as Wrench
