"""Description and machine code together: load a robot, call its quantities."""

from mafsil.lazy_module import face

__all__ = face(__name__)
