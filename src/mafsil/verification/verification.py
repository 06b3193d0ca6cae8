"""The checks of a robot and what `verify` makes of them: one per routine and method, and what the worst one means.

Those that stand here are of what a robot makes of its quantities: task-space dynamics, friction, base parameters, the
way back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, Literal, TypeAlias

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.arm_size import RATE, ArmSize
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantity import States
from mafsil.mechanics.textbook import Textbook, along
from mafsil.messages import say
from mafsil.robot import Robot
from mafsil.verification.tolerances import CONDITION


class Agreement(Status):
    """How the checks of a robot ended."""

    AGREES = ("verification.all_agree", True)
    DIFFERS = ("verification.some_differ", False)
    INCOMPLETE = ("verification.incomplete", False)


UNCHECKED = "verification.loops_not_found"
"""Reason of what was not compared without which nobody may say that all agrees."""


@dataclass(frozen=True, slots=True)
class Check:
    """One routine, called in one way, compared with one method.

    Attributes:
        routine: such as `inverse_dynamics(tip_wrench)`.
        method: key of the sentence that says how the other number was made.
        error: worst difference, relative to the robot's natural size or the largest entry of the state.
        limit: what rounding may cost.
        state: number of the worst state.
        reason: why there is no number (a refusal of the routine, confirmed by the other method), or empty.
    """

    routine: str
    method: str
    error: float
    limit: float
    state: int = 0
    reason: str = ""

    @property
    def passed(self) -> bool:
        """Both methods agree; NaN agrees with nothing."""
        return isfinite(self.error) and self.error <= self.limit

    def sentence(self, language: str | None = None) -> str:
        """Routine, method, error and verdict in words."""
        key = (
            "verification.refused" if self.reason else "verification.agrees" if self.passed else "verification.differs"
        )
        return say(
            key,
            language=language,
            routine=self.routine,
            method=say(self.method, language=language),
            error=f"{self.error:.1e}",
            limit=f"{self.limit:.0e}",
            state=self.state,
            reason=self.reason,
        )


@dataclass(frozen=True, slots=True)
class Verification(Answer, entries="checks"):
    """All checks of one robot: true if all agree, iterable over the checks, a table when printed.

    Attributes:
        robot: its name.
        checks: in the order of the catalogue.
        states: how many random states.
        seed: of the states.
        left_out: routines that were not compared, with the key of the reason.
        peers: other libraries that could be compared with, with the key of the sentence that says whether this one was.
    """

    robot: str
    checks: tuple[Check, ...]
    states: int
    seed: int
    left_out: tuple[tuple[str, str], ...] = ()
    peers: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        return self.explain()

    @property
    def status(self) -> Agreement:
        """Whether every routine agrees with its independent method."""
        if not (self.checks and all(check.passed for check in self.checks)):
            return Agreement.DIFFERS
        return Agreement.INCOMPLETE if any(key == UNCHECKED for _, key in self.left_out) else Agreement.AGREES

    @property
    def ok(self) -> bool:
        """Every routine agrees with its independent method."""
        return bool(self)

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that do not agree."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def worst(self) -> Check:
        """The check with the largest error in units of its limit."""
        return max(self.checks, key=lambda check: check.error / check.limit if isfinite(check.error) else float("inf"))

    def explain(self, language: str | None = None) -> str:
        """The verdict, every disagreement, and what was left out."""
        lines = [
            self.status.sentence(
                language,
                robot=self.robot,
                checks=len(self.checks),
                failed=len(self.failed),
                states=self.states,
                seed=self.seed,
                worst=f"{self.worst.error:.1e}",
                routine=self.worst.routine,
            )
        ]
        lines += [f"  {check.sentence(language)}" for check in self.checks if not check.passed or check.reason]
        lines += [
            "  " + say("verification.left_out", language=language, routine=routine, reason=say(key, language=language))
            for routine, key in self.left_out
        ]
        lines += ["  " + say(key, language=language, peer=peer) for peer, key in self.peers]
        return "\n".join(lines)

    def table(self, language: str | None = None) -> list[tuple[str, str, str, str, str]]:
        """Rows of text: routine, method, error, limit, verdict."""
        return [
            (
                check.routine,
                say(check.method, language=language),
                "" if check.reason else f"{check.error:.1e}",
                f"{check.limit:.0e}",
                say("verification.yes" if check.passed else "verification.no", language=language),
            )
            for check in self.checks
        ]

    def to_dict(self) -> dict[str, Any]:
        """Plain data, fit for JSON."""
        return {
            "robot": self.robot,
            "ok": self.ok,
            "states": self.states,
            "seed": self.seed,
            "checks": [
                {
                    "routine": check.routine,
                    "method": check.method.removeprefix("verification."),
                    "error": check.error,
                    "limit": check.limit,
                    "passed": check.passed,
                    "state": check.state,
                    "reason": check.reason,
                }
                for check in self.checks
            ],
            "left_out": [{"routine": routine, "reason": say(key, language="en")} for routine, key in self.left_out],
            "peers": {peer: key.removeprefix("verification.peer_") for peer, key in self.peers},
        }


LeftOut: TypeAlias = list[tuple[str, str]]
"""Routines that were not compared, with the key of the reason."""


def composed_checks(
    robot: Robot, book: Textbook, size: ArmSize, s: States, limit: float
) -> tuple[list[Check], LeftOut]:
    """Each with the routine's name and the sentence of its method; and what was not compared.

    Args:
        robot, book, size: the robot, its second methods and its size.
        s: states.
        limit: relative error allowed.
    """
    checks = [_power(robot, size, s, limit), _passivity(robot, size, s, limit), *_friction(robot, book, s, limit)]
    checks.append(_base_parameters(robot, book, size, s, limit))
    left_out: LeftOut = []
    for name, check in (("forward_dynamics (way back)", _round_trip), ("task_space", _task_space)):
        try:
            found = check(robot, book, s, limit)
        except ModelError:
            left_out.append((name, "verification.no_inverse"))
            continue
        checks += found
        left_out += [] if found else [(name, "verification.no_margin")]
    return checks, left_out


def _power(robot: Robot, size: ArmSize, s: States, limit: float) -> Check:
    """tau . qd = d(K + P)/dt, the energies of the second method differentiated along the motion."""
    tau = robot.inverse_dynamics(s.q, s.qd, s.qdd)
    book = Textbook(robot.mechanism)
    kinetic = np.einsum("bi,bij,bj->b", s.qd, book.mass_matrix(s.q), s.qdd)
    kinetic += np.einsum("bi,bij,bj->b", s.qd, along(book.mass_matrix, s.q, s.qd), s.qd) / 2
    lifted = along(book.potential_energy, s.q, s.qd)
    power = np.abs(np.einsum("bi,bi->b", tau, s.qd) - kinetic - lifted)
    largest = np.maximum(RATE * size.moment, np.einsum("bi,bi->b", np.abs(tau), np.abs(s.qd)))
    return _check("inverse_dynamics . qd", "verification.power", power / largest, limit)


def _passivity(robot: Robot, size: ArmSize, s: States, limit: float) -> Check:
    """dM/dt - 2 C is skew-symmetric, dM/dt by the complex step."""
    N = along(Textbook(robot.mechanism).mass_matrix, s.q, s.qd) - 2 * robot.coriolis_matrix(s.q, s.qd)
    entry = quantity("coriolis_matrix").size(size)
    return _check("coriolis_matrix (passivity)", "verification.skew", (N + np.swapaxes(N, 1, 2)) / entry, limit)


def _friction(robot: Robot, book: Textbook, s: States, limit: float) -> list[Check]:
    """Joint by joint from the description, by virtual work of all that move; the regressor for the leaders alone."""
    torque, own, numbers, smoothing = np.zeros_like(s.qd), np.zeros_like(s.qd), np.zeros((3, robot.n)), 1e-3
    names = robot.joint_names
    for k, joint in enumerate(robot.mechanism.joints):
        if joint.friction is None or not joint.moves:
            continue
        f, rate = joint.friction, s.qd @ book.share[k]
        below = f.coulomb if f.coulomb_negative is None else f.coulomb_negative
        steep = np.tanh(rate / smoothing)
        effort = f.viscous * rate + np.where(rate > 0, f.coulomb, below) * steep + f.offset
        torque += effort[:, None] * book.share[k]
        if joint.mimic is None:
            column = names.index(joint.name)
            numbers[:, column] = f.viscous, f.coulomb, f.offset
            own[:, column] = f.viscous * rate + f.coulomb * steep + f.offset
    size = max(1.0, float(np.abs(torque).max()))
    ours = robot.friction_torque(s.qd, smoothing=smoothing)
    product = robot.friction_regressor(s.qd, smoothing=smoothing) @ numbers.ravel()
    return [
        _check("friction_torque", "verification.by_joint", (ours - torque) / size, limit),
        _check("friction_regressor", "verification.by_joint", (product - own) / size, limit),
    ]


def _base_parameters(robot: Robot, book: Textbook, size: ArmSize, s: States, limit: float) -> Check:
    """Efforts from the regressor's independent columns alone, times their combined parameters."""
    base = robot.base_parameters()
    resting = replace(s, base_twist=None, base_acceleration=None)
    Y = quantity("regressor").second.value(book, resting).reshape(len(s.q), robot.n, -1)[..., list(base.columns)]
    tau = Y @ (base.combination @ robot.inertial_parameters.ravel())
    rotors = book.rotors(s.q, s.qd, s.qdd)
    gap = (tau + rotors - robot.inverse_dynamics(s.q, s.qd, s.qdd)) / size.effort
    return _check("base_parameters", "verification.unit_bodies", gap, limit)


def _round_trip(robot: Robot, book: Textbook, s: States, limit: float) -> list[Check]:
    """Efforts of the accelerations that efforts produce."""
    assert s.tip_wrench is not None
    qdd = robot.forward_dynamics(s.q, s.qd, s.tau, s.tip_wrench)
    back = book.newton_euler(s.q, s.qd, qdd, s.tip_wrench).tau
    size = np.abs(s.tau) + np.einsum("bij,bj->bi", np.abs(book.mass_matrix(s.q)), np.abs(qdd))
    ratio = (back - s.tau) / np.maximum(size, LEAST_DIVISOR)
    return [_check("forward_dynamics (way back)", "verification.newton_euler", ratio, limit)]


def _task_space(robot: Robot, book: Textbook, s: States, limit: float) -> list[Check]:
    """Lambda, mu and p by solving, and F -> dV -> F, in both frames, for as many rows as the arm can move freely."""
    rows = tuple(range(6)) if robot.n >= 6 else (3, 4, 5)[: max(1, min(robot.n, 3))]
    M, g = book.mass_matrix(s.q), quantity("gravity_torque").second.value(book, s)
    c = quantity("velocity_torque").second.value(book, s)
    checks: list[Check] = []
    frames: tuple[tuple[Literal["body", "space"], Callable[..., Floats]], ...] = (
        ("body", book.jacobian_body),
        ("space", book.jacobian_space),
    )
    for name, jacobian in frames:
        task = robot.task_space(s.q, s.qd, expressed_in=name, rows=rows)
        good = ~task.singular & (task.margin > CONDITION)
        if not good.any():
            continue
        J, dJ = jacobian(s.q)[:, rows][good], along(jacobian, s.q, s.qd)[:, rows][good]
        Minv: Floats = np.linalg.inv(M[good]).astype(np.float64, copy=False)
        inverse = J @ Minv @ np.swapaxes(J, 1, 2)
        Lambda: Floats = np.linalg.inv(inverse).astype(np.float64, copy=False)
        back = Lambda @ J @ Minv
        drift = np.einsum("bij,bj->bi", dJ, s.qd[good])
        eta = np.einsum("bij,bj->bi", back, (c + g)[good]) - np.einsum("bij,bj->bi", Lambda, drift)
        gaps = [
            _relative(task.Lambda[good], Lambda),
            _relative(task.eta[good], eta),
            _relative(task.mu[good] + task.p[good], eta),
            _relative(task.J_bar[good], np.swapaxes(back, 1, 2)),
        ]
        dV = np.ones((len(s.q), len(rows)))
        gaps.append(_relative(task.acceleration(task.force(dV))[good], dV[good]))
        worst = np.max(gaps, axis=0) * task.margin[good]
        checks.append(_check(f"task_space({name})", "verification.khatib", worst, limit))
    return checks


def _relative(a: Floats, b: Floats) -> Floats:
    """(b,) largest difference of each state over the largest entry."""
    core = tuple(range(1, b.ndim))
    return np.abs(a - b).max(axis=core) / np.maximum(np.abs(b).max(axis=core), LEAST_DIVISOR)


def _check(routine: str, method: str, ratio: Floats, limit: float) -> Check:
    flat = np.abs(ratio).reshape(len(ratio), -1).max(axis=1)
    flat = np.where(np.isfinite(flat), flat, np.inf)
    return Check(routine, method, float(flat.max()), limit, int(flat.argmax()))
