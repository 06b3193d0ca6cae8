"""MuJoCo's model files: reader and writer of the part that describes mechanisms, with coded diagnostics and repairs."""

from mafsil.lazy_module import face

__all__ = face(__name__)
