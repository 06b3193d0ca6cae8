"""The closed loop: sense, decide, move, record."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from time import perf_counter

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6, require_kind
from mafsil.control import saturated
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.simulation.disturbance import push_at
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.scenario import Scenario
from mafsil.solvers import method, second_order
from mafsil.trajectory import Motion

RUNAWAY = 1e6
"""Root mean square joint rate [rad/s | m/s] beyond which a run counts as blown up."""

Progress = Callable[[float], object]


def simulate(scenario: Scenario, progress: Progress | None = None) -> Recording:
    """Run a scenario.

    The law sees the state (with sensor noise) once every control period; its efforts are clipped and held while the
    plant is integrated with the fixed step.

    Args:
        scenario: what to run.
        progress: called with the fraction done, about a hundred times; the run stops if it returns False.

    Returns:
        The recording up to the end, or up to the last good state if the motion blows up or is cancelled; its status
        says which.

    Raises:
        InputError: the law returns efforts of a wrong shape.
    """
    require_kind("scenario", scenario, "Scenario", "trajectory", "law", "ticks")
    began = perf_counter()
    run = _Run(scenario)
    status = run.to_the_end(progress)
    return run.recording(status, perf_counter() - began)


class _Run:
    """The arrays and clocks of one run."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.plant = scenario.true_plant
        self.t = scenario.ticks()
        self.reference = scenario.trajectory.at(self.t)
        self.start = scenario.start()
        shape = self.start[0].shape
        self.q, self.qd, self.commanded, self.tau = np.empty((4, len(self.t), *shape))
        self.pushes = push_at(scenario.disturbances, self.t)
        self.noise = None if scenario.noise is None else scenario.noise.drawn(len(self.t), shape)
        self.done = 0
        self.push: Vector6 | None = None
        self.effort = np.zeros(shape)

    def to_the_end(self, progress: Progress | None) -> SimulationStatus:
        """The loop; every tick costs a handful of array operations."""
        scenario = self.scenario
        law = scenario.law.session(scenario.control_period)
        step = second_order(method(scenario.integrator), self._acceleration)
        limit = scenario.robot.limits.effort if scenario.saturate else None
        h, substeps, last = scenario.step, scenario.substeps, len(self.t) - 1
        runaway = RUNAWAY**2 * max(self.start[0].size, 1)
        every = max(1, last // 100)
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
                self.done = k + isfinite(np.vdot(effort, effort))
                return SimulationStatus.CANCELLED
            if k == last:
                break
            self.effort, self.push = effort, self.pushes[k]
            try:
                for i in range(substeps):
                    q, qd = step(t + i * h, (q, qd), h)
            except InputError:
                # Single calls refuse NaN; in batches it shows in the rates below.
                qd = np.full_like(qd, np.nan)
            # Also false for NaN: the law never sees one.
            if not np.vdot(qd, qd) <= runaway:
                healthy = isfinite(np.vdot(effort, effort))
                self.done = k + healthy
                return SimulationStatus.BLOWN_UP if healthy else SimulationStatus.NOT_FINITE
        healthy = isfinite(np.vdot(self.tau[last], self.tau[last]))
        self.done = last + healthy
        return SimulationStatus.COMPLETED if healthy else SimulationStatus.NOT_FINITE

    def recording(self, status: SimulationStatus, seconds: float) -> Recording:
        """What was recorded, with what follows from it: accelerations and tip errors."""
        scenario, kept = self.scenario, slice(0, self.done)
        q, qd, tau = self.q[kept], self.qd[kept], self.tau[kept]
        u, v, a = (np.broadcast_to(_aligned(part[kept], q), q.shape) for part in self.reference)
        T, T_wanted = (scenario.robot.forward_kinematics(x) for x in (q, u))
        twist = pose.error(T, T_wanted)
        return Recording(
            t=self.t[kept],
            q=q,
            qd=qd,
            qdd=self.plant.acceleration(q, qd, tau, self._pushes(q)),
            q_ref=u,
            qd_ref=v,
            qdd_ref=a,
            tau=tau,
            tau_commanded=self.commanded[kept],
            tip_position_error=np.linalg.norm(T_wanted[..., :3, 3] - T[..., :3, 3], axis=-1),
            tip_rotation_error=np.linalg.norm(twist[..., :3], axis=-1),
            status=status,
            metadata=_metadata(scenario, seconds, float(self.t[-1])),
        )

    def _acceleration(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        return self.plant.acceleration(q, qd, self.effort, self.push)

    def _pushes(self, q: Floats) -> Floats | None:
        """(k, *batch, 6) the pushes of all ticks, or None if there are none."""
        if not any(push is not None for push in self.pushes[: self.done]):
            return None
        still = np.zeros((*q.shape[1:-1], 6))
        return np.stack([still if push is None else still + push for push in self.pushes[: self.done]])


def _aligned(part: Floats, q: Floats) -> Floats:
    """A reference (k, n) for a batch of states (k, *batch, n)."""
    return part.reshape(part.shape[0], *(1,) * (q.ndim - part.ndim), *part.shape[1:])


def _require_efforts(command: object, q: JointVector) -> None:
    if not isinstance(command, np.ndarray) or command.shape != q.shape:
        got = command.shape if isinstance(command, np.ndarray) else type(command).__name__
        raise InputError("simulation.efforts", expected=q.shape, got=got)


def _metadata(scenario: Scenario, seconds: float, end: float) -> dict[str, object]:
    """What one needs to know besides the numbers."""
    from mafsil import __version__

    return {
        "version": __version__,
        "robot": scenario.robot.name,
        "joints": list(scenario.robot.joint_names),
        "integrator": scenario.integrator,
        "step": scenario.step,
        "period": scenario.control_period,
        "end": end,
        "saturate": scenario.saturate,
        "noise_seed": None if scenario.noise is None else scenario.noise.seed,
        "seconds": seconds,
    }
