"""One robot, many states, every quantity, every oracle: the worst and the median error of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Mechanism
from tests.oracles import subjects
from tests.oracles.mujoco_model import MuJoCoOracle
from tests.oracles.natural_scale import natural_scale
from tests.oracles.oracle import Answers, Oracle, Unsupported
from tests.oracles.pinocchio_file import PinocchioFileOracle
from tests.oracles.pinocchio_model import PinocchioOracle
from tests.oracles.states import States, sample

RAW = "qdd itself"
"""Accelerations compared entry by entry: shown, not judged, for the condition of the mass matrix is in them."""

BLOCK = 500
"""States evaluated at once."""


@dataclass
class Errors:
    """Errors of one quantity against one oracle, and where the worst stood."""

    worst: float = 0.0
    state: int = -1
    medians: list[float] = field(default_factory=list)

    def add(self, errors: Floats, first: int) -> None:
        self.medians.append(float(np.median(errors)))
        if errors.max() > self.worst:
            self.worst, self.state = float(errors.max()), first + int(errors.argmax())

    @property
    def median(self) -> float:
        return float(np.median(self.medians))


Table = dict[str, dict[str, Errors]]
"""Oracle name -> quantity -> errors."""


def oracles_of(name: str, mechanism: Mechanism) -> list[Oracle]:
    """All that can take the robot; the file's own reader for files."""
    oracles: list[Oracle] = [PinocchioOracle(mechanism)]
    with suppress(Unsupported):
        oracles.append(MuJoCoOracle(mechanism))
    if name.startswith("urdf:"):
        oracles.append(PinocchioFileOracle(subjects.path_of(name.removeprefix("urdf:")), mechanism))
    return oracles


def compared(
    mechanism: Mechanism, oracles: list[Oracle], ours: Callable[[States], Answers], states: States
) -> tuple[Table, dict[str, float]]:
    """The table, and the seconds that each side took."""
    scale = natural_scale(mechanism)
    table: Table = {oracle.name: {} for oracle in oracles}
    seconds: dict[str, float] = {}

    def timed(who: str, evaluate: Callable[[States], Answers], block: States) -> Answers:
        start = perf_counter()
        answers = evaluate(block)
        seconds[who] = seconds.get(who, 0.0) + perf_counter() - start
        return answers

    for first, block in _blocks(states):
        mine = timed("mafsil", ours, block)
        for oracle in oracles:
            theirs = timed(oracle.name, oracle.evaluate, block)
            for quantity in (name for name in theirs if name in mine):
                errors = scale.error(quantity, mine[quantity], theirs[quantity], theirs.get("mass_matrix"))
                table[oracle.name].setdefault(quantity, Errors()).add(errors, first)
            if "forward_dynamics" in theirs.keys() & mine.keys():
                errors = scale.error("forward_dynamics", mine["forward_dynamics"], theirs["forward_dynamics"])
                table[oracle.name].setdefault(RAW, Errors()).add(errors, first)
    return table, seconds


def states_of(mechanism: Mechanism, count: int, seed: int) -> States:
    """The same states for the same robot, count and seed."""
    return sample(mechanism, count, np.random.default_rng([seed, count]))


def _blocks(states: States) -> Iterator[tuple[int, States]]:
    for first in range(0, len(states), BLOCK):
        yield first, states.part(slice(first, first + BLOCK))
