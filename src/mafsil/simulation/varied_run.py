"""Runs side by side whose plants, gains, delays and starts differ; each ends by itself, the others go on."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.errors import InputError
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.loop_terms import Loop, Term
from mafsil.simulation.closed_plant import ClosedPlant
from mafsil.simulation.fused import FusedRun, loop_kernel
from mafsil.simulation.plant import Plant
from mafsil.simulation.recording import SimulationStatus
from mafsil.simulation.run import RUNAWAY, Run
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.stepping import Stepper
from mafsil.simulation.variation import Variants
from mafsil.solvers.integrate import State, Step

if TYPE_CHECKING:
    from mafsil.kernels import Kernel


class VariedStepper(Stepper):
    """Steps of plants that differ from row to row: one compiled step with their numbers as inputs.

    Attributes:
        lost: (b,) rows whose loops could not be followed: their rates are NaN from then on.
        lost_after: (b,) of them those that were lost at the end of a step, not where it began.
    """

    def __init__(self, scenario: Scenario, variants: Variants) -> None:
        plant = scenario.true_plant
        if type(plant) not in (Plant, ClosedPlant):
            raise InputError("simulation.varied_engine", engine=plant.engine)
        super().__init__(plant, scenario.chosen_integrator, scenario.step)
        self.variants = variants
        self.lost, self.lost_after = np.zeros((2, variants.count), np.bool_)
        self._holding = plant.chain.holding(scenario.start()[0]) if isinstance(plant, ClosedPlant) else None

    def move(self) -> Step:
        """The step as a function of (t, state, h)."""
        return self._next_state

    def acceleration(self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None) -> JointVector:
        """qdd (*batch, b, n) with which a step begins."""
        return np.asarray(self._results(q, qd, effort, push, self.step)["acceleration"])

    def _next_state(self, t: float, state: State, h: float) -> State:
        q, qd = state
        after = self._results(q, qd, self.effort, self.push, h)["next_state"]
        return self.settle(after[..., 0, :], after[..., 1, :])

    def settle(self, q: JointVector, qd: JointVector) -> State:
        """The state that a step begins with: of closed chains the nearest with closed loops, by each plant's inertia.

        Args:
            q, qd: (*batch, b, n) coordinates and rates.
        """
        if self._holding is None:
            return q, qd
        before = self.lost.copy()
        closed = self._results(q, qd, np.zeros_like(q), None, self.step)["closed_state"]
        self.lost_after |= self.lost & ~before
        return closed[..., 0, :], closed[..., 1, :]

    def _results(
        self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None, h: float
    ) -> dict[str, Floats]:
        push = self.plant.tip_push(q, qd, push)
        given = self._numbers | {
            "state": np.stack([q, qd], axis=-2),
            "given": effort,
            "step": np.array(h),
            "push": np.zeros(6) if push is None else push,
        }
        signature = self._kernel.signature
        results = self._kernel(*(given[port.name] for port in signature.inputs))
        found = dict(zip((port.name for port in signature.outputs), results, strict=True))
        if self._holding is not None:
            rows = np.broadcast_shapes(found["doubt"].shape, (1, 1))
            states = np.broadcast_to(given["state"], (*found["doubt"].shape, 2, q.shape[-1]))
            doubtful = not_held(found["doubt"].reshape(rows), states.reshape(*rows, 2, q.shape[-1]))
            self.lost |= doubtful.any(axis=0)
            for name in ("next_state", "closed_state"):
                found[name][~(found["doubt"] < 1.0), 1] = np.nan
        return found

    @cached_property
    def _numbers(self) -> dict[str, Floats]:
        robot = self.plant.robot
        return {
            "bodies": self.variants.bodies(robot),
            "friction": self.variants.friction_of(robot),
            "reference": np.zeros((3, robot.n)),
            "T_desired": np.eye(4),
        }

    @cached_property
    def _kernel(self) -> Kernel:
        plant = self.plant
        return loop_kernel(
            Loop(
                plant=plant.robot.mechanism,
                terms=(Term("given"),),
                shown=plant.robot.mechanism,
                scheme=self.scheme(),
                substeps=1,
                friction=SMOOTHING if plant.has_friction else None,
                pushed=True,
                noisy=False,
                saturated=False,
                integrates=False,
                varied=True,
                holding=self._holding,
            )
        )


class VariedRun(Run):
    """Runs tick by tick in Python.

    Args:
        scenario: with variants; a run whose loops cannot be followed ends, as one that blew up.

    Attributes:
        ends: (b,) ticks of each run; fewer than all where it blew up or its loops were lost.
        lost: (b,) whether its loops were lost.
        waiting: (most late + 1, b, n) commands that are still to act.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.variants = variants_of(scenario)
        self.ends = np.full(self.variants.count, len(scenario.ticks()))
        self.lost = np.zeros(self.variants.count, np.bool_)
        super().__init__(scenario)

    def _stepper(self) -> Stepper:
        if not self.variants.changes_plant and not isinstance(self.scenario.true_plant, ClosedPlant):
            return super()._stepper()  # Loops are followed row by row, so that one that tears is no other's end.
        stepper = VariedStepper(self.scenario, self.variants)
        self.lost = stepper.lost
        return stepper

    @property
    def lost_as_it_began(self) -> NDArray[np.bool_]:
        """(b,) runs whose loops were lost where a step began: that tick does not count."""
        stepper = self.stepper
        return self.lost & ~stepper.lost_after if isinstance(stepper, VariedStepper) else self.lost

    def _acting(self, k: int, command: JointVector) -> JointVector:
        delay = self.variants.delay
        if delay is None:
            return command
        if k == 0:
            self.waiting = np.empty((int(delay.max(initial=0)) + 1, *command.shape))
        size, rows = len(self.waiting), np.arange(len(delay))
        before = None if self.memory is None else self.memory.waiting
        self.waiting[k % size] = command
        acting = self.waiting[np.maximum(k - delay, 0) % size, rows]
        if before is None or k >= size:
            return acting
        return np.where((k < delay)[:, None], before[np.maximum(delay - k, 0), rows], acting)

    def _end(self, k: int, status: SimulationStatus) -> SimulationStatus:
        """Efforts of runs that ended before do not count.

        Commands that still wait are left to the run that follows, which begins with the last tick of this one.
        """
        self.tau[k][self.ends <= k] = 0.0
        if self.memory is not None and self.variants.delay is not None:
            size = len(self.waiting)
            late = self.waiting[np.maximum(k - np.arange(size), 0) % size]
            self.memory.waiting = np.where(np.isfinite(late), late, 0.0)
        return super()._end(k, status)

    def _require_finite(self, t: float, command: JointVector) -> None:
        """A run whose efforts are not finite blows up by itself; the others go on."""

    def _sound(self, k: int, q: JointVector, qd: JointVector) -> bool:
        """A run that blew up stays where it was, so that no law sees what is not finite."""
        good = np.einsum("bi,bi->b", qd, qd) <= runaway_of(qd.shape[-1])
        bad = ~good
        if bad.any():
            self.ends[bad] = np.minimum(self.ends[bad], k + ~self.lost_as_it_began[bad])
            q[bad], qd[bad] = self.q[k][bad], 0.0
        return True


class VariedFusedRun(FusedRun):
    """The same runs as compiled code; arguments and attributes as there."""

    def __init__(self, scenario: Scenario) -> None:
        self.variants = variants_of(scenario)
        self.ends = np.full(self.variants.count, len(scenario.ticks()))
        self.lost = np.zeros(self.variants.count, np.bool_)
        super().__init__(scenario)

    def _stepper(self) -> Stepper:
        if not self.variants.changes_plant:
            return super()._stepper()
        return VariedStepper(self.scenario, self.variants)

    def _end(self, k: int, status: SimulationStatus) -> SimulationStatus:
        """Efforts of runs that ended before do not count."""
        self.tau[k][self.ends <= k] = 0.0
        return super()._end(k, status)

    def _trusted_until(self, first: int, end: int) -> int:
        """The end: rows whose steps do not hold end there, for nobody can do them by hand."""
        self.see_lost(first, self.loop.doubt[first:end], self.loop.states[first:end])
        return end

    def see_lost(self, first: int, doubt: Floats, states: Floats) -> None:
        """Rows whose loops cannot be followed end before that tick.

        Args:
            first: number of the first tick.
            doubt, states: as for `not_held`.
        """
        doubtful = not_held(doubt, states) & (first + np.arange(len(doubt))[:, None] < self.ends)
        lost = doubtful.any(axis=0)
        self.lost |= lost
        self.ends[lost] = first + doubtful[:, lost].argmax(axis=0)

    def _sound_until(self, first: int, end: int) -> NDArray[np.bool_]:
        rates = self.loop.states[first + 1 : end + 1, :, 1]
        with np.errstate(over="ignore", invalid="ignore"):
            good = np.einsum("kbi,kbi->kb", rates, rates) <= runaway_of(rates.shape[-1])
        bad = ~good.all(axis=0)
        self.ends[bad] = np.minimum(self.ends[bad], first + 1 + good[:, bad].argmin(axis=0))
        return np.ones(end - first, np.bool_)


def not_held(doubt: Floats, states: Floats) -> NDArray[np.bool_]:
    """(k, b) where compiled steps do not hold the loops: too near singular, or torn apart.

    Args:
        doubt: (k, b) of steps, below one where they hold.
        states: (k, b, 2, n) they began with; those of a run that has blown up are not looked at any more.
    """
    doubtful = ~(doubt < 1.0)
    if doubtful.any():
        rates = states[..., 1, :]
        with np.errstate(over="ignore", invalid="ignore"):
            sound = np.einsum("kbi,kbi->kb", rates, rates) <= runaway_of(rates.shape[-1])
        doubtful &= np.logical_and.accumulate(sound, axis=0)
    return doubtful


def runaway_of(n: int) -> float:
    """Sum of squared rates of one run beyond which it has blown up."""
    return RUNAWAY**2 * n


def variants_of(scenario: Scenario) -> Variants:
    """Those of a scenario that has some."""
    assert scenario.variants is not None
    return scenario.variants
