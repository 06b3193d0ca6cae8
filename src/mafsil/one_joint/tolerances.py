"""Thresholds of one joint, each with its reason: what rounding explains, and where a series takes over."""

ROUNDOFF = 1e-12
"""Share by which sums, quotients and logarithms of some thousand roundings may miss a number or a sign."""
NO_COEFFICIENT = 1e-14
"""Coefficients of a polynomial below this share of its largest are the rounding of zeros: 45 EPS."""
LINEAR = 1e-8
"""Below it sin(x)/x and its like are 1 to the last digit: x^2/6 < EPS."""
BELOW_ONE = 1.0 - 1e-16
"""The largest share of which an inverse hyperbolic tangent is finite: the number before 1."""
NO_GAP = 1e-9
"""Half the gap of two roots over their frequency below which they are one, and its quotients rounding alone."""
SAME_MEETING = 1e-6
"""Two places where branches meet that are nearer to each other are one: double roots know half the digits."""
WHOLE_STEPS = 1e-6
"""Share of a step by which a duration may miss a whole number of steps: typed durations have six digits."""
BALANCED = 1e-9
"""Moments that remain, relative to the load, at which a rest is one: Newton's method ends far below."""
SETTLED = 1e-6
"""Share of an error at which a crossing is no longer looked for."""
SOFTEST = 1e-6
"""Gain over stiffness at which the search for the largest stable one begins."""
