"""A function y = f(x) as angles of crank and rocker: precision points by Chebyshev, and the error between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, require_finite, require_function, single, whole
from mafsil.errors import InputError
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.spaces.planar_positions import wrapped
from mafsil.mobility.synthesis.answers import Synthesis
from mafsil.mobility.synthesis.candidate import Candidate
from mafsil.mobility.synthesis.function import synthesise_function


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
        missing: (samples,) length by which the linkage does not close; zero where it does, elsewhere `generated` is of
            its nearest dead point [m].
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

    def synthesise(self, count: int = 3, *, x: ArrayLike | None = None, ground: float = 1.0) -> Synthesis:
        """Four-bars that are exact at precision points; see `synthesise_function` for which lines the dials leave free.

        Args:
            count: of the precision points, 3 to 5, spaced by Chebyshev.
            x: the precision points themselves, instead.
            ground: distance of the fixed pivots [m].
        """
        chosen = chebyshev_spacing(*self.interval, whole("count", count, 3, 5)) if x is None else np.asarray(x, float)
        return synthesise_function(self.crank_angles(chosen), self.rocker_angles(self.values(chosen)), ground=ground)

    def structural_error(self, found: Synthesis, index: int = 0, samples: int = 181) -> StructuralError:
        """The error of a candidate over the whole interval.

        Args:
            found: the answer of `synthesise`.
            index: of the candidate.
            samples: arguments at which it is taken.
        """
        one = found[index]
        x = np.linspace(*self.interval, whole("samples", samples, 2, 1_000_000))
        y = self.values(x)
        theta = self.crank_angles(x) + float(one.theta[0] - found.task[0, 0])
        first = _rocker_angle(one, one.theta[:1])
        error = wrapped(_rocker_angle(one, theta) - float(first[0]) - (self.rocker_angles(y) - found.task[0, 1]))
        low, high = self.values(np.array(self.interval))
        scale = (high - low) / (self.outputs[1] - self.outputs[0])
        assert isinstance(one.linkage, FourBar)
        return StructuralError(x, y, y + scale * error, error, one.linkage.positions(theta).missing)


def _rocker_angle(one: Candidate, theta: Floats) -> Floats:
    """(k,) angles of the rocker in the mode of the first position, from D to C [rad]."""
    _, C = one.moving_pivots(theta, int(one.modes[0]))
    arm = C - one.D
    assert isinstance(one.linkage, FourBar)
    return np.arctan2(arm[..., 1], arm[..., 0])
