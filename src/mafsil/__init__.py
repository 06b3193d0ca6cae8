"""mafsil: robot manipulators, from the mathematics of a screw to a controlled arm.

Names are found at their first use, so that `import mafsil` stays quick.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
