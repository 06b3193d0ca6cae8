"""What friction depends on beside speed: load, time at rest, temperature, and the way gone since it stuck.

Reference: Armstrong-Helouvry, Dupont and Canudas de Wit, A survey of models, analysis tools and compensation methods
for the control of machines with friction, Automatica 30(7), 1994; Dahl, A solid friction model, 1968.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, require_kind
from mafsil.one_joint.arguments import above_zero, above_zero_or_unbounded, check_batch, finite, magnitude, together
from mafsil.one_joint.drives.dry_friction import SpeedFriction


@dataclass(frozen=True, eq=False, slots=True)
class FrictionConditions:
    """How the numbers of a friction law move with load, rest and temperature.

    Dry friction: b + load_share |load|, kinetic and static alike. Static: it grows at rest from b_k to b_s as
    T / (T + rest_time). Viscous: b_v exp(-thinning (temperature - reference)), as a lubricant that gets thinner.
    Pre-sliding: a spring of the stiffness given, until the bristles slide.

    Attributes:
        friction: at no load, after a long rest, at the reference temperature.
        load_share: (*batch) dry friction per effort that the gear passes [1].
        rest_time: (*batch) after which half of the difference of static and kinetic is there; 0 is at once [s].
        thinning: (*batch) [1/K].
        reference: (*batch) temperature [degrees Celsius].
        stiffness: (*batch) of pre-sliding; infinite if there is none [N m/rad | N/m].
    """

    friction: SpeedFriction
    load_share: Floats
    rest_time: Floats
    thinning: Floats
    reference: Floats
    stiffness: Floats
    __post_init__ = check_batch(
        load_share=magnitude,
        rest_time=magnitude,
        thinning=magnitude,
        reference=finite,
        stiffness=above_zero_or_unbounded,
    )

    @classmethod
    def of(
        cls, friction: SpeedFriction, *, load_share: ArrayLike = 0.0, rest_time: ArrayLike = 0.0,
        thinning: ArrayLike = 0.0, reference: ArrayLike = 20.0, stiffness: ArrayLike = np.inf,
    ) -> FrictionConditions:  # fmt: skip
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a negative number, a stiffness of zero, shapes that do not go together.
        """
        require_kind("friction", friction, "SpeedFriction", "torque", "interval")
        parts = together(
            load_share=load_share, rest_time=rest_time, thinning=thinning, reference=reference, stiffness=stiffness
        )
        return cls(friction, *parts)

    def at(self, load: ArrayLike = 0.0, rest: ArrayLike = 1e6, temperature: ArrayLike | None = None) -> SpeedFriction:
        """The friction law (*batch) under these conditions, for a run or the test of holding.

        Args:
            load: effort that the gear passes (*batch) [N m | N].
            rest: time since the last motion (*batch) [s].
            temperature: (*batch), that of the reference if None [degrees Celsius].

        Raises:
            InputError: not finite, a negative time, shapes that do not go together.
        """
        law, warm = self.friction, self.reference if temperature is None else finite("temperature", temperature)
        waited = magnitude("rest", rest)
        added = self.load_share * np.abs(finite("load", load))
        grown = np.divide(waited, waited + self.rest_time, out=np.ones_like(waited + self.rest_time),
                          where=waited + self.rest_time > 0.0)  # fmt: skip
        kinetic = law.kinetic + added
        static = kinetic + (law.static - law.kinetic) * grown
        viscous = law.viscous * np.exp(-self.thinning * (warm - self.reference))
        return SpeedFriction.of(static, kinetic, viscous, law.stribeck_speed, law.exponent)

    def presliding(self, way: ArrayLike, load: ArrayLike = 0.0) -> Floats:
        """Torque (*batch) after a way from where nothing was strained: b (1 - exp(-k |x| / b)) sgn(x), b kinetic.

        Dahl's law: its slope at the start is the stiffness, and it ends at kinetic friction.

        Args:
            way: x (*batch) gone in one sense [rad | m].
            load: effort that the gear passes (*batch) [N m | N].
        """
        x = finite("way", way)
        b = above_zero("kinetic friction", self.friction.kinetic + self.load_share * np.abs(finite("load", load)))
        with np.errstate(invalid="ignore"):
            strained = np.where(x == 0.0, 0.0, self.stiffness * np.abs(x) / b)
        return b * -np.expm1(-strained) * np.sign(x)

    def breakaway(self, load: ArrayLike = 0.0) -> Floats:
        """(*batch) way after which 98 % of the kinetic friction is there: 4 b / k [rad | m]."""
        return 4.0 * (self.friction.kinetic + self.load_share * np.abs(finite("load", load))) / self.stiffness
