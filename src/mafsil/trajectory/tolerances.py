"""Thresholds of paths and pieces in time, each with its reason."""

ON_PATH = 1e-11
"""Size of the pose error [m | rad] at the knots of a path: as near as Newton's method gets with some hundred operations
of numbers of size ten, 45,000 EPS."""
REGULAR = 1e9
"""Times as long as the right side as a solution of equations is at most whose matrix counts as regular: 1e-7 / EPS."""
SINGULAR_VALUE = 1e-6
"""Smallest singular value of the Jacobian at which a path cannot be followed: a description of six digits leaves it."""
NEARBY = 1e-9
"""Step of the search for a configuration near the end that ends it: what is said of it has six digits."""
REAL_ROOT = 1e-6
"""Imaginary part of a root, over its size, of a double root that is real: 64 sqrt(EPS)."""
ROUNDING = 1e-12
"""What a few thousand operations leave of a duration, a share, a distance or a limit, relative to it: 4500 EPS."""
FEW_ROUNDINGS = 1e-13
"""What a few hundred leave, 450 EPS; a singular value that is smaller, relative to the largest, is zero."""
GIVEN = 1e-9
"""Points, limits and velocities that users give in nine digits meet each other within it, relative or in SI units."""
REPEATED = 1e-14
"""Share of the largest coordinate below which the distance of two neighbouring points is rounding: 45 EPS."""
CORNER = 1e-6
"""Jump of a slope, as share of the largest slope there, from which on a break is a corner: points of six digits."""
