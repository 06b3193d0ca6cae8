"""Planning: paths that meet nothing, among polygons, for arms, in any number of coordinates; several robots in time."""

from mafsil.lazy_module import face

__all__ = face(__name__)
