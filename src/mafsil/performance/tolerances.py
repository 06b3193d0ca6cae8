"""Thresholds of performance, each with its reason; Jacobians are free of units by then.

A Jacobian of an arm of size one is known to some ten EPS, its singular values likewise; the description leaves more.
"""

ROUNDOFF = 1e-12
"""Numbers of size one that are zero: 4500 EPS, some hundred operations with a condition of ten."""
COMPUTED = 1e-11
"""The same of what a solution of linear equations, with a condition of ten more, stands behind."""
CLEAR = 1e-9
"""Parts of screws and wrenches, over the whole, of singular values and balances, that are zero: the null space of a
matrix known to `ROUNDOFF` with singular values from a thousandth on."""
SINGLE_DIGITS = 1e3 * CLEAR
"""Pivots, over the largest, that a canonical basis does not divide by: six digits of the others would be lost."""
COARSEST = 0.5
"""Largest tolerance that can be asked for: from 1 on every Jacobian would have rank zero."""
TOLERANCE = 1e-6
"""Smallest singular value of the scaled Jacobian, over its largest, that counts as not zero: six digits of a
description leave some 1e-7 of a zero as a rule, and `DESCRIBED` at worst: there the verdict is in doubt."""
NO_LEVER = 1e-5
"""Lever arms, relative to the size of the arm, that are the rounding of a description: six digits, as seen from axes
ten times as long."""
WITHIN = 1e-6
"""Parts of a unit direction, pitches and other numbers of size one, that are zero where they come from singular vectors
beside `TOLERANCE`."""
SHOWN = 5e-7
"""Half a unit of the sixth digit, which is the last one that is shown."""
ISOTROPIC = 1e-8
"""Condition number minus one of an isotropic configuration: sqrt(EPS) = 1.5e-8, for it is least there, and a minimum is
known to the root of what its value is."""
LEAST_DAMPING = 1e-14
"""Damping of Newton's method that is none: 45 EPS."""
NO_TRACE = 1e-30
"""Square of a Jacobian of rounding alone, to divide by."""
SAME = 1e-3
"""Angles [rad] of configurations that are listed once."""
SLOPE_STEP = 1e-4
"""Step of second differences: EPS^(1/4) = 1.2e-4, the best."""
ROOT_STEP = 1e-6
"""Step of central differences: EPS^(1/3) = 6e-6 leaves the least error, this one a tenth of the digits less."""
REAL_ROOT = 1e-6
"""Imaginary part of a root, over its size, of a double root that is real: 64 sqrt(EPS)."""
ON_CIRCLE = 1e-5
"""Distance of a root from the unit circle that is rounding: of a triple root, EPS^(1/3) = 6e-6."""
FLAT_SLOPE = 1e-7
"""Slopes by which Newton's method does not divide: its values are known to `ROUNDOFF`, its roots then to 1e-5."""
LONGEST_MOVE = 1e-3
"""Longest move of a root in one of its steps: it begins within `ON_CIRCLE`."""
SAME_FORM = 1e-10
"""Difference of values, over the largest, of functions that are one: 100 times `ROUNDOFF`."""
DEPENDENT = 1e-6
"""Singular values of unit vectors that depend, as `TOLERANCE`."""
LEAST_SPAN = 1e-3
"""Share of the widest extent of a map that stands for the extent of a flat one."""
