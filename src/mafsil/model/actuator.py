"""What drives a joint, and what resists it besides the links."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from mafsil.errors import ModelError
from mafsil.fields import check_fields, or_none, real


@dataclass(frozen=True, slots=True)
class Actuator:
    """Motor and gear of one joint.

    Attributes:
        rotor_inertia: inertia of the rotor about its own axis, on the motor side [kg m^2].
        gear_ratio: motor turns per joint turn (or motor radians per metre).
        armature: inertia seen at the joint in addition to the rotor's, as MuJoCo's `armature` [kg m^2 | kg].
    """

    rotor_inertia: float = 0.0
    gear_ratio: float = 1.0
    armature: float = 0.0
    _numbers = check_fields(rotor_inertia=real, gear_ratio=real, armature=real)

    def __post_init__(self) -> None:
        self._numbers()
        _require_magnitudes(rotor_inertia=self.rotor_inertia, armature=self.armature)
        if not isfinite(self.gear_ratio):
            raise ModelError("model.finite", name="gear_ratio", value=self.gear_ratio)

    @property
    def reflected_inertia(self) -> float:
        """Inertia seen at the joint: gear_ratio^2 rotor_inertia + armature [kg m^2 | kg]."""
        return self.gear_ratio**2 * self.rotor_inertia + self.armature

    @property
    def equivalent_rotor(self) -> tuple[float, float]:
        """Gear ratio, and inertia of a rotor behind it that is felt at the joint as rotor and armature together."""
        if self.armature == 0.0 or self.gear_ratio == 0.0:
            return (self.gear_ratio, self.rotor_inertia) if self.gear_ratio else (1.0, self.armature)
        return self.gear_ratio, self.reflected_inertia / self.gear_ratio**2


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction of one joint, on the joint side.

    Attributes:
        viscous: effort per speed [N m s/rad | N s/m].
        coulomb: effort against the motion, positive sense [N m | N].
        coulomb_negative: the same in the negative sense (a magnitude); equal to `coulomb` if None.
        offset: constant effort of either sign, such as a sensor's or a balance spring's [N m | N].
    """

    viscous: float = 0.0
    coulomb: float = 0.0
    coulomb_negative: float | None = None
    offset: float = 0.0
    _numbers = check_fields(viscous=real, coulomb=real, coulomb_negative=or_none(real), offset=real)

    def __post_init__(self) -> None:
        self._numbers()
        negative = self.coulomb if self.coulomb_negative is None else self.coulomb_negative
        _require_magnitudes(viscous=self.viscous, coulomb=self.coulomb, coulomb_negative=negative)
        if not isfinite(self.offset):
            raise ModelError("model.finite", name="offset", value=self.offset)

    @property
    def is_uneven(self) -> bool:
        """Whether it differs for both senses of motion, or has an offset."""
        return self.coulomb_negative not in (None, self.coulomb) or bool(self.offset)

    @property
    def mean_coulomb(self) -> float:
        """Mean of the Coulomb efforts of both senses [N m | N]."""
        return self.coulomb if self.coulomb_negative is None else (self.coulomb + self.coulomb_negative) / 2


def _require_magnitudes(**values: float) -> None:
    for name, value in values.items():
        if not (isfinite(value) and value >= 0):
            raise ModelError("model.magnitude", name=name, value=value)
