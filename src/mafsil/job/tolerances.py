"""The thresholds of jobs, each with its reason: files are typed in decimals, and motions are checked at all breaks."""

WITHIN_LIMITS = 1e-6
"""Relative excess over a limit that a planned motion may show: what planners of time promise between points."""
SAME_TIME = 1e-9
"""Relative difference of durations that is the rounding of a typed one: nine digits."""
SLOWED = 1e-6
"""Relative excess of a duration above which a motion counts as slowed: what `WITHIN_LIMITS` costs."""
NO_DIRECTION = 1e-6
"""Length of a typed quaternion below which it has no direction: six decimals that are all zero."""
SAME_POINT = 1e-9
"""Distance [m] of two typed points that are one: nine decimals."""
ARRIVED = 1e-6
"""Distance of the TCP from where a path of it ended, in each entry of its pose: what following a path promises."""
MOVED = 1e-12
"""Difference of joint coordinates [rad | m] that is rounding: a thousand operations on coordinates of order one."""
LEAST_SLOPE = 1e-12
"""Slope of a path below which a limit of the joint does not bind: its quotient would be beyond all limits."""
MOVES_TIP = 1e-9
"""Entry of a Jacobian above which a joint moves the tip, and singular value that counts: 1e6 EPS."""
LEAST_DEXTERITY = 1e-12
"""Smallest and largest singular values, and their ratios, are not divided by less."""
STILL_LOG = 1e-9
"""Range of a logged column [rad | m] that stands for none, and slope of one on another."""
FLAT_SHARE = 1e-6
"""Share of a column's range that its remainder is compared with where it does not change: six digits of a log."""
