"""Named tolerances. Knows no expressions, so that reading them costs nothing."""

ROTATION = 1e-6
"""Largest Frobenius norm of R'R - I at which a matrix counts as a rotation: single-precision data pass."""
UNIT = 1e-6
"""Largest deviation of a length from 1 at which a quaternion or an axis counts as unit."""
SKEW = 1e-6
"""Largest norm of the symmetric part of R'Rdot, over the norm of Rdot, at which Rdot counts as a velocity of R."""
TRANSLATION = 1e-12
"""Angle [rad] below which a displacement counts as a translation when its screw axis is asked for."""
SQUARE = 1e300
"""Largest square of an angle, so that nothing overflows on the way to its sine."""
WHOLE_TURNS = 1e15
"""Largest (1 + |theta|) / |sin(theta / 2)| at which an angle is told from a whole number of turns."""

LIMITS: dict[str, float] = {
    "rotation": ROTATION,
    "pose": ROTATION,
    "planar_rotation": ROTATION,
    "planar_pose": ROTATION,
    "unit_quaternion": UNIT,
    "axis_triple": UNIT,
    "unit_screw": UNIT,
    "axis": 0.0,
    "quaternion": 0.0,
    "rotation_vector": SQUARE,
    "exponential_coordinates": SQUARE,
    "planar_coordinates": SQUARE,
    "amount": SQUARE,
    "duration": SQUARE,
    "part_turn": WHOLE_TURNS,
}
"""Largest measure (`mafsil.algebra.membership`) of every kind of member."""
