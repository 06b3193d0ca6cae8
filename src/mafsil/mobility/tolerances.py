"""Every threshold of the package with its reason.

Screws are taken about the middle of the joints and lengths over their spread, so that all are free of units.
"""

RANK = 1e-9
"""Singular values below this share of the largest count as zero: what nine typed digits leave of a dependence."""
ROUNDED = 1e-5
"""Singular values below this share of the largest, though they count, are said: six typed digits leave a millionth."""
CLOSED = 1e-10
"""A loop whose gap (angle, and length over the size) is below it is closed: typed digits after Newton's method."""
AS_DRAWN = 1e-6
"""Gap of a loop as typed up to which Newton's method is tried silently; beyond it the caller is shown the gap."""
TYPED = 1e-9
"""Directions and points of drawings that agree to nine digits agree."""
PATH_STEP = 1e-3
"""Steps [rad, sizes] with which the neighbourhood of a configuration is looked at: errors of their squares, 1e-6, are
far above rounding and far below the steps."""
DEFINITE = 1e-7
"""Eigenvalues of second order forms of unit size beyond it have a sign: a hundred times what RANK leaves of them."""
IN_SUPPORT = 1e-6
"""Entries of orthonormal bases below it are zeros with rounding of a decomposition of condition up to 1/RANK."""
TOUCHING = 1e-13
"""Squares of lengths below it, over the largest, are rounding: circles nearer than 5e-14 of their radius touch."""
