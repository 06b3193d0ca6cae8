"""The robot as immutable data, and what makes it: readers and writers of files, tables, mass properties, lint."""

from mafsil.lazy_module import face

__all__ = face(__name__)
