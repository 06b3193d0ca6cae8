"""Compiled code on disk: which folder, that nobody else can write to it, and entries that are whole or absent."""

from mafsil.lazy_module import face

__all__ = face(__name__)
