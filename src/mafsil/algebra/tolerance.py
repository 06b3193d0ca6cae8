"""The tolerances that all packages share, each with its reason. Knows no expressions: reading them costs nothing.

EPS = 2^-52 is the distance of 1 from the next number. Three rules give nearly all of them:

- A sum of n products is known to about n EPS of its largest term.
- A double root of an equation that is known to e is known to sqrt(e).
- A direction that is found from a vector of length d is known to EPS / d.
"""


# ---- what a member of a group may be away from it ------------------------------------------------------------------

ROTATION = 1e-6
"""Largest Frobenius norm of R'R - I at which a matrix counts as a rotation: single-precision data pass, whose nine
entries are known to 2^-24 of one each, products to some 8 of these (5e-7)."""
UNIT = 1e-6
"""Largest deviation of a length from 1 at which a quaternion or an axis counts as unit: single precision, as above."""
PRINTED = 3e-3
"""Largest such norm at which a matrix counts as a rotation printed with three to five digits, and is made one again:
nine entries wrong by 5e-4 each lie 1.5e-3 from the rotation, and R'R - I is twice as large."""
PRINTED_UNIT = 1e-3
"""Largest deviation of the length of a quaternion printed so: four numbers wrong by 5e-4 each."""
SKEW = 1e-6
"""Largest norm of the symmetric part of R'Rdot, over that of Rdot, at which Rdot counts as a velocity of R."""
TRANSLATION = 1e-12
"""Angle [rad] below which a displacement counts as a translation when its screw axis is computed: the axis would lie
farther than 1e12 times the displacement, its place known to EPS / 1e-12, 2e-4 of that distance."""
SQUARE = 1e300
"""Largest square of an angle, so that nothing overflows on the way to its sine."""
WHOLE_TURNS = 1e15
"""Largest (1 + |theta|) / |sin(theta / 2)| at which an angle differs from a whole number of turns: the sine is known to
EPS (1 + |theta|), so from 1 / EPS = 4.5e15 on no digit of it is left."""

# ---- what a description leaves open ---------------------------------------------------------------------------------

DESCRIBED = 2e-5
"""By how much an arm [rad, and m relative to its size] may differ from the one that was meant, where its description
has six digits: each of the 36 numbers between base and tip of six joints is wrong by 5e-7 at most."""

# ---- equations of inverse kinematics -------------------------------------------------------------------------------

FREE = 1e-9
"""Distance from an axis, relative to the size of the arm, below which every turn about it counts as a solution: it
would determine the turn to EPS / 1e-9 = 2e-7 rad only, and any other one moves the arm by 1e-9 of its size at most."""
VANISHING = 1e-12
"""Coefficients, relative to the terms they are made of, below which an equation says nothing: 2^12 EPS, for they are
sums of some hundred products, each of factors that were sums before."""
DOUBLE_ROOT = 1e-6
"""Relative distance of a line from a curve up to which it may touch it but for roundoff: 64 sqrt(EPS), the square root
that a double root costs, of an equation known to VANISHING."""

LIMITS: dict[str, float] = {
    "rotation": ROTATION,
    "pose": ROTATION,
    "planar_rotation": ROTATION,
    "planar_pose": ROTATION,
    "unit_quaternion": UNIT,
    "axis_triple": UNIT,
    "unit_screw": UNIT,
    "axis": 0.0,
    "quaternion": 0.0,
    "rotation_vector": SQUARE,
    "exponential_coordinates": SQUARE,
    "planar_coordinates": SQUARE,
    "amount": SQUARE,
    "duration": SQUARE,
    "part_turn": WHOLE_TURNS,
}
"""Largest measure (`mafsil.algebra.membership`) of every kind of member."""

MENDED: dict[str, float] = {
    "rotation": PRINTED,
    "pose": PRINTED,
    "planar_rotation": PRINTED,
    "planar_pose": PRINTED,
    "unit_quaternion": PRINTED_UNIT,
}
"""Largest measure of the kinds whose members are made again from printed digits, with a warning."""
