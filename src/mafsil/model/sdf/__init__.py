"""SDFormat, the robot format of Gazebo: models, and worlds that hold one robot."""

from mafsil.lazy_module import face

__all__ = face(__name__)
