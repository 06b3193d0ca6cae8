"""Named tolerances of membership. Knows no expressions, so that reading them costs nothing."""

ROTATION = 1e-6
"""Largest entry of |R'R - I| at which a matrix still counts as a rotation: single-precision data pass."""
UNIT = 1e-6
"""Largest deviation of a length from 1 at which a quaternion or an axis still counts as unit."""
AXIS = 1e-150
"""Largest component below which a vector has no direction to speak of: its square would underflow."""
TRANSLATION = 1e-12
"""Angle [rad] below which a displacement counts as a translation when its screw axis is asked for."""
