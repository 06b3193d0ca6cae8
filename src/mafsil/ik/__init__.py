"""Inverse kinematics: joint vectors that bring a frame to a wanted pose, with honest verdicts."""

from mafsil.ik.numerical import solve_ik as solve_ik
from mafsil.ik.result import IKResult as IKResult
from mafsil.ik.result import IKStatus as IKStatus
