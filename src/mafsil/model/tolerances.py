"""Thresholds of robot descriptions, each with its reason: what people and programs write has few decimals.

Files made by programs carry 10 to 17 digits, printed tables 4 to 7. A threshold lies above the rounding of what is
written and below what a drawing means by different.
"""

WRITTEN = 1e-9
"""Relative difference of two values that mean one: files of programs carry ten digits and more, so 5e-11, times twenty.

Lengths of unit axes, opposite entries of an inertia, coordinates of one mimic pair, distances over the size.
"""
PRINTED = 1e-6
"""Deviation of a printed rotation, unit screw or inertia from a true one: six decimals leave 5e-7 in each entry."""
PRINTED_ROTATION = 2e-6
"""Deviation of R R' from the identity where R is printed: products of rows are wrong by 2 sqrt(3) 5e-7 = 1.74e-6."""
PARALLEL = 1e-7
"""Angle [rad] between axes that count as parallel.

An axis turned into place by rpy angles of eight decimals is wrong by 5e-9 per angle; twenty times that.
"""
UNIT_QUATERNION = 1e-3
"""Difference of a quaternion's length from 1 up to which it was meant to be 1: three decimals leave 9e-4."""
NO_LENGTH = 1e-14
"""Length of a vector of MJCF that has no direction: ten times mjMINVAL, below which MuJoCo divides by nothing."""
ROUNDED_TURN = 1e-14
"""Angle [rad] beside a multiple of a quarter turn below which it is one: some units in the last place of pi."""
POLE = 1e-14
"""Cosine of the pitch below which yaw is free: of pi/2 as a double it is 6e-17, after products more."""
SAME_POSE = 1e-12
"""Entry of a pose beside the identity's that is the rounding of products of poses."""
NO_AXIS = 1e-150
"""Largest component of an axis without direction: its square would be no number any more."""
QUATERNION_LENGTHS = (1e-6, 1e6)
"""Lengths between which a quaternion that nobody normed has a direction: beyond, digits of its squares are lost."""
SHOWN_AS_ZERO = 1e-12
"""Number of a table to read that is printed as 0: rounding, and less than any digit shown of lengths in metres."""
