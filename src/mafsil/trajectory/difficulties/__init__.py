"""Difficulties of a path of the tip: places out of reach, high joint rates, changes of branch; and what mends them."""

from mafsil.lazy_module import face

__all__ = face(__name__)
