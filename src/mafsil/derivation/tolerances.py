"""Thresholds of derivations, each with its reason: lines are shown only where numbers prove them."""

from mafsil.mechanics.tolerances import TYPED

NOTHING = TYPED
"""Lengths [m], differences of directions and of quarter turns [rad] that a description's eleventh digit explains."""
LIMIT = 1e-9
"""Largest difference of a line from the compiled robot, relative to the largest number in it (or 1): 4.5e6 EPS, what a
few thousand operations leave, with a condition of a thousand; a wrong sign or term is larger by many orders."""
HALF_DIGITS = 1e-7
"""The same [rad | m] of a line with an angle from a cosine near one, which has half the digits: sqrt(EPS) = 1.5e-8."""
ROUNDOFF = 1e-12
"""Numbers that are shown as zero, or as the integer that they are so near to: 4500 EPS."""
ROUNDING = 1e-13
"""Coefficients, of polynomials of numbers of size one, that are rounding: 450 EPS."""
SAME = 1e-9
"""Differences of numbers of two tables, lengths or angles, that are none: what people type has nine digits at most."""
QUARTER = 1e-8
"""Difference [rad] from a quarter turn, of a number found by Newton's method with central differences, that is none:
the square of `DH_STEP` over what its slope loses."""
DH_STEP = 1e-5
"""Step [rad | m over the size] of central differences of a table's poses: EPS^(1/3) = 6e-6, the best of order two."""
LEAST_LENGTH = 1e-3
"""Size [m] of a table that has no length, as of arms without one."""
DEPENDENT = 1e-12
"""Square of a slope, per unit, of a number on which no pose depends."""
DIFFERENT = 1e-3
"""Step [s] of differences of fourth order in time: EPS^(1/5) = 7e-4, the best of that order."""
COMPLEX_STEP = 1e-30
"""Step in the imaginary direction: no difference is taken, so it may be as small as numbers allow its square to be."""
ALMOST_PARALLEL = 1e-4
"""Second singular value of the directions, over the first, below which the places of axes are asked too: typed with
four digits they are parallel."""
PSEUDOINVERSE = 1e-9
"""Eigenvalues of a sum of squares, over the largest, that are zero: directions that differ by 3e-5 are parallel."""
NEAREST = 1e-13
"""Differences of two arms, over their size, that no further step reduces: 450 EPS; from a hundredth on none helps."""
