"""Coulomb's law at one contact: friction angle, slip or stick, sliding force, and the laws that refine it.

Friction coefficients of pairs of materials: a small table with its source, and room for one's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, exp, log, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, as_batch, not_negative, positive, real_array
from mafsil.errors import InputError
from mafsil.fields import check_fields, or_none
from mafsil.grasp.contact import Contact
from mafsil.grasp.tolerances import ROUNDOFF
from mafsil.messages import say

TYPICAL = (0.1, 1.0)
"""Friction coefficients of common pairs of hard dry materials."""


class ContactState(Status):
    """What a contact force does; it succeeds where a resting contact can carry the force."""

    STICK = ("grasp.stick", True)
    IMPENDING = ("grasp.impending", True)
    SLIP = ("grasp.slip", False)
    NO_LOAD = ("grasp.no_load", True)
    TENSION = ("grasp.tension", False)

    @property
    def admissible(self) -> bool:
        """Whether a resting contact can carry the force."""
        return self.succeeded


def friction_angle(mu: ArrayLike) -> Any:
    """Half opening of the friction cone, alpha = atan(mu) [rad].

    Args:
        mu: (*batch,) friction coefficient, at least 0.
    """
    return np.arctan(_coefficient("mu", mu))


def coefficient(alpha: float) -> float:
    """mu = tan(alpha).

    Args:
        alpha: friction angle [rad], from 0 to below pi/2.

    Raises:
        InputError: outside that range.
    """
    if not 0.0 <= alpha < np.pi / 2:
        raise InputError("input.range", name="alpha", value=alpha, low=0, high="pi/2")
    return tan(alpha)


def is_typical(mu: float) -> bool:
    """Whether mu is one of hard dry materials (or 0); others are allowed, and worth a second look."""
    return mu == 0.0 or TYPICAL[0] <= mu <= TYPICAL[1]


def friction_remarks(contacts: Sequence[Contact], language: str | None = None) -> list[str]:
    """One sentence for every coefficient out of the common range; empty if all are common.

    Args:
        contacts: of a grasp.
        language: of the sentences.
    """
    found: dict[float, list[str]] = {}
    for index, contact in enumerate(contacts):
        if not is_typical(contact.mu):
            found.setdefault(contact.mu, []).append(contact.name or str(index))
    return [
        say("grasp.unusual_friction", language=language, mu=mu, names=", ".join(names), low=TYPICAL[0], high=TYPICAL[1])
        for mu, names in found.items()
    ]


def split(force: ArrayLike, normal: ArrayLike) -> tuple[Floats, Floats]:
    """A force as its part along the normal and its part in the tangent plane.

    f_n = (f . n) n,  f_t = f - f_n

    Args:
        force: (*batch, d) force [N], d = 2 or 3.
        normal: (*batch, d) normal, any length but zero.

    Returns:
        (*batch, d) normal part and (*batch, d) tangential part.
    """
    f, n = np.asarray(force, float), np.asarray(normal, float)
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    along = np.sum(f * n, axis=-1, keepdims=True) * n
    return along, f - along


def margin(force: ArrayLike, mu: ArrayLike, normal: ArrayLike = (0.0, 0.0, 1.0)) -> Any:
    """How far a force is inside its friction cone: mu f_n - |f_t| [N], negative outside.

    Args:
        force: (*batch, d) force on the body [N].
        mu: (*batch,) friction coefficient.
        normal: (d,) normal into the body.
    """
    f, n = np.asarray(force, float), np.asarray(normal, float)
    pushed = f @ (n / np.linalg.norm(n))
    _, tangential = split(f, n)
    return _coefficient("mu", mu) * pushed - np.linalg.norm(tangential, axis=-1)


def contact_state(force: ArrayLike, mu: float, normal: ArrayLike = (0.0, 0.0, 1.0)) -> ContactState:
    """Whether a contact sticks, slips or would have to pull: |f_t| <= mu f_n with f_n >= 0.

    Args:
        force: (d,) force on the body [N].
        mu: friction coefficient.
        normal: (d,) normal into the body.
    """
    f = as_batch("force", force, np.shape(normal), finite=True)
    size = float(np.linalg.norm(f))
    if size == 0.0:
        return ContactState.NO_LOAD
    n = np.asarray(normal, float)
    if float(f @ n) < 0.0:
        return ContactState.TENSION
    left = float(margin(f, mu, n))
    if abs(left) <= ROUNDOFF * size:
        return ContactState.IMPENDING
    return ContactState.STICK if left > 0 else ContactState.SLIP


def angle_to_normal(force: ArrayLike, normal: ArrayLike) -> Any:
    """Angle beta between a force and the normal [rad]; no slip iff beta <= alpha.

    Args:
        force: (*batch, d) force [N].
        normal: (d,) normal into the body.
    """
    f, n = np.asarray(force, float), np.asarray(normal, float)
    _, tangential = split(f, n)
    return np.arctan2(np.linalg.norm(tangential, axis=-1), f @ (n / np.linalg.norm(n)))


def soft_finger_admits(force: ArrayLike, torsion: ArrayLike, mu: float, gamma: float, *, elliptic: bool = False) -> Any:
    """May a soft finger carry this force and this moment about the normal?

    |f_t| <= mu f_n and |tau| <= gamma f_n, or elliptic (f_t/mu)^2 + (tau/gamma)^2 <= f_n^2

    Args:
        force: (*batch, 3) force [N] in the contact frame, z into the body.
        torsion: (*batch,) moment about z [N m].
        mu: friction coefficient.
        gamma: torsional coefficient [m].
        elliptic: the combined law.
    """
    f, tau = np.asarray(force, float), np.asarray(torsion, float)
    pushed, sideways = f[..., 2], np.hypot(f[..., 0], f[..., 1])
    slack = ROUNDOFF * np.maximum(1.0, np.abs(pushed))
    if not elliptic:
        return (pushed >= 0) & (sideways <= mu * pushed + slack) & (np.abs(tau) <= gamma * pushed + slack)
    if mu == 0.0 or gamma == 0.0:
        raise InputError("input.positive", name="gamma" if mu else "mu", got=0)
    return (pushed >= 0) & (np.hypot(sideways / mu, tau / gamma) <= pushed + slack)


def sliding_force(normal_force: float, velocity: ArrayLike, mu_k: float) -> Floats:
    """Friction on a body that slides: -mu_k f_n v/|v| [N].

    Args:
        normal_force: f_n [N].
        velocity: (d,) sliding velocity of the body at the contact [m/s].
        mu_k: kinetic coefficient.

    Raises:
        InputError: no velocity: a resting contact has no direction of sliding.
    """
    v = np.asarray(velocity, float)
    speed = float(np.linalg.norm(v))
    if speed == 0.0:
        raise InputError("grasp.no_sliding")
    return -float(_coefficient("mu_k", mu_k)) * normal_force * v / speed


@dataclass(frozen=True)
class FrictionLaw:
    """Friction coefficients at rest and in motion, with the two refinements that are in use.

    mu(v) = mu_k + (mu_s - mu_k) exp(-(v/v_s)^2) + viscous v   (Stribeck)
    mu_s(t) = mu_s + aging log(1 + t/t_0)                      (dwell time at rest)

    Attributes:
        mu_s: at rest.
        mu_k: in motion, at most mu_s; mu_s if None.
        stribeck_speed: v_s [m/s].
        viscous: growth with speed [s/m].
        aging: growth with the logarithm of the dwell time.
        aging_time: t_0 [s].
    """

    mu_s: float
    mu_k: float | None = None
    stribeck_speed: float = 1e-3
    viscous: float = 0.0
    aging: float = 0.0
    aging_time: float = 1.0
    _numbers = check_fields(
        mu_s=not_negative, mu_k=or_none(not_negative), stribeck_speed=positive, viscous=not_negative,
        aging=not_negative, aging_time=positive,
    )  # fmt: skip

    def __post_init__(self) -> None:
        self._numbers()
        if self.mu_k is not None and self.mu_k > self.mu_s:
            raise InputError("grasp.kinetic_above_static", kinetic=self.mu_k, static=self.mu_s)

    @property
    def kinetic(self) -> float:
        """Coefficient of motion."""
        return self.mu_s if self.mu_k is None else self.mu_k

    def at_rest(self, dwell: float = 0.0) -> float:
        """Coefficient after resting for `dwell` seconds."""
        return self.mu_s + self.aging * log(1.0 + dwell / self.aging_time)

    def sliding(self, speed: float) -> float:
        """Coefficient at a sliding speed [m/s]; towards zero speed it rises to the one of rest (stiction)."""
        v = abs(speed)
        drop = (self.mu_s - self.kinetic) * exp(-((v / self.stribeck_speed) ** 2))
        return self.kinetic + drop + self.viscous * v

    def breakaway_drop(self) -> float:
        """Share of the force that is lost at the moment of slipping."""
        return 0.0 if self.mu_s == 0 else 1.0 - self.kinetic / self.mu_s

    @property
    def angle(self) -> float:
        """Friction angle at rest [rad]."""
        return atan(self.mu_s)


def _coefficient(name: str, value: ArrayLike) -> Any:
    numbers: NDArray[np.float64] = real_array(name, value)
    if not np.isfinite(numbers).all() or (numbers < 0).any():
        worst = float(numbers[~(numbers >= 0)].ravel()[0]) if (~(numbers >= 0)).any() else float(numbers.max())
        raise InputError("grasp.negative_coefficient", name=name, value=worst)
    return numbers if numbers.ndim else float(numbers)


SERWAY = "R. A. Serway, J. W. Jewett, Physics for Scientists and Engineers, table of coefficients of friction"


@dataclass(frozen=True)
class PairFriction:
    """Coefficients of one pair.

    Attributes:
        mu_s: at rest.
        mu_k: in motion, or None if the source has none.
        source: where the numbers are from.
    """

    mu_s: float
    mu_k: float | None
    source: str

    @property
    def law(self) -> FrictionLaw:
        """The pair as a friction law."""
        return FrictionLaw(self.mu_s, self.mu_k)


TABLE: dict[frozenset[str], PairFriction] = {
    frozenset(("steel",)): PairFriction(0.74, 0.57, SERWAY),
    frozenset(("aluminium", "steel")): PairFriction(0.61, 0.47, SERWAY),
    frozenset(("copper", "steel")): PairFriction(0.53, 0.36, SERWAY),
    frozenset(("rubber", "concrete")): PairFriction(1.0, 0.8, SERWAY),
    frozenset(("glass",)): PairFriction(0.94, 0.40, SERWAY),
    frozenset(("teflon",)): PairFriction(0.04, 0.04, SERWAY),
}
"""Dry and clean, by unordered pair; one name stands for a material on itself."""


def pair_friction(body: str, finger: str, own: dict[tuple[str, str], PairFriction] | None = None) -> PairFriction:
    """Friction coefficients of two materials, in either order.

    Args:
        body, finger: names of materials.
        own: further pairs; they go before the table's.

    Raises:
        InputError: no such pair.
    """
    pair = frozenset((body, finger))
    mine = {frozenset(key): value for key, value in (own or {}).items()}
    found = mine.get(pair) or TABLE.get(pair)
    if found is None:
        known = sorted(" / ".join(sorted(key)) for key in {*mine, *TABLE})
        raise InputError("grasp.no_material", body=body, finger=finger, known=", ".join(known))
    return found
