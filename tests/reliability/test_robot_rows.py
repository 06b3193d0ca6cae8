"""Rows F3, C1, C2 and D1 for whole robots; larger sizes by `tests.reliability.api_fuzz`."""

from __future__ import annotations

import copy
import json
import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.robot import Robot, load
from tests.oracles.states import States, sample

ROOT = Path(__file__).resolve().parents[2]
ROUTINES = ("forward_kinematics", "jacobian_body", "mass_matrix", "inverse_dynamics", "forward_dynamics")

PROGRAM = """
import pickle, sys
import numpy as np
robot, states = pickle.load(sys.stdin.buffer)
print(b"".join(getattr(robot, name)(*inputs).tobytes() for name, inputs in states.items()).hex())
"""


def inputs(states: States, name: str) -> list[np.ndarray]:
    return states.arguments(CATALOGUE[name].inputs)


def answers(robot: Robot, states: States, **options: object) -> dict[str, np.ndarray]:
    return {name: getattr(robot, name)(*inputs(states, name), **options) for name in ROUTINES}


def same(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> bool:
    return all(np.array_equal(a[name], b[name]) for name in a)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("ur5e")


@pytest.fixture(scope="module")
def states(robot: Robot) -> States:
    return sample(robot.mechanism, 3000, np.random.default_rng(4))


@pytest.mark.row("F3")
@pytest.mark.skipif(sys.platform != "linux", reason="the harness forks")
def test_hostile_calls(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tests.reliability.api_fuzz", "--calls", "1200", "--resume", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr[-4000:]
    figures = json.loads(done.stdout.splitlines()[-1])
    assert figures["calls"] == 1200
    assert min(figures["right"], figures["refused"]) > 250


@pytest.mark.row("F3")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_bad_rows_never_touch_good_ones(robot: Robot, states: States, bad: float) -> None:
    rng = np.random.default_rng(11)
    clean = answers(robot, states)
    rows = np.sort(rng.choice(len(states), 40, replace=False))
    spoiled = States(*(x.copy() for x in states.arguments(("q", "qd", "qdd", "tau", "tip_wrench"))))
    spoiled.q[rows, rng.integers(1, robot.n - 1, size=40)] = bad  # first and last joint do not enter every quantity
    for name, found in answers(robot, spoiled).items():
        assert np.array_equal(np.delete(found, rows, 0), np.delete(clean[name], rows, 0))
        assert not np.isfinite(found[rows].reshape(40, -1)).all(axis=1).any(), name


@pytest.mark.row("C1")
def test_threads_share_a_robot_from_its_first_call_on(states: States) -> None:
    fresh = load("ur5e")
    expected = answers(load("ur5e"), states)

    def use(seed: int) -> bool:
        rng = np.random.default_rng(seed)
        for _ in range(20):
            name = ROUTINES[int(rng.integers(len(ROUTINES)))]
            row = int(rng.integers(len(states)))
            point = getattr(fresh, name)(*(x[row] for x in inputs(states, name)))
            block = getattr(fresh, name)(*(x[row : row + 9] for x in inputs(states, name)), threads=2)
            if not (
                np.array_equal(point, expected[name][row]) and np.array_equal(block, expected[name][row : row + 9])
            ):
                return False
        return same(answers(fresh, states), expected)

    with ThreadPoolExecutor(32) as threads:
        assert all(threads.map(use, range(32)))


@pytest.mark.row("D1")
def test_threads_order_and_pieces_do_not_change_a_bit(robot: Robot, states: States) -> None:
    expected = answers(robot, states, threads=1)
    for threads in (2, 3, 8, None):
        assert same(answers(robot, states, threads=threads), expected)
    for size in (1, 7, 1000):
        pieces = [answers(robot, states.part(slice(k, k + size))) for k in range(0, 1000 if size > 1 else 20, size)]
        joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in ROUTINES}
        assert same(joined, {name: values[: len(joined[name])] for name, values in expected.items()})
    order = np.random.default_rng(1).permutation(len(states))
    assert same(answers(robot, states.part(order)), {name: values[order] for name, values in expected.items()})  # type: ignore[arg-type]


@pytest.mark.row("C2")
@pytest.mark.row("D1")
@pytest.mark.parametrize("cache", ["shared", "cold", "off"])
def test_another_process_gives_the_same_bits(robot: Robot, states: States, cache: str, tmp_path: Path) -> None:
    few = states.part(slice(0, 50))
    parcel = pickle.dumps((robot, {name: inputs(few, name) for name in ROUTINES}))
    environment = dict(os.environ) | (
        {} if cache == "shared" else {"MAFSIL_CACHE": "off" if cache == "off" else str(tmp_path)}
    )
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], input=parcel, env=environment, capture_output=True, check=True
    )
    expected = b"".join(values.tobytes() for values in answers(robot, few).values())
    assert bytes.fromhex(done.stdout.decode()) == expected


@pytest.mark.row("C2")
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_used_robots_and_their_kernels_travel(robot: Robot, states: States, protocol: int) -> None:
    few = states.part(slice(0, 3))
    expected = answers(robot, few)
    for other in (pickle.loads(pickle.dumps(robot, protocol)), copy.copy(robot), copy.deepcopy(robot)):
        assert same(answers(other, few), expected)
        assert other.mechanism.link_names == robot.mechanism.link_names
    for frame in (None, robot.mechanism.link_names[2]):
        kernel = robot.kernel("jacobian_body", frame)
        assert np.array_equal(pickle.loads(pickle.dumps(kernel, protocol))(few.q), kernel(few.q))
