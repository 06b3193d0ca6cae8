"""Thresholds of solvers, each with its reason; they know nothing of robots, so all are relative to what is solved.

EPS is the spacing of numbers at 1. A sum of n products is known to n EPS of its largest term, a double root to the
square root of what its equation is known to, and a method of order p stops where its error is below both.
"""

FEW_ROUNDINGS = 1e-15
"""4.5 EPS: steps, weights, gaps and tolerances below it are lost in the number they belong to."""

# ---- integration ---------------------------------------------------------------------------------------------------

ORDER_CONDITION = 1e-14
"""What sums of some ten coefficients of a method, written with 16 digits, leave of an order condition: 45 EPS."""
ORDER_CONDITION_LONG = 1e-13
"""The same of the pairs of order 8, whose coefficients reach 40 and cancel."""
CLOSE_RESETS = 1e-7
"""Share of the interval: resets closer than it, again and again, are chattering; 1e7 of them would not end."""
LAST_STEP = 1e-10
"""Share of a step that is not left for another one: its error, to the power of the order, is none."""
EARLIEST = 1e-290
"""Stands for the time zero, whose spacing would be none."""
LEAST_ERROR = 1e-10
"""Errors over the tolerance below which the step grows no further: its bound, `MOST`, is reached anyway."""
AFTER_RESET = 1e-3
"""Share of a step after which the side of an event is looked at that is zero at a reset."""
AT_EVENT = 1e-9
"""Values of an event, over its change in a step, that are zero at a reset: the default tolerance of integration."""
FIRST_STEP = 1e-6
"""First step where nothing is known of the motion, and norms, over the tolerance, of which ten times as much is as
good as nothing (1e-5); Hairer, Norsett and Wanner, sec. II.4."""
NO_SPEED = 1e-5

# ---- least squares -------------------------------------------------------------------------------------------------

LEAST_DAMPING = 1e-30
"""Square of the rounding of a Jacobian of size one, EPS^2 times a hundred: a Jacobian of zeros is damped so."""

# ---- convex hulls, spans and distances: sets are scaled to size one ------------------------------------------------

JOGGLE = 1e-9
"""Moves of the corners: 4.5e6 EPS, far above rounding; far below 1e-6, to which a quality is known."""
VISIBLE = 1e-13
"""Heights over a facet from which a corner sees it: 450 EPS, the rounding of its plane."""
FLATNESS = 1e-10
"""Heights over the flat of the corners before below which the set is flat: a tenth of the joggle."""
TURNED = 1e-6
"""Distance from the span of a facet's edges, in directions, below which its normal has less than half its digits."""
ON_FACET = 1e-7
"""Points within it of a facet may lie on it: 100 times the joggle."""
DEPENDENT = 1e-12
"""Corners closer than this share of their distance to the flat of the others add nothing: 4500 EPS."""
NEAR_BOUNDARY = 1e-5
"""Distances below it may be the boundary: a double root, sqrt(EPS) = 1.5e-8, times a condition of some hundred."""
ENTERING = 1e-9
"""Gains of columns of length 1 below it are none: prices carry the rounding of some tens of pivots, each of them of
size `PIVOT` to 1."""
PIVOT = 1e-9
"""Entries of the entering column, of length about 1, on which no pivot is made: sqrt(EPS) over ten."""
NEGLIGIBLE = 1e-14
"""Rows below this share of the largest (45 EPS) are rounding and stay small."""
FULL_RANK = NEGLIGIBLE
"""Least det(A A') / (trace / m)^m that is surely full rank: the determinant is known to as much."""
ASIDE = 1e-6
"""Moments about a line, over the spread of the points, that are surely not zero: points are typed with six digits."""
WALL = 1e-6
"""A cone of directions this near to a wall of symmetry is not left to its image: discs are typed with six digits."""
STILL = 1e-9
"""Relative gain of a cutting plane that is none: rounding of its matrix game, 1000 steps of `DEPENDENT`."""
TINY = 1e-12
"""Relative difference of heights that is rounding: 4500 EPS, as `DEPENDENT`."""
PARALLEL = 1e-12
"""Determinants of a ray and a triangle below this share of their terms have no sign."""
