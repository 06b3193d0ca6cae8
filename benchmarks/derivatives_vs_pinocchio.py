"""How fast are analytic derivatives of dynamics beside Pinocchio's, in the same run?

python benchmarks/derivatives_vs_pinocchio.py [--robots panda ur5e ...] [--quick]

Both return three matrices: by q, by qd, and the mass matrix or its inverse. Pinocchio writes them into its data object;
ours are fresh arrays. The batch runs on one thread. Operations are those left after the kernel's own reduction.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.large_robots import large_robot  # noqa: E402
from benchmarks.stopwatch import BRIEF, BRIEFER, machine, race, verdict  # noqa: E402
from mafsil.kernels.reduce import reduce  # noqa: E402
from mafsil.kernels.tape import read  # noqa: E402
from mafsil.mechanics.catalogue import quantity  # noqa: E402
from mafsil.model import library  # noqa: E402
from mafsil.robot import Robot  # noqa: E402
from mafsil.robot.trace import trace  # noqa: E402
from tests.oracles.pinocchio_model import model_of  # noqa: E402
from tests.oracles.states import States, sample  # noqa: E402

ROBOTS = ("panda", "iiwa7", "ur5e", "puma560", "tree30", "talos")
ROWS = 2048
BATCH_TARGET, SINGLE_TARGET, OPERATIONS_TARGET = 25, 1, 1600
QUANTITIES = {
    "inverse_dynamics_derivatives": ("q", "qd", "qdd"),
    "forward_dynamics_derivatives": ("q", "qd", "tau"),
}


def operations(robot: Robot, name: str) -> int:
    """Arithmetic operations of the kernel."""
    tape = reduce(read(trace(robot.mechanism, quantity(name), None)))
    return sum(node.op not in ("input", "const") for node in tape.nodes)


def rival(robot: Robot, name: str, states: States) -> Callable[[], object]:
    """Pinocchio's call for the first state."""
    model, _ = model_of(robot.mechanism)
    data = model.createData()
    a, b, c = (np.ascontiguousarray(x[0]) for x in states.arguments(QUANTITIES[name]))
    compute = pin.computeRNEADerivatives if name.startswith("inverse") else pin.computeABADerivatives
    return lambda: compute(model, data, a, b, c)


def measured(robot: Robot, name: str, quick: bool) -> tuple[float, float, float]:
    """Seconds of one evaluation in a batch, of one call, of Pinocchio's call."""
    states = sample(robot.mechanism, ROWS, np.random.default_rng(1))
    arguments = states.arguments(QUANTITIES[name])
    a, b, c = (np.ascontiguousarray(x[0]) for x in arguments)
    kernel, call = robot.kernel(name), getattr(robot, name)
    result = kernel(*arguments)
    tasks: dict[str, Callable[[], object]] = {
        "batch": lambda: kernel(*arguments, out=result, threads=1),
        "call": lambda: call(a, b, c),
        "pinocchio": rival(robot, name, states),
    }
    times = race(tasks, **(BRIEFER if quick else BRIEF))
    return times["batch"].least / ROWS, times["call"].least, times["pinocchio"].least


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=list(ROBOTS), choices=(*ROBOTS, "chain30"))
    parser.add_argument("--quick", action="store_true", help="a quarter of the repeats")
    options = parser.parse_args()
    print(" | ".join(f"{key} {value}" for key, value in machine("mafsil", "numpy", "llvmlite", "pin").items()))
    head = f"{'robot':9}{'quantity':30}{'operations':>11}{'batch ns':>10}{'times':>7}"
    print(head + f"{'call ns':>9}{'pin ns':>8}{'times':>7}")
    batches: list[float] = []
    calls: list[float] = []
    for robot_name in options.robots:
        robot = Robot(large_robot(robot_name) or library.load(robot_name))
        for name in QUANTITIES:
            batch, call, pinocchio = measured(robot, name, options.quick)
            batches.append(pinocchio / batch)
            calls.append(pinocchio / call)
            print(
                f"{robot_name:9}{name:30}{operations(robot, name):11}{1e9 * batch:10.0f}{pinocchio / batch:7.1f}"
                f"{1e9 * call:9.0f}{1e9 * pinocchio:8.0f}{pinocchio / call:7.2f}",
                flush=True,
            )
    print(verdict("batch", batches, BATCH_TARGET))
    print(verdict("single", calls, SINGLE_TARGET))
    print(f"operations of the Panda's inverse dynamics derivatives: target {OPERATIONS_TARGET}")


if __name__ == "__main__":
    main()
