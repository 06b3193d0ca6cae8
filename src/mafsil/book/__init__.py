"""The book, live: its figures, worked examples and remarks by their numbers, computed and drawn anew."""

from mafsil.lazy_module import face

__all__ = face(__name__)
