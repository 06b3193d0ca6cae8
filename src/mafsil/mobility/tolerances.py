"""Every threshold of the package with its reason.

Screws are taken about the middle of the joints and lengths over their spread, so that all are free of units.

Of the synthesis: poses are first brought to size one: origins about their middle, over their spread.
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


SAME_POSE = 1e-9
"""Poses nearer than it, in angle and in size, are one pose typed twice with nine digits."""
COMPLEX = 1e-5
"""Imaginary parts of normalised eigenvectors up to it may be rounding of a double root; Newton's method decides."""
SOLVED = 1e-11
"""Conditions of size one that are below it hold: Newton's method reaches 1e-15, a pair of complex roots does not."""
APART = 1e-7
"""Normalised solutions nearer than it are one double root: roots of multiplicity two carry half of the digits."""
AT_INFINITY = 1e-7
"""Third coordinates of points of length one below it are zero: a crank of 10^7 sizes is a straight line."""
NO_LENGTH = 1e-6
"""Links shorter than this share of the size of the poses are points: no linkage is built with them."""
SINGULAR_PENCIL = 1e-12
"""Least singular value of a pencil at generic places, over its largest, below which it is singular everywhere."""
DEAD = 1e-9
"""Sine of the transmission angle below which a position is a dead point itself."""
ILL_CONDITIONED = 1e-4
"""Sine of a transmission angle below which a pin closed by lengths loses more than four digits: it is not compared."""
EXACT = 1e-9
"""Largest error, over the size of the linkage, up to which a position is met: a hundred times what Newton leaves."""
SAME_GROUND = 1e-3
"""A dyad nearer to a known link is that link: an ill-conditioned root keeps three digits at least."""
GRID = 720
"""Crank angles of a turn at which six-bars and spherical four-bars are looked at; minima between them by parabolas."""
MOST_JUDGED = 200
"""Linkages of a family whose configurations are followed, those of the best transmission angles at the positions."""
BULKY = 30.0
"""Linkages with links longer than so many sizes of the task stand behind the others of as many defects."""
MOST_CANDIDATES = 60
"""Candidates that an answer keeps of a family; those of finite problems are all kept (at most twelve)."""
UNDETERMINED = 1e-13
"""Shorter homogeneous points are rounding: the conditions leave their place open, as at a pole."""
