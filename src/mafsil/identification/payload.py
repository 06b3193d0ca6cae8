"""What a known robot carries: mass, centre of mass and inertia of the body at its tip, from motion or poses at rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.identification.log import MotionLog, Remark
from mafsil.identification.regression import (
    BodyParameterisation,
    Parameterisation,
    RegressorStack,
    ball,
    fit_base_parameters,
    most_likely,
)
from mafsil.identification.smoothing import Log, SmoothMotion, opened, prepare_log
from mafsil.identification.tolerances import LEAST_MASS, LEAST_SHARE, NO_EFFORT, NO_MOTION
from mafsil.identification.torque_model import CHUNK, thin_rows, with_load
from mafsil.mechanics.inertial_parameters import inertial_of
from mafsil.messages import say
from mafsil.robot import Robot, of_robot

RADIUS = 0.1
"""Size [m] that loads are assumed to have."""
SPREAD = 1.0
"""How far that may be off, as a logarithm."""
IDENTIFIABLE = 0.7
"""A number is identifiable if its standard error is below this share of the prior's."""
SIGNIFICANT = 3.0
"""A load is there if its mass is this many standard errors."""


class PayloadStatus(Status):
    """Whether there is a load."""

    FOUND = ("identification.payload_mass", True)
    NONE = ("identification.no_payload", False)


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Payload(Answer):
    """The answer of `estimate_payload`, in the tip frame: true if there certainly is a load.

    Attributes:
        mass: [kg].
        com: (3,) centre of mass [m].
        inertia: (3, 3) about the centre of mass [kg m^2].
        mass_error, com_error, inertia_error: standard errors, of the same shapes.
        com_identifiable, inertia_identifiable: of the same shapes: whether the log identifies the number;
            if not it is a guess.
        certain: whether the log shows that there is a load at all.
        before, after: (n,) torque error without and with the load, in percent of the torque.
        robot: the robot with the load.
        remarks: what was irregular.
    """

    mass: float
    com: Floats
    inertia: Floats
    mass_error: float
    com_error: Floats
    inertia_error: Floats
    com_identifiable: NDArray[np.bool_]
    inertia_identifiable: NDArray[np.bool_]
    certain: bool
    before: Floats
    after: Floats
    robot: Robot
    remarks: tuple[Remark, ...]

    def __bool__(self) -> bool:
        return self.certain

    @property
    def status(self) -> PayloadStatus:
        """Whether there certainly is a load."""
        return PayloadStatus.FOUND if self.certain else PayloadStatus.NONE

    def explain(self, language: str | None = None) -> str:
        """The load in sentences, and what the log does not identify of it."""
        lines = [self.status.sentence(language, mass=self.mass, error=self.mass_error)]
        if not self.certain:
            return "\n".join([*lines, *(remark.sentence(language) for remark in self.remarks)])
        lines += [
            say(
                "identification.payload_com" if identifiable else "identification.payload_com_guessed",
                language=language, axis=axis, value=1e3 * value, error=1e3 * error,
            )
            for axis, value, error, identifiable in zip(
                "xyz", self.com, self.com_error, self.com_identifiable, strict=True
            )
        ]  # fmt: skip
        if not self.inertia_identifiable.any():
            lines.append(say("identification.payload_inertia_guessed", language=language))
        else:
            lines += self._inertia_lines(language)
        return "\n".join([*lines, *(remark.sentence(language) for remark in self.remarks)])

    def _inertia_lines(self, language: str | None) -> list[str]:
        return [
            say(
                f"identification.payload_{'inertia' if self.inertia_identifiable[i, j] else 'moment_guessed'}",
                language=language, name=f"I{'xyz'[i]}{'xyz'[j]}", value=self.inertia[i, j],
                error=self.inertia_error[i, j],
            )
            for i in range(3)
            for j in range(i, 3)
        ]  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Everything but the robot as plain data, for machines."""
        quantities = ("mass", "com", "inertia")
        names = [name + end for end in ("", "_error", "_identifiable") for name in quantities]
        names.remove("mass_identifiable")
        return {
            "robot": self.robot.name,
            "status": self.status.name.lower(),
            **{name: getattr(self, name) for name in names},
            "certain": self.certain,
            "before_percent": self.before,
            "after_percent": self.after,
            "remarks": [remark.sentence() for remark in self.remarks],
        }


@of_robot
def estimate_payload(
    robot: Robot,
    log: Log,
    *,
    at_rest: bool = False,
    bandwidth: float | None = None,
    degrees: bool = False,
) -> Payload:
    """The body at the tip of a robot whose own masses and friction are known.

    tau - tau_robot(q, qd, qdd) - friction(qd) = Y_tip(q, qd, qdd) (m, m c, I), by weighted least squares

    Poses at rest identify mass and centre of mass only; motion identifies the inertia where it is fast enough. What
    friction takes at rest is not known: it counts as noise.

    Args:
        robot: without the load; errors of its model become errors of the load.
        log: motion with the load; see `read_log` for files.
        at_rest: every row is a pose at rest, rows need not follow each other in time evenly.
        bandwidth: highest frequency of the motion [Hz]; found in the log if None.
        degrees: whether revolute joints of a log file are in degrees.

    Raises:
        InputError: a log of another robot, too short, or not clean; the row is named.
        FileError: a log file that cannot be read; the line is named.

    Reference: Atkeson, An & Hollerbach, Estimation of inertial parameters of manipulator loads and links, IJRR 5, 1986.
    """
    given = opened(log, robot, degrees)
    remarks = [] if at_rest else given.remarks()
    if at_rest:
        stack = RegressorStack.of(_poses(robot, given), robot.n, 10)
        remarks.append(Remark("identification.at_rest"))
    else:
        motions, _, found = prepare_log(given, bandwidth)
        remarks += found
        stack = RegressorStack.of((block for m in motions for block in _rows(robot, m)), robot.n, 10)
    if stack.rows < 2:
        raise InputError("identification.too_short", seconds=given.duration)
    effort = np.maximum(np.sqrt((given.signals()["tau"] ** 2).mean(axis=0)), NO_EFFORT)
    return _estimate(robot, stack, effort, remarks)


def _estimate(robot: Robot, stack: RegressorStack, effort: Floats, remarks: list[Remark]) -> Payload:
    start = _rough(stack)
    parameterisation = Parameterisation({0: BodyParameterisation.around(start)}, np.zeros(10), start, SPREAD)
    spread = parameterisation.at(np.zeros(10))[1]
    fit = fit_base_parameters(stack, start, spread)
    load = most_likely(parameterisation, fit.triangle, np.eye(10), np.zeros(0, dtype=np.int64))
    body, rates = inertial_of(load), _rates(load)
    errors = np.sqrt(np.einsum("ij,jk,ik->i", rates, fit.covariance, rates))
    before = np.sqrt(((_rates(start) @ spread) ** 2).sum(axis=1))
    certain = bool(fit.b[0] > SIGNIFICANT * fit.standard_errors[0])
    identifiable = (errors < IDENTIFIABLE * before) & certain
    return Payload(
        mass=body.mass,
        com=np.array(body.com),
        inertia=np.array(body.inertia),
        mass_error=float(errors[0]),
        com_error=errors[1:4],
        inertia_error=_tensor(errors[4:]),
        com_identifiable=identifiable[1:4],
        inertia_identifiable=_tensor(identifiable[4:]),
        certain=certain,
        before=100.0 * stack.residual(np.zeros(10)) / effort,
        after=100.0 * stack.residual(load) / effort,
        robot=Robot(with_load(robot.mechanism, load)),
        remarks=tuple(remarks),
    )


def _rows(robot: Robot, motion: SmoothMotion) -> Iterator[Floats]:
    """Blocks (rows, n, 11): efforts per parameter of the load, and what the robot alone does not explain."""

    def rows(part: slice) -> Floats:
        q, qd, qdd = motion.q[part], motion.qd[part], motion.qdd[part]
        rest = motion.tau[part] - robot.inverse_dynamics(q, qd, qdd) - robot.friction_torque(qd)
        return np.concatenate([robot.payload_regressor(q, qd, qdd), rest[..., None]], axis=-1)

    return thin_rows(motion, rows)


def _poses(robot: Robot, log: MotionLog) -> Iterator[Floats]:
    """As `_rows`, for rows at rest, none left out."""
    signals = log.signals()
    for start in range(0, len(log.times), CHUNK):
        q, tau = signals["q"][start : start + CHUNK], signals["tau"][start : start + CHUNK]
        still = np.zeros_like(q)
        rest = tau - robot.gravity_torque(q) - robot.friction_torque(still)
        yield np.concatenate([robot.payload_regressor(q, still, still), rest[..., None]], axis=-1)


def _rough(stack: RegressorStack) -> Floats:
    """A ball with the mass and the centre that the rows ask for without any prior."""
    weight = max(float(stack.size()[:, 0].max()), NO_EFFORT)
    mass = max(float(stack.effort().max()) / weight, LEAST_MASS)
    size = np.array([1.0, *3 * (3 * RADIUS,), *6 * (9 * RADIUS**2,)])
    fit = fit_base_parameters(stack, np.zeros(10), np.diag(10.0 * mass * size))
    heavy = max(float(fit.b[0]), LEAST_SHARE * mass)
    centre = fit.b[1:4] / heavy
    distance = float(np.linalg.norm(centre))
    return ball(heavy, RADIUS, centre * min(1.0, 10 * RADIUS / max(distance, NO_MOTION)))


def _rates(load: Floats) -> Floats:
    """(10, 10) derivatives of mass, centre and inertia about the centre by the ten parameters."""
    m, h = load[0], load[1:4]
    c = h / m
    J = np.eye(10)
    J[1:4, 0], J[1:4, 1:4] = -c / m, np.eye(3) / m
    shift = (c @ c) * np.eye(3) - np.outer(c, c)
    entries = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    for row, (i, j) in enumerate(entries, start=4):
        J[row, 0] = shift[i, j]
        for k in range(3):
            J[row, 1 + k] = -(2 * c[k] * (i == j) - (c[j] * (k == i) + c[i] * (k == j)))
    return J


def _tensor(six: NDArray[Any]) -> NDArray[Any]:
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
