"""Thresholds of identification, each with its reason: what a recording cannot show, and what rounding leaves of zeros.

Sensors have five digits at best (encoders of 17 bits, currents of 12): a thousandth of that is none.
"""

NO_MOTION = 1e-12
"""Ranges, rates, accelerations and lengths, in SI units, of joints that stand still, to divide by."""
NO_EFFORT = 1e-9
"""Efforts [N m | N] that stand for none: nine digits below one, where sensors have five."""
LEAST_MASS = 1e-6
"""Mass [kg] and inertia [kg m^2] of bodies for which a recording shows none; as of arms without mass."""
LEAST_SHARE = 1e-3
"""Share of the whole that a part is given at least where the data leave none of it: mass of a body, freedom of a fit,
radius of gyration, power of a joint; ten times the noise of what is measured."""
LEAST_NOISE = 1e-9
"""Smallest noise that is assumed for a joint, as a share of its efforts: rounding of recordings with nine digits."""
ALONE = 1e-6
"""How far a parameter may be from the span of the base parameters and still count as identifiable alone: random
regressors are dependent to 1e-8, half the digits, and a hundred columns add up."""
DEPENDENT = 1e-9
"""Singular values, over the largest, of columns that depend: regressors are sums known to 1e6 EPS at worst."""
NO_EXCITATION = 1e-14
"""Eigenvalues of a normal matrix, over the largest, that are rounding: 45 EPS."""
WORST_CONDITION = 1e7
"""Condition number that is said of a regressor there: the root of 1 / `NO_EXCITATION`."""
PART_OF_BAND = 0.01
"""Rates of joints, over the largest, that say nothing of a filter: their noise is as large."""
