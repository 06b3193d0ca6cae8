"""Workspace: maps from samples, and annuli in closed form."""

from mafsil.lazy_module import face

__all__ = face(__name__)
