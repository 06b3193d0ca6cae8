"""Files of scanners and cameras: points, and heights on a grid."""

from mafsil.lazy_module import face

__all__ = face(__name__)
