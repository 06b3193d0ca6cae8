"""What inverse kinematics answers: solutions with their branches, continua, limits, and the reason of every no."""

from mafsil.lazy_module import face

__all__ = face(__name__)
