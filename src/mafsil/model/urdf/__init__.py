"""Robot description files of ROS: a strict reader with coded diagnostics and repairs, and a writer."""

from mafsil.lazy_module import face

__all__ = face(__name__)
