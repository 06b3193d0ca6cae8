"""The thresholds of mechanics, each from the rounding of a double, the digits of a description, and what is computed.

A number of a description is a decimal: eleven digits are what careful files have for pi/2, which then is off by at
most half a unit of the eleventh. What a few dozen operations compute from numbers of size 1 is off by a few dozen EPS.
"""

TYPED = 1e-11
"""Entries of constant rotations, and distances of joint offsets from a quarter turn [rad], that the eleventh digit of a
description explains: they are exact zeros and quarter turns."""
ROUNDED = 1e-14
"""45 EPS: what products of a few rotations leave of a zero, as an entry, or as a length in metres."""
SKEW = 1e-2
"""Axes closer to parallel than this angle [rad] have a far and ill-conditioned common normal: its foot would cost as
many digits, four, as the square of the angle has zeros."""
OPPOSITE = 1e-12
"""Sine below which opposite axes have no plane of rotation: the normal is then found to less than four digits."""

SINGULAR_PIVOT = ROUNDED
"""Share of a pivot, inertia or eigenvalue, in expressions and of single bodies, that is rounding beside the largest."""
SINGULAR = 10 * SINGULAR_PIVOT
"""Smallest eigenvalue of a mass matrix of unit diagonal that is rounding: of (n, n) numbers that were computed by some
hundred operations each."""
SINGULAR_TASK = 100 * SINGULAR_PIVOT
"""The same of J M^-1 J', which a solution of linear equations and two products stand behind."""
INVOLVED = 1e-6
"""Share of the largest rate of a singular motion, an eigenvector found to half the digits, that is none."""
DEPENDENT = 1e-8
"""Share of a column's length that is left of it by projection on columns on which it depends: half the digits, for
states are random and columns may depend weakly."""
NEGLIGIBLE_INERTIA = 1e-15
"""Share of a body's largest moment of inertia, four EPS, that regrouping leaves of a moment that is zero."""
NEGLIGIBLE_RATE = 1e-8
"""Share of the smoothing rate below which tanh(x)/x is 1 to the last digit: x^2/3 < EPS."""
WEAK_ROW = 1e-6
"""Square of the share of a row of loops, in kinetic energy, that is left beside the other rows: a factorisation without
choice of pivots then loses six of sixteen digits, and whoever can choose is asked."""
DEPENDENT_ROW = 1e-12
"""The same over all rows together, from which on a row counts: below it, rounding of a difference (EPS) shows."""
FOLLOWS = 1e-9
"""Share of its terms by which a row that follows from others may miss a solution: what a `WEAK_ROW` leaves."""
LARGEST = 1e300
"""In place of infinity to compare with."""
