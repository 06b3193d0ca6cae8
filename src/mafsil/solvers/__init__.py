"""Numbers only: iterations, integrators and their honest outcomes; no robot."""

from mafsil.lazy_module import face

__all__ = face(__name__)
