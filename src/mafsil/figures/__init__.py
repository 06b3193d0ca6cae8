"""Pictures in files, by matplotlib: imported at the first picture."""

from mafsil.lazy_module import face

__all__ = face(__name__)
