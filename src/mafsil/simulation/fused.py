"""The closed loop compiled as a whole: law, plant and integrator in one kernel, marched without returning to Python."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil import kernels
from mafsil.arrays import Floats
from mafsil.control.laws.closed_chain_laws import closed_law_terms
from mafsil.control.laws.feedback import Integral
from mafsil.control.laws.law_terms import LawTerms, law_terms
from mafsil.kernels import Port, Signature
from mafsil.kernels.march import march
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.loop_terms import Loop, input_sizes, output_sizes
from mafsil.model.fingerprint import fingerprint, friction_fingerprint
from mafsil.simulation.closed_plant import ClosedPlant
from mafsil.simulation.plant import Plant
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.stepping import MOST_EVALUATIONS, Stepper

if TYPE_CHECKING:
    import mafsil.mechanics.closed_loop as closed_loop
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
        and _holds(scenario)
        and (scenario.variants is None or scenario.variants.delay is None)
        and stepper.evaluations() * scenario.substeps <= MOST_EVALUATIONS
    )


def _law_of(scenario: Scenario) -> LawTerms | None:
    law = scenario.acting_law
    if isinstance(scenario.true_plant, ClosedPlant):
        return closed_law_terms(law, scenario.start()[0])
    return law_terms(law)


def _holds(scenario: Scenario) -> bool:
    """Whether steps of a closed chain can be compiled."""
    plant = scenario.true_plant
    return not isinstance(plant, ClosedPlant) or plant.chain.holding(scenario.start()[0]) is not None


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
        moving = {"state": self.states[here], "integral": self.integrals[here]}
        arrays: list[Floats] = []
        for port in self.kernel.signature.inputs:
            given = moving.get(port.name)
            if given is None:
                given = self.inputs[port.name]
                given = given if len(given) == 1 else given[ticks]
            arrays.append(given)
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
        arrays += [outputs[port.name] for port in self.kernel.signature.outputs]
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
