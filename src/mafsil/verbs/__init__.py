"""The verbs of a robot: what people type first, as methods of `Robot`. The stub is the table of them.

`mafsil.Robot` takes them from here when its class is made; the packages that compute are imported at the first call.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
