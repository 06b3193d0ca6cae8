"""Configuration and task spaces: their topology and distances, groups of motions, polygons, constraints on rates."""

from mafsil.lazy_module import face

__all__ = face(__name__)
