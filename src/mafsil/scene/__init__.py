"""What reports and pages draw: a robot as solids in Python, and the scripts that show solids in a browser."""

from mafsil.lazy_module import face

__all__ = face(__name__)
