"""Trajectories in files: CSV both ways, ROS 2 JointTrajectory and URScript."""

from mafsil.lazy_module import face

__all__ = face(__name__)
