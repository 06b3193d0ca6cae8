"""Thresholds of geometry, each with its reason; what all layers share stands in `mafsil.algebra.tolerance`.

EPS is the spacing of numbers at 1. A value that went through n operations with condition c is wrong by n c EPS at most.
"""

ROUNDOFF = 1e-12
"""Numbers of order one that are equal but for rounding: 4,500 EPS, a hundred motions multiplied, condition ten."""
SPECIAL = 1e-9
"""Angle [rad] from a special one (none, a half turn, a gimbal lock, points on a line) that counts as it, or distance
[m], over the size where there is one, that counts as none.

A rotation written with ten decimals has entries wrong by 5e-11 and hence angles by 1e-10; ten times that.
"""
ON_A_LINE = 1e-13
"""Spread across a line over spread along it, both squared, below which a rotation about the line is open.

The spreads are singular values of products of coordinates, wrong by some hundred EPS of the largest.
"""
SKEWNESS = 1e-6
"""By how much W + W' may differ from zero, as a share of the largest entry: data of single precision, and differences
of poses, whose best step h = EPS^(1/3) leaves errors of h^2 = 4e-11 and a careless one of 1e-3 leaves 1e-6.
"""
LOOP_ANGLE = 1e-6
"""Angle [rad] that two ways between two frames may differ by: the rotations that are accepted agree so far only."""
LOOP_DISTANCE = 1e-6
"""Distance [m] likewise; relative to the longest edge where that is longer than 1 m."""
