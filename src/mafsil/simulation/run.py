"""One run tick by tick in Python: sense, decide, move, record; or a motion passed exactly as it is planned."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.control import saturate
from mafsil.control.contact import tip_wrench_of
from mafsil.control.contact.tip_sensor import pushed_by
from mafsil.control.laws import LawMemory
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import rotation
from mafsil.kernels.lazy import lazy
from mafsil.robot import Robot
from mafsil.simulation.clock import RealTime
from mafsil.simulation.closed_plant import LoopsLost, stepper_of
from mafsil.simulation.faults import law_efforts, law_name, require_efforts, require_measured, task_of
from mafsil.simulation.live_log import RunListener
from mafsil.simulation.point_contact import NoContactForce
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.stepping import Stepper
from mafsil.simulation.stored_arrays import KINEMATIC
from mafsil.simulation.tolerances import PART_OF_STEP
from mafsil.simulation.variation import push_at
from mafsil.trajectory import Motion, Trajectory
from mafsil.version import __version__

if TYPE_CHECKING:
    from mafsil.control import Law


RUNAWAY = 1e6
"""Root mean square joint rate [rad/s | m/s] beyond which a run counts as blown up."""
MOST_LOOKED_AT, NEAR_SINGULAR = 5_000, 0.02
"""Ticks that are looked at, and the ratio of singular values of the tip's Jacobian below which a pose is named."""
Progress = Callable[[float], object]


class Run:
    """The arrays and clocks of one run, tick by tick in Python."""

    fused = False

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.t = scenario.ticks()
        self.reference = scenario.trajectory.at(self.t)
        for part in self.reference:
            part.setflags(write=False)
        self.start = scenario.start()
        self.pushes = push_at(scenario.disturbances, self.t)
        self.pushed = any(push is not None for push in self.pushes)
        self.noise = self._noise()
        self.stepper = self._stepper()
        self.done = self.tick = 0
        self.fault = ""
        self.clock: RealTime | None = None
        self.log: RunListener | None = None
        self.memory: LawMemory | None = None
        self.logged: int = 0
        self._allocate()

    def _stepper(self) -> Stepper:
        scenario = self.scenario
        return stepper_of(scenario.true_plant, scenario.chosen_integrator, scenario.step)

    def _noise(self) -> tuple[Floats, Floats] | None:
        """Of every tick; of runs that differ each its own, whatever runs beside it."""
        scenario, shape = self.scenario, self.start[0].shape
        if scenario.noise is None:
            return None
        if scenario.variants is None:
            return scenario.noise.drawn(len(self.t), shape)
        return scenario.variants.noise_of(scenario.noise, len(self.t), shape[-1])

    def _allocate(self) -> None:
        self.q, self.qd, self.commanded, self.tau = np.empty((4, len(self.t), *self.start[0].shape))

    @lazy
    def runaway(self) -> float:
        """Sum of squared rates beyond which the run has blown up."""
        return RUNAWAY**2 * max(self.start[0].size, 1)

    def to_the_end(self, progress: Progress | None) -> SimulationStatus:
        """The loop; every tick costs a handful of array operations."""
        scenario, stepper = self.scenario, self.stepper
        memory = self.memory or LawMemory()
        law, step = memory.begun(scenario.acting_law, scenario.control_period), stepper.move()
        limit = scenario.robot.limits.effort if scenario.saturate else None
        h, substeps, last = scenario.step, scenario.substeps, len(self.t) - 1
        every = max(1, last // 100)
        references = [Motion(*row) for row in zip(*self.reference, strict=True)]
        q, qd = self.start
        clock, log = self.clock, self.log
        for k, t in enumerate(self.t.tolist()):
            if clock is not None:
                clock.begin()
            self.tick = k
            command = self._command(law, k, t, q, qd, references[k])
            if clock is not None:
                clock.end_law()
            self._require_finite(t, command)
            command = self._acting(k, command)
            effort = command if limit is None else saturate(command, limit)
            self.q[k], self.qd[k], self.commanded[k], self.tau[k] = q, qd, command, effort
            if log is not None and log.is_due():
                self._keep(log, k)
            if progress is not None and k % every == 0 and progress(k / max(last, 1)) is False:
                return self._end(k, SimulationStatus.CANCELLED)
            if k == last:
                break
            stepper.effort, stepper.push = effort, self.pushes[k]
            try:
                for i in range(substeps):
                    q, qd = step(t + i * h, (q, qd), h)
            except LoopsLost as lost:
                return self._lost(k, lost)
            except NoContactForce as none:
                return self.stop(SimulationStatus.NO_CONTACT_FORCE, none.message())
            except InputError:
                # Single calls refuse NaN; in batches it shows in the rates below.
                qd = np.full_like(qd, np.nan)
            if clock is not None:
                clock.end()
            if not self._sound(k, q, qd):
                return self._end(k, SimulationStatus.BLOWN_UP)
        return self._end(last, SimulationStatus.COMPLETED)

    def _command(self, law: Law, k: int, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """What the law asks for at tick k, from what the sensors say; those of force feel the pushes."""
        whole = self.scenario.law
        if self.noise is not None:
            q, qd = q + self.noise[0][k], qd + self.noise[1][k]
            require_measured(t, q, qd, self.scenario.robot.joint_names, whole)
        if not self.pushed:
            return law_efforts(law, t, q, qd, reference, whole)
        with pushed_by(lambda: self.pushes[k]):
            return law_efforts(law, t, q, qd, reference, whole)

    def _require_finite(self, t: float, command: JointVector) -> None:
        require_efforts(t, command, self.scenario.law)

    def stop(self, status: SimulationStatus, fault: str = "") -> SimulationStatus:
        """Keep the ticks before the present one.

        Args:
            status: why the run stops.
            fault: in a few words.
        """
        self.done, self.fault = self.tick, fault
        return status

    def _lost(self, k: int, lost: LoopsLost) -> SimulationStatus:
        self.fault = lost.message()
        return self._end(k, SimulationStatus.LOOPS_LOST)

    def _acting(self, k: int, command: JointVector) -> JointVector:
        """What acts at tick k of the commands so far."""
        return command

    def _sound(self, k: int, q: JointVector, qd: JointVector) -> bool:
        """Whether the run goes on from the state after tick k. Also false for NaN: the law never sees one."""
        return bool(np.vdot(qd, qd) <= self.runaway)

    def _end(self, k: int, status: SimulationStatus) -> SimulationStatus:
        """Keep the ticks up to k; tick k itself only with finite efforts, without which it is the law that failed."""
        effort: Floats = np.asarray(self.tau[k])
        healthy = bool(np.isfinite(np.vdot(effort, effort)))
        self.done = k + healthy
        return status if healthy or status is SimulationStatus.CANCELLED else SimulationStatus.NOT_FINITE

    def recording(self, status: SimulationStatus, seconds: float) -> Recording:
        """What was recorded, with what follows from it: accelerations and tip errors."""
        rows = self.rows(0, self.done)
        metadata = self.metadata() | {"seconds": seconds} | self._near_singular(rows["q"])
        return Recording(**rows, status=status, metadata=metadata)

    def begin_log(self) -> None:
        """Say in the log, if there is one, that the run begins."""
        if self.log is not None:
            self.log.begin(self.metadata())

    def end_log(self, recording: Recording) -> None:
        """Write the last ticks into the log, if there is one, and how the run ended.

        Args:
            recording: of the run.
        """
        if self.log is not None:
            self._keep(self.log, self.done)
            self.log.end(recording.metadata | {"status": recording.status.name})

    def _keep(self, log: RunListener, last: int) -> None:
        """Write the ticks before tick `last` into the log."""
        if last > self.logged:
            log.add(self.rows(self.logged, last))
            self.logged = last

    def rows(self, first: int, last: int) -> dict[str, Floats]:
        """The arrays of a recording, by name, for the ticks first .. last - 1."""
        kept = slice(first, last)
        q, qd, tau = self.q[kept], self.qd[kept], self.tau[kept]
        u, v, a = (np.broadcast_to(align_reference(part[kept], q), q.shape) for part in self.reference)
        distance, angle = self.tip_errors(kept, q, u)
        contact = self._contact(kept, q, qd, tau)
        return {
            "t": self.t[kept],
            "q": q,
            "qd": qd,
            "qdd": self._accelerations(kept, q, qd, tau),
            "q_ref": u,
            "qd_ref": v,
            "qdd_ref": a,
            "tau": tau,
            "tau_commanded": self.commanded[kept],
            "tip_position_error": distance,
            "tip_rotation_error": angle,
            **({} if contact is None else {"contact_wrench": contact}),
        }

    def _near_singular(self, q: Floats) -> dict[str, object]:
        """Where a law of the tip came near a pose at which the tip loses a direction."""
        task = task_of(self.scenario.law)
        if task is None or not len(q):
            return {}
        every = max(1, q[..., 0].size // MOST_LOOKED_AT)
        J = task.jacobian(self.scenario.robot, q[::every])
        sizes = np.linalg.svd(J, compute_uv=False)
        ratio = (sizes[..., -1] / np.maximum(sizes[..., 0], LEAST_DIVISOR)).reshape(len(J), -1).min(axis=1)
        worst = int(ratio.argmin())
        if ratio[worst] >= NEAR_SINGULAR:
            return {}
        return {"near_singular": {"ratio": float(ratio[worst]), "time": float(self.t[worst * every])}}

    def _contact(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats | None:
        """(k, *batch, 6) what the environment exerts on the tip."""
        plant = self.scenario.true_plant
        return None if plant.environment is None else tip_wrench_of(plant.robot, plant.environment, q, qd)

    def tip_errors(self, kept: slice, q: Floats, u: Floats) -> tuple[Floats, Floats]:
        """Distance and angle (k, *batch) of the tip from the reference tip.

        Args:
            kept: the k ticks.
            q, u: (k, *batch, n) where the arm is there and where it should be.
        """
        T, T_desired = (self.scenario.robot.forward_kinematics(x) for x in (q, u))
        distance = np.linalg.norm(T_desired[..., :3, 3] - T[..., :3, 3], axis=-1)
        return distance, np.asarray(rotation.angle_between(T[..., :3, :3], T_desired[..., :3, :3]))

    def _accelerations(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats:
        return self.stepper.acceleration(q, qd, tau, self._pushes(kept))

    def _pushes(self, kept: slice) -> Floats | None:
        """(k, *batch, 6) the pushes of k ticks, or None if there are none."""
        if not self.pushed or not len(self.t[kept]):
            return None
        still = np.zeros((*self.start[0].shape[:-1], 6))
        return np.stack([still if push is None else still + push for push in self.pushes[kept]])

    def metadata(self) -> dict[str, object]:
        """What one needs to know besides the numbers, but for how long it took."""
        scenario = self.scenario
        return {
            "version": __version__,
            "robot": scenario.robot.name,
            "plant": self.stepper.plant.engine,
            "joints": list(scenario.robot.joint_names),
            "integrator": self.stepper.name,
            "step": scenario.step,
            "period": scenario.control_period,
            "end": float(self.t[-1]),
            "saturate": scenario.saturate,
            "noise_seed": None if scenario.noise is None else scenario.noise.seed,
            "friction_stiffness": scenario.stiffness,
            "fused": self.fused,
            "law": law_name(scenario.law),
            "fault": self.fault,
            **({} if self.clock is None else {"clock": self.clock.deadlines().to_dict()}),
        }


def align_reference(part: Floats, q: Floats) -> Floats:
    """A reference (k, n) for a batch of states (k, *batch, n).

    Args:
        part: of the reference.
        q: the states.
    """
    return part.reshape(part.shape[0], *(1,) * (q.ndim - part.ndim), *part.shape[1:])


def as_planned(robot: Robot, trajectory: Trajectory, period: float) -> Recording:
    """The recording of an arm that follows its trajectory exactly; its efforts are NaN, for nothing is known of them.

    Args:
        robot: whose joints move; it needs no masses.
        trajectory: of all its joints.
        period: between rows [s].
    """
    t = np.arange(ceil(trajectory.duration / period - PART_OF_STEP) + 1.0) * period
    q, qd, qdd = trajectory.at(t)
    unknown, zero = np.full_like(q, np.nan), np.zeros(len(t))
    metadata = {
        "version": __version__, "robot": robot.name, "plant": KINEMATIC, "joints": list(robot.joint_names),
        "integrator": KINEMATIC, "step": period, "period": period, "end": float(t[-1]), "saturate": False,
        "noise_seed": None, "friction_stiffness": 0.0, "fused": False, "law": "", "fault": "", "seconds": 0.0,
    }  # fmt: skip
    return Recording(
        t=t, q=q, qd=qd, qdd=qdd, q_ref=q, qd_ref=qd, qdd_ref=qdd, tau=unknown, tau_commanded=unknown,
        tip_position_error=zero, tip_rotation_error=zero, status=SimulationStatus.COMPLETED, metadata=metadata,
    )  # fmt: skip
