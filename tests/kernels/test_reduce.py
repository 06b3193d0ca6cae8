"""Rewriting a tape keeps its values, up to the rounding that fusing changes; NaN stays where it was."""

from __future__ import annotations

import math
import random
from hashlib import blake2b

import numpy as np
import pytest

import mafsil.expression as ex
from mafsil.kernels.audit import Program, ulps
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.reduce import reduce
from mafsil.kernels.reference import evaluate, exact
from mafsil.kernels.schedule import schedule
from mafsil.kernels.tape import BINARY, UNARY, Node, Tape, arguments, read
from tests.sizes import few

CONSTANTS = [0.0, -0.0, 1.0, -1.0, 2.0, 0.5, -4.0, 3.7, 1e-300, math.inf]
SPECIAL = [0.0, -0.0, 1.0, -1.0, 0.5, math.inf, -math.inf, math.nan, 1e308, 5e-324]
EXACT = sorted({*UNARY, *BINARY} - {"pow"})


def random_tape(rng: random.Random, size: int, ops: list[str], inputs: int = 4) -> Tape:
    """A tape of `size` operations; constants and negations are frequent, so that rules meet."""
    nodes = [Node("input", (0, k)) for k in range(inputs)]
    nodes += [Node("const", (), rng.choice(CONSTANTS)) for _ in range(4)]
    for _ in range(size):
        op = rng.choice([*ops, "neg", "add", "sub", "mul", "neg", "mul"])
        nodes.append(
            Node(op, tuple(rng.randrange(max(0, len(nodes) - 12), len(nodes)) for _ in range(1 if op in UNARY else 2)))
        )
    return Tape(tuple(nodes), (inputs,), (tuple(range(len(nodes) - 5, len(nodes))),))


def alike(a: np.ndarray, b: np.ndarray) -> bool:
    """Equal, the sign of zero aside; NaN equals NaN."""
    return np.array_equal(a, b, equal_nan=True)


@pytest.mark.parametrize("seed", few(range(60), 12))
def test_random_programs_keep_their_values(seed: int) -> None:
    """NaN in the same places, numbers within 16 ulp of natural scale.

    Signs of zeros may change, so operations that see them are left out.
    """
    rng = random.Random(seed)
    plain = [op for op in EXACT if op not in ("div", "atan2", "copysign", "sign")]
    tape = random_tape(rng, 40, plain)
    samples = np.array(
        [[rng.choice(SPECIAL) if rng.random() < 0.3 else rng.gauss(0, 2) for _ in range(4)] for _ in range(200)]
    )
    ((before, scale),) = evaluate(tape, [samples])
    reduced = reduce(tape)
    ((after, _),) = evaluate(reduced, [samples])
    for column in range(before.shape[1]):
        assert alike(np.isnan(before[:, column]), np.isnan(after[:, column])), column
    fine = np.isfinite(before) & np.isfinite(after)
    assert ulps(np.where(fine, after, 0), np.where(fine, before, 0), scale).max() <= 16


@pytest.mark.row("R2")
@pytest.mark.parametrize("seed", range(12))
def test_random_programs_compile_to_their_values(seed: int) -> None:
    rng = random.Random(1000 + seed)
    tape = random_tape(
        rng, 60, ["sin", "cos", "sqrt", "atan2", "div", "fmin", "lt", "if_else_zero", "and", "not", "exp", "tanh"]
    )
    samples = np.array([[rng.gauss(0, 1) for _ in range(4)] for _ in range(40)])
    ((expected, scale),) = evaluate(tape, [samples])
    program = Program(reduce(tape), Signature("f", (Port("x", (4,)),), (Port("y", (5,)),)))
    (found,) = program.batch(samples)
    assert alike(np.isnan(found), np.isnan(expected))
    fine = np.isfinite(found) & np.isfinite(expected) & (scale < 1e290)
    assert ulps(np.where(fine, found, 0), np.where(fine, expected, 0), scale).max() <= 64
    for row, values in zip(samples, found, strict=True):
        assert np.array_equal(program.single(row)[0], values, equal_nan=True)


def one(op: str, *args: int, consts: tuple[float, ...] = (), inputs: int = 2, then: tuple[Node, ...] = ()) -> Tape:
    nodes = [Node("input", (0, k)) for k in range(inputs)] + [Node("const", (), c) for c in consts]
    nodes += [Node(op, args), *then]
    return reduce(Tape(tuple(nodes), (inputs,), ((len(nodes) - 1,),)))


def ops(tape: Tape) -> list[str]:
    return [node.op for node in tape.nodes if node.op not in ("input", "const")]


def test_neutral_elements_go() -> None:
    assert ops(one("add", 0, 2, consts=(0.0,))) == []
    assert ops(one("sub", 0, 2, consts=(0.0,))) == []
    assert ops(one("mul", 2, 0, consts=(1.0,))) == []
    assert ops(one("mul", 2, 0, consts=(-1.0,))) == ["neg"]
    assert ops(one("div", 0, 2, consts=(1.0,))) == []


def test_what_may_be_nan_stays() -> None:
    assert ops(one("mul", 0, 2, consts=(0.0,))) == ["mul"]
    assert ops(one("sub", 0, 0)) == ["sub"]
    assert ops(one("div", 0, 0)) == ["div"]


def test_division_by_a_power_of_two_is_a_product_and_by_others_is_not() -> None:
    assert ops(one("div", 0, 2, consts=(-8.0,))) == ["mul"]
    assert ops(one("div", 0, 2, consts=(3.0,))) == ["div"]
    assert ops(one("div", 0, 2, consts=(0.0,))) == ["div"]
    assert ops(one("div", 0, 2, consts=(5e-324,))) == ["div"]


def test_products_and_sums_are_fused_with_their_signs() -> None:
    x, y, z = 0, 1, 2
    mul = Node("mul", (x, y))
    for then, expected in (
        ((Node("add", (3, z)),), "fma"),
        ((Node("sub", (3, z)),), "fms"),
        ((Node("sub", (z, 3)),), "fnma"),
        ((Node("add", (3, z)), Node("neg", (4,))), "fnms"),
        ((Node("sub", (3, z)), Node("neg", (4,))), "fnma"),
        ((Node("neg", (3,)), Node("add", (4, z))), "fnma"),
    ):
        nodes = (*(Node("input", (0, k)) for k in range(3)), mul, *then)
        assert ops(reduce(Tape(nodes, (3,), ((len(nodes) - 1,),)))) == [expected]


def test_sums_of_products_with_other_terms_leave_no_product_unfused() -> None:
    a, b, c, d, e = (ex.symbol(name) for name in "abcde")
    for total, expected in (
        (a + (b * c + d * e), {"fma": 2}),
        (a - (b * c - d * e), {"fma": 1, "fnma": 1}),
        ((b * c - d * e) - a, {"fms": 1, "fnma": 1}),
        ((a + (b * c + d * e)) + e, {"fma": 2, "add": 1}),
        (-(b * c + d * e) - a, {"fma": 1, "fnms": 1}),
        ((a * b + c * d) + (b * c + d * e), {"mul": 1, "fma": 3}),
        (b * c + d * e, {"mul": 1, "fma": 1}),
    ):
        f = ex.Function("f", [ex.vertcat(a, b, c, d, e)], [total])
        reduced = reduce(read(f))
        assert reduced.counts() == expected, total
        point = [1.5, -2.25, 3.0, 0.75, 5.0]
        assert exact(reduced, [point])[0][0] == float(f(point))


def test_a_sum_that_others_use_stays_whole() -> None:
    a, b, c, d, e = (ex.symbol(name) for name in "abcde")
    shared = b * c + d * e
    f = ex.Function("f", [ex.vertcat(a, b, c, d, e)], [ex.vertcat(a + shared, e - shared)])
    assert reduce(read(f)).counts() == {"add": 1, "fma": 1, "mul": 1, "sub": 1}


def test_a_product_used_elsewhere_is_not_computed_twice() -> None:
    nodes = (*(Node("input", (0, k)) for k in range(3)), Node("mul", (0, 1)), Node("add", (3, 2)))
    assert ops(reduce(Tape(nodes, (3,), ((3, 4),)))) == ["mul", "add"]


def test_equal_values_are_shared_up_to_sign() -> None:
    x = ex.symbol("x", 2)
    f = ex.Function("f", [x], [ex.vertcat(x[0] * x[1], x[1] * x[0], -x[0] * x[1], x[0] - x[1], x[1] - x[0])])
    assert sorted(ops(reduce(read(f)))) == ["mul", "neg", "neg", "sub"]


def test_sine_and_cosine_of_opposite_angles_share_their_argument() -> None:
    x = ex.symbol("x", 1)
    assert sorted(ops(reduce(read(ex.Function("f", [x], [ex.vertcat(ex.sin(x), ex.cos(-x))]))))) == ["cos", "sin"]


def test_if_else_becomes_one_select() -> None:
    x = ex.symbol("x", 2)
    assert ops(reduce(read(ex.Function("f", [x], [ex.if_else(x[0] < x[1], x[0], x[1])])))) == ["lt", "select"]


def test_order_needs_few_values_at_once_and_groups_angles() -> None:
    x = ex.symbol("x", 8)
    chains = [x[k] for k in range(8)]
    for _ in range(5):
        chains = [c * c + x[0] for c in chains]
    total = sum(chains) + ex.dot(ex.sin(x), ex.ones(8))
    tape = schedule(read(ex.Function("f", [x], [total])))
    alive, most, last = set[int](), 0, {}
    for i, node in enumerate(tape.nodes):
        for a in arguments(node):
            last[a] = i
    for i in range(len(tape.nodes)):
        alive = {a for a in alive if last.get(a, -1) >= i} | {i}
        most = max(most, len(alive))
    sines = [i for i, node in enumerate(tape.nodes) if node.op == "sin"]
    assert sines == list(range(sines[0], sines[0] + 8))
    assert most <= 22


def test_exact_evaluation_knows_what_is_undefined() -> None:
    tape = Tape((Node("input", (0, 0)), Node("sqrt", (0,)), Node("neg", (0,))), (1,), ((1, 2),))
    assert exact(tape, [[4.0]])[0] == [2, -4]
    assert exact(tape, [[-4.0]])[0][0] is None


SUMS = ["add", "sub", "mul", "mul", "neg", "div", "sqrt", "fabs", "lt", "if_else_zero"]
"""Operations whose folded constants are the same on every system."""


@pytest.mark.parametrize("seed", few(range(60), 12))
def test_dead_values_leave_no_trace(seed: int) -> None:
    """Nobody needs them, so nobody's order, sharing or fusing depends on them."""
    rng = random.Random(seed)
    tape = random_tape(rng, 80, SUMS if seed % 2 else [*SUMS, "sin", "cos", "exp"])
    dead = random_tape(rng, 60, ["sin", "cos", "exp", "add", "mul"]).nodes[8:]
    shift = len(tape.nodes) - 8
    more = [Node(n.op, tuple(a if a < 8 else a + shift for a in arguments(n)), n.value) for n in dead]
    assert reduce(Tape((*tape.nodes, *more), tape.input_sizes, tape.outputs)) == reduce(tape)


def test_the_passes_write_the_same_tapes_as_ever() -> None:
    """Whoever makes them faster changes no bit; whoever changes what they choose says so by this number."""
    digest = blake2b(digest_size=8)
    for seed in range(40):
        digest.update(reduce(random_tape(random.Random(seed), 60 + 5 * seed, SUMS)).text.encode())
    assert digest.hexdigest() == "ff60b200290aba9c"
