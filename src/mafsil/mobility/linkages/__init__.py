"""Linkages: joints, bodies and couplings, from files and robots, drawn at coordinates, with their loops closed."""

from mafsil.lazy_module import face

__all__ = face(__name__)
