"""Arms of six joints without a special shape: all solutions, up to sixteen, of whole batches of poses."""

from mafsil.lazy_module import face

__all__ = face(__name__)
