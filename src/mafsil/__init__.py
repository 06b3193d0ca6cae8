"""mafsil: robot manipulators, from the mathematics of a screw to a controlled arm.

Names are found at their first use, so that `import mafsil` stays quick.
"""

from mafsil.argument_gate import gated, unknown_name
from mafsil.lazy_module import extend, face, stand_before_public_names

extend("Robot", "mafsil.verbs")
extend("kinds of robots", "mafsil.parallel.legs.leg_library")
stand_before_public_names(gated, unknown_name)
__all__ = face(__name__)
