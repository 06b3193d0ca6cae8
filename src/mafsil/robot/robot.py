"""A robot: a mechanism whose quantities are compiled at their first use.

The efforts of a motion, separated by where they come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import extension, lazily
from mafsil.mechanics.friction import SMOOTHING, friction_columns
from mafsil.mechanics.inertial_parameters import (
    BaseParameters,
    base_parameters,
    inertial_parameters,
    reflected_inertias,
)
from mafsil.mechanics.mass_matrix_singularity import mass_matrix_singularity
from mafsil.mechanics.task_space import TaskSpace, task_space
from mafsil.mechanics.tolerances import SINGULAR
from mafsil.robot.compiled_robot import CompiledRobot
from mafsil.robot.degrees import takes_degrees

if TYPE_CHECKING:
    import mafsil.robot.exported_quantity as exported_quantity
    from mafsil.kernels.export import Export
    from mafsil.robot.verbs import Verbs
else:
    exported_quantity = lazily("mafsil.robot.exported_quantity")
    Verbs = extension("Robot")


class Robot(CompiledRobot, Verbs):
    """The quantities of a mechanism as fast routines.

    Every routine takes single states or batches with any leading dimensions: q (*batch, n) and so on, inputs broadcast.
    The first call of each compiles machine code for this very robot, or loads it from the cache on disk.

    Attributes:
        mechanism: the description; immutable.
    """

    @takes_degrees("q", "qd", "qdd")
    def torque_terms(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        *,
        other: ArrayLike | None = None,
        smoothing: float = SMOOTHING,
        degrees: bool = False,
    ) -> TorqueTerms:
        """All parts of the efforts by name: links, rotors, centrifugal, coriolis, gravity, friction, tip, other.

        Args:
            q, qd, qdd: (*batch, n) motion [rad | m] and time derivatives.
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N].
            other: (*batch, n) efforts of anything else that depends on the state, such as springs [N m | N].
            smoothing: as in `friction_torque`.
            degrees: q, qd and qdd are in degrees.
        """
        return torque_terms_of(self, q, qd, qdd, tip_wrench, other, smoothing)

    @takes_degrees("qd")
    def friction_regressor(self, qd: ArrayLike, *, smoothing: float = SMOOTHING, degrees: bool = False) -> Floats:
        """(*batch, n, 3 n): efforts per viscous coefficient (n), Coulomb effort (n, equal both ways), offset (n).

        They are those of the joints that own a coordinate; what resists joints that follow them is not among them.

        Args:
            qd, smoothing, degrees: as in `friction_torque`.
        """
        columns = friction_columns(as_batch("qd", qd, (self.n,)), smoothing)
        return np.concatenate([columns[..., k, None] * np.eye(self.n) for k in range(3)], axis=-1)

    @property
    def inertial_parameters(self) -> Floats:
        """(L, 10) of all links: tau = sum of regressor times parameters + armatures qdd; see `mechanics`."""
        return inertial_parameters(self.mechanism)

    def base_parameters(self, samples: int = 200, seed: int = 0) -> BaseParameters:
        """The fewest inertial parameters that determine the efforts, found at random states.

        Args:
            samples: number of states.
            seed: of the states.

        Raises:
            InputError: no samples.
        """
        if samples < 1:
            raise InputError("dynamics.samples", count=samples)
        states = np.random.default_rng(seed).uniform(-2.0, 2.0, (3, samples, self.n))
        return base_parameters(self.mechanism, self.regressor(*states))

    def export(
        self,
        name: str,
        to: str = "c",
        *,
        frame: str | None = None,
        optional: tuple[str, ...] = (),
        target: str | None = None,
        real: str = "double",
        function: str | None = None,
    ) -> Export:
        """A quantity as C, an object file or PTX, not yet written; arguments as `mafsil.export`."""
        return exported_quantity.export_files(
            self, name, to, frame=frame, optional=optional, target=target, real=real, function=function
        )

    @takes_degrees("q", "qd")
    def task_space(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        expressed_in: Literal["body", "space"] = "body",
        frame: str | None = None,
        rows: Sequence[int] = range(6),
        degrees: bool = False,
    ) -> TaskSpace:
        """Dynamics in the tip's coordinates, F = Lambda dV + eta; singular states are marked and NaN.

        Args:
            q, qd: (*batch, n) coordinates [rad | m] and rates.
            expressed_in: whether twists and wrenches are those of the tip frame or of {s}.
            frame: link name; the tip frame if None.
            rows: which components of the twist (omega, v) count, such as (3, 4, 5) for the translation.
            degrees: q and qd are in degrees.

        Raises:
            InputError: wrong shapes, NaN, an unknown frame or rows.

        Reference: Lynch & Park, Modern Robotics, sec. 8.6; Khatib 1987.
        """
        return task_space_of(self, q, qd, expressed_in, frame, rows)


def task_space_of(
    robot: CompiledRobot,
    q: ArrayLike,
    qd: ArrayLike,
    expressed_in: Literal["body", "space"],
    frame: str | None,
    rows: Sequence[int],
) -> TaskSpace:
    """Task-space dynamics; arguments as in `Robot.task_space`, and the robot.

    Raises:
        InputError: as `Robot.task_space`.
        ModelError: the mass matrix of a state is singular; names the joints that move no inertia.
    """
    if expressed_in not in ("body", "space"):
        raise InputError("dynamics.expressed_in", value=expressed_in)
    chosen = list(rows)
    if not chosen or len(set(chosen)) != len(chosen) or not set(chosen) <= set(range(6)):
        raise InputError("dynamics.task_rows", rows=tuple(chosen))
    q, qd = as_batch("q", q, (robot.n,), finite=True), as_batch("qd", qd, (robot.n,), finite=True)
    jacobian, rate = (
        (robot.jacobian_body, robot.jacobian_body_rate)
        if expressed_in == "body"
        else (robot.jacobian_space, robot.jacobian_space_rate)
    )
    M = robot.mass_matrix(q)
    _require_regular(M, robot)
    return task_space(
        M,
        robot.velocity_torque(q, qd),
        robot.gravity_torque(q),
        jacobian(q, frame=frame)[..., chosen, :],
        rate(q, qd, frame=frame)[..., chosen, :],
        qd,
    )


def _require_regular(M: Floats, robot: CompiledRobot) -> None:
    """Refuses the first state (of a batch) whose mass matrix has no inverse, with the motion that moves no inertia."""
    flat = M.reshape(-1, robot.n, robot.n)
    size = np.sqrt(np.maximum(np.einsum("bii->bi", flat), LEAST_DIVISOR))
    margins = np.linalg.eigvalsh(flat / (size[:, :, None] * size[:, None, :]))[:, 0] if len(flat) else np.ones(0)
    for k in np.flatnonzero(~(margins >= SINGULAR)):
        mass_matrix_singularity(flat[k], robot.joint_names).require_regular()


@dataclass(frozen=True, eq=False, slots=True)
class TorqueTerms:
    """Joint efforts by name, each (*batch, n) [N m | N]; together they are the whole effort.

    Attributes:
        links: M qdd of the links.
        rotors: reflected rotor inertia times qdd.
        centrifugal: the part of c with squares of one rate.
        coriolis: the part of c with products of different rates.
        gravity: what holds the links up.
        friction: viscous, Coulomb and offset.
        tip: J' F_tip, what the tip does to the world.
        other: what the caller gave, such as springs.
    """

    links: Floats
    rotors: Floats
    centrifugal: Floats
    coriolis: Floats
    gravity: Floats
    friction: Floats
    tip: Floats
    other: Floats

    @property
    def total(self) -> Floats:
        """(*batch, n) the sum of all terms."""
        return self.without()

    def only(self, *names: str) -> Floats:
        """(*batch, n) the sum of the named terms.

        Raises:
            InputError: a name that is no term.
        """
        _known(names)
        return sum((getattr(self, name) for name in dict.fromkeys(names)), np.zeros_like(self.links))

    def without(self, *names: str) -> Floats:
        """(*batch, n) the sum of all terms but the named ones.

        Raises:
            InputError: a name that is no term.
        """
        return self.only(*(name for name in _known(names) if name not in names))


def _known(names: tuple[str, ...]) -> tuple[str, ...]:
    """All terms, after a look that the named ones are among them."""
    known = tuple(field.name for field in fields(TorqueTerms))
    for name in names:
        if name not in known:
            raise InputError("input.choice", name="term", value=name, known=", ".join(known))
    return known


def torque_terms_of(
    robot: CompiledRobot,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    tip_wrench: ArrayLike | None,
    other: ArrayLike | None,
    smoothing: float,
) -> TorqueTerms:
    """The terms; arguments as in `Robot.torque_terms`, and the robot."""
    given = (("q", q), ("qd", qd), ("qdd", qdd), ("other", np.zeros(robot.n) if other is None else other))
    motion = [as_batch(name, value, (robot.n,), finite=True) for name, value in given]
    wrench = None if tip_wrench is None else as_batch("tip_wrench", tip_wrench, (6,), finite=True)
    batch = np.broadcast_shapes(*(part.shape[:-1] for part in motion), () if wrench is None else wrench.shape[:-1])
    position, rate, acceleration, rest = (np.broadcast_to(part, (*batch, robot.n)).copy() for part in motion)
    rotors: JointVector = reflected_inertias(robot.mechanism) * acceleration
    inertia = np.einsum("...ij,...j->...i", robot.mass_matrix(position), acceleration)
    tip = np.zeros_like(rotors)
    if wrench is not None:
        tip = np.einsum("...ji,...j->...i", robot.jacobian_body(position), wrench)
    return TorqueTerms(
        links=inertia - rotors,
        rotors=rotors,
        centrifugal=robot.centrifugal_torque(position, rate),
        coriolis=robot.coriolis_torque(position, rate),
        gravity=robot.gravity_torque(position),
        friction=robot.friction_torque(rate, smoothing=smoothing),
        tip=tip,
        other=rest,
    )
