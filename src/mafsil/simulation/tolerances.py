"""Thresholds of simulation, each with its reason: time is counted in steps, and a step is a decimal."""

PART_OF_STEP = 1e-9
"""Share of a step that is the rounding of a time: a million steps (1e6 EPS) of a decimal, and ten times that."""
PERIOD = 1e-9
"""Relative difference of a control period from whole steps: both are typed with nine digits."""
NO_SECONDS = 1e-9
"""Seconds of computing that are left at least, so that a budget is positive: a clock's tick."""
SLOWEST_TURN = 1e-3
"""Rate [rad/s] that stands for none where a body's turn decides how long a piece of its motion is."""
NEWTON_RESIDUAL = 4e-16
"""Residual, over the momenta, at which Newton's method stops: 2 EPS, no step makes it smaller."""
TOUCHING = 1e-12
"""Distance [m] of a tip from a rigid surface that is rounding: coordinates of metres, through a thousand operations."""
RESTING = 1e-12
"""Speed [m/s] along its normal that is rounding, in the same way."""
QUIET = 1e-10
"""Acceleration [m/s^2] into it that is none: rounding of efforts and inertias, a thousand operations of 10 m/s^2."""
FAILED = 1e-9
"""The same above which a step has failed: the default tolerance of integration."""
IMMOBILE = 1e-12
"""Part of the largest inverse mass at the tip that is none: rounding of an arm that cannot move it that way."""
PARALLEL = 1e-12
"""Sine of an angle between directions that are parallel, or a determinant of unit vectors that vanishes: rounding."""
ON_THE_CONE = 1e-9
"""Share of a force by which it may be outside the friction cone and still stick: a coefficient of nine digits."""
END_OF_SLIDING = 1e-11
"""Share of a speed below which an impact does not slide any more: rounding of the integration of its direction."""
STILL = 1e-9
"""Speed [m/s] of a tip that does not slide: what a step of a millisecond gives at a thousandth of a thousandth of g."""
SINGULAR_CONTACT = 1e-7
"""Acceleration [m/s^2] by which two forces of contact differ: a thousand times `QUIET`."""
