"""Contacts are never quite where they should be: how much closure survives, proven and by sampling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, not_negative, whole
from mafsil.errors import InputError
from mafsil.grasp.contact import Contact
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.wrench_batch import wrench_closures

EDGES = 8


class RobustnessStatus(Status):
    """Whether a grasp closes, and with a margin."""

    PROVEN = ("grasp.robust_proven", True)
    """It closes, and as long as its wrenches change by less than the margin."""
    NO_MARGIN = ("grasp.robust_no_margin", False)
    """As planned it does not close, or only just: every error however small may open it."""


@dataclass(frozen=True, eq=False, repr=False)
class Robustness(Answer, data="proven probability low high samples"):
    """How a grasp fares when its contacts are off: true if it closes with a margin.

    Attributes:
        proven: closure is certain as long as no wrench of unit push changes by more than this (moments divided by
            the length scale): it is the epsilon quality.
        probability: share of the samples that close.
        low, high: 95 % interval of the probability that the number of samples allows (Wilson).
        samples: how many.
    """

    proven: float
    probability: float
    low: float
    high: float
    samples: int

    @property
    def status(self) -> RobustnessStatus:
        """Whether there is a margin."""
        return RobustnessStatus.PROVEN if self.proven > 0 else RobustnessStatus.NO_MARGIN

    def explain(self, language: str | None = None) -> str:
        """The margin, and the share of the samples that close with its interval."""
        shares = {"share": 100 * self.probability, "low": 100 * self.low, "high": 100 * self.high}
        return self.status.sentence(language, margin=self.proven, samples=self.samples, **shares)


def robustness(
    grasp: Grasp, *, position: float = 0.0, angle: float = 0.0, friction: float = 0.0, length: float = 1.0,
    samples: int = 1000, seed: int = 0,
) -> Robustness:  # fmt: skip
    """Closure under normally distributed errors of every contact, independent of each other.

    Args:
        grasp: the contacts as planned.
        position: standard deviation of each coordinate of a contact point [m].
        angle: standard deviation of the normal's tilt about each tangent [rad].
        friction: standard deviation of mu relative to mu; never below 0.
        length: moments are divided by it [m].
        samples: grasps drawn.
        seed: of the draws.

    Raises:
        InputError: negative deviations or no samples.
    """
    for name, value in (("position", position), ("angle", angle), ("friction", friction)):
        if not (np.isfinite(value) and value >= 0):
            raise InputError("grasp.negative_coefficient", name=name, value=value)
        not_negative(name, value)
    whole("samples", samples, 1, 10_000_000)
    rng = np.random.default_rng(seed)
    drawn = np.array(
        [
            Grasp([_shaken(c, position, angle, friction, rng) for c in grasp.contacts]).matrix(EDGES)
            for _ in range(samples)
        ]
    )
    share = float(wrench_closures(drawn).force_closure.mean())
    low, high = _wilson(share, samples)
    return Robustness(grasp.quality(length).epsilon, share, low, high, samples)


def _shaken(contact: Contact, position: float, angle: float, friction: float, rng: np.random.Generator) -> Contact:
    point = contact.point + position * rng.normal(size=contact.dimension)
    normal = contact.normal + np.tan(angle * rng.normal(size=contact.dimension - 1)) @ contact.tangents
    factor = max(0.0, 1.0 + friction * rng.normal()) if contact.mu > 0 else 1.0
    # A cone that vanishes keeps its columns, so all samples have one shape.
    mu = max(contact.mu * factor, 1e-12) if contact.mu > 0 else 0.0
    return Contact(point, normal, mu, contact.gamma)


def _wilson(share: float, samples: int) -> tuple[float, float]:
    z = 1.959963984540054
    middle = share + z * z / (2 * samples)
    half = z * np.sqrt(share * (1 - share) / samples + z * z / (4 * samples**2))
    size = 1 + z * z / samples
    return max(0.0, float((middle - half) / size)), min(1.0, float((middle + half) / size))


def tolerance(grasp: Grasp, length: float = 1.0) -> Floats:
    """How far each contact alone may slide, all at once, before the proof of closure is lost [m].

    Sliding by s changes the wrench of unit push by at most s sqrt(1 + mu^2) / length (normal unchanged).

    Args:
        grasp: a grasp that closes.
        length: moments are divided by it [m].

    Returns:
        (contacts,) [m]; zero if the grasp does not close.
    """
    epsilon = grasp.quality(length).epsilon
    return np.array([epsilon * length / np.sqrt(1.0 + c.mu**2) for c in grasp.contacts])
