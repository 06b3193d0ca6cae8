"""How well an arm moves and pushes at a configuration: ellipsoids, measures, directions, isotropy."""

from mafsil.lazy_module import face

__all__ = face(__name__)
