"""Elementary functions against mpmath: dense samples and seams, on every instruction set this machine can run."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import casadi as ca
import mpmath as mp
import numpy as np
import pytest

from mafsil.kernels import coefficients, reduce, tape, target
from mafsil.kernels.audit import Program, exact_ulps
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.tape import Node, Tape
from mafsil.kernels.transcendental import ULP

LEVELS = {"host": "", "avx2": "-avx512f", "avx2 without fma": "-avx512f,-fma", "sse2": "-sse4.1,-avx"}
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
    if op in ("asin", "acos", "atanh"):
        parts = [rng.uniform(-1, 1, count), 1 - np.abs(spread(rng, 1e-16, 0.5, count // 2)), spread(rng, 1e-300, 1, 200)]
        return np.concatenate([*parts, around(0.5, 0.55, 1 / 3, np.nextafter(1, 0)), [1.0, -1.0, 0.0, SMALLEST]])
    if op in ("log", "acosh"):
        parts = [rng.uniform(0.5, 2, count), np.abs(spread(rng, SMALLEST * 10, 1e308, count)), 1 + np.abs(spread(rng, 1e-15, 1, count // 4))]
        seams = [*around(math.sqrt(2), math.sqrt(0.5), 1.0, 2.0, 2.0**28), *EXTREMES]
        x = np.abs(np.concatenate([*parts, seams]))
        return x[x >= 1] if op == "acosh" else x[x > 0]
    if op == "log1p":
        parts = [rng.uniform(-0.9, 2, count), spread(rng, 1e-300, 0.99, count), np.abs(spread(rng, 1, 1e308, count // 4))]
        x = np.concatenate([*parts, around(math.sqrt(2) - 1, 1 - math.sqrt(0.5), 2.0**-53, 2.0**-54), EXTREMES])
        return x[x > -1]
    if op in ("exp", "expm1", "sinh", "cosh", "tanh"):
        halves = [math.log(2) * (k + 0.5) for k in (0, 1, 2, 10, 100)]
        seams = around(*halves, 0.55, 1.0, 36.7, 709.7, 708.4, 2.0**-54, *EXTREMES)
        x = np.concatenate([rng.uniform(-2, 2, count), rng.uniform(-709, 709, count // 2), spread(rng, 1e-20, 1, count // 2), seams])
        return np.append(x, rng.uniform(-745, -708, 100)) if op == "exp" else x
    seams = around(1.0, math.tan(math.pi / 8), 1 / math.tan(math.pi / 8), 2.0**28, *EXTREMES)
    return np.concatenate([rng.uniform(-3, 3, count), spread(rng, 1e-300, 1e300, count), seams])


def pairs(op: str, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Where a function of two arguments is tried."""
    if op == "pow":
        x = np.concatenate([rng.uniform(0, 3, count), np.abs(spread(rng, 1e-300, 1e300, count)), 1 + spread(rng, 1e-12, 0.3, count)])
        y = np.concatenate([rng.uniform(-5, 5, count), rng.uniform(-1, 1, count), spread(rng, 1e-3, 1e3, count)])
        limit = 700 / np.maximum(np.abs(np.log(x)), 1e-300)
        return x, np.clip(y, -limit, limit)
    x, y = rng.normal(size=count), rng.normal(size=count)
    far = spread(rng, 1e-150, 1e150, count), spread(rng, 1e-150, 1e150, count)
    close = spread(rng, 0.3, 3, count)
    seams = np.array([(a, b) for a in around(*EXTREMES) for b in around(*EXTREMES)]).T
    return np.concatenate([x, far[0], close, seams[0]]), np.concatenate([y, far[1], close * rng.choice([1, 0.41421356, 1.0000001], count), seams[1]])


def program(op: str, arity: int, level: str) -> Program:
    """The function alone as a kernel."""
    nodes = (*(Node("input", (0, k)) for k in range(arity)), Node(op, tuple(range(arity))))
    signature = Signature(op, (Port("x", (arity,)),), (Port("y", (1,)),))
    return Program(Tape(nodes, (arity,), ((arity,),)), signature, target.host(LEVELS[level]))


TRUTH = {
    "sin": mp.sin, "cos": mp.cos, "tan": mp.tan, "asin": mp.asin, "acos": mp.acos, "atan": mp.atan, "exp": mp.exp,
    "expm1": mp.expm1, "log": mp.log, "log1p": mp.log1p, "sinh": mp.sinh, "cosh": mp.cosh, "tanh": mp.tanh,
    "asinh": mp.asinh, "acosh": mp.acosh, "atanh": mp.atanh, "atan2": mp.atan2, "pow": mp.power, "hypot": mp.hypot,
}  # fmt: skip
BINARY = ("atan2", "pow", "hypot")


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
