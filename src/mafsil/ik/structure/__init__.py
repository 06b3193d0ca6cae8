"""Which arms have closed-form inverse kinematics, why, and the geometric subproblems that these reduce to."""

from mafsil.lazy_module import face

__all__ = face(__name__)
