"""How the joints of a job are driven, disturbed, simulated and varied, as typed data.

Field names are the keys of the file.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.job.language.part import NotNegative, Part, Positive, Six, Three

LawKind: TypeAlias = Literal[
    "computed_torque", "pd_gravity", "pid", "feedforward", "sliding_mode", "min_max", "adaptive",
    "model_predictive", "linear_quadratic", "task_computed_torque", "impedance", "admittance", "hybrid",
]  # fmt: skip
"""Laws of the joints, then laws of the tip."""
WITHOUT_INERTIA = ("pid", "pd_gravity")
"""Laws that know no inertia, and lag behind accelerations."""
TIP_LAWS: tuple[LawKind, ...] = ("task_computed_torque", "impedance", "admittance", "hybrid")
PerAxis: TypeAlias = NotNegative | tuple[NotNegative, ...]
"""One number, or one along each axis of {s}: three. (Beside a tuple of fixed length msgspec 0.22 overwrites memory.)"""


def has_free_direction(stiffness: PerAxis | None) -> bool:
    """Whether nothing pulls the tip back in some direction."""
    return 0.0 in (stiffness if isinstance(stiffness, tuple) else (stiffness,))


class Controller(Part, frozen=True, kw_only=True):
    """The law that drives the joints.

    Attributes:
        kind: `computed_torque`; `pd_gravity`, PD with gravity compensation; `pid` of each joint by itself;
            `feedforward` of the model with PD; `sliding_mode` and `min_max`, for masses known within a share;
            `adaptive`, which learns what the tool carries; `model_predictive`, which looks ahead and keeps efforts
            within their limits; `linear_quadratic`, of least cost about the middle of the motion. Of the tip:
            `task_computed_torque`; `impedance` and `admittance`, a tip that gives way; `hybrid`, motion along the first
            surface and force into it.
        frequency: natural frequency of the error dynamics of computed torque, in joints or at the tip, and of
            the motion of `hybrid`, 20 if None; of `model_predictive` away from limits 80, of `linear_quadratic` about
            its pose 40 if None, or the half, the quarter... that the sampling bears [rad/s].
        damping: its damping ratio, or that of the tip's impedance; 1 if None.
        kp, kd: of the PD and PID laws, one number or one per joint; from the inertia of each joint if
            None [N m/rad, N m s/rad].
        integral: gain of PID, likewise; a tenth of what would make it unstable if None [N m/(rad s)].
        mass_uncertainty: by which sliding mode takes every mass, and min-max all together, to be wrong; 0.2 if None.
        margin: effort of sliding mode for friction; what the model's friction asks for and 1 if None [N m | N].
        width: of the boundary layer; 0.02 if None, or twice, four times... that, where the sampling would make the law
            chatter [rad/s | m/s]; of min-max 1 [N m/s | N/s].
        horizon: intervals that `model_predictive` looks ahead; 20 if None.
        interval: length of one; 0.005 if None [s].
        tip_stiffness, rotational_stiffness: of impedance and admittance, one number or one along each axis of {s}; 0
            leaves a direction free; if None, what makes the arm's inertia at the start swing with 20 rad/s
            [N/m, N m/rad].
        tip_damping, rotational_damping: likewise, instead of the damping ratio [N s/m, N m s/rad].
        tip_mass, turn_inertia: of admittance; those of the arm at the start if None [kg, kg m^2].
        normal_force: force of `hybrid` into the surface; 10 if None [N].
        force_gain, force_integral: of the error of that force; 0 and 10 if None [1, 1/s].
        learning: how fast the adaptive law learns; 1 if None.
        friction: whether the friction that the description has is compensated along the planned motion; if None, by
            `computed_torque`, `pd_gravity` and `feedforward` where it acts.
        rate: how often the law is evaluated [Hz]; each simulation step if None.
        delay: from the measurement to the effort, a whole number of periods of the law [s].
    """

    kind: LawKind = "computed_torque"
    frequency: Positive | None = None
    damping: Positive | None = None
    kp: Positive | tuple[Positive, ...] | None = None
    kd: Positive | tuple[Positive, ...] | None = None
    integral: NotNegative | tuple[NotNegative, ...] | None = None
    mass_uncertainty: NotNegative | None = None
    margin: NotNegative | tuple[NotNegative, ...] | None = None
    width: Positive | None = None
    horizon: Annotated[int, msgspec.Meta(ge=1, le=200)] | None = None
    interval: Positive | None = None
    learning: NotNegative | None = None
    tip_stiffness: PerAxis | None = None
    rotational_stiffness: PerAxis | None = None
    tip_damping: PerAxis | None = None
    rotational_damping: PerAxis | None = None
    tip_mass: Positive | None = None
    turn_inertia: Positive | None = None
    normal_force: Positive | None = None
    force_gain: NotNegative | None = None
    force_integral: NotNegative | None = None
    friction: bool | None = None
    rate: Positive | None = None
    delay: NotNegative = 0.0

    @property
    def guides(self) -> bool:
        """Whether the tip may be led away from the plan: in some direction nothing pulls it back."""
        return has_free_direction(self.tip_stiffness) or has_free_direction(self.rotational_stiffness)


class Noise(Part, frozen=True, kw_only=True):
    """Errors of the sensors.

    Attributes:
        position, velocity: standard deviations of what the joints measure.
        force: that of the sensor of force at the tip [N].
        resolution: steps of the encoders at the joints; rates are then differences of them [rad | m].
        filter_time: time constant of the filter of such rates [s].
        seed: by which noise is reproducible.
    """

    position: NotNegative = 0.0
    velocity: NotNegative = 0.0
    force: NotNegative = 0.0
    resolution: NotNegative = 0.0
    filter_time: NotNegative = 0.0
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0


class Simulation(Part, frozen=True, kw_only=True):
    """How the motion is simulated.

    Attributes:
        step: of the integrator [s].
        method: integrator; rk4 if None, or implicit_friction where the friction of light links is too stiff for the
            step. A method that is named is used or refused, never replaced.
        settle: time at rest after the last move [s].
        friction: whether the joints have the friction of the description.
        mass_error: the real masses are this much larger than the controller believes (0.1 is ten per cent).
        payload: mass that hangs at the tip besides, which the controller does not know of [kg].
        noise: of the sensors.
        plant: who computes the motion: `mafsil`; `mujoco` where it is installed; `kinematic`, the plan is followed
            exactly, without masses, controller and forces. If None `mafsil`, or `kinematic` where masses are missing.
        real_time: every evaluation of the law begins when it is due, and those that come late are counted; a run takes
            as long as the motion.
    """

    step: Annotated[float, msgspec.Meta(ge=1e-6, le=0.1)] = 0.001
    method: Literal["rk4", "semi_implicit_euler", "implicit_friction"] | None = None
    settle: NotNegative = 0.3
    friction: bool = True
    mass_error: Annotated[float, msgspec.Meta(gt=-1, le=10)] = 0.0
    payload: NotNegative = 0.0
    noise: Noise = Noise()
    plant: Literal["mafsil", "mujoco", "kinematic"] | None = None
    real_time: bool = False


class Disturbance(Part, frozen=True, kw_only=True):
    """A push of the world on the tip.

    Attributes:
        start, duration: [s].
        wrench: (m, f) on the tip, in the tip frame [N m, N].
    """

    start: NotNegative
    duration: Positive
    wrench: Six


class Track(Part, frozen=True, kw_only=True):
    """An axis on which the robot, or the next axis, stands. Its coordinate comes before those of the robot.

    Attributes:
        direction: of a linear axis in {s}.
        axis: of a turntable in {s}: it turns about it counter-clockwise.
        point: on that axis [m].
        range: least and largest coordinate; at 0 the robot stands at the origin of {s} [m | rad, or degrees].
        speed, acceleration: largest [m/s, m/s^2 | rad/s, rad/s^2, or degrees]; as assumed for all joints if None.
    """

    direction: Three | None = None
    axis: Three | None = None
    point: Three = (0.0, 0.0, 0.0)
    range: tuple[float, float]
    speed: Positive | None = None
    acceleration: Positive | None = None


class Normal(Part, frozen=True, kw_only=True):
    """Values about a mean, normally distributed."""

    mean: float
    deviation: NotNegative


Spread: TypeAlias = tuple[float, float] | Normal
"""Two ends, between which any value is as likely, or a mean with a deviation."""


class VariationTable(Part, frozen=True, kw_only=True):
    """The job is driven many times; in each run what stands here is drawn anew, and the controller does not know it.

    Attributes:
        runs: how many.
        seed: of the draws.
        bound: distance of the tip from its path that counts as good, if any [m].
        payload: mass that hangs at the tip besides [kg].
        payload_offset: of its centre of mass from the tip, drawn for each axis of the tip frame [m].
        inertia: factor of mass and inertia, drawn for each link.
        friction: factor of all coefficients of friction, drawn for each joint.
        gains: factor of all gains of the law.
        delay: by which efforts come later, rounded to whole periods of the law [s].
        noise: factor of the noise of positions and rates in `[simulation]`.
    """

    runs: Annotated[int, msgspec.Meta(ge=1, le=100_000)] = 200
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    bound: Positive | None = None
    payload: Spread | None = None
    payload_offset: Spread | None = None
    inertia: Spread | None = None
    friction: Spread | None = None
    gains: Spread | None = None
    delay: Spread | None = None
    noise: Spread | None = None


SPREADS = tuple(name for name in VariationTable.__struct_fields__ if name not in ("runs", "seed", "bound"))
"""Keys of what is drawn, as `mafsil.simulation.Variation` calls them."""
