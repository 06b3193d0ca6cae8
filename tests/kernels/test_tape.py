"""Reading functions, writing tapes as text, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil.expression as ex
from mafsil.errors import KernelError
from mafsil.expression.matrix import matrix
from mafsil.expression.node import LEAF
from mafsil.expression.node import Node as Value
from mafsil.kernels.layout import Port, Signature, contiguous_steps
from mafsil.kernels.reference import evaluate
from mafsil.kernels.tape import Node, Tape, from_text, read


def values(tape: Tape, *inputs: np.ndarray) -> list[np.ndarray]:
    return [value for value, _ in evaluate(tape, inputs)]


def test_zeros_are_written_and_unused_inputs_are_kept() -> None:
    x, y = ex.symbol("x", 4), ex.zeros(5, 1)
    y[1], y[4] = x[3] * 2, x[1]
    tape = read(ex.Function("f", [x], [y]))
    assert tape.input_sizes == (4,)
    assert tape.output_sizes == (5,)
    (found,) = values(tape, np.array([[9.0, 2.0, 9.0, 5.0]]))
    assert found.tolist() == [[0.0, 10.0, 0.0, 0.0, 2.0]]


def test_squares_doubles_and_inverses_are_products_sums_and_quotients() -> None:
    x = ex.symbol("x", 3)
    tape = read(ex.Function("f", [x], [ex.vertcat(x * ex.norm_2(x), 2 * ex.sin(x[1]), 1 / x[1])]))
    assert set(tape.counts()) == {"add", "mul", "sqrt", "sin", "div"}
    (found,) = values(tape, np.array([[0.0, 3.0, 4.0]]))
    assert found.tolist() == [[0.0, 15.0, 20.0, 2 * np.sin(3.0), 1 / 3]]


def test_text_keeps_every_bit_and_the_hash() -> None:
    nodes = (
        Node("input", (0, 0)),
        Node("const", (), 0.1 + 0.2),
        Node("const", (), -0.0),
        Node("mul", (0, 1)),
        Node("const", (), float("inf")),
    )
    tape = Tape(nodes, (1,), ((3, 2, 4),))
    again = from_text(tape.text)
    assert again == tape
    assert again.hash == tape.hash
    assert str(again.nodes[2].value) == "-0.0"
    assert Tape(nodes, (1,), ((3, 4, 2),)).hash != tape.hash


@settings(max_examples=50, deadline=None)
@given(st.floats(allow_nan=False), st.floats(allow_nan=False))
def test_different_constants_have_different_hashes(a: float, b: float) -> None:
    one, two = (Tape((Node("const", (), v),), (), ((0,),)) for v in (a, b))
    assert (one.hash == two.hash) == (a.hex() == b.hex())


def test_the_same_expression_has_the_same_hash() -> None:
    def tape() -> Tape:
        x = ex.symbol("x", 3)
        return read(ex.Function("f", [x], [ex.sin(x) * ex.dot(x, x)]))

    assert tape().hash == tape().hash


def test_an_operation_without_compiled_form_is_named() -> None:
    x = ex.symbol("x", 1)
    unknown = matrix(1, 1, [Value("erf", x.entries[0], LEAF)])
    with pytest.raises(KernelError, match="operation erf ") as caught:
        read(ex.Function("f", [x], [unknown]))
    assert caught.value.details["operation"] == "erf"
    assert "erf" in caught.value.message("ar")


def test_a_port_that_is_no_column_is_refused() -> None:
    x = ex.symbol("x", 2, 3)
    with pytest.raises(KernelError, match="2 x 3"):
        read(ex.Function("f", [x], [x[:, 0]], ["x"], ["y"]))


def test_counts_name_the_work() -> None:
    x = ex.symbol("x", 2)
    tape = read(ex.Function("f", [x], [ex.vertcat(x[0] * x[1] + x[0], ex.sin(x[0]))]))
    assert tape.operations == 3
    assert tape.counts() == {"add": 1, "mul": 1, "sin": 1}


def test_signatures_speak_numpy() -> None:
    signature = Signature("f", (Port("q", (7,)), Port("s")), (Port("T", (4, 4)),))
    assert signature.gufunc == "(7),()->(4,4)"
    assert signature.core_steps == (3, 4, 4)
    assert contiguous_steps(signature.outputs[0]) == (32, 8)
    assert [port.size for port in signature.ports] == [7, 1, 16]
