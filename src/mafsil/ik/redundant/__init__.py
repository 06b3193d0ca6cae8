"""Arms with seven joints: configurations by arm angle or by a locked joint, and the intervals in which they exist."""

from mafsil.lazy_module import face

__all__ = face(__name__)
