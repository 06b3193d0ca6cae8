"""Xacro, the macro language of ROS for URDF: our own expander, bounded in time and size."""

from mafsil.lazy_module import face

__all__ = face(__name__)
