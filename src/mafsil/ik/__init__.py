"""Inverse kinematics: joint vectors that bring a frame to a desired pose, with honest verdicts."""

from mafsil.lazy_module import face

__all__ = face(__name__)
