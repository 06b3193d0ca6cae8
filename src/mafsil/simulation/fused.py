"""The closed loop compiled as a whole: law, plant and integrator in one kernel, and a run that marches with it.

A run goes in pieces, between which it can be watched; ticks that the compiled step doubts are done as in Python.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil import kernels
from mafsil.arrays import Floats
from mafsil.control import saturate
from mafsil.control.laws.closed_chain_laws import LawTerms, closed_law_terms, law_terms
from mafsil.control.laws.feedback import Integral, integrals_of
from mafsil.errors import InputError
from mafsil.kernels import Port, Signature
from mafsil.kernels.march import march
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.loop_terms import Loop, input_sizes, output_sizes
from mafsil.model.fingerprint import fingerprint, friction_fingerprint
from mafsil.simulation.closed_plant import ClosedPlant, LoopsLost
from mafsil.simulation.plant import Plant
from mafsil.simulation.recording import SimulationStatus
from mafsil.simulation.run import Progress, Run, align_reference
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.stepping import MOST_EVALUATIONS, Stepper
from mafsil.trajectory import Motion

if TYPE_CHECKING:
    import mafsil.mechanics.closed_loop as closed_loop
    from mafsil.control import Law
    from mafsil.kernels import Kernel
else:
    closed_loop = lazily("mafsil.mechanics.closed_loop")


WORTH = 5_000
"""Ticks times batch from which on a run is compiled when it is left to us; fewer take less time than compiling."""


def can_fuse(scenario: Scenario) -> bool:
    """Whether the whole loop of a scenario is an expression of reasonable length."""
    plant = scenario.true_plant
    if type(plant) not in (Plant, ClosedPlant):
        return False
    law = _law_of(scenario)
    same_width = plant.robot.n == scenario.robot.n
    stepper = Stepper(plant, scenario.chosen_integrator, scenario.step)
    return (
        law is not None
        and plant.environment is None
        and same_width
        and (not isinstance(plant, ClosedPlant) or plant.chain.holding(scenario.start()[0]) is not None)
        and (scenario.variants is None or scenario.variants.delay is None)
        and stepper.evaluations() * scenario.substeps <= MOST_EVALUATIONS
    )


def _law_of(scenario: Scenario) -> LawTerms | None:
    law = scenario.acting_law
    if isinstance(scenario.true_plant, ClosedPlant):
        return closed_law_terms(law, scenario.start()[0])
    return law_terms(law)


class FusedLoop:
    """One run of a scenario as a kernel and the arrays it marches through.

    Args:
        scenario: what to run.
        ticks: how many.
        reference: (k, 1 or b, 3, n) positions, rates, accelerations.
        push: (k, 1 or b, 6), or None.
        noise: (k, b, 2, n), or None.
        window: ticks that are kept at a time, one window after the other; all of them if None.

    Attributes:
        states: (window + 1, b, 2, n), the state after the window last; of closed chains as the step left it.
        closed: (window, b, 2, n) the states that were recorded: of closed chains with closed loops.
        command, effort, acceleration: (window, b, n).
        tip_errors: (window, b, 2) distance and angle of the tip from its reference [m], [rad].
        remembers: whether the law has an integral.
        doubt: (window, b) of the steps of closed chains, below one where they hold; zero of trees.
    """

    def __init__(
        self,
        scenario: Scenario,
        ticks: int,
        reference: Floats,
        push: Floats | None,
        noise: Floats | None,
        window: int | None = None,
    ) -> None:
        q, qd = (x.reshape(-1, scenario.robot.n) for x in scenario.start())
        law, variants = _law_of(scenario), scenario.variants
        assert law is not None
        self._integrating = [row for row, gains in enumerate(law.gains) if gains.integrates]
        self.kernel = _kernel_of(scenario, law, pushed=push is not None)
        sizes = {port.name: port.shape for port in self.kernel.signature.ports}
        rows, n = q.shape
        self.window = kept = min(window or ticks, ticks)
        self.states = np.empty((kept + 1, rows, 2, n))
        self.states[0] = np.stack([q, qd], axis=1)
        self.integrals = np.zeros((kept + 1, rows, *sizes.get("integral", ())))
        self.remembers = "integral" in sizes
        self.command, self.effort, self.acceleration = (np.empty((kept, rows, n)) for _ in range(3))
        self.tip_errors = np.empty((kept, rows, 2))
        self.doubt = np.zeros((kept, rows))
        self.closed = np.empty((kept, rows, 2, n)) if "closed_state" in sizes else self.states
        desired = scenario.robot.forward_kinematics(reference[..., 0, :])
        period = scenario.control_period
        gains = [np.stack([g.kp, g.kd, period * g.ki], axis=-2) for g in law.gains]
        fixed: dict[str, Floats | None] = {
            "gains": np.stack(np.broadcast_arrays(*gains), axis=-3) if gains else np.zeros((0, 3, n)),
            "step": np.array(scenario.step),
            "limit": scenario.robot.limits.effort,
            "integral_limit": np.stack(law.limits) if law.limits else None,
        }
        if variants is not None:
            fixed["bodies"] = variants.bodies(scenario.true_plant.robot)
            fixed["friction"] = variants.friction_of(scenario.true_plant.robot)
        over_time = {"reference": reference, "T_desired": desired, "push": push, "noise": noise}
        self.inputs: dict[str, Floats] = {}
        for port in self.kernel.signature.inputs:
            if port.name in fixed:
                numbers = np.array(fixed[port.name], order="C")
                alike = numbers.ndim == len(port.shape)
                self.inputs[port.name] = numbers[None, None] if alike else numbers[None]
            elif port.name in over_time:
                self.inputs[port.name] = np.ascontiguousarray(over_time[port.name])

    def begin_with(self, integrals: Sequence[Integral], shape: tuple[int, ...]) -> None:
        """Let the integrals of the law go on where they stand.

        Args:
            integrals: of a session of the law.
            shape: (*batch, n) of the states.
        """
        for row, integral in zip(self._integrating, integrals, strict=True):
            self.integrals[0, :, row] = np.broadcast_to(integral.sum.value, shape).reshape(-1, shape[-1])

    def leave_to(self, integrals: Sequence[Integral], shape: tuple[int, ...], k: int) -> None:
        """Let a session go on after tick k, the last one; the integral of a run that blew up begins afresh.

        Args:
            integrals: of the session.
            shape: (*batch, n) of the states.
            k: of the present window.
        """
        here = k % self.window
        for row, integral in zip(self._integrating, integrals, strict=True):
            around = self.integrals[here : here + 2, :, row].reshape(2, *shape)
            integral.sum.become(*np.where(np.isfinite(around).all(axis=0), around, 0.0))

    def advance(self, first: int, last: int) -> None:
        """Run the ticks first .. last - 1, all of one window."""
        begin = first % self.window
        if first and not begin:
            self.states[0], self.integrals[0] = self.states[-1], self.integrals[-1]
        ticks, here = slice(first, last), slice(begin, begin + last - first)
        after = slice(here.start + 1, here.stop + 1)
        inputs = {name: given if len(given) == 1 else given[ticks] for name, given in self.inputs.items()}
        inputs |= {"state": self.states[here], "integral": self.integrals[here]}
        outputs = {
            "next_state": self.states[after],
            "next_integral": self.integrals[after],
            "command": self.command[here],
            "effort": self.effort[here],
            "acceleration": self.acceleration[here],
            "tip_errors": self.tip_errors[here],
            "closed_state": self.closed[here],
            "doubt": self.doubt[here],
        }
        ports = self.kernel.signature
        arrays = [inputs[port.name] for port in ports.inputs] + [outputs[port.name] for port in ports.outputs]
        march(self.kernel, arrays, last - first)


def _kernel_of(scenario: Scenario, law: LawTerms, *, pushed: bool) -> Kernel:
    plant = scenario.true_plant
    loop = Loop(
        plant=plant.robot.mechanism,
        terms=law.terms,
        shown=scenario.robot.mechanism,
        scheme=Stepper(plant, scenario.chosen_integrator, scenario.step).scheme(),
        substeps=scenario.substeps,
        friction=SMOOTHING if plant.has_friction else None,
        pushed=pushed,
        noisy=scenario.noise is not None,
        saturated=scenario.saturate,
        integrates=any(gains.integrates for gains in law.gains),
        varied=scenario.variants is not None and scenario.variants.changes_plant,
        holding=plant.chain.holding(scenario.start()[0]) if isinstance(plant, ClosedPlant) else None,
    )
    return loop_kernel(loop)


@lru_cache(maxsize=32)
def loop_kernel(loop: Loop) -> Kernel:
    """One step of a closed loop as a kernel; its ports are those of `mafsil.mechanics.loop_terms`."""
    inputs = tuple(Port(name, shape) for name, shape in input_sizes(loop).items())
    outputs = tuple(Port(name, shape) for name, shape in output_sizes(loop).items())
    return kernels.compile(
        Signature("closed_loop", inputs, outputs),
        partial(_build, loop),
        key=_key(loop),
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


def _key(loop: Loop) -> str:
    """Words that differ whenever the expression does."""
    terms = [term.key for term in loop.terms]
    same = [term.model is loop.plant for term in loop.terms]
    flags = (loop.pushed, loop.noisy, loop.saturated, loop.integrates, loop.varied)
    robots = (fingerprint(loop.plant), fingerprint(loop.shown), loop.shown is loop.plant, same)
    holding = (loop.holding, [term.holding for term in loop.terms])
    # Its numbers stand in the expression; where they vary, still which joints rub.
    rubbing = "" if loop.friction is None else friction_fingerprint(loop.plant)
    return f"closed_loop {robots} {terms} {loop.scheme} {loop.substeps} {loop.friction} {rubbing} {flags} {holding}"


def _build(loop: Loop) -> Any:
    """The function; its expressions are loaded only when a kernel has to be made."""
    return closed_loop.function(loop)


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
            aligned = align_reference(reference, np.empty((0, *shape, 0)))
            reference = np.broadcast_to(aligned, (ticks, *shape[:-1], 3, n))
        pushes = self._pushes(slice(ticks))
        push = None if pushes is None else pushes.reshape(ticks, -1, 6)
        noise = None if self.noise is None else np.stack(self.noise, axis=-2).reshape(ticks, -1, 2, n)
        self.loop = FusedLoop(self.scenario, ticks, reference.reshape(ticks, -1, 3, n), push, noise, self.window)
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
