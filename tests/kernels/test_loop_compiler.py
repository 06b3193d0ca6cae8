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
from mafsil.ik.numerical import batch_loops, pose_loops, records, search_loops
from mafsil.ik.numerical import sample_loops as sample_loops_of_search
from mafsil.ik.numerical.fast_search import search_of
from mafsil.ik.numerical.program import MODULES, PROGRAM
from mafsil.ik.numerical.search import new_search
from mafsil.kernels.loop_compiler import LoopProgram, Rows
from tests.kernels import sample_loops

SAMPLES = LoopProgram(
    ["tests.kernels.sample_loops"], ("arithmetic", "squared", "singles", "control", "views", "recorded")
)
LOADED = "from mafsil.kernels.loop_compiler import Record, Rows"
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
        "class P(Record):\n    a: int\ndef f(p: P) -> int:\n    return p.b",
        "class P(Record):\n    a: Floats\ndef f(p: P, x: Floats) -> None:\n    p.a = x",
        "class P(Record):\n    a: int\ndef f(p: Rows[P]) -> int:\n    return p.a",
    ],
)
def test_what_is_not_of_the_language_is_refused(body, tmp_path, monkeypatch):
    name = f"refused_{abs(hash(body))}"
    (tmp_path / f"{name}.py").write_text(f"from __future__ import annotations\nimport numpy as np\n{LOADED}\n{body}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(KernelError, match="refused"):
        _ = LoopProgram([name], ("f",))["f"]


@pytest.mark.parametrize("name", ["panda", "ur5e", "planar3r", "scara_rrrp"])
def test_the_search_is_the_same_as_python(name):
    """The whole search for some poses, its loops run by Python around the same kernels."""
    robot = mf.load(name)
    search = search_of(robot, None, True, 0, "pose", (0.0, 0.0, 1.0), None, 1e-10, None)
    plan, n, k = search.plan, robot.n, 5
    q = np.random.default_rng(3).uniform(-1, 1, (k, n))
    T = robot.forward_kinematics(np.clip(q, robot.limits.lower, robot.limits.upper)).reshape(k, 16)
    T[3, 5] += 0.1
    found, _ = search.rows(T, np.zeros((0, n)), 31)
    state = new_search(plan, np.zeros((k, 16)), np.zeros(k, records.PoseRecord.dtype()))
    state.step, state.q0 = plan.step.addresses.batch, np.zeros(0)
    for name in ("desired", "q", "lane_desired", "lane_states"):
        setattr(state, name, getattr(state, name).ravel())
    report = np.zeros_like(found).ravel()
    batch = records.Batch(search=state, check=plan.check.addresses.batch, given=T.ravel(), allowed=32, report=report)
    batch.zeros = np.zeros(n)
    assert batch_loops.solve_batch(batch) == k - 1
    np.testing.assert_array_equal(report.reshape(found.shape), found)
    for row in (0, 1, 2, 4):
        alone = search.single(T[row].reshape(4, 4), None, 31)
        np.testing.assert_array_equal(alone.nearest, found[row, records.CONFIGURATION :])


def test_samples_come_in_the_order_of_their_distance():
    robot = mf.load("puma560")
    plan = search_of(robot, None, True, 0, "pose", (0.0, 0.0, 1.0), None, 1e-10, None).plan
    T = robot.forward_kinematics(np.full(6, 0.3)).reshape(1, 16)
    exact, lane = np.zeros(12), records.Lane(nearest=-1, last=-1)
    sample_loops_of_search.features_of(plan.record, T[0], exact)
    rows, pool = plan.problem.poses(plan.pool.samples), plan.pool
    features = np.hstack([pool.rotation_factor * rows[:, :3, :3].reshape(-1, 9), pool.position_factor * rows[:, :3, 3]])
    distances = ((features - exact) ** 2).sum(axis=1)
    chosen = []
    while (k := sample_loops_of_search.next_sample(plan.record, T[0], lane)) >= 0:
        chosen.append(k)
    begins = pool.first_sample
    cells = [np.arange(begins[c], begins[c + 1]) for c in (lane.nearest, lane.second)]
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
    assert elf.load(code, ("advance", "solve_batch")) is not None or sys.platform != "linux"


def test_a_program_takes_numbers_from_its_own_modules_only():
    """Numbers imported from elsewhere would be frozen in the code without being part of its name."""
    own = {f"mafsil.ik.numerical.{name}" for name in MODULES}
    for module in (records, sample_loops_of_search, search_loops, pose_loops, batch_loops):
        assert module.__name__ in own
        for node in ast.walk(ast.parse(inspect.getsource(module))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("mafsil"):
                assert node.module in own | {"mafsil.arrays", "mafsil.kernels.loop_compiler"}, node.module


def test_records_are_read_and_written_as_in_python():
    states = []
    for run in (sample_loops.recorded, lambda outer: SAMPLES["recorded"](outer.address)):
        points = np.zeros(3, sample_loops.Point.dtype())
        points["x"] = [0.5, -1.5, 2.0]
        outer = sample_loops.Cloud(points=Rows(sample_loops.Point, points), numbers=np.arange(3.0), size=3, total=0.25)
        outer.first = sample_loops.Point(x=7.0, count=2)
        states.append((run(outer), outer.total, outer.first.count, outer.numbers.tolist(), points.tolist()))
    assert states[0] == states[1]
    assert states[0][1] == 0.25 + 0.5 - 1.5 + 2.0 + 7.0
