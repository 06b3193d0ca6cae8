"""Surfaces in files, for pictures: STL, OBJ and the triangles of Collada, with sizes checked before memory is taken."""

from mafsil.lazy_module import face

__all__ = face(__name__)
