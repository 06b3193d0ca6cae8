"""Platforms on legs: Stewart-Gough, Delta, Eclipse, three RPS: all poses, workspace, singular places."""

from mafsil.lazy_module import face

__all__ = face(__name__)
