"""The language of job files: frames, names, patterns, loops and units; and the job that a file asks for."""

from mafsil.lazy_module import face

__all__ = face(__name__)
