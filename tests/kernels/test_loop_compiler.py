"""Compiled loops: what LLVM makes of a function does what Python does, bit for bit, and without numba."""

from __future__ import annotations

import ast
import inspect
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import KernelError
from mafsil.ik.numerical import block_loops, pose_loops, search_loops, start_loops
from mafsil.ik.numerical.fast_search import search_of
from mafsil.ik.numerical.program import PROGRAM
from mafsil.kernels.loop_compiler import LoopProgram
from tests.kernels import sample_loops

SAMPLES = LoopProgram(["tests.kernels.sample_loops"], ("arithmetic", "squared", "singles", "control", "views"))
reals = st.floats(-1e6, 1e6, allow_nan=False)
wholes = st.integers(-1000, 1000)


def compiled(program, name, *given):
    """A call with arrays in place of their addresses."""
    return program[name](*(x.ctypes.data if isinstance(x, np.ndarray) else x for x in given))


def both(name, *given):
    """Result and changed arrays of Python and of the machine code."""
    copies = [x.copy() if isinstance(x, np.ndarray) else x for x in given]
    answers = getattr(sample_loops, name)(*given), compiled(SAMPLES, name, *copies)
    for mine, theirs in zip(given, copies, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    return answers


@given(reals, reals.filter(bool), wholes, wholes.filter(bool))
@settings(max_examples=300, deadline=None)
def test_arithmetic_is_that_of_python(a, b, p, q):
    both("arithmetic", np.array([a, b]), np.array([p, q]), np.zeros(15), np.zeros(14, np.int64))


@given(reals)
@settings(max_examples=100, deadline=None)
def test_a_square_is_one_product(a):
    """Python's power goes through the mathematics library, which may be a last bit off."""
    out = np.zeros(1)
    compiled(SAMPLES, "squared", np.array([a]), out)
    assert out[0] == (a - 2) * (a - 2)


@pytest.mark.parametrize("a", [0.5, 1.5, 2.5, -0.5, 4503599627370497.0, 1e300, -(2.0**52) + 0.5])
def test_rounding_to_integers_is_to_even(a):
    out = np.zeros(15)
    whole = np.zeros(14, np.int64)
    compiled(SAMPLES, "arithmetic", np.array([a, 1.0]), np.array([1, 1]), out, whole)
    assert out[10] == np.rint(a)
    assert np.signbit(out[10]) == np.signbit(np.rint(a))


@given(st.lists(st.floats(-1e3, 1e3, width=32), min_size=8, max_size=8), st.lists(reals, min_size=8, max_size=8))
@settings(max_examples=100, deadline=None)
def test_single_precision_stays_single(x, y):
    mine, theirs = both("singles", np.array(x, np.float32), np.array(y), np.zeros(8, np.float32))
    assert float(mine) == theirs


@given(st.lists(st.floats(-1, 1), min_size=0, max_size=12))
@settings(max_examples=200, deadline=None)
def test_loops_and_results_from_their_middle(x):
    mine, theirs = both("control", np.array(x), len(x), np.zeros(len(x) + 1))
    assert mine == theirs


@given(st.lists(st.floats(-1, 1), min_size=0, max_size=5))
@settings(max_examples=100, deadline=None)
def test_views_and_conditions_that_must_not_be_looked_at(x):
    mine, theirs = both("views", np.array(x * 3), len(x), np.zeros(3))
    assert bool(mine) == theirs


@pytest.mark.parametrize(
    "body",
    [
        "def f(x: str) -> None:\n    pass",
        "def f(x: int) -> None:\n    with x: pass",
        "def f(x: int) -> int:\n    return unknown",
        "def f(x: Floats) -> None:\n    x[0] = [1]",
        "def f(x: int) -> int:\n    return other(x)",
        "def f(x: float) -> int:\n    return x",
        "def f(x: Floats) -> None:\n    y = np.empty(x)",
        "def f(x: Floats, i: int) -> float:\n    return x[1:i]",
        "def f(x: float) -> float:\n    return x ** 3",
        "def f(x: float) -> None:\n    for i in x: pass",
        "def f(x: Floats, y: Whole) -> None:\n    z = x\n    z = y",
    ],
)
def test_what_is_not_of_the_language_is_refused(body, tmp_path, monkeypatch):
    name = f"refused_{abs(hash(body))}"
    (tmp_path / f"{name}.py").write_text(f"from __future__ import annotations\nimport numpy as np\n{body}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(KernelError, match="refused"):
        _ = LoopProgram([name], ("f",))["f"]


@pytest.mark.parametrize("name", ["panda", "ur5e", "planar3r", "scara_rrrp"])
def test_the_search_is_the_same_as_python(name):
    """The whole search for some poses, its loops run by Python around the same kernels."""
    robot = mf.load(name)
    search = search_of(robot, None, True, 0, "pose", (0.0, 0.0, 1.0), None, 1e-10, None)
    plan, n, k, lanes = search.plan, robot.n, 5, 8
    q = np.random.default_rng(3).uniform(-1, 1, (k, n))
    T = robot.forward_kinematics(np.clip(q, robot.limits.lower, robot.limits.upper)).reshape(k, 16)
    T[3, 5] += 0.1
    found = search.rows(T, np.zeros((0, n)), 31)
    work, report = np.zeros((17 + n) * k + n + (28 + 2 * n) * lanes), np.zeros_like(found).ravel()
    whole = np.zeros(search_loops.RECORD * k + start_loops.LANE * lanes + 3, np.int64)
    entries = plan.step.addresses.batch, plan.check.addresses.batch
    given = plan.record, plan.pool.features.ravel(), *entries, T.ravel(), np.zeros(0), 0, k, lanes, 32
    assert block_loops.block(*given, work, whole, report) == k - 1
    np.testing.assert_array_equal(report.reshape(found.shape), found)
    for row in (0, 1, 2, 4):
        alone = search.single(T[row].reshape(4, 4), None, 31)
        np.testing.assert_array_equal(alone.nearest, found[row, block_loops.CONFIGURATION :])


def test_samples_come_in_the_order_of_their_distance():
    robot = mf.load("puma560")
    plan = search_of(robot, None, True, 0, "pose", (0.0, 0.0, 1.0), None, 1e-10, None).plan
    T = robot.forward_kinematics(np.full(6, 0.3)).reshape(1, 16)
    exact, lane = np.zeros(12), np.full(start_loops.LANE, -1, np.int64)
    start_loops.features_of(plan.record, T[0], exact)
    rows = plan.problem.poses(plan.pool.samples)
    features = np.hstack([plan.pool.turning * rows[:, :3, :3].reshape(-1, 9), plan.pool.shifting * rows[:, :3, 3]])
    distances = ((features - exact) ** 2).sum(axis=1)
    chosen = []
    while (k := start_loops.next_sample(plan.record, plan.pool.features.ravel(), T[0], lane)) >= 0:
        chosen.append(k)
    begins = plan.pool.begins
    cells = [np.arange(begins[c], begins[c + 1]) for c in lane[start_loops.NEAREST : start_loops.SECOND + 1]]
    assert sorted(chosen) == sorted(np.concatenate(cells).tolist())
    np.testing.assert_array_less(-1e-5, np.diff(distances[chosen]))
    assert distances[chosen[0]] <= np.sort(distances)[20]


def test_the_first_answer_needs_no_numba(tmp_path):
    program = (
        "import sys, numpy as np, mafsil as mf; robot = mf.load('ur5e');"
        "T = robot.forward_kinematics(np.full(6, 0.3));"
        "assert mf.solve_ik(robot, T) and mf.solve_ik(robot, T[None]);"
        "assert 'numba' not in sys.modules"
    )
    environment = dict(os.environ) | {"MAFSIL_CACHE": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_no_call_leaves_the_compiled_search():
    """The code refers to nothing outside itself: no function of the system's library was put in by the optimiser."""
    from mafsil.kernels import elf, target

    machine = target.host()
    code = target.optimised(PROGRAM.ir(machine), machine)
    assert elf.load(code, ("advance", "block")) is not None or sys.platform != "linux"
    assert {search_loops.RECORD, pose_loops.TASK} == {4, 16}


def test_a_program_takes_numbers_from_its_own_modules_only():
    """Numbers imported from elsewhere would be frozen in the code without being part of its name."""
    own = {f"mafsil.ik.numerical.{name}_loops" for name in ("start", "search", "pose", "block")}
    for module in (start_loops, search_loops, pose_loops, block_loops):
        for node in ast.walk(ast.parse(inspect.getsource(module))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("mafsil"):
                assert node.module in own | {"mafsil.arrays", "mafsil.kernels.loop_compiler"}, node.module
