"""Row R1: random mechanisms against Pinocchio and MuJoCo, four states each.

python -m tests.reliability.random_trees --robots 1000000 --shard 1/2 --resume

Robot number k is made from seed k alone. A shard takes every N-th number and writes its figures after every hundred
robots; --resume goes on where the file ends. Robots beyond the limit are listed with their numbers.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Mechanism
from tests.oracles import ours
from tests.oracles.comparison import RAW, compared, oracles_of
from tests.oracles.oracle import Answers
from tests.oracles.random_tree import random_tree
from tests.oracles.states import States, sample

LIMIT, MEDIAN_LIMIT = 1e-12, 1e-14
STATES_EACH = 4
WRITTEN_EVERY = 100


@dataclass
class Figures:
    """What a run has seen: errors by quantity, robots beyond the limit."""

    robots: int = 0
    next: int = 0
    joints: int = 0
    seconds: float = 0.0
    singular: int = 0
    checks: dict[str, int] = field(default_factory=dict)
    worst: dict[str, list[float]] = field(default_factory=dict)
    histogram: list[int] = field(default_factory=lambda: [0] * 20)
    beyond: list[int] = field(default_factory=list)

    def add(self, number: int, mechanism: Mechanism, errors: dict[str, float], oracles: Sequence[str]) -> None:
        """Count one robot; `errors` are the largest of its states and oracles, by quantity."""
        self.robots += 1
        self.joints += len([joint for joint in mechanism.joints if joint.moves])
        self.singular += "forward_dynamics" not in errors
        for oracle in oracles:
            self.checks[oracle] = self.checks.get(oracle, 0) + 1
        for name, error in errors.items():
            if error >= self.worst.get(name, [-1.0, 0])[0]:
                self.worst[name] = [error, number]
            self.histogram[int(np.clip(-np.log10(max(error, 1e-19)), 0, 19))] += 1
        if max(errors.values()) > LIMIT:
            self.beyond.append(number)

    @property
    def median_below(self) -> float:
        """The power of ten below which half of the errors lie (largest of four states each)."""
        total, seen = sum(self.histogram), 0
        for power, count in enumerate(self.histogram):
            seen += count
            if 2 * seen >= total:
                return 10.0**-power
        return 0.0


def robot(number: int) -> Mechanism:
    """The random mechanism of that number; most are small, some have 40 joints."""
    rng = np.random.default_rng([1, number])
    return random_tree(rng, most_joints=int(2 ** rng.uniform(0, np.log2(41))))


def errors_of(
    number: int, mechanism: Mechanism, evaluate: Callable[[States], Answers]
) -> tuple[dict[str, float], list[str]]:
    """Largest error by quantity over states and oracles, and the names of the oracles."""
    oracles = oracles_of("random tree", mechanism)
    states = sample(mechanism, STATES_EACH, np.random.default_rng([2, number]))
    table, _ = compared(mechanism, oracles, evaluate, states)
    errors: dict[str, float] = {}
    for row in table.values():
        for name, each in row.items():
            if name != RAW:
                errors[name] = max(errors.get(name, 0.0), each.worst)
    if "forward_dynamics" not in errors and not _singular(oracles[0].evaluate(states)["mass_matrix"]):
        errors["forward_dynamics"] = np.inf
    return errors, list(table)


def _singular(M: Floats) -> bool:
    """Whether the mass matrices (N, n, n), scaled to a unit diagonal, are singular to rounding: a refusal is right."""
    size = np.sqrt(np.maximum(np.einsum("kii->ki", M), 1e-300))
    return bool(np.linalg.eigvalsh(M / size[:, :, None] / size[:, None, :])[:, 0].max() < 1e-12)


def run(numbers: range, figures: Figures, place: Path | None, seconds: float = np.inf) -> Figures:
    """Go on with the robots of `numbers` from `figures.next` on, for at most that many seconds."""
    start = perf_counter() - figures.seconds
    for position in range(figures.next, len(numbers)):
        number = numbers[position]
        mechanism = robot(number)
        errors, oracles = errors_of(number, mechanism, partial(ours.traced, mechanism))
        figures.add(number, mechanism, errors, oracles)
        figures.next, figures.seconds = position + 1, perf_counter() - start
        if place is not None and (figures.robots % WRITTEN_EVERY == 0 or position + 1 == len(numbers)):
            _write(place, figures)
        if figures.seconds > seconds:
            break
    return figures


def _write(place: Path, figures: Figures) -> None:
    partial_file = place.with_suffix(".part")
    partial_file.write_text(json.dumps(vars(figures) | {"median_below": figures.median_below}, indent=1))
    partial_file.replace(place)


def _read(place: Path) -> Figures:
    details = json.loads(place.read_text())
    del details["median_below"]
    return Figures(**details)


def report(figures: Figures) -> str:
    """The figures as text."""
    worst = ", ".join(f"{name} {error:.1e} (robot {number:.0f})" for name, (error, number) in figures.worst.items())
    return (
        f"{figures.robots} robots, {figures.joints} joints, {STATES_EACH} states each, {figures.seconds:.0f} s; "
        f"checked by {figures.checks}; {figures.singular} without accelerations, their mass matrix being singular\n"
        f"worst: {worst}\n"
        f"half of the errors below {figures.median_below:.0e}; beyond {LIMIT:g}: {figures.beyond or 'none'}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.reliability.random_trees", description=__doc__)
    parser.add_argument("--robots", type=int, default=2000)
    parser.add_argument("--shard", default="1/1", help="k/N")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--seconds", type=float, default=np.inf, help="stop after this time")
    parser.add_argument("--output", type=Path, default=Path("build/random_trees"))
    options = parser.parse_args(arguments)
    index, count = (int(part) for part in options.shard.split("/"))
    options.output.mkdir(parents=True, exist_ok=True)
    place = options.output / f"{options.robots}-{index}-of-{count}.json"
    figures = _read(place) if options.resume and place.exists() else Figures()
    limit = figures.seconds + options.seconds
    figures = run(range(index - 1, options.robots, count), figures, place, limit)
    _write(place, figures)
    print(report(figures))
    return 1 if figures.beyond or not figures.robots else 0


if __name__ == "__main__":
    sys.exit(main())
