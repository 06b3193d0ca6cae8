"""Elementary functions against mpmath: dense samples and seams, on every instruction set this machine can run."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from mafsil.kernels import exact, target
from mafsil.kernels.audit import Program, exact_ulps
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.program import ULP
from mafsil.kernels.tape import Node, Tape

LEVELS = {
    "host": "",
    "avx2": "-avx512f",
    "avx2 without fma": "-avx512f,-fma",
    "sse2": "-sse3,-ssse3,-sse4.1,-sse4.2,-avx",
}
TINY, SMALLEST, LARGEST = 2.0**-1022, 5e-324, float(np.finfo(float).max)
EXTREMES = [0.0, SMALLEST, TINY / 3, TINY, 1e-300, 1e-20, 1e-8, 0.1, 1.0, 2.0, 1e8, 1e300, LARGEST]


def around(*points: float) -> list[float]:
    """The points, their neighbours, and the same negative."""
    near = [math.nextafter(x, way) for x in points for way in (-math.inf, x, math.inf)]
    return [sign * x for x in near if math.isfinite(x) for sign in (1.0, -1.0)]


def spread(rng: np.random.Generator, low: float, high: float, count: int) -> np.ndarray:
    """Signed numbers, uniform in the logarithm."""
    return np.exp(rng.uniform(math.log(low), math.log(high), count)) * rng.choice([-1.0, 1.0], count)


def samples(op: str, rng: np.random.Generator, count: int) -> np.ndarray:
    """Where a function is tried: its whole domain, its common range more densely, its seams."""
    if op in ("sin", "cos", "tan"):
        quarters = np.array([math.pi / 2 * k for k in (*range(1, 40), 1000003, 2**19 + 1, 2**20 - 1, 2**20, 2**20 + 1)])
        seams = around(*quarters, *(quarters / 2), 6381956970095103.0 * 2.0**797, 1e22, 2.0**20, 1e300, LARGEST)
        parts = [rng.uniform(-4, 4, count), rng.uniform(-1e6, 1e6, count // 2), spread(rng, 1e-10, 1e308, count // 2)]
        return np.concatenate([*parts, seams, around(*EXTREMES)])
    if op in ("asin", "acos"):
        parts = [
            rng.uniform(-1, 1, count),
            1 - np.abs(spread(rng, 1e-16, 0.5, count // 2)),
            spread(rng, 1e-300, 1, 200),
        ]
        return np.concatenate([*parts, around(0.5, 0.55, 1 / 3, np.nextafter(1, 0)), [1.0, -1.0, 0.0, SMALLEST]])
    if op == "log":
        parts = [
            rng.uniform(0.5, 2, count),
            np.abs(spread(rng, SMALLEST * 10, 1e308, count)),
            1 + np.abs(spread(rng, 1e-15, 1, count // 4)),
        ]
        seams = [*around(math.sqrt(2), math.sqrt(0.5), 1.0, 2.0, 2.0**28), *EXTREMES]
        x = np.abs(np.concatenate([*parts, seams]))
        return x[x > 0]
    if op in ("exp", "tanh"):
        halves = [math.log(2) * (k + 0.5) for k in (0, 1, 2, 10, 100)]
        seams = around(*halves, 0.55, 1.0, 36.7, 709.7, 708.4, 2.0**-54, *EXTREMES)
        x = np.concatenate(
            [rng.uniform(-2, 2, count), rng.uniform(-709, 709, count // 2), spread(rng, 1e-20, 1, count // 2), seams]
        )
        return np.append(x, rng.uniform(-745, -708, 100)) if op == "exp" else x
    seams = around(1.0, math.tan(math.pi / 8), 1 / math.tan(math.pi / 8), 2.0**28, *EXTREMES)
    return np.concatenate([rng.uniform(-3, 3, count), spread(rng, 1e-300, 1e300, count), seams])


def pairs(op: str, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Where a function of two arguments is tried."""
    if op == "pow":
        x = np.concatenate(
            [rng.uniform(0, 3, count), np.abs(spread(rng, 1e-300, 1e300, count)), 1 + spread(rng, 1e-12, 0.3, count)]
        )
        y = np.concatenate([rng.uniform(-5, 5, count), rng.uniform(-1, 1, count), spread(rng, 1e-3, 1e3, count)])
        limit = 700 / np.maximum(np.abs(np.log(x)), 1e-300)
        return x, np.clip(y, -limit, limit)
    x, y = rng.normal(size=count), rng.normal(size=count)
    far = spread(rng, 1e-150, 1e150, count), spread(rng, 1e-150, 1e150, count)
    close = spread(rng, 0.3, 3, count)
    seams = np.array([(a, b) for a in around(*EXTREMES) for b in around(*EXTREMES)]).T
    return np.concatenate([x, far[0], close, seams[0]]), np.concatenate(
        [y, far[1], close * rng.choice([1, 0.41421356, 1.0000001], count), seams[1]]
    )


def program(op: str, arity: int, level: str) -> Program:
    """The function alone as a kernel."""
    nodes = (*(Node("input", (0, k)) for k in range(arity)), Node(op, tuple(range(arity))))
    signature = Signature(op, (Port("x", (arity,)),), (Port("y", (1,)),))
    return Program(Tape(nodes, (arity,), ((arity,),)), signature, target.host(LEVELS[level]))


TRUTH = {
    "sin": mp.sin, "cos": mp.cos, "tan": mp.tan, "asin": mp.asin, "acos": mp.acos, "atan": mp.atan, "exp": mp.exp,
    "log": mp.log, "tanh": mp.tanh, "atan2": mp.atan2, "pow": mp.power,
}  # fmt: skip
BINARY = ("atan2", "pow")


def truth(op: str, *x: float) -> mp.mpf:
    """The function to more digits than any cancellation takes."""
    if op == "atan2" and 0.0 in x:
        return mp.mpf(math.atan2(*x)) * mp.pi / mp.mpf(math.pi)  # signs of zeros
    with mp.workprec(1200 if max(abs(v) for v in x) > 1e6 or min(abs(v) for v in x) < 1e-6 else 160):
        return TRUTH[op](*(mp.mpf(float(v)) for v in x))


def worst(op: str, level: str, count: int, seed: int = 0) -> tuple[float, object]:
    """Largest error in ulp over the samples, and where."""
    rng = np.random.default_rng(seed)
    columns = pairs(op, rng, count) if op in BINARY else (samples(op, rng, count),)
    x = np.stack(columns, axis=1)
    (found,) = program(op, x.shape[1], level).batch(x)
    result: tuple[float, object] = (0.0, None)
    for row, value in zip(x, found[:, 0], strict=True):
        expected = truth(op, *row)
        if abs(expected) > LARGEST or abs(expected) < SMALLEST / 2:
            near = math.copysign(math.inf, expected) if abs(expected) > 1 else 0.0
            assert value == near or abs(value) in (LARGEST, SMALLEST), (op, row, value, expected)
            continue
        error = exact_ulps(value, expected) if math.isfinite(value) else math.inf
        if error > result[0]:
            result = error, (tuple(map(float.hex, row.tolist())), float(value), float(expected))
    return result


@pytest.mark.parametrize("level", ["host", "avx2 without fma"])
@pytest.mark.parametrize("op", sorted(TRUTH))
def test_error_stays_below_the_stated_ulp(op: str, level: str) -> None:
    error, where = worst(op, level, 400)
    assert error <= ULP[op], f"{op} on {level}: {error:.2f} ulp at {where}"


def test_special_values_are_those_of_c() -> None:
    inf, nan = math.inf, math.nan
    table = {
        "sin": {inf: nan, -inf: nan, nan: nan, 0.0: 0.0, SMALLEST: SMALLEST},
        "cos": {inf: nan, nan: nan, 0.0: 1.0},
        "tan": {inf: nan, nan: nan, 0.0: 0.0, SMALLEST: SMALLEST},
        "exp": {inf: inf, -inf: 0.0, nan: nan, 0.0: 1.0, 800.0: inf, -800.0: 0.0, 1e300: inf, -1e300: 0.0},
        "log": {inf: inf, 0.0: -inf, -1.0: nan, -inf: nan, nan: nan, 1.0: 0.0},
        "atan": {inf: math.pi / 2, -inf: -math.pi / 2, nan: nan, 0.0: 0.0, SMALLEST: SMALLEST},
        "asin": {1.0: math.pi / 2, -1.0: -math.pi / 2, 1.0000001: nan, inf: nan, nan: nan, SMALLEST: SMALLEST},
        "acos": {1.0: 0.0, -1.0: math.pi, -1.0000001: nan, inf: nan, nan: nan, 0.0: math.pi / 2},
        "tanh": {inf: 1.0, -inf: -1.0, nan: nan, 0.0: 0.0, SMALLEST: SMALLEST, 800.0: 1.0},
    }
    for op, cases in table.items():
        for level in LEVELS:
            (found,) = program(op, 1, level).batch(np.array(list(cases))[:, None])
            assert np.array_equal(found[:, 0], list(cases.values()), equal_nan=True), (op, level, found[:, 0])


def test_odd_functions_keep_the_sign_of_zero() -> None:
    for op in ("sin", "tan", "asin", "atan", "tanh"):
        (found,) = program(op, 1, "host").batch(np.array([[-0.0], [0.0]]))
        assert np.signbit(found[:, 0]).tolist() == [True, False], op


@pytest.mark.parametrize("level", list(LEVELS))
def test_two_arguments_at_the_edges_are_those_of_c(level: str) -> None:
    edges = [0.0, 1.0, 0.5, 2.0, 3.0, 2.5, 1e300, SMALLEST, 2.0**53 + 2, math.inf]
    values = [*edges, *(-x for x in edges), math.nan]
    x = np.array([(a, b) for a in values for b in values])
    with np.errstate(all="ignore"):
        expected = {
            "pow": np.power(x[:, 0], x[:, 1]),
            "atan2": np.arctan2(x[:, 0], x[:, 1]),
        }
    for op, values in expected.items():
        (found,) = program(op, 2, level).batch(x)
        found = found[:, 0]
        assert np.array_equal(np.isnan(found), np.isnan(values)), (op, x[np.isnan(found) != np.isnan(values)])
        assert np.array_equal(np.signbit(found[~np.isnan(found)]), np.signbit(values[~np.isnan(found)])), op
        near = np.isclose(found, values, rtol=1e-15, atol=0, equal_nan=True)
        assert near.all(), (op, x[~near], found[~near], values[~near])


def test_a_huge_angle_leaves_its_neighbours_alone() -> None:
    rng = np.random.default_rng(4)
    x = rng.uniform(-3, 3, (64, 1))
    compiled = program("sin", 1, "host")
    expected = compiled.batch(x)[0]
    for k in range(0, 64, 5):
        spoiled = x.copy()
        spoiled[k] = 1e200
        found = compiled.batch(spoiled)[0]
        assert np.array_equal(np.delete(found, k), np.delete(expected, k))
        assert exact_ulps(found[k, 0], truth("sin", 1e200)) <= 1


def test_the_tables_are_the_minimax_polynomials() -> None:
    path = Path(__file__).with_name("minimax.py")
    spec = importlib.util.spec_from_file_location("minimax", path)
    assert spec is not None
    assert spec.loader is not None
    minimax = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(minimax)
    for name, table in minimax.tables().items():
        assert tuple(table) == getattr(exact, name), name
