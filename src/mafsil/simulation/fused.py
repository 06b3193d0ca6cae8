"""The closed loop compiled as a whole: law, plant and integrator in one kernel, marched without returning to Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from mafsil import kernels
from mafsil.arrays import Floats
from mafsil.control import Combined, ComputedTorque, Feedforward, Gains, JointFeedback, Law
from mafsil.kernels import Kernel, Port, Signature
from mafsil.kernels.march import march
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.loop_terms import Loop, Term, input_sizes, output_sizes
from mafsil.model.fingerprint import fingerprint
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.stepping import Stepper

if TYPE_CHECKING:
    import mafsil.mechanics.closed_loop as closed_loop
else:
    closed_loop = lazily("mafsil.mechanics.closed_loop")

MOST_EVALUATIONS = 4
"""Evaluations of the dynamics per call of the law, beyond which the expression gets too long to compile."""
WORTH = 5_000
"""Ticks times batch from which on a run is compiled when it is left to us; fewer take less time than compiling."""


@dataclass(frozen=True, eq=False, slots=True)
class LawTerms:
    """A control law as data: its terms, the gains of those that have some."""

    terms: tuple[Term, ...]
    gains: tuple[Gains, ...]


def _computed_torque(law: ComputedTorque) -> LawTerms:
    return LawTerms((Term("computed_torque", law.robot.mechanism),), (law.gains,))


def _joint_feedback(law: JointFeedback) -> LawTerms:
    gravity = () if law.model is None else (Term("gravity", law.model.mechanism),)
    return LawTerms((Term("feedback"), *gravity), (law.gains,))


def _feedforward(law: Feedforward) -> LawTerms:
    return LawTerms((Term("feedforward", law.robot.mechanism),), ())


def _combined(law: Combined) -> LawTerms | None:
    parts = [law_terms(part) for part in law.laws]
    if not parts or any(part is None for part in parts):
        return None
    known = cast("list[LawTerms]", parts)
    return LawTerms(sum((p.terms for p in known), ()), sum((p.gains for p in known), ()))


LAWS: dict[type, Callable[[Any], LawTerms | None]] = {
    ComputedTorque: _computed_torque,
    JointFeedback: _joint_feedback,
    Feedforward: _feedforward,
    Combined: _combined,
}
"""Laws that are expressions, and how they are read."""


def law_terms(law: Law) -> LawTerms | None:
    """A law as data, or None if it is Python that only Python can run."""
    reader = LAWS.get(type(law))
    return None if reader is None else reader(law)


def can_fuse(scenario: Scenario) -> bool:
    """Whether the whole loop of a scenario is an expression of reasonable length."""
    law, plant = law_terms(scenario.law), scenario.true_plant
    same_width = plant.robot.n == scenario.robot.n
    stepper = Stepper(plant, scenario.chosen_integrator, scenario.step)
    return (
        law is not None
        and plant.environment is None
        and same_width
        and stepper.evaluations() * scenario.substeps <= MOST_EVALUATIONS
    )


class FusedLoop:
    """One run of a scenario as a kernel and the arrays it marches through.

    Args:
        scenario: what to run.
        ticks: how many.
        reference: (k, 1 or b, 3, n) positions, rates, accelerations.
        push: (k, 1 or b, 6), or None.
        noise: (k, b, 2, n), or None.
    """

    def __init__(
        self, scenario: Scenario, ticks: int, reference: Floats, push: Floats | None, noise: Floats | None
    ) -> None:
        q, qd = (x.reshape(-1, scenario.robot.n) for x in scenario.start())
        law = law_terms(scenario.law)
        assert law is not None
        self.kernel = _kernel_of(scenario, law, pushed=push is not None)
        sizes = {port.name: port.shape for port in self.kernel.signature.ports}
        rows, n = q.shape
        self.states = np.empty((ticks + 1, rows, 2, n))
        self.states[0] = np.stack([q, qd], axis=1)
        self.integrals = np.zeros((ticks + 1, rows, *sizes.get("integral", ())))
        self.command, self.effort, self.acceleration = (np.empty((ticks, rows, n)) for _ in range(3))
        self.tip_errors = np.empty((ticks, rows, 2))
        desired = scenario.robot.forward_kinematics(reference[..., 0, :])
        period = scenario.control_period
        gains = [np.stack([g.kp, g.kd, period * g.ki]) for g in law.gains]
        fixed: dict[str, Floats | None] = {
            "gains": np.stack(gains) if gains else np.zeros((0, 3, n)),
            "step": np.array(scenario.step),
            "limit": scenario.robot.limits.effort,
        }
        over_time = {"reference": reference, "T_desired": desired, "push": push, "noise": noise}
        self.inputs: dict[str, Floats] = {}
        for port in self.kernel.signature.inputs:
            if port.name in fixed:
                self.inputs[port.name] = np.array(fixed[port.name], order="C")[None, None]
            elif port.name in over_time:
                self.inputs[port.name] = np.ascontiguousarray(over_time[port.name])

    def advance(self, first: int, last: int) -> None:
        """Run the ticks first .. last - 1."""
        ticks, after = slice(first, last), slice(first + 1, last + 1)
        moving = {"state": self.states[ticks], "integral": self.integrals[ticks]}
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
            "command": self.command[ticks],
            "effort": self.effort[ticks],
            "acceleration": self.acceleration[ticks],
            "tip_errors": self.tip_errors[ticks],
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
    terms = [(term.kind, None if term.model is None else fingerprint(term.model)) for term in loop.terms]
    same = [term.model is loop.plant for term in loop.terms]
    flags = (loop.pushed, loop.noisy, loop.saturated, loop.integrates)
    robots = (fingerprint(loop.plant), fingerprint(loop.shown), loop.shown is loop.plant, same)
    return f"closed_loop {robots} {terms} {loop.scheme} {loop.substeps} {loop.friction} {flags}"


def _build(loop: Loop) -> Any:
    """The function; its expressions are loaded only when a kernel has to be made."""
    return closed_loop.function(loop)
