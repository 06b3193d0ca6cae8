"""A function y = f(x) as angles of crank and rocker: precision points by Chebyshev, and the error between them.

Function generation: four-bars whose rocker takes given angles at given angles of the crank (Freudenstein).

With lengths a (crank), b (coupler), c (rocker), d (ground) and angles theta, phi of crank and rocker from the ground
line, |C - B| = b says K1 cos phi - K2 cos theta + K3 = cos(theta - phi), with K1 = d/a, K2 = d/c and
K3 = (a^2 - b^2 + c^2 + d^2)/(2 a c). Three pairs of angles give K1, K2, K3 by linear equations. Four leave one line
free from which the rocker's angles count: a determinant that is a quadratic form in its cosine and sine. Five leave
both lines free: seen from the crank the rocker is a body in five poses, and crank pin and rocker pin are a dyad of it;
one of at most four is the ground itself, so that three linkages are left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, radians, real_array, require_finite, require_function, single, whole
from mafsil.errors import InputError
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.synthesis.answers import NOTHING, Synthesis, SynthesisStatus, outcome, rank_candidates
from mafsil.mobility.synthesis.assessment import NO_LIMITS, LinkageLimits
from mafsil.mobility.synthesis.candidate import Candidate
from mafsil.mobility.synthesis.crank_chain import ChainCandidate, ChainSynthesis
from mafsil.mobility.synthesis.dyads import Complexes, Dyad, PoseConditions, as_complex, common_pole, cranks_and_blocks
from mafsil.mobility.synthesis.fitting import Positions
from mafsil.mobility.synthesis.motion import dyads_through
from mafsil.mobility.tolerances import SAME_GROUND, SAME_POSE, SINGULAR_PENCIL


def chebyshev_spacing(lower: float, upper: float, count: int) -> Floats:
    """(count,) zeros of Chebyshev's polynomial on an interval: of all polynomials through them, the least error.

    Args:
        lower, upper: ends of the interval.
        count: of the points.

    Reference: F. Freudenstein, Structural error analysis in plane kinematic synthesis, J. Eng. Ind. 81 (1959).
    """
    ends = single("lower, upper", [lower, upper], (2,))
    n = whole("count", count, 1, 100)
    k = np.arange(1, n + 1)
    return ends.mean() - (ends[1] - ends[0]) / 2 * np.cos((2 * k - 1) * np.pi / (2 * n))


@dataclass(frozen=True, eq=False)
class StructuralError:
    """How far a linkage is from a function.

    Attributes:
        x: (samples,) arguments.
        desired, generated: (samples,) values of the function and of the linkage.
        output_error: (samples,) error of the rocker's angle [rad].
        missing: (samples,) length by which the linkage does not close, of six-bars and on the sphere the excess of the
            cosine of its transmission angle; zero where it does, elsewhere `generated` is of a dead point [m].
    """

    x: Floats
    desired: Floats
    generated: Floats
    output_error: Floats
    missing: Floats

    @property
    def error(self) -> Floats:
        """(samples,) generated minus desired values."""
        return self.generated - self.desired

    @property
    def largest(self) -> float:
        """Largest error of the value; infinite if the linkage does not close everywhere."""
        return float(np.abs(self.error).max()) if not self.missing.any() else float("inf")


@dataclass(frozen=True, eq=False)
class FunctionTask:
    """y = f(x) over an interval, drawn on two dials.

    Attributes:
        function: x (k,) to y (k,).
        interval: (lower, upper) of x.
        inputs: angles of the crank at both ends of the interval [rad].
        outputs: angles of the rocker at f(lower) and f(upper) [rad].
    """

    function: Callable[[Floats], Floats]
    interval: tuple[float, float]
    inputs: tuple[float, float]
    outputs: tuple[float, float]

    def __post_init__(self) -> None:
        require_function("function", self.function, "function f(x)", 1)
        for name in ("interval", "inputs", "outputs"):
            pair = single(name, getattr(self, name), (2,))
            pair = pair if name == "interval" else radians(name, pair)
            if pair[0] == pair[1]:
                raise InputError("synthesis.empty_range", name=name, value=float(pair[0]))
            object.__setattr__(self, name, (float(pair[0]), float(pair[1])))
        low, high = self.values(np.array(self.interval)).tolist()
        if low == high:
            raise InputError("synthesis.level_function", value=low)

    def values(self, x: ArrayLike) -> Floats:
        """(k,) values of the function.

        Raises:
            InputError: one is not finite.
        """
        return require_finite(
            "function", single("function", self.function(np.asarray(x, dtype=np.float64)), np.shape(x))
        )

    def crank_angles(self, x: ArrayLike) -> Floats:
        """(k,) where the dial of the crank shows x [rad]."""
        low, high = self.interval
        start, end = self.inputs
        return start + (np.asarray(x, dtype=np.float64) - low) * ((end - start) / (high - low))

    def rocker_angles(self, y: ArrayLike) -> Floats:
        """(k,) where the dial of the rocker shows y [rad]."""
        low, high = self.values(np.array(self.interval))
        start, end = self.outputs
        return start + (np.asarray(y, dtype=np.float64) - low) * ((end - start) / (high - low))

    def synthesise(
        self, count: int = 3, *, x: ArrayLike | None = None, ground: float = 1.0, limits: LinkageLimits = NO_LIMITS
    ) -> Synthesis:
        """Four-bars that are exact at precision points; see `synthesise_function` for which lines the dials leave free.

        Args:
            count: of the precision points, 3 to 5, spaced by Chebyshev.
            x: the precision points themselves, instead.
            ground: distance of the fixed pivots [m].
            limits: least transmission angle, longest link, region of fixed pivots.
        """
        chosen = chebyshev_spacing(*self.interval, whole("count", count, 3, 5)) if x is None else np.asarray(x, float)
        return synthesise_function(
            self.crank_angles(chosen), self.rocker_angles(self.values(chosen)), ground=ground, limits=limits
        )

    def structural_error(
        self, found: Synthesis | ChainSynthesis, index: int = 0, samples: int = 181
    ) -> StructuralError:
        """The error of a candidate over the whole interval.

        Args:
            found: the answer of `synthesise`, or of six-bars or spherical four-bars for its angles.
            index: of the candidate.
            samples: arguments at which it is taken.
        """
        one = found[index]
        x = np.linspace(*self.interval, whole("samples", samples, 2, 1_000_000))
        y = self.values(x)
        theta = self.crank_angles(x) + float(one.theta[0] - found.task[0, 0])
        first, _ = _output(one, one.theta[:1])
        angle, missing = _output(one, theta)
        error = wrap_angle(angle - float(first[0]) - (self.rocker_angles(y) - found.task[0, 1]))
        low, high = self.values(np.array(self.interval))
        scale = (high - low) / (self.outputs[1] - self.outputs[0])
        return StructuralError(x, y, y + scale * error, error, missing)


def _output(one: Candidate | ChainCandidate, theta: Floats) -> tuple[Floats, Floats]:
    """Angles (k,) of the output link in the modes of the first position [rad], and by how much (k,) it stays open."""
    if isinstance(one, ChainCandidate):
        modes: list[int] = one.modes[0].tolist()
        excess = np.abs(one.linkage.cosines(theta, modes)).max(axis=1) - 1.0
        return one.linkage.output_angle(theta, modes), np.maximum(excess, 0.0)
    _, C = one.moving_pivots(theta, int(one.modes[0]))
    arm = C - one.D
    assert isinstance(one.linkage, FourBar)
    return np.arctan2(arm[..., 1], arm[..., 0]), one.linkage.positions(theta).missing


def synthesise_function(
    inputs: ArrayLike, outputs: ArrayLike, *, ground: float = 1.0, limits: LinkageLimits = NO_LIMITS
) -> Synthesis:
    """Four-bars that coordinate angles of crank and rocker, with A at the origin and D at (ground, 0).

    Of three pairs both angles count from the ground line; of four the rocker's count from any line; of five both do.
    All linkages are found: at most one, two and three.

    Args:
        inputs: (N,) angles of the crank, N from 3 to 5 [rad].
        outputs: (N,) angles of the rocker, from D to C [rad].
        ground: distance of the fixed pivots, which sets the scale [m].
        limits: least transmission angle, longest link, region of fixed pivots.

    Returns:
        All candidates, driven by the crank; good ones first.

    Raises:
        InputError: another number of angles, two equal angles of the crank, a ground that is not positive.
    """
    theta, phi = angle_pairs(inputs, outputs)
    g, task = positive("ground", ground), np.column_stack([theta, phi])
    if len(theta) == 5:
        return _five(theta, phi, g, limits)
    shifts = [0.0] if len(theta) == 3 else rocker_lines(theta, phi)
    if any(is_free(theta, phi + shift) for shift in shifts or [0.0]):
        return Synthesis(SynthesisStatus.INFINITE, "function", NOTHING, task, (), None, "", {"ground": g})
    solved = [(K, shift) for shift in shifts for K in freudenstein_ratios(theta, phi + shift)]
    batches = [one for K, shift in solved if (one := _linkage(K, theta, phi + shift, g)) is not None]
    ranking = rank_candidates(batches, g, either_side=False, limits=limits)
    method = "function_by_three" if len(theta) == 3 else "function_by_four"
    return Synthesis(outcome(ranking), "function", ranking, task, (), None, method, {"real": len(solved), "ground": g})


def angle_pairs(inputs: ArrayLike, outputs: ArrayLike) -> tuple[Floats, Floats]:
    """Checked angles (N,), (N,) of crank and rocker, N from 3 to 5 [rad].

    Raises:
        InputError: another number of angles, two equal angles of the crank.
    """
    theta = real_array("inputs", inputs)
    if theta.ndim != 1 or not 3 <= len(theta) <= 5:
        raise InputError("synthesis.angle_count", got=theta.shape, least=3, most=5)
    theta = radians("inputs", single("inputs", inputs, theta.shape))
    phi = radians("outputs", single("outputs", outputs, theta.shape))
    for k in range(len(theta)):
        same = np.flatnonzero(np.abs(wrap_angle(theta[:k] - theta[k])) <= SAME_POSE)
        if len(same):
            raise InputError("synthesis.same_timing", first=int(same[0]) + 1, second=k + 1)
    return theta, phi


def is_free(theta: Floats, phi: Floats, ground: float = 1.0) -> bool:
    """Whether the pairs fit Freudenstein's equation with more than one choice of ratios, as equal angles do.

    Args:
        theta, phi: (N,) angles from the ground line.
        ground: cosine of the arc between the fixed axes; 1 in the plane.
    """
    right = ground * np.cos(theta) * np.cos(phi) + np.sin(theta) * np.sin(phi)
    rows = np.stack([np.cos(phi), -np.cos(theta), np.ones(len(theta)), right], axis=1)
    first, whole = (np.linalg.svd(each, compute_uv=False) > SAME_POSE for each in (rows[:, :3], rows))
    return bool(first.sum() < 3 and whole.sum() == first.sum())


def freudenstein_ratios(theta: Floats, phi: Floats, ground: float = 1.0) -> list[Floats]:
    """(K1, K2, K3) of Freudenstein's equation, or none if the pairs do not determine them; arguments as `is_free`."""
    rows = np.stack([np.cos(phi), -np.cos(theta), np.ones(len(theta))], axis=1)
    s = np.linalg.svd(rows, compute_uv=False)
    if s[-1] < SINGULAR_PENCIL * s[0]:
        return []
    right = ground * np.cos(theta) * np.cos(phi) + np.sin(theta) * np.sin(phi)
    return [np.asarray(np.linalg.lstsq(rows, right, rcond=None)[0], dtype=np.float64)]


def rocker_lines(theta: Floats, phi: Floats, ground: float = 1.0) -> list[float]:
    """Angles modulo pi that, added to those of the rocker, make four equations of Freudenstein depend on each other."""
    middle = np.stack([np.cos(theta), np.ones(4)], axis=1)
    first = np.cos(phi), -np.sin(phi)
    x, y = ground * np.cos(theta), np.sin(theta)
    last = x * np.cos(phi) + y * np.sin(phi), y * np.cos(phi) - x * np.sin(phi)

    def det(i: int, k: int) -> float:
        return float(np.linalg.det(np.column_stack([first[i], middle, last[k]])))

    square, mixed, other = det(0, 0), det(0, 1) + det(1, 0), det(1, 1)  # C^2, C S, S^2
    size = max(abs(square), abs(mixed), abs(other))
    root = mixed**2 - 4 * square * other
    if size < SINGULAR_PENCIL or root < -SINGULAR_PENCIL * size**2:
        return []
    half = -(mixed + np.copysign(np.sqrt(max(root, 0.0)), mixed)) / 2
    lines = [float(np.arctan2(half, other)), float(np.arctan2(square, half))]
    return lines if abs(np.sin(lines[0] - lines[1])) > SAME_POSE else lines[:1]


def _linkage(K: Floats, theta: Floats, phi: Floats, ground: float) -> Positions | None:
    """The linkage of Freudenstein's ratios; None if a length is infinite or the coupler's is not real.

    Args:
        K: (3,) ratios; a negative length is an arm on the other side of its pivot.
        theta, phi: (N,) angles from the ground line.
        ground: distance of the pivots [m].
    """
    if min(abs(K[0]), abs(K[1])) < SINGULAR_PENCIL:
        return None
    a, c = ground / K[0], ground / K[1]
    if a * a + c * c + ground * ground - 2 * a * c * K[2] <= 0.0:
        return None
    return _between(a * np.exp(1j * theta)[None], ground + c * np.exp(1j * phi)[None], ground)


def _between(B: Complexes, C: Complexes, ground: float) -> Positions:
    """Four-bars (k, N) over a ground from the origin along x [m]."""
    count = len(B)
    A, D = np.zeros(count, dtype=np.complex128), np.full(count, ground, dtype=np.complex128)
    return Positions(A, B, C, D, np.zeros((count, 3)))


def _five(theta: Floats, phi: Floats, ground: float, limits: LinkageLimits) -> Synthesis:
    """Five pairs: dyads of the rocker's poses as seen from the crank, without the ground."""
    task = np.column_stack([theta, phi])
    D = ground * np.exp(-1j * theta)
    conditions = PoseConditions.of(np.stack([D.real, D.imag, phi - theta], axis=1))
    details: dict[str, Any] = {"ground": ground}
    if common_pole(conditions) is not None:
        return Synthesis(SynthesisStatus.INFINITE, "function", NOTHING, task, (), None, "", details)
    dyads, _, infinite = dyads_through(conditions, 0)
    if infinite:
        return Synthesis(SynthesisStatus.INFINITE, "function", NOTHING, task, (), None, "", details)
    pins = _without_ground(cranks_and_blocks(dyads)[0], ground)
    on_crank, on_rocker = (
        as_complex(np.array([getattr(one, name) for one in pins]).reshape(-1, 2)) for name in ("pivot", "point")
    )
    B = on_crank[:, None] * np.exp(1j * theta)
    C = ground + on_rocker[:, None] * np.exp(1j * phi)
    ranking = rank_candidates([_between(B, C, ground)], ground, either_side=False, limits=limits)
    details["real"] = len(pins)
    return Synthesis(outcome(ranking), "function", ranking, task, tuple(pins), None, "function_by_five", details)


def _without_ground(dyads: list[Dyad], ground: float) -> list[Dyad]:
    """The dyads without the one from A to D: that whose pins lie nearest to the fixed pivots."""
    gaps = [float(np.abs(np.append(one.pivot, one.point)).max()) for one in dyads]
    nearest = int(np.argmin(gaps)) if gaps else 0
    return [one for k, one in enumerate(dyads) if k != nearest or gaps[k] > SAME_GROUND * ground]
