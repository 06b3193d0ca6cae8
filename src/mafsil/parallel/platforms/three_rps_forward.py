"""All poses of the platform on three legs RPS for given lengths: elimination to one polynomial of degree sixteen.

Leg k swings in the plane through z at g_k, at the elevation th_k above the direction inwards:
B_k = (r - s_k cos th_k) u_k + s_k sin th_k z. Three distances of the platform, |B_i - B_j| = side, are
a + b cos th_i + ... = 0, in t_k = tan(th_k / 2) biquadratic each.

1. F(t1, t3) and G(t2, t3) lose t3: a determinant (4, 4), of degree four in t1 and in t2.
2. That and E(t1, t2) lose t2: a determinant (6, 6), of degree sixteen in t1.
3. Back: t2 as the common zero of both, t3 likewise, and Newton's method on the three distances.
4. Where sixteen are not found, a leg may lie flat outwards, t = infinity: once more with angles from another direction.
5. Without a real one: how near the distances come to the sides, by least squares from many starts.

Reference: Tsai, Robot Analysis, 1999, sec. 3.6; Nanua, Waldron, Murthy, IEEE Trans. Rob. Autom. 6, 1990.

Sylvester's dialytic elimination: one unknown removed from two polynomials, numerically, for whole batches.

f = sum f_i x^i and g = sum g_j x^j have a common zero x where the determinant of the matrix of m + n shifted rows is
zero. If the coefficients are polynomials in another unknown t, its values at points of the circle |t| = r and a
discrete Fourier transform give the coefficients of the eliminant in t.

Reference: Raghavan and Roth, Solving polynomial systems for the kinematic analysis and synthesis of mechanisms and
robot manipulators, J. Mech. Design 117, 1995.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, not_negative, positive, real_array, single, whole
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.solvers import levenberg_marquardt

Complexes = NDArray[np.complex128]
DEGREE = 16
PAIRS = ((0, 1), (0, 2), (1, 2))
COMMON = 1e-4
"""Zeros of two polynomials that agree so far are tried as common: Newton's method decides."""
FITS = 1e-10
ELSEWHERE = 0.7
"""Direction of no meaning from which elevations are counted a second time [rad]."""
STARTS, SETTLING = 16, 12
"""Searches, and steps of Newton's method from the best of them: where it ends the derivatives have lost their rank, so
that searches are slow."""
DIFFERENCE = 1e-5


class ThreeRPSStatus(Status):
    """Whether there are real poses."""

    ALL = ("parallel.rps_all", True)
    SOME = ("parallel.rps_some", True)
    NONE = ("parallel.rps_none", False)
    NOT_FOUND = ("parallel.rps_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ThreeRPSModes(Answer, data="T theta error misfit nearest"):
    """All solutions of a platform on three legs RPS; true if there is a real one, iterable over the real poses.

    Attributes:
        coefficients: (17,) of the polynomial in t1 = tan(th_1 / 2), ascending, of largest absolute value one.
        t: (k, 3) complex solutions t1, t2, t3, those with real ones first.
        real: number of real ones.
        theta: (real, 3) elevations of the legs [rad].
        T: (real, 4, 4) poses of the platform.
        error: largest error of a distance [m].
        misfit: (3,) how much longer the sides 12, 13 and 23 of the platform would have to be for the nearest pose that
            was found [m]; zero where there is a real one.
        nearest: (3,) elevations of the legs at the first real pose, else at that nearest one [rad].
    """

    coefficients: Complexes
    t: Complexes
    real: int
    theta: Floats
    T: Floats
    error: float
    misfit: Floats
    nearest: Floats

    @property
    def status(self) -> ThreeRPSStatus:
        """Some real or none, and whether all were found: double ones count once, so that fewer prove nothing."""
        if len(self.t) == DEGREE:
            return ThreeRPSStatus.ALL if self.real else ThreeRPSStatus.NONE
        return ThreeRPSStatus.SOME if self.real else ThreeRPSStatus.NOT_FOUND

    def __len__(self) -> int:
        return self.real

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.T)

    def explain(self, language: str | None = None) -> str:
        """How many solutions there are, real and complex, and how exactly the distances fit."""
        return self.status.sentence(
            language, real=self.real, count=len(self.t), error=self.error, most=DEGREE,
            misfit=float(np.abs(self.misfit).max()),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"complex": len(self.t)}


@dataclass(frozen=True)
class ThreeRPS:
    """A platform on three legs RPS with tangent hinges at thirds of a turn.

    Attributes:
        base, platform: radii of the circles of the hinges and of the spherical joints [m].
    """

    base: float
    platform: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "base", positive("base", self.base))
        object.__setattr__(self, "platform", positive("platform", self.platform))

    def forward_kinematics(self, lengths: ArrayLike) -> ThreeRPSModes:
        """All assembly modes for lengths (3,) [m], complex ones included, sixteen at most.

        Raises:
            InputError: wrong lengths, a negative one.
        """
        s = single("lengths", lengths, (3,))
        if (s < 0).any():
            raise InputError("parallel.negative", name="lengths", value=float(s.min()))
        c, t, error = self._solutions(s)
        # 4.
        if len(t) != DEGREE:
            _, turned, other = self._solutions(s, ELSEWHERE)
            if len(turned) <= DEGREE and (len(turned) > len(t) or len(t) > DEGREE):
                t, error = _from(turned, ELSEWHERE), other
        real = np.where(np.isinf(t), 0.0, np.abs(t.imag)).max(axis=1, initial=0.0) < 1e-7
        t = np.concatenate([t[real], t[~real]])
        theta = 2 * np.arctan(t[: int(real.sum())].real)
        # 5.
        misfit, nearest = np.zeros(3), theta[0] if len(theta) else np.zeros(3)
        if not len(theta):
            nearest, misfit = self._nearest(s)
            if np.abs(misfit).max() <= FITS * self.size:
                theta, t = nearest[None], np.concatenate([np.tan(nearest / 2)[None].astype(np.complex128), t])
        T = np.array([self._pose(s, each) for each in theta]).reshape(-1, 4, 4)
        return ThreeRPSModes(c, t, len(theta), theta, T, error * self.size, misfit, nearest)

    @property
    def size(self) -> float:
        """The larger radius [m]."""
        return max(self.base, self.platform)

    def _solutions(self, s: Floats, from_direction: float = 0.0) -> tuple[Complexes, Complexes, float]:
        """The polynomial (17,), solutions (k, 3) that differ, and their largest error, elevations from a direction."""
        sides = [self._distance(s, i, j, from_direction) / self.size**2 for i, j in PAIRS]
        E, F, G = sides
        # 1. and 2.
        c = eliminant(lambda t1: _second(E, F, G, t1), DEGREE)
        c = c / np.abs(c).max()
        # 3.
        t, error = _polish(sides, _lift(E, F, G, zeros(trim_leading(c, 1e-13))))
        return c, _distinct(t[error < FITS]), float(error[error < FITS].max(initial=0.0))

    def _nearest(self, s: Floats) -> tuple[Floats, Floats]:
        """(3,) elevations at which the distances of the joints come nearest to the sides, and what they miss (3,)."""
        side, rng = np.sqrt(3) * self.platform, np.random.default_rng(0)

        def missed(theta: Floats) -> tuple[Floats, Floats]:
            B, swing, J = self.joints(s, theta), self._swing(s, theta), np.zeros((3, 3))
            apart = [B[i] - B[j] for i, j in PAIRS]
            far = np.array([max(float(np.linalg.norm(d)), 1e-12 * self.size) for d in apart])
            for row, ((i, j), d) in enumerate(zip(PAIRS, apart, strict=True)):
                J[row, i], J[row, j] = d @ swing[i] / far[row], -d @ swing[j] / far[row]
            return far - side, J

        found = [
            levenberg_marquardt(missed, start, iterations=40).value for start in rng.uniform(-np.pi, np.pi, (STARTS, 3))
        ]
        best = min(found, key=lambda theta: float(np.linalg.norm(missed(theta)[0])))
        best = _settle(missed, best)
        return best, missed(best)[0]

    def _swing(self, s: Floats, theta: Floats) -> Floats:
        """(3, 3) rates of the joints by the elevations [m/rad]."""
        g, out = 2 * np.pi * np.arange(3) / 3, s * np.sin(theta)
        return np.stack([out * np.cos(g), out * np.sin(g), s * np.cos(theta)], axis=-1)

    def joints(self, lengths: ArrayLike, theta: ArrayLike) -> Floats:
        """(3, 3) places of the spherical joints for lengths and elevations (3,)."""
        s, th = single("lengths", lengths, (3,)), single("theta", theta, (3,))
        g = 2 * np.pi * np.arange(3) / 3
        out = self.base - s * np.cos(th)
        return np.stack([out * np.cos(g), out * np.sin(g), s * np.sin(th)], axis=-1)

    def _distance(self, s: Floats, i: int, j: int, begin: float) -> Floats:
        """(3, 3) biquadratic coefficients of |B_i - B_j|^2 - side^2 in t_i and t_j, times both 1 + t^2.

        Args:
            s: (3,) lengths [m].
            i, j: of the legs.
            begin: direction from which the elevations count: th = begin + 2 atan t.
        """
        cos = np.cos(2 * np.pi * (j - i) / 3)
        r, a, b = self.base, float(s[i]), float(s[j])
        # Bilinear in (1, cos, sin) of both: |B|^2 = r^2 - 2 r s cos + s^2, and B_i . B_j.
        M = np.zeros((3, 3))
        M[0, 0] = 2 * r * r + a * a + b * b - 2 * r * r * cos - 3 * self.platform**2
        M[1, 0], M[0, 1] = 2 * r * a * (cos - 1), 2 * r * b * (cos - 1)
        M[1, 1], M[2, 2] = -2 * a * b * cos, -2 * a * b
        turn = np.eye(3)
        turn[1:, 1:] = [[np.cos(begin), -np.sin(begin)], [np.sin(begin), np.cos(begin)]]
        by_half = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 2.0], [1.0, -1.0, 0.0]]) @ turn.T
        return by_half @ M @ by_half.T

    def _pose(self, s: Floats, theta: Floats) -> Floats:
        B = self.joints(s, theta)
        middle = B.mean(axis=0)
        x = (B[0] - middle) / np.linalg.norm(B[0] - middle)
        z = np.cross(B[1] - B[0], B[2] - B[0])
        z = z / np.linalg.norm(z)
        return pose.from_rotation_translation(np.stack([x, np.cross(z, x), z], axis=1), middle)


def _settle(missed: Callable[[Floats], tuple[Floats, Floats]], theta: Floats) -> Floats:
    """The minimum (3,) of |r|^2 near theta, by Newton's method on J' r with differences of it."""
    for _ in range(SETTLING):
        r, J = missed(theta)
        ahead, back = ([_gradient(missed, theta + sign * DIFFERENCE * e) for e in np.eye(3)] for sign in (1, -1))
        H = (np.array(ahead) - np.array(back)) / (2 * DIFFERENCE)
        step = np.linalg.pinv((H + H.T) / 2, rcond=1e-9) @ (J.T @ r)
        if not np.linalg.norm(missed(theta - step)[0]) <= np.linalg.norm(r):
            break
        theta = theta - step
    return theta


def _gradient(missed: Callable[[Floats], tuple[Floats, Floats]], theta: Floats) -> Floats:
    r, J = missed(theta)
    return J.T @ r


def _from(t: Complexes, begin: float) -> Complexes:
    """Half tangents of elevations whose half tangents from another direction are given; infinite at a half turn."""
    tangent = np.tan(begin / 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = (t + tangent) / (1 - tangent * t)
    return np.where(np.abs(1 - tangent * t) < 1e-7 * (1 + np.abs(t)), np.inf, found)


def _powers(t: Complexes) -> Complexes:
    return np.stack([np.ones_like(t), t, t * t], axis=-1)


def _first(F: Floats, G: Floats, t1: Complexes) -> Complexes:
    """(k, 5) coefficients in t2 of the determinant that removes t3, at values of t1 (k,)."""
    points = np.exp(2j * np.pi * np.arange(8) / 8)
    f, g = _powers(t1) @ F, _powers(points) @ G
    values = resultant(f[:, None, :], g[None, :, :])
    return np.asarray(np.fft.fft(values, axis=1)[:, :5] / 8, dtype=np.complex128)


def _second(E: Floats, F: Floats, G: Floats, t1: Complexes) -> NDArray[np.inexact]:
    return resultant(_powers(t1) @ E, _first(F, G, t1))


def _lift(E: Floats, F: Floats, G: Floats, t1: Complexes) -> Complexes:
    """(k, 3) candidates for all zeros t1."""
    found: list[list[complex]] = []
    for value in t1:
        powers = _powers(np.array([value]))
        four = _first(F, G, np.array([value]))[0]
        for second in zeros(np.asarray((powers @ E)[0], dtype=np.complex128)):
            value_there: complex = complex(four @ second ** np.arange(5))
            if abs(value_there) > 1e-2 * float(np.abs(four).sum()) * max(1.0, abs(second)) ** 4:
                continue
            row = np.asarray((powers @ F)[0], dtype=np.complex128)
            found += [[value, second, third] for third in zeros(row)]
    return np.array(found, dtype=np.complex128).reshape(-1, 3)


def _polish(sides: list[Floats], t: Complexes) -> tuple[Complexes, Floats]:
    """Newton's method on the three distances; (k, 3) and the errors (k,)."""
    t = t.copy()
    error = np.full(len(t), np.inf)
    for _ in range(30):
        miss = np.zeros((len(t), 3), dtype=np.complex128)
        J = np.zeros((len(t), 3, 3), dtype=np.complex128)
        weight = np.ones((len(t), 3))
        for row, ((i, j), M) in enumerate(zip(PAIRS, sides, strict=True)):
            a, b = _powers(t[:, i]), _powers(t[:, j])
            da, db = (np.stack([np.zeros(len(t)), np.ones(len(t)), 2 * t[:, k]], axis=-1) for k in (i, j))
            miss[:, row] = np.einsum("ki,ij,kj->k", a, M, b)
            J[:, row, i], J[:, row, j] = np.einsum("ki,ij,kj->k", da, M, b), np.einsum("ki,ij,kj->k", a, M, db)
            weight[:, row] = (np.abs(a).sum(axis=1)) * (np.abs(b).sum(axis=1))
        error = np.abs(miss / weight).max(axis=1, initial=0.0)
        step = np.einsum("kij,kj->ki", np.linalg.pinv(J), miss)
        t = t - np.where((error > 1e-15)[:, None], step, 0.0)
    return t, error


def _distinct(t: Complexes) -> Complexes:
    kept: list[Complexes] = []
    for each in t:
        if all(np.abs(each - other).max() > 1e-6 * max(1.0, float(np.abs(each).max())) for other in kept):
            kept.append(each)
    return np.array(kept, dtype=np.complex128).reshape(-1, 3)


def half_angle_polynomial(constant: ArrayLike, cosine: ArrayLike, sine: ArrayLike) -> Floats:
    """(*batch, 3) of a + b cos x + c sin x in t = tan(x / 2), times 1 + t^2: a + b, 2 c, a - b, ascending."""
    a, b, c = np.broadcast_arrays(
        real_array("constant", constant), real_array("cosine", cosine), real_array("sine", sine)
    )
    return np.stack([a + b, 2 * c, a - b], axis=-1)


def sylvester_matrix(f: ArrayLike, g: ArrayLike) -> NDArray[np.inexact]:
    """(*batch, m + n, m + n) of polynomials of degrees m and n by ascending coefficients (*batch, m + 1), (.., n + 1).

    Args:
        f, g: real or complex coefficients.

    Raises:
        InputError: a polynomial is constant.
    """
    f, g = (np.atleast_1d(np.asarray(each)) * 1.0 for each in (f, g))
    m, n = f.shape[-1] - 1, g.shape[-1] - 1
    if m < 1 or n < 1:
        raise InputError("parallel.constant_polynomial", degrees=[m, n])
    shape = np.broadcast_shapes(f.shape[:-1], g.shape[:-1])
    M = np.zeros((*shape, m + n, m + n), dtype=np.result_type(f, g))
    for k in range(n):
        M[..., k, k : k + m + 1] = f
    for k in range(m):
        M[..., n + k, k : k + n + 1] = g
    return M


def resultant(f: ArrayLike, g: ArrayLike) -> NDArray[np.inexact]:
    """(*batch,) determinant of Sylvester's matrix: zero where both polynomials have a common zero."""
    return np.asarray(np.linalg.det(sylvester_matrix(f, g)))


def eliminant(values: Callable[[Complexes], NDArray[np.inexact]], degree: int, radius: float = 1.0) -> Complexes:
    """(degree + 1,) ascending coefficients of a polynomial known by its values.

    Args:
        values: of complex numbers (k,), to (k,): for example resultants whose coefficients are polynomials.
        degree: at least that of the polynomial.
        radius: of the circle on which it is taken; about the size of the zeros that matter.
    """
    most, r = whole("degree", degree, 1, 10_000), positive("radius", radius)
    count = 2 * (most + 1)
    points = np.asarray(r * np.exp(2j * np.pi * np.arange(count) / count), dtype=np.complex128)
    powers: Complexes = np.asarray(r ** np.arange(most + 1), dtype=np.complex128)
    c = np.fft.fft(np.asarray(values(points), dtype=np.complex128)) / count
    return np.asarray(c[: most + 1] / powers, dtype=np.complex128)


def trim_leading(coefficients: Complexes, share: float = 1e-9) -> Complexes:
    """The coefficients without leading ones that are below a share of the largest."""
    share = not_negative("share", share)
    coefficients = np.atleast_1d(coefficients)
    size = np.abs(coefficients)
    kept = np.flatnonzero(size > share * size.max(initial=0.0))
    return coefficients[: int(kept[-1]) + 1] if len(kept) else coefficients[:1]


def zeros(coefficients: Complexes) -> Complexes:
    """All zeros of a polynomial by ascending coefficients, as eigenvalues of its companion matrix."""
    c = trim_leading(np.asarray(coefficients, dtype=np.complex128), 0.0)
    companion = np.zeros((len(c) - 1, len(c) - 1), dtype=np.complex128)
    companion[1:, :-1] = np.eye(len(c) - 2)
    companion[:, -1] = -c[:-1] / c[-1]
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)
