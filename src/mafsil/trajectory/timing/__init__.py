"""The time along a path: shortest within limits of velocity, effort and jerk; paths of the tip followed."""

from mafsil.lazy_module import face

__all__ = face(__name__)
