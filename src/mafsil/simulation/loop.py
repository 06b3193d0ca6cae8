"""The closed loop: sense, decide, move, record; in Python, or compiled as a whole."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import cast

import numpy as np

from mafsil.arrays import Floats, JointVector, require_function, require_kind
from mafsil.control import saturated
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.simulation.disturbance import push_at
from mafsil.simulation.fused import WORTH, FusedLoop, can_fuse
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.stepping import Stepper
from mafsil.trajectory import Motion
from mafsil.version import __version__

RUNAWAY = 1e6
"""Root mean square joint rate [rad/s | m/s] beyond which a run counts as blown up."""

PIECE = 150_000
"""Ticks times batch that compiled code runs without a break: at most some tenths of a second."""

Progress = Callable[[float], object]


def simulate(scenario: Scenario, progress: Progress | None = None, *, fused: bool | None = None) -> Recording:
    """Run a scenario.

    The law sees the state (with sensor noise) once every control period; its efforts are clipped and kept constant
    while the plant is integrated with the fixed step. Where law and plant are expressions, the whole loop can run as
    compiled code; it agrees with the general loop to rounding.

    Args:
        scenario: what to run.
        progress: called with the fraction done, about a hundred times; the run stops if it returns False.
        fused: whether the loop is compiled as a whole; None compiles long runs of laws that allow it.

    Returns:
        The recording up to the end, or up to the last good state if the motion blows up or is cancelled; its status
        says which.

    Raises:
        InputError: the law returns efforts of a wrong shape; progress cannot be called; `fused` is asked of a law or a
            number of substeps that cannot be compiled.
    """
    require_kind("scenario", scenario, "Scenario", "trajectory", "law", "ticks")
    if progress is not None:
        require_function("progress", progress, "function of the fraction done", 1)
    if fused not in (None, True, False):
        raise InputError("input.choice", name="fused", value=fused, known="None, True, False")
    began = perf_counter()
    run = _FusedRun(scenario) if _is_fused(scenario, fused) else _Run(scenario)
    status = run.to_the_end(progress)
    return run.recording(status, perf_counter() - began)


def _is_fused(scenario: Scenario, requested: bool | None) -> bool:
    if requested is False:
        return False
    states = max(1, scenario.start()[0].size // scenario.robot.n)
    if requested is None and scenario.length / scenario.control_period * states < WORTH:
        return False
    possible = can_fuse(scenario)
    if requested and not possible:
        raise InputError("simulation.not_fused", law=type(scenario.law).__name__, substeps=scenario.substeps)
    return possible


class _Run:
    """The arrays and clocks of one run, tick by tick in Python."""

    fused = False

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.t = scenario.ticks()
        self.reference = scenario.trajectory.at(self.t)
        self.start = scenario.start()
        self.pushes = push_at(scenario.disturbances, self.t)
        self.noise = None if scenario.noise is None else scenario.noise.drawn(len(self.t), self.start[0].shape)
        self.stepper = Stepper(scenario.true_plant, scenario.chosen_integrator, scenario.step)
        self.done = 0
        self._allocate()

    def _allocate(self) -> None:
        self.q, self.qd, self.commanded, self.tau = np.empty((4, len(self.t), *self.start[0].shape))

    @property
    def runaway(self) -> float:
        """Sum of squared rates beyond which the run has blown up."""
        return RUNAWAY**2 * max(self.start[0].size, 1)

    def to_the_end(self, progress: Progress | None) -> SimulationStatus:
        """The loop; every tick costs a handful of array operations."""
        scenario, stepper = self.scenario, self.stepper
        law, step = scenario.law.session(scenario.control_period), stepper.move()
        limit = scenario.robot.limits.effort if scenario.saturate else None
        h, substeps, last = scenario.step, scenario.substeps, len(self.t) - 1
        runaway, every = self.runaway, max(1, last // 100)
        references = [Motion(*row) for row in zip(*self.reference, strict=True)]
        q, qd = self.start
        for k, t in enumerate(self.t.tolist()):
            if self.noise is None:
                command = law(t, q, qd, references[k])
            else:
                command = law(t, q + self.noise[0][k], qd + self.noise[1][k], references[k])
            if k == 0:
                _require_efforts(command, q)
            effort = command if limit is None else saturated(command, limit)
            self.q[k], self.qd[k], self.commanded[k], self.tau[k] = q, qd, command, effort
            if progress is not None and k % every == 0 and progress(k / max(last, 1)) is False:
                return self._ended(k, SimulationStatus.CANCELLED)
            if k == last:
                break
            stepper.effort, stepper.push = effort, self.pushes[k]
            try:
                for i in range(substeps):
                    q, qd = step(t + i * h, (q, qd), h)
            except InputError:
                # Single calls refuse NaN; in batches it shows in the rates below.
                qd = np.full_like(qd, np.nan)
            # Also false for NaN: the law never sees one.
            if not np.vdot(qd, qd) <= runaway:
                return self._ended(k, SimulationStatus.BLOWN_UP)
        return self._ended(last, SimulationStatus.COMPLETED)

    def _ended(self, k: int, status: SimulationStatus) -> SimulationStatus:
        """Keep the ticks up to k; tick k itself only with finite efforts, without which it is the law that failed."""
        effort: Floats = np.asarray(self.tau[k])
        healthy = bool(np.isfinite(np.vdot(effort, effort)))
        self.done = k + healthy
        return status if healthy or status is SimulationStatus.CANCELLED else SimulationStatus.NOT_FINITE

    def recording(self, status: SimulationStatus, seconds: float) -> Recording:
        """What was recorded, with what follows from it: accelerations and tip errors."""
        kept = slice(0, self.done)
        q, qd, tau = self.q[kept], self.qd[kept], self.tau[kept]
        u, v, a = (np.broadcast_to(_aligned(part[kept], q), q.shape) for part in self.reference)
        distance, angle = self._tip_errors(q, u)
        return Recording(
            t=self.t[kept],
            q=q,
            qd=qd,
            qdd=self._accelerations(q, qd, tau),
            q_ref=u,
            qd_ref=v,
            qdd_ref=a,
            tau=tau,
            tau_commanded=self.commanded[kept],
            tip_position_error=distance,
            tip_rotation_error=angle,
            status=status,
            metadata=_metadata(self, seconds),
        )

    def _tip_errors(self, q: Floats, u: Floats) -> tuple[Floats, Floats]:
        """Distance and angle (k, *batch) of the tip from the reference tip."""
        T, T_desired = (self.scenario.robot.forward_kinematics(x) for x in (q, u))
        distance = np.linalg.norm(T_desired[..., :3, 3] - T[..., :3, 3], axis=-1)
        return distance, np.asarray(rotation.angle_between(T[..., :3, :3], T_desired[..., :3, :3]))

    def _accelerations(self, q: Floats, qd: Floats, tau: Floats) -> Floats:
        return self.stepper.acceleration(q, qd, tau, self._pushes(q))

    def _pushes(self, q: Floats) -> Floats | None:
        """(k, *batch, 6) the pushes of all ticks of q (k, *batch, n), or None if there are none."""
        if not self.scenario.disturbances or not any(push is not None for push in self.pushes[: len(q)]):
            return None
        still = np.zeros((*q.shape[1:-1], 6))
        return np.stack([still if push is None else still + push for push in self.pushes[: len(q)]])


class _FusedRun(_Run):
    """The same run as compiled code."""

    fused = True

    def _allocate(self) -> None:
        shape, n, ticks = self.start[0].shape, self.scenario.robot.n, len(self.t)
        reference = np.stack(np.broadcast_arrays(*self.reference), axis=-2)
        if reference.ndim > 3:
            reference = np.broadcast_to(_aligned(reference, np.empty((0, *shape, 0))), (ticks, *shape[:-1], 3, n))
        push = self._pushes(np.empty((ticks, *shape)))
        noise = None if self.noise is None else np.stack(self.noise, axis=-2).reshape(ticks, -1, 2, n)
        self.loop = FusedLoop(
            self.scenario,
            ticks,
            reference.reshape(ticks, -1, 3, n),
            None if push is None else push.reshape(ticks, -1, 6),
            noise,
        )
        loop = self.loop
        self.q, self.qd = (loop.states[:ticks, :, part].reshape(ticks, *shape) for part in (0, 1))
        self.commanded, self.tau = loop.command.reshape(ticks, *shape), loop.effort.reshape(ticks, *shape)

    def to_the_end(self, progress: Progress | None) -> SimulationStatus:
        """The loop in pieces, between which progress is reported and Ctrl-C is heard."""
        ticks, last = len(self.t), len(self.t) - 1
        piece = max(1, PIECE // max(1, self.loop.states.shape[1]))
        every = max(1, last // 100)
        piece = piece if progress is None else min(piece, every)
        first = 0
        while first < ticks:
            end = min(first + piece, ticks)
            self.loop.advance(first, end)
            rates = self.loop.states[first + 1 : end + 1, :, 1]
            with np.errstate(over="ignore", invalid="ignore"):
                good = np.einsum("kbi,kbi->k", rates, rates) <= self.runaway
            if end == ticks:
                good[-1] = True
            if not good.all():
                return self._ended(first + int(np.argmin(good)), SimulationStatus.BLOWN_UP)
            if progress is not None and progress(min(end, last) / max(last, 1)) is False:
                return self._ended(end - 1, SimulationStatus.CANCELLED)
            first = end
        return self._ended(last, SimulationStatus.COMPLETED)

    def _tip_errors(self, q: Floats, u: Floats) -> tuple[Floats, Floats]:
        errors = self.loop.tip_errors[: len(q)].reshape(*q.shape[:-1], 2)
        return errors[..., 0], errors[..., 1]

    def _accelerations(self, q: Floats, qd: Floats, tau: Floats) -> Floats:
        return self.loop.acceleration[: len(q)].reshape(q.shape)


def _aligned(part: Floats, q: Floats) -> Floats:
    """A reference (k, n) for a batch of states (k, *batch, n)."""
    return part.reshape(part.shape[0], *(1,) * (q.ndim - part.ndim), *part.shape[1:])


def _require_efforts(command: object, q: JointVector) -> None:
    got = cast("Floats", command).shape if isinstance(command, np.ndarray) else type(command).__name__
    if got != q.shape:
        raise InputError("simulation.efforts", expected=q.shape, got=got)


def _metadata(run: _Run, seconds: float) -> dict[str, object]:
    """What one needs to know besides the numbers."""
    scenario = run.scenario
    return {
        "version": __version__,
        "robot": scenario.robot.name,
        "joints": list(scenario.robot.joint_names),
        "integrator": run.stepper.name,
        "step": scenario.step,
        "period": scenario.control_period,
        "end": float(run.t[-1]),
        "saturate": scenario.saturate,
        "noise_seed": None if scenario.noise is None else scenario.noise.seed,
        "friction_stiffness": scenario.stiffness,
        "fused": run.fused,
        "seconds": seconds,
    }
