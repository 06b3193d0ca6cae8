"""The thresholds of the command line, each with its reason: what is typed and printed has few digits."""

ROUNDOFF = 1e-12
"""Numbers [SI] below it are shown as zero, and turns by less are none: rounding of a thousand operations."""
KEPT = 1e-4
"""Share of given rates by which they may open a loop: four typed digits."""
TYPED = 1e-5
"""Gap of loops over the size of the robot that typed digits leave."""
ROUNDED = 1e-6
"""How far the tip may be from a typed pose that is not met exactly [m, rad]."""
SAME_HEIGHT = 1e-9
"""Difference of heights of a tip [m], and of a joint's screw from the vertical axis, that is rounding (1e6 EPS)."""
SAME_QUALITY = 1e-9
"""Relative distance of the bounds of a grasp's quality that are one number."""
