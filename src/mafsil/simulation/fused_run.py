"""One run as compiled code, in pieces; ticks that the compiled step doubts are done as in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.control import saturate
from mafsil.control.laws.feedback import Integral, integrals_of
from mafsil.errors import InputError
from mafsil.simulation.closed_plant import LoopsLost
from mafsil.simulation.fused import FusedLoop
from mafsil.simulation.recording import SimulationStatus
from mafsil.simulation.run import Progress, Run, align_reference
from mafsil.trajectory import Motion

if TYPE_CHECKING:
    from mafsil.control import Law

PIECE, LOGGED_PIECE = 150_000, 500
"""Ticks times batch that compiled code runs without a break: at most some tenths of a second, with a log some ms."""

AFTER_DOUBT = 16
"""Ticks that are run at once after one that did not hold, then twice as many: what is run beyond the next is lost."""


class FusedRun(Run):
    """The same run as compiled code."""

    fused = True
    before: Law | None = None
    integrals: tuple[Integral, ...] = ()
    window: int | None = None
    """Ticks that are kept at a time; None for all, as a recording needs them."""

    def _allocate(self) -> None:
        shape, n, ticks = self.start[0].shape, self.scenario.robot.n, len(self.t)
        reference = np.stack(np.broadcast_arrays(*self.reference), axis=-2)
        if reference.ndim > 3:
            reference = np.broadcast_to(
                align_reference(reference, np.empty((0, *shape, 0))), (ticks, *shape[:-1], 3, n)
            )
        push = self._pushes(slice(ticks))
        noise = None if self.noise is None else np.stack(self.noise, axis=-2).reshape(ticks, -1, 2, n)
        self.loop = FusedLoop(
            self.scenario,
            ticks,
            reference.reshape(ticks, -1, 3, n),
            None if push is None else push.reshape(ticks, -1, 6),
            noise,
            self.window,
        )
        if self.window is None:
            self._see_all(self.loop)

    def _see_all(self, loop: FusedLoop) -> None:
        shape, ticks = self.start[0].shape, len(self.t)
        self.q, self.qd = (loop.closed[:ticks, :, part].reshape(ticks, *shape) for part in (0, 1))
        self.commanded, self.tau = loop.command.reshape(ticks, *shape), loop.effort.reshape(ticks, *shape)

    def to_the_end(self, progress: Progress | None) -> SimulationStatus:
        """The loop in pieces, between which progress is reported and Ctrl-C is heard."""
        self._begin_memory()
        ticks, last = len(self.t), len(self.t) - 1
        piece = max(1, PIECE // max(1, self.loop.states.shape[1]))
        every = max(1, last // 100)
        piece = piece if progress is None else min(piece, every)
        if self.log is not None:
            piece = max(1, min(piece, LOGGED_PIECE // max(1, self.loop.states.shape[1])))
        first, reach = 0, piece
        while first < ticks:
            end = min(first + reach, ticks)
            self.tick = first
            self.loop.advance(first, end)
            doubtful = self._trusted_until(first, end)
            reach = min(2 * reach, piece)
            if doubtful < end and self.loop.remembers:
                return self._tick_by_tick(progress)
            if doubtful < end:
                end, reach = doubtful, min(AFTER_DOUBT, piece)
                if self._sound_until(first, doubtful).all():
                    try:
                        self._by_hand(doubtful)
                    except LoopsLost as lost:
                        return self._lost(max(self.tick - 1, 0), lost)
                    end = doubtful + 1
            good = self._sound_until(first, end)
            if end == ticks:
                good[-1] = True
            if not good.all():
                return self._end(first + int(np.argmin(good)), SimulationStatus.BLOWN_UP)
            if self.log is not None and self.log.is_due():
                self._keep(self.log, end)
            if progress is not None and progress(min(end, last) / max(last, 1)) is False:
                return self._end(end - 1, SimulationStatus.CANCELLED)
            first = end
        return self._end(last, SimulationStatus.COMPLETED)

    def _begin_memory(self) -> None:
        """Integrals go on where the run before left them, if there was one."""
        if self.memory is None:
            return
        self.before = self.memory.session
        session = self.memory.begun(self.scenario.acting_law, self.scenario.control_period)
        self.integrals = integrals_of(session)
        self.loop.begin_with(self.integrals, self.start[0].shape)

    def _end_memory(self, k: int) -> None:
        """Leave the integrals as they are at tick k to the run that follows."""
        if self.memory is not None:
            self.loop.leave_to(self.integrals, self.start[0].shape, k)

    def _end(self, k: int, status: SimulationStatus) -> SimulationStatus:
        self._end_memory(k)
        return super()._end(k, status)

    def _trusted_until(self, first: int, end: int) -> int:
        """The first tick whose results do not hold: where a closed chain is too near a singular state."""
        doubtful = ~(self.loop.doubt[first:end] < 1.0).all(axis=1)
        return first + int(np.argmax(doubtful)) if doubtful.any() else end

    def _tick_by_tick(self, progress: Progress | None) -> SimulationStatus:
        """The whole run again as `Run` does it: only so are the integrals of a law known where it takes over."""
        run, self.fused = Run(self.scenario), False
        if self.memory is not None:
            run.memory, self.memory.session = self.memory, self.before
        run.log, run.logged = self.log, self.logged
        try:
            return run.to_the_end(progress)
        finally:
            self.tick, self.done, self.fault, self.logged = run.tick, run.done, run.fault, run.logged
            self.q[:], self.qd[:], self.commanded[:], self.tau[:] = run.q, run.qd, run.commanded, run.tau
            kept, loop = slice(0, max(run.done, run.tick)), self.loop
            q, qd, tau = run.q[kept], run.qd[kept], run.tau[kept]
            distance, angle = Run.tip_errors(
                self, kept, q, np.broadcast_to(align_reference(self.reference.u[kept], q), q.shape)
            )
            loop.tip_errors[kept] = np.stack([distance, angle], axis=-1).reshape(loop.tip_errors[kept].shape)
            loop.acceleration[kept] = Run._accelerations(self, kept, q, qd, tau).reshape(loop.acceleration[kept].shape)

    def _by_hand(self, k: int) -> None:
        """Tick k as `Run` does it, from the state that the step before left.

        Raises:
            LoopsLost: the loops cannot be closed before or after the step.
        """
        self.tick = k
        scenario, loop, shape = self.scenario, self.loop, self.start[0].shape
        stepper, h, flat = self.stepper, scenario.step, loop.effort[k].shape
        q, qd = stepper.settle(*(loop.states[k, :, part].reshape(shape) for part in (0, 1)))
        law = scenario.acting_law.session(scenario.control_period)
        command = self._command(law, k, float(self.t[k]), q, qd, Motion(*(part[k] for part in self.reference)))
        self._require_finite(float(self.t[k]), command)
        effort = saturate(command, scenario.robot.limits.effort) if scenario.saturate else command
        stepper.effort, stepper.push = effort, self.pushes[k]
        acceleration = stepper.acceleration(q, qd, effort, stepper.push)
        loop.command[k], loop.effort[k], loop.acceleration[k] = (
            x.reshape(flat) for x in (command, effort, acceleration)
        )
        loop.closed[k, :, 0], loop.closed[k, :, 1] = q.reshape(flat), qd.reshape(flat)
        tip_errors = super().tip_errors(slice(k, k + 1), q, np.broadcast_to(self.reference.u[k], q.shape))
        loop.tip_errors[k] = np.stack(tip_errors, axis=-1).reshape(loop.tip_errors[k].shape)
        for i in range(scenario.substeps if k < len(self.t) - 1 else 0):
            try:
                q, qd = stepper.move()(self.t[k] + i * h, (q, qd), h)
            except LoopsLost:
                self.tick = k + 1
                raise
            except InputError:
                qd = np.full_like(qd, np.nan)
        loop.states[k + 1, :, 0], loop.states[k + 1, :, 1] = q.reshape(flat), qd.reshape(flat)

    def _sound_until(self, first: int, end: int) -> NDArray[np.bool_]:
        """(end - first,) whether the run goes on from the states after these ticks."""
        rates = self.loop.states[first + 1 : end + 1, :, 1]
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(np.einsum("kbi,kbi->k", rates, rates) <= self.runaway)

    def tip_errors(self, kept: slice, q: Floats, u: Floats) -> tuple[Floats, Floats]:
        """The same as the compiled code found them; arguments as there."""
        errors = self.loop.tip_errors[kept].reshape(*q.shape[:-1], 2)
        return errors[..., 0], errors[..., 1]

    def _accelerations(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats:
        return self.loop.acceleration[kept].reshape(q.shape)
