"""What disturbs a run, and what may differ from run to run: as declared, and as drawn.

Runs are disturbed by pushes at the tip and noise of the sensors; payloads, inertias, friction, gains, delays and starts
differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import (
    Floats,
    Vector6,
    as_batch,
    frozen,
    not_negative,
    number,
    positive,
    real_array,
    require_finite,
    whole,
)
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite
from mafsil.lazy_module import lazily
from mafsil.mechanics.inertial_parameters import inertial_parameters
from mafsil.messages import say
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.mechanics.tree_plant as tree_plant
else:
    tree_plant = lazily("mafsil.mechanics.tree_plant")


@dataclass(frozen=True, eq=False)
class WrenchPulse:
    """A constant wrench during an interval of time.

    Attributes:
        start, duration: when it acts [s].
        push: (6,) or (*batch, 6) wrench (m, f) that the world exerts on the tip, in the tip frame [N m, N].

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """

    start: float
    duration: float
    push: Vector6

    def __post_init__(self) -> None:
        number("start", self.start)
        positive("duration", self.duration)
        object.__setattr__(self, "push", frozen(require_finite("push", as_batch("push", self.push, (6,)))))


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """Normal noise of the measured positions and rates, the same for the same seed.

    Attributes:
        position, velocity: standard deviations, a number or (n,) [rad | m], [rad/s | m/s].
        seed: of the generator.
    """

    position: Floats | float = 0.0
    velocity: Floats | float = 0.0
    seed: int | tuple[int, ...] = 0
    __post_init__ = check_fields(position=finite(0, 1, low=0.0), velocity=finite(0, 1, low=0.0))

    def drawn(self, ticks: int, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
        """Noise of every control tick, (ticks, *shape) for positions and for rates."""
        sizes = (whole("ticks", ticks), *(whole("shape", each) for each in shape))
        draws = np.random.default_rng(self.seed).standard_normal((2, *sizes))
        return self.position * draws[0], self.velocity * draws[1]


def push_at(pulses: Sequence[WrenchPulse], times: Floats) -> list[Vector6 | None]:
    """The sum of the pulses that act at each time; None where there is none."""
    if not pulses:
        return [None] * len(times)
    pushes: list[Vector6 | None] = []
    for t in times:
        acting = [pulse.push for pulse in pulses if pulse.start <= t < pulse.start + pulse.duration]
        pushes.append(sum(acting[1:], acting[0]) if acting else None)
    return pushes


MOST_DELAY = 10_000
"""Control periods that a command may be late."""


@dataclass(frozen=True, slots=True)
class Uniform:
    """Any value between two, all alike."""

    low: float
    high: float
    __post_init__ = check_fields(low=number, high=number)

    def value(self, uniform: Floats, normal: Floats) -> Floats:
        """Values from draws of both kinds."""
        return self.low + (self.high - self.low) * uniform


@dataclass(frozen=True, slots=True)
class Normal:
    """Values about a mean."""

    mean: float
    deviation: float
    __post_init__ = check_fields(mean=number, deviation=not_negative)

    def value(self, uniform: Floats, normal: Floats) -> Floats:
        """Values from draws of both kinds."""
        return self.mean + self.deviation * normal


Spread: TypeAlias = Uniform | Normal | tuple[float, float]
"""A distribution; two numbers are the ends of a uniform one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Variation:
    """Random variation between runs; None means no variation.

    Attributes:
        payload: mass at the tip that the law does not know [kg].
        payload_offset: of its centre of mass from the tip, drawn for each axis of the tip frame [m].
        inertia: factor of mass and inertia, drawn for each link; 1 is the model.
        friction: factor of all coefficients of friction, drawn for each joint.
        gains: factor of all gains of the law, drawn once a run.
        delay: of the commands, rounded to whole control periods [s].
        noise: factor of the scenario's sensor noise, drawn once a run.
        start: added to each initial position [rad | m].
    """

    payload: Spread | None = None
    payload_offset: Spread | None = None
    inertia: Spread | None = None
    friction: Spread | None = None
    gains: Spread | None = None
    delay: Spread | None = None
    noise: Spread | None = None
    start: Spread | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            given = getattr(self, field.name)
            if given is not None:
                object.__setattr__(self, field.name, _spread(field.name, given))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Variants:
    """The values drawn for b runs; None where all are alike.

    Attributes:
        count: b.
        payload: (b,) [kg].
        payload_offset: (b, 3) [m].
        inertia: (b, L) factors.
        friction: (b, joints with friction) factors.
        gains: (b,) factors.
        delay: (b,) control periods.
        noise: (b,) factors.
        start: (b, n) [rad | m].
        numbers: (b,) of the runs, which seed their noise; 0, 1, .. if None.
    """

    count: int
    payload: Floats | None = None
    payload_offset: Floats | None = None
    inertia: Floats | None = None
    friction: Floats | None = None
    gains: Floats | None = None
    delay: NDArray[np.int64] | None = None
    noise: Floats | None = None
    start: Floats | None = None
    numbers: NDArray[np.int64] | None = None

    @property
    def changes_plant(self) -> bool:
        """Whether the plants differ from each other."""
        return any(each is not None for each in (self.payload, self.inertia, self.friction))

    def bodies(self, robot: Robot) -> Floats:
        """(b, bodies, 10) inertial parameters of the plants, `mafsil.mechanics.tree_plant`."""
        parameters = np.broadcast_to(
            inertial_parameters(robot.mechanism), (self.count, len(robot.mechanism.links), 10)
        ).copy()
        if self.inertia is not None:
            parameters *= self.inertia[..., None]
        payload = None
        if self.payload is not None:
            c = np.zeros((self.count, 3)) if self.payload_offset is None else self.payload_offset
            x, y, z = c.T
            about = np.stack([y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z], axis=-1)
            payload = self.payload[:, None] * np.concatenate([np.ones((self.count, 1)), c, about], axis=1)
        return tree_plant.body_parameters(robot.mechanism, parameters, payload)

    def friction_of(self, robot: Robot) -> Floats:
        """(b, joints with friction, 4) coefficients of the plants."""
        rows = tree_plant.friction_rows(robot.mechanism)
        factors = np.ones((self.count, len(rows))) if self.friction is None else self.friction
        return factors[..., None] * rows

    def noise_of(self, noise: SensorNoise, ticks: int, n: int) -> tuple[Floats, Floats]:
        """(ticks, b, n) of positions and of rates: that of a run depends on the seed and on its number alone.

        Args:
            noise: of one run.
            ticks: how many.
            n: coordinates.
        """
        numbers = np.arange(self.count) if self.numbers is None else self.numbers
        factors = np.ones(self.count) if self.noise is None else self.noise
        rows = [replace(noise, seed=(noise.seed, int(number))).drawn(ticks, (n,)) for number in numbers]
        positions, rates = (np.stack(part, axis=1) * factors[:, None] for part in zip(*rows, strict=True))
        return positions, rates

    def columns(self) -> dict[str, Floats]:
        """(b,) each: every drawn number by its name, such as `inertia[3]`."""
        table: dict[str, Floats] = {}
        for field in fields(self):
            drawn = getattr(self, field.name)
            if field.name in ("count", "numbers") or drawn is None:
                continue
            array = np.asarray(drawn, dtype=np.float64)
            if array.ndim == 1:
                table[field.name] = array
            else:
                table |= {f"{field.name}[{k}]": array[:, k] for k in range(array.shape[1])}
        return table

    def rows(self, first: int, last: int) -> Variants:
        """Those of the runs first .. last - 1."""
        parts: dict[str, Any] = {
            field.name: None if getattr(self, field.name) is None else getattr(self, field.name)[first:last]
            for field in fields(self)
            if field.name != "count"
        }
        return Variants(count=min(last, self.count) - first, **parts)


def drawn_name(column: str, language: str | None = None, *, unit: bool = False) -> str:
    """What was drawn, in words.

    Args:
        column: one of `Variants.columns`, such as `inertia[3]`.
        language: `en` or `ar`; the current one if None.
        unit: whether it is said, in brackets.
    """
    name, _, place = column.rstrip("]").partition("[")
    axis = "xyz"[int(place)] if name == "payload_offset" else ""
    said = say(f"simulation.drawn_{name}", language=language, number=place, axis=axis)
    return said if unit else said.partition(" [")[0]


def drawn(
    variation: Variation, robot: Robot, period: float, runs: int, seed: int, *, first: int = 0
) -> Variants:  # fmt: skip
    """What differs in each of many runs; run k depends on the seed and on k alone.

    Args:
        variation: what may differ.
        robot: the true arm.
        period: between two calls of the law [s].
        runs: how many.
        seed: of the draws.
        first: number of the first run.

    Raises:
        InputError: a mass, a factor or a delay came out negative, a factor of inertia not positive.
    """
    links, joints, n = len(robot.mechanism.links), len(tree_plant.friction_rows(robot.mechanism)), robot.n
    sizes = {
        "payload": 1, "payload_offset": 3, "inertia": links, "friction": joints, "gains": 1, "delay": 1, "start": n,
        "noise": 1,
    }  # fmt: skip
    total = sum(sizes.values())
    uniform, normal = np.empty((2, runs, total))
    for k in range(runs):
        source = np.random.default_rng([seed, first + k])
        uniform[k], normal[k] = source.random(total), source.standard_normal(total)
    parts: dict[str, Any] = {}
    at = 0
    for name, size in sizes.items():
        spread, columns = getattr(variation, name), slice(at, at + size)
        at += size
        if spread is None or not size:
            continue
        values = spread.value(uniform[:, columns], normal[:, columns])
        if name not in ("payload_offset", "start"):
            _require_sensible(name, values)
        parts[name] = values[:, 0] if name in ("payload", "gains", "delay", "noise") else values
    if "delay" in parts:
        late = np.rint(parts["delay"] / period)
        if (late > MOST_DELAY).any():
            raise InputError("input.range", name="delay", value=late.max() * period, low=0.0, high=MOST_DELAY * period)
        parts["delay"] = late.astype(np.int64)
    return Variants(count=runs, numbers=np.arange(first, first + runs), **parts)


def _spread(name: str, given: Spread) -> Uniform | Normal:
    if isinstance(given, Normal):
        return given
    if not isinstance(given, Uniform):
        ends = real_array(name, given)
        if ends.shape != (2,) or not np.isfinite(ends).all():
            raise InputError("simulation.spread", name=name, value=given)
        given = Uniform(*ends.tolist())
    if given.high < given.low:
        raise InputError("simulation.spread", name=name, value=given)
    return given


def _require_sensible(name: str, values: Floats) -> None:
    least = float(values.min())
    if least < 0.0 or (least == 0.0 and name == "inertia"):
        raise InputError("simulation.drawn", name=name, value=least)
