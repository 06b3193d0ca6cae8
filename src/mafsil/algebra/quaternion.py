"""Unit quaternions (w, x, y, z) and other numbers of a rotation that hang on them, as expressions."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import series
from mafsil.algebra.spatial import cross, skew, skew_square


def vector(q: ex.Expression) -> ex.Expression:
    """(3,) the part (x, y, z)."""
    return q[1:]


def multiply(q: ex.Expression, p: ex.Expression) -> ex.Expression:
    """(4,) q p, the rotation p followed by q about fixed axes: R(q p) = R(q) R(p)."""
    a, b = vector(q), vector(p)
    return ex.vertcat(q[0] * p[0] - ex.dot(a, b), q[0] * b + p[0] * a + cross(a, b))


def conjugate(q: ex.Expression) -> ex.Expression:
    """(4,) (w, -x, -y, -z), the inverse of a unit quaternion."""
    return ex.vertcat(q[0], -vector(q))


def normalise(q: ex.Expression) -> ex.Expression:
    """(4,) q / |q|, of any length but zero."""
    largest = ex.fmax(ex.fmax(ex.fabs(q[0]), ex.fabs(q[1])), ex.fmax(ex.fabs(q[2]), ex.fabs(q[3])))
    scaled = q / largest
    return scaled / ex.sqrt(ex.dot(scaled, scaled))


def canonical(q: ex.Expression) -> ex.Expression:
    """(4,) of q and -q the one whose first non-zero number is positive."""
    sign = 1.0
    for k in reversed(range(4)):
        sign = ex.if_else(q[k] > 0, 1.0, ex.if_else(q[k] < 0, -1.0, sign))
    return sign * q


def rotate(q: ex.Expression, x: ex.Expression) -> ex.Expression:
    """(3,) R(q) x = x + 2 (w a + b), a = u x x, b = u x a, for unit q = (w, u)."""
    u = vector(q)
    a = 2 * cross(u, x)
    return x + q[0] * a + cross(u, a)


def exp(r: ex.Expression) -> ex.Expression:
    """(4,) (cos(theta/2), r sin(theta/2)/theta) of exponential coordinates r = omega theta [rad]."""
    s = ex.dot(r, r)
    return ex.vertcat(series.half_cosine(s), series.half_sine(s) * r)


def log(q: ex.Expression) -> ex.Expression:
    """(3,) r = omega theta [rad], theta in [0, pi], the same for q and -q; q need not be normalised."""
    u = vector(q)
    sign = ex.if_else(q[0] < 0, -1.0, 1.0)
    return 2 * sign * series.arctangent_ratio(ex.dot(u, u), ex.fabs(q[0])) * u


def angle(q: ex.Expression) -> ex.Expression:
    """Angle of the rotation [rad], in [0, pi]; q need not be normalised."""
    u = vector(q)
    return 2 * ex.atan2(ex.sqrt(ex.dot(u, u)), ex.fabs(q[0]))


def to_matrix(q: ex.Expression) -> ex.Expression:
    """(3, 3) R = I + (2 / |q|^2) (w [u] + [u]^2), q = (w, u); the length of q does not matter.

    Reference: Shuster, A survey of attitude representations, 1993.
    """
    return _matrix(q, 2 / ex.dot(q, q))


def to_matrix_unit(q: ex.Expression) -> ex.Expression:
    """(3, 3) R = I + 2 (w [u] + [u]^2) of a quaternion known to be unit."""
    return _matrix(q, 2.0)


def to_matrix_rounded(q: ex.Expression) -> ex.Expression:
    """(3, 3) R of a quaternion that is unit but for rounding, which is divided out: 2 / |q|^2 ~ 2 (2 - |q|^2)."""
    return _matrix(q, 4 - 2 * ex.dot(q, q))


def from_matrix(R: ex.Expression) -> ex.Expression:
    """(4,) unit quaternion of R with w >= 0 (at w = 0: first non-zero number positive).

    4 q q' is linear in R; the column of its largest diagonal entry, scaled to unit length, is q.

    Reference: Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1, 1978.
    """
    q = proportional_to_matrix(R)
    return canonical(q / ex.sqrt(ex.dot(q, q)))


def proportional_to_matrix(R: ex.Expression) -> ex.Expression:
    """(4,) a quaternion of R, not of unit length: the column of 4 q q' with the largest diagonal entry."""
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    xy, yz, zx = R[0, 1] + R[1, 0], R[1, 2] + R[2, 1], R[2, 0] + R[0, 2]
    a, b, c = R[0, 0], R[1, 1], R[2, 2]
    columns = [
        ex.vertcat(1 + a + b + c, x, y, z),
        ex.vertcat(x, 1 + a - b - c, xy, zx),
        ex.vertcat(y, xy, 1 - a + b - c, yz),
        ex.vertcat(z, zx, yz, 1 - a - b + c),
    ]
    best, largest = columns[0], columns[0][0]
    for k in (1, 2, 3):
        better = columns[k][k] > largest
        best, largest = ex.if_else(better, columns[k], best), ex.if_else(better, columns[k][k], largest)
    return best


def slerp(p: ex.Expression, q: ex.Expression, t: ex.Expression) -> ex.Expression:
    """(4,) p exp(t log(p* q)): constant angular velocity from p (t = 0) to q (t = 1), the short way."""
    return multiply(p, exp(t * log(multiply(conjugate(p), q))))


def to_su2(q: ex.Expression) -> ex.Expression:
    """(2, 2, 2) as (8,): [[w + ix, y + iz], [-y + iz, w - ix]], every entry as (real, imaginary).

    Products of these matrices are products of quaternions.
    """
    w, x, y, z = q[0], q[1], q[2], q[3]
    return ex.vertcat(w, x, y, z, -y, z, w, -x)


def from_su2(u: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """Quaternion (4,) of a matrix [[a, b], [-b*, a*]] given as (8,) real and imaginary parts, and its defect.

    Both rows are averaged; the defect is the norm of what they differ by and of what the length of q misses to 1.
    """
    q = ex.vertcat(u[0] + u[6], u[1] - u[7], u[2] - u[4], u[3] + u[5]) / 2
    rest = to_su2(q) - u
    return q, ex.sqrt(ex.dot(rest, rest) + (ex.sqrt(ex.dot(q, q)) - 1) ** 2)


def to_gibbs(q: ex.Expression) -> ex.Expression:
    """(3,) Rodrigues (Cayley, Gibbs) parameters u / w = omega tan(theta/2); infinite at half turns."""
    return vector(q) / q[0]


def from_gibbs(g: ex.Expression) -> ex.Expression:
    """(4,) unit quaternion (1, g) / sqrt(1 + g.g)."""
    return ex.vertcat(1, g) / ex.sqrt(1 + ex.dot(g, g))


def to_modified_rodrigues(q: ex.Expression) -> ex.Expression:
    """(3,) u / (1 + w) = omega tan(theta/4) of a unit quaternion with w >= 0; inside the unit ball."""
    return vector(q) / (1 + q[0])


def from_modified_rodrigues(m: ex.Expression) -> ex.Expression:
    """(4,) unit quaternion (1 - m.m, 2 m) / (1 + m.m)."""
    s = ex.dot(m, m)
    return ex.vertcat(1 - s, 2 * m) / (1 + s)


def _matrix(q: ex.Expression, scale: ex.Expression | float) -> ex.Expression:
    u = vector(q)
    return ex.eye(3) + scale * (q[0] * skew(u) + skew_square(u))
