"""Bodies as points and angles, joints of a plane as equations, wheels: what freedoms they have."""

from mafsil.lazy_module import face

__all__ = face(__name__)
