"""V1: every slip of the pen in every routine of a robot, each held against the second method of `mafsil.verify`.

`python -m tests.reliability.slips --robots 6 --resume DIR`

One after the other every sum, product, sine and cosine of every routine's expression is exchanged for its neighbour or
its negative. A slip that changes a number and is not caught at the states that `verify` draws is a survivor.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from mafsil.kernels.tape import Tape
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantity import States, random_states
from mafsil.mechanics.textbook import Textbook
from mafsil.model import library
from mafsil.robot import Robot
from mafsil.robot.trace import signature
from mafsil.verification.verify import LIMIT, Judge
from tests.oracles.random_tree import random_tree
from tests.reliability import figures
from tests.verification.mutants import Way, calls, outputs_of, places

ARMS = ("stanford_arm", "planar2r_point_masses", "scara_rrrp", "panda")
"""Then random trees."""
WIDE_STATES = 40
"""States, other than those of `verify`, on which a slip may show that it changes a number."""
NOTHING = 1e-13
"""Change relative to the natural size that is rounding: the exchange makes no difference."""
TOGETHER = 100
"""Mutants evaluated side by side."""


class Survey:
    """A routine called in one way with the states that `verify` draws, and the second method's numbers for them."""

    def __init__(self, robot: Robot, way: Way, s: States, tape: Tape | None = None) -> None:
        book, sizes = Textbook(robot.mechanism), ArmSize.of(robot.mechanism)
        self.way, self.tape = way, tape or way.tape(robot.mechanism)
        self.judge, self.reference = Judge(book, sizes, s, LIMIT), quantity(way.routine).second.value(book, s)
        self.wide = Judge(book, sizes, random_states(robot.mechanism, sizes, WIDE_STATES, 1), LIMIT)

    @property
    def is_caught(self) -> bool:
        """Whether `verify` finds out the tape as it is."""
        return self._errors(self.judge, self.reference, [])[0] > LIMIT

    def not_caught(self) -> Iterator[tuple[int, bool]]:
        """Every exchange that `verify` does not find out, and whether it changes a number at all."""
        numbers = places(self.tape)
        for start in range(0, len(numbers), TOGETHER):
            some = numbers[start : start + TOGETHER]
            for number, error in zip(some, self._errors(self.judge, self.reference, some), strict=True):
                if error <= LIMIT:
                    truth = self._outputs(self.wide, [])[0]
                    yield number, self._errors(self.wide, truth, [number])[0] > NOTHING

    def _errors(self, judge: Judge, reference: Any, numbers: list[int]) -> list[float]:
        found = self._outputs(judge, numbers)
        return [float(judge.error(self.way.routine, values, reference).max()) for values in found]

    def _outputs(self, judge: Judge, numbers: list[int]) -> Any:
        """(mutants, b, ...) with each operation exchanged in turn; of the tape itself if there is none."""
        row, mechanism = quantity(self.way.routine), judge.book.mechanism
        columns = [getattr(judge.drawn, name) for name in (*row.inputs, *self.way.optional)]
        outputs = outputs_of(self.tape, columns, numbers)
        return outputs.reshape(max(1, len(numbers)), -1, *signature(mechanism, row, self.way.optional).outputs[0].shape)


def work(seed: int, cases: int) -> dict[str, int]:
    """All slips in all routines of one robot, however many `cases` say."""
    rng = np.random.default_rng(seed)
    robot = Robot(library.load(ARMS[seed]) if seed < len(ARMS) else random_tree(rng, most_joints=8))
    count = {"robots": cases, "ways": 0, "mutants": 0, "without_effect": 0, "bad_survivors": 0}
    for way, s in calls(robot):
        survey = Survey(robot, way, s)
        count["ways"] += 1
        count["mutants"] += len(places(survey.tape))
        for number, changes in survey.not_caught():
            count["bad_survivors" if changes else "without_effect"] += 1
            if changes:
                print(f"{robot.name}: {way}: operation {number} {survey.tape.nodes[number]}", file=sys.stderr)
    return count


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "robots", len(ARMS) + 2, 1)
    sys.exit(not figures.run("V1", options, work)["passed"])
