"""Thresholds of inverse kinematics, each with its reason.

EPS is the spacing of numbers at 1. Three rules give nearly all: a closed form of some hundred operations with a
condition of a hundred is known to 1e-11 (`CLEAR` of `mafsil.mechanics.arm_pattern`, with what its compiled
decision needs); a double root to the square root of that; descriptions and poses are typed with 4 to 14 digits.
"""

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import EPS
from mafsil.mechanics import arm_pattern

INSIDE = arm_pattern.INSIDE
"""By how much a joint may seem beyond its limit by rounding [rad | m]: where its value is chosen, not measured."""
ON_LIMIT = arm_pattern.ON_LIMIT
"""By how much a joint of an isolated solution may lie beyond its limit and count as on it: `MEASURED` [rad | m]."""
WHOLE_TURN = arm_pattern.WHOLE_TURN
"""Share of a turn by which rounding may miss a whole one."""

# ---- residuals of solutions [m | rad] ------------------------------------------------------------------------------

REACHED = 1e-9
"""Largest residual of a solution where nothing else is asked for: a pose typed with nine digits is met."""
EXACT_POSE = 1e-12
"""Entries of rotations, and cosines, that are the same: 4500 EPS."""
NO_BETTER = 1e-14
"""Errors that no step makes smaller: 45 EPS, the rounding of forward kinematics."""
FINEST = 1e-13
"""Residuals that are not refined where anything is: ten times as much."""
CLOSED = 1e-10
"""Error of the loop below which a candidate of elimination is a solution: Newton's step from there leaves EPS."""
STRAIGHT = arm_pattern.CLEAR
"""Residual up to which a pose is reached with the wrist locked straight."""
HIDDEN = 5e-10
"""The same where it is a thousandth (`PART_OF_BEND`) of the bend that was taken away: half of what is `REACHED`."""
PART_OF_BEND = 1e-3
NEARLY_REACHED = 1e-5
"""Residuals up to which a row may become a solution by refinement: a double root, known to the square root of CLEAR."""
QUADRATIC = 5e-9
"""Error whose Newton step leaves nothing that is seen: its square over `LEAST_MARGIN` is 2.5e-14."""
ONE_MORE = 1e-7
"""Scaled error from which one more step is trusted to end within rounding: its square, 1e-14, of arms up to a metre."""
FROM_THE_POSE = 1e-6
"""Residual of a search, and of a drift over a closed path, that is none of the pose asked for: six digits."""

# ---- coordinates [rad | m] -----------------------------------------------------------------------------------------

SAME = 1e-6
"""Coordinates up to which rows are one solution: `CLEAR` at a double root, 3e-6, and less at others."""
SAME_AT_DOUBLE_ROOT = 1e-4
"""The same beside a fold, and of joints that stand still in a family, which begins there: errors of 1e-10 to 1e-8 move
them by their square root."""
SAME_SUBPROBLEM = 1e-7
"""The same of one subproblem, known to EPS: 7 times its square root."""
STILL = 1e-8
"""Self-motion, and least gain, at which an approach counts as ended: half the digits."""
LEAST_GAIN = 1e-6
"""Part of a step below which nothing is gained any more."""
ADDED_STILL = 1e-7
"""Values of added joints that count as standing still: 7 sqrt(EPS), as they are often double."""
INSET = 1e-3
"""How far from the end of an interval a value is chosen, if it is wide enough: its root, 0.03, is how far branches are
from merging there."""
INWARDS: Floats = np.array([1e-2, 1e-4, 1e-6])
"""How far from a configuration at a limit the locked joint is moved: by two digits less each time."""
AT_LIMIT = 1e-9
"""Distance from a bound at which a joint counts as being there, as `REACHED`."""
CELL_SLACK = 1e-10
"""By how much a joint may be beyond its limit in a cell: EPS times a condition number of some 1e5."""
STEP_RESIDUAL = 1e-12
"""Residual of a step of a closed form up to which it exists: 4500 EPS."""
SLIGHT, RELATIVELY = 1e-14, 2 * EPS
"""Rounding of a parameter's value: 45 EPS near zero [rad | m], two relative to it."""
CELL = 1e-9
"""Cells narrower than that are left undecided: ends are known, and gaps and intervals seen, to it, as `REACHED`."""
PLACE = 1e-12
"""Width at which the search for a crossing of continua ends: 4500 EPS."""

# ---- margins and rates ---------------------------------------------------------------------------------------------

LEAST_MARGIN = 1e-3
"""Branch margins below which rows are not trusted: there, errors of 1e-6 are enough to merge them."""
FREE_BRANCH = arm_pattern.MERGED
"""Degeneracy of a row (its distance from merging) up to which a solution may be the member of a further continuum."""
APART_BRANCH = 1e-4
"""The same below which two branches may be one, where turning joints were added: ten times as far as without."""
FAR_ALONG = 1e-3
"""Part of a motion that a joint must have for its value to lead along it: three digits of the others are left."""
SELF_MOTION = 1e-6
"""Singular values of the Jacobian, over the largest, below which axes depend on each other and a motion may leave the
pose as it is: six digits of a description."""
SINGULAR = 1e-7
"""The same below which Newton's method leaves a direction alone: 7 sqrt(EPS), the root of a double root's error."""
RANK = 1e-9
"""The same of rates: a twist is made to as many digits as are left, seven."""
MADE = 1e-9
"""Residual over the twist up to which it is made."""
SYMMETRIC = 1e-9
"""Largest difference of a cost from its transpose, over its largest element: typed with nine digits."""
PULLED = 1e-9
"""Rates of joints at their limits that press on: more than rounding of pseudoinverses of condition 1e6."""
NEARLY_SINGULAR = 1e-3
"""Conditioning below which a configuration is named as nearly singular: three digits are lost there."""
DIRECTION = 1e-5
"""Values of a form on a unit vector that may be none: merged roots are known to the square root of CLEAR."""
TANGENT = 1e-9
"""Singular values of the slopes of such forms that are none; cosines, from 1, of directions that are one."""

# ---- steps and damping ---------------------------------------------------------------------------------------------

CENTRAL = 6e-6
"""Step of central differences: EPS^(1/3)."""
SIXTH_ORDER = 1e-3
"""Step of differences of sixth order, in units of time [s]: rounding and truncation meet near EPS^(6/7) = 4e-14 for
EPS^(1/7) = 6e-3, and motions faster than that are differentiated well, too."""
START_DAMPING, LEAST_DAMPING = 1e-3, 1e-12
"""Damping of a descent at first, relative to its curvature, and the least: 4500 EPS keep its factors regular."""
REFINED_DAMPING = 1e-6
"""The first damping where the start is near: rates of merged roots are as small as its root."""
FACTOR_DAMPING = 1e-14
"""Keeps a factorisation regular at singular poses without slowing the last steps elsewhere: 45 EPS."""
NO_STEP, NO_COST = 1e-15, 1e-29
"""Steps, 4.5 EPS, and squares of errors, with a dozen terms of EPS^2 each fifteen times, from which none is better."""
NO_GRADIENT = 1e-13
"""Gradient, over the size squared, at the nearest point: 450 EPS."""
SUFFICIENT = 1e-4
"""Share of the predicted decrease that a step must make (Armijo)."""
SHORTEST = 1e-4
"""Step, in parts of the way, at which a branch is given up: it ends there, known to four digits."""

# ---- the structure of an arm: sines and angles [rad], distances over its size ---------------------------------------

DEFECT = 1e-9
"""Defects that are rounding, the closed form is the arm's own: its solutions then are within `REACHED`."""
SNAP = 5e-4
"""Defects up to which a simple family is preferred to an exact one that solves an equation of fourth degree: angles
printed with four digits and more, 1.571 or 1.5708 for a quarter turn. Its rows are refined to the arm as it is, and
merged roots, which the exact equation then nearly has, need no care."""
WELL_POSED = 1e-3
"""Sines, cosines and determinants of directions below which a closed form that divides by them loses three digits of
the twelve that `REACHED` asks of `EXACT_POSE`."""
COINCIDENT = 1e-6
"""Distances below which a joint does not move a point: a description of six digits."""
CONDITIONED = 1e-5
"""Conditions of the first joints' equations below which another way is taken: half the digits of `CLEAR` are left."""
FLAT_CIRCLE = 1e-7
"""Determinant of two equations below which a circle is flat: its half axes are known to the square root, 3e-4."""
NO_EXTENT = 1e-9
"""Extent [m] of an arm that has none: its points are typed."""
TYPED_ZERO = 1e-13
"""Components of axes and points that are zero: 450 EPS, what turning them into {s} leaves."""
IDEAL_REACHED, IDEAL_QUARTIC_REACHED = 1e-9, 1e-5
"""By how much the ideal arm's subproblems may be unsolved and its branch still exist [m | rad]: `REACHED`, and of
equations of fourth degree, whose roots rounding moves more where axes are almost parallel or meet, its root or so."""

# ---- elimination ---------------------------------------------------------------------------------------------------

CLEAN = 1e-12
"""Coefficients that must be zero, relative to the others, beyond which rounding is measured: it also stays within."""
DISTURBANCE = 1e-10
"""Of the equations, relative, by which the effect of rounding is measured: far above it, and small still squared."""
MATCHED = 1e-3
"""Difference of a solution from the zero that it explains [rad]: zeros of multiplicity four are known to EPS^(1/4)."""
DETERMINED = 1e-5
"""Rank of all zeros of a list beyond which each of them leads to one solution only: rows are known to CLEAR's root."""
REGULAR = 1e-6
"""Distance from merged ways, from b and d about one axis, and from dependent prismatic axes that a proof needs."""
LAST_CORRECTION = 1e-13
"""Corrections of a zero that are the last: 450 EPS."""

MILLIMETRES = 50.0
"""Reaches of an arm beyond which a place counts as one in millimetres: nobody asks for it in metres."""
