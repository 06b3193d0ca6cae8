"""The message catalogue: every sentence that a user reads, in English and Arabic."""

from mafsil.lazy_module import face

__all__ = face(__name__)
