"""Collision of arms with what stands around them and with themselves; `mf.collision.Checker(robot, scene).check(q)`."""

from mafsil.lazy_module import face

__all__ = face(__name__)
