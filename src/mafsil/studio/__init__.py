"""The page on a server of one's own machine: several windows share one robot, heavy work is done in Python."""

from mafsil.lazy_module import face

__all__ = face(__name__)
