"""The rotation group SO(3): hat, exp, log, Jacobians, membership and projection, as expressions.

Symmetric eigenproblems of fixed small size as straight-line expressions: cyclic Jacobi rotations, no branches.
"""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import quaternion, series
from mafsil.algebra.spatial import cross, length, skew, skew_square

SWEEPS = 6
"""Cyclic sweeps; convergence is quadratic, sizes 3 and 4 are converged to rounding after four to five."""


def hat(w: ex.Expression) -> ex.Expression:
    """(3, 3) skew matrix [w] with [w] x = w x x."""
    return skew(w)


def vee(W: ex.Expression) -> ex.Expression:
    """(3,) w with [w] = (W - W') / 2."""
    return ex.vertcat(W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]) / 2


def compose(R_ab: ex.Expression, R_bc: ex.Expression) -> ex.Expression:
    """(3, 3) R_ac = R_ab R_bc."""
    return R_ab @ R_bc


def inverse(R: ex.Expression) -> ex.Expression:
    """(3, 3) R' = R^-1."""
    return R.T


def act(R: ex.Expression, x: ex.Expression) -> ex.Expression:
    """(3,) R x: a free vector x_b seen from {a}, or a vector turned by R."""
    return R @ x


def exp(r: ex.Expression) -> ex.Expression:
    """(3, 3) R = I + sin(theta)/theta [r] + (1 - cos(theta))/theta^2 [r]^2, |r| = theta [rad].

    Reference: Lynch & Park, Modern Robotics, prop. 3.11 (Rodrigues' formula), by half angles.
    """
    return quaternion.to_matrix_rounded(quaternion.exp(r))


def log(R: ex.Expression) -> ex.Expression:
    """(3,) r with exp(r) = R, |r| = theta in [0, pi] [rad]; at half turns one of the two answers +-r.

    r = 2 atan2(|u|, w) u / |u|, (w, u) the quaternion of R: accurate from 0 to pi, both ends included.
    """
    return quaternion.log(quaternion.proportional_to_matrix(R))


def angle(R: ex.Expression) -> ex.Expression:
    """Angle theta of a rotation [rad], in [0, pi]."""
    return quaternion.angle(quaternion.proportional_to_matrix(R))


def axis_angle(axis: ex.Expression, theta: ex.Expression) -> ex.Expression:
    """(3, 3) Rot(axis, theta [rad]) about an axis of any length but zero."""
    u = axis / ex.sqrt(ex.dot(axis, axis))
    return quaternion.to_matrix_rounded(ex.vertcat(ex.cos(theta / 2), ex.sin(theta / 2) * u))


def left_jacobian(r: ex.Expression) -> ex.Expression:
    """(3, 3) J with omega_s = J(r) rdot for R = exp(r), and exp(r + dr) ~ exp(J dr) exp(r).

    J = I + (1 - cos)/theta^2 [r] + (theta - sin)/theta^3 [r]^2

    Reference: Barfoot, State Estimation for Robotics, eq. 7.77.
    """
    s = ex.dot(r, r)
    return _polynomial(r, 1.0, series.versinc(s), series.sinc_defect(s))


def left_jacobian_inverse(r: ex.Expression) -> ex.Expression:
    """(3, 3) J^-1 = I - [r]/2 + (1 - (theta/2) cot(theta/2))/theta^2 [r]^2, for theta < 2 pi."""
    return _polynomial(r, 1.0, ex.Expression(-0.5), series.cotangent_defect(ex.dot(r, r)))


def apply_left_jacobian(r: ex.Expression, v: ex.Expression) -> ex.Expression:
    """(3,) J(r) v, without forming the matrix."""
    s = ex.dot(r, r)
    a = cross(r, v)
    return v + series.versinc(s) * a + series.sinc_defect(s) * cross(r, a)


def apply_left_jacobian_inverse(r: ex.Expression, p: ex.Expression) -> ex.Expression:
    """(3,) J(r)^-1 p, without forming the matrix."""
    a = cross(r, p)
    return p - a / 2 + series.cotangent_defect(ex.dot(r, r)) * cross(r, a)


def right_jacobian(r: ex.Expression) -> ex.Expression:
    """(3, 3) J(-r), with omega_b = J_r(r) rdot for R = exp(r)."""
    return left_jacobian(-r)


def right_jacobian_inverse(r: ex.Expression) -> ex.Expression:
    """(3, 3) inverse of the right Jacobian, for theta < 2 pi."""
    return left_jacobian_inverse(-r)


def residuals(M: ex.Expression) -> ex.Expression:
    """(7,): the six entries of M'M - I on and above the diagonal (11, 22, 33, 12, 13, 23), then det M - 1."""
    a, b, c = M[:, 0], M[:, 1], M[:, 2]
    norms = ex.vertcat(ex.dot(a, a), ex.dot(b, b), ex.dot(c, c)) - 1
    return ex.vertcat(norms, ex.dot(a, b), ex.dot(a, c), ex.dot(b, c), ex.dot(a, cross(b, c)) - 1)


def project(M: ex.Expression) -> ex.Expression:
    """(3, 3) the rotation nearest to M in the Frobenius norm: the R that maximises tr(R'M).

    R is that of the unit quaternion that maximises q'K q, K = Horn's symmetric matrix of M.

    Reference: Horn, Closed-form solution of absolute orientation using unit quaternions, J. Opt. Soc. Am. A 4, 1987.
    """
    return quaternion.to_matrix(dominant_vector(horn_matrix(M)))


def horn_matrix(M: ex.Expression) -> ex.Expression:
    """(4, 4) symmetric K with q'K q = tr(R(q)'M) for unit quaternions q."""
    trace = M[0, 0] + M[1, 1] + M[2, 2]
    u = ex.vertcat(M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1])
    return ex.blockcat([[trace, u.T], [u, M + M.T - trace * ex.eye(3)]])


def _polynomial(r: ex.Expression, a: float, b: ex.Expression, c: ex.Expression) -> ex.Expression:
    """(3, 3) a I + b [r] + c [r]^2."""
    return a * ex.eye(3) + b * skew(r) + c * skew_square(r)


def angle_between(R_0: ex.Expression, R_1: ex.Expression) -> ex.Expression:
    """Angle of R_0' R_1 [rad], in [0, pi]."""
    return angle(R_0.T @ R_1)


def to_axis_angle(R: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """Unit axis (3,) and angle in [0, pi] [rad]; the axis of the identity is x by convention."""
    r = log(R)
    theta = length(r)
    rotates = theta > 0
    axis = ex.if_else(rotates, r / ex.if_else(rotates, theta, 1.0), ex.Expression([1, 0, 0]))
    return axis, theta


def slerp(R_0: ex.Expression, R_1: ex.Expression, t: ex.Expression) -> ex.Expression:
    """(3, 3) R_0 exp(t log(R_0' R_1))."""
    return R_0 @ exp(t * log(R_0.T @ R_1))


def symmetric(K: ex.Expression, sweeps: int = SWEEPS) -> tuple[ex.Expression, ex.Expression]:
    """Eigenvalues (n,) in no order and eigenvectors, the columns of (n, n), of a symmetric (n, n) matrix.

    Reference: Golub & Van Loan, Matrix Computations, sec. 8.5 (Jacobi methods).
    """
    n = K.shape[0]
    A = [[K[i, j] for j in range(n)] for i in range(n)]
    V = [[ex.Expression(float(i == j)) for j in range(n)] for i in range(n)]
    for _ in range(sweeps):
        for p in range(n - 1):
            for q in range(p + 1, n):
                _annihilate(A, V, p, q)
    return ex.vertcat(*(A[i][i] for i in range(n))), ex.blockcat(V)


def dominant_vector(K: ex.Expression) -> ex.Expression:
    """(n,) unit eigenvector of the largest eigenvalue of a symmetric matrix."""
    values, vectors = symmetric(K)
    best, largest = vectors[:, 0], values[0]
    for k in range(1, K.shape[0]):
        better = values[k] > largest
        best, largest = ex.if_else(better, vectors[:, k], best), ex.if_else(better, values[k], largest)
    return best


def _annihilate(A: list[list[ex.Expression]], V: list[list[ex.Expression]], p: int, q: int) -> None:
    """One Jacobi rotation in the plane (p, q), in place; the identity where the entry is zero already."""
    apq = A[p][q]
    zero = ex.fabs(apq) <= 2.0**-56 * ex.sqrt(A[p][p] ** 2 + A[q][q] ** 2)
    tau = (A[q][q] - A[p][p]) / (2 * ex.if_else(zero, 1.0, apq))
    t = ex.if_else(tau < 0, -1.0, 1.0) / (ex.fabs(tau) + ex.sqrt(1 + tau**2))
    t = ex.if_else(zero, 0.0, t)
    c = 1 / ex.sqrt(1 + t**2)
    s = t * c
    A[p][p], A[q][q] = A[p][p] - t * apq, A[q][q] + t * apq
    A[p][q] = A[q][p] = ex.Expression(0)
    for k in range(len(A)):
        if k not in (p, q):
            a, b = A[k][p], A[k][q]
            A[k][p] = A[p][k] = c * a - s * b
            A[k][q] = A[q][k] = s * a + c * b
        a, b = V[k][p], V[k][q]
        V[k][p], V[k][q] = c * a - s * b, s * a + c * b
