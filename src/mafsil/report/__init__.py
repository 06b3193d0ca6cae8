"""Reports: one self-contained page per run with its data, and pages that show a robot."""

from mafsil.lazy_module import face

__all__ = face(__name__)
