"""Every threshold of the package with its reason.

Wrenches are compared relative to the largest, moments over the spread of the contacts, so that all are free of units.
eps = 2^-52 = 2.2e-16; in at most six dimensions, products, eliminations and singular values of well scaled columns
keep all but some hundred eps; typed input carries nine digits at worst.
"""

ROUNDOFF = 1e-12
"""Relative error of sums of products and of margins: 4500 eps, for which six dimensions and a condition of 100 do."""
NEGLIGIBLE = 1e-14
"""Rows below this share (45 eps) of the largest hold nothing but the rounding of zeros."""
RANK = 1e-10
"""Singular values below this share of the largest count as zero: below typed digits, above 1e5 eps."""
TYPED = 1e-9
"""What typed points, normals and curvatures with nine digits leave of an equation that they should fulfil."""
SOLVER = 1e-7
"""Feasibility of HiGHS, and of our own simplex in floats: an optimum nearer to zero has no certain sign."""
OPTIMUM = 1e-9
"""Optima of scaled programs below it are zero: HiGHS's polished vertices are solved to some hundred eps, times 1e4."""
QUALITY_GAP = 1e-6
"""Gap of the bounds of an epsilon quality, relative: six digits, more than any contact is known to."""
DISTANCE_GAP = ROUNDOFF
"""Gap of the bounds of a distance, relative: as far as sums of products go."""
ON_FACET = 1e-7
"""Points within it of the nearest facet, relative to the largest, may lie on it: 100 times the joggle of the growth."""
COLLINEAR = TYPED
"""Area of a triangle, over its longest edge squared, below which three typed points lie on one line."""
ON_MESH = 1e-4
"""Contacts farther than this share of the size from a mesh are off it: meshes approximate curved bodies."""
ON_OUTLINE = 1e-6
"""The same for outlines and equations, which are exact but for typed digits."""
SAME_PLACE = 1e-7
"""Corners of a mesh within this share of its size are one: STL stores single precision (6e-8)."""
SYMMETRIC = 1e-9
"""Discs this near to each other, relative to the largest, are images of each other: typed digits."""
MULTIPLIER = 1e-10
"""Prices of a program of loads of size 1 below it are none: eps times the condition of a basis, 1e5."""
UNLOADED = 1e-8
"""Remainder of a load, relative, up to which it is balanced: ten times below what HiGHS promises, as it delivers."""
STATIONARY = 1e-13
"""Remainder of the conditions of a least reach, relative, at which Newton's method has ended: 450 eps, near which it
stays."""
NOT_STATIONARY = 1e-9
"""The same after all of its steps, from which on it found nothing: halfway to where typed digits begin."""
CARRIES = 1e-6
"""Share of a mixture that a disc has to have to count among those that carry it: the start is found by a program."""
NO_BEND = 1e-7
"""Slope along a direction, relative to the reach, that is none: differences of reaches know half the digits."""
LEAST_FRICTION = 1e-12
"""A friction that varies stays above it, so that no cone vanishes and all samples have one shape."""
