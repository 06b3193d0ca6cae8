"""Robots by name: published numbers and textbook arms, each with its provenance."""

from mafsil.lazy_module import face

__all__ = face(__name__)
