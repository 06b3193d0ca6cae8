"""Control laws of joints and of the tip: feedback, computed torque, adaptive, robust, optimal, null space."""

from mafsil.lazy_module import face

__all__ = face(__name__)
