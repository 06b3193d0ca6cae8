"""Naming the machine: features that may be switched off, lanes that follow, code that stays loaded."""

from __future__ import annotations

import ctypes
import gc

import pytest

from mafsil.kernels import target

X86 = target.host().triple.startswith("x86_64")
ADD = "define double @f(double %x) { %y = fadd double %x, 1.0 ret double %y }"


@pytest.mark.row("D2")
@pytest.mark.skipif(not X86, reason="x86 features")
@pytest.mark.parametrize(
    ("changes", "lanes", "fma", "rounding"),
    [
        ("-avx512f", 4, True, True),
        ("-avx512f,-fma", 4, False, True),
        ("-avx", 2, False, True),
        ("-avx,-sse4.1", 2, False, False),
    ],
)
def test_removed_features_take_their_dependents_along(changes: str, lanes: int, fma: bool, rounding: bool) -> None:
    machine = target.emulate(
        target.describe_target("x86_64-unknown-linux-gnu", "znver4", target.host().features), changes
    )
    assert "+avx512" not in machine.features
    assert machine.lanes <= lanes
    assert not (machine.fma and not fma)
    assert not (machine.rounding and not rounding)


@pytest.mark.skipif(not X86, reason="x86 features")
def test_the_environment_may_remove_features(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(target.FEATURES_VARIABLE, "-avx")
    assert target.host().lanes == 2
    assert not target.host().fma
    assert target.host("").identity != target.host().identity or target.host("").lanes == 2


def test_lanes_may_be_chosen() -> None:
    assert target.host(lanes=1 + 1).lanes == 2


def test_code_lives_as_long_as_its_object() -> None:
    codes = [target.load(target.compile(ADD, target.host()), ("f",)) for _ in range(3)]
    functions = [ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(code.addresses["f"]) for code in codes]
    del codes[0]
    gc.collect()
    assert [f(2.0) for f in functions[1:]] == [3.0, 3.0]


def test_imports_are_resolved_by_address() -> None:
    twice = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(lambda x: 2 * x)
    ir = "declare double @g(double) define double @f(double %x) { %y = call double @g(double %x) ret double %y }"
    address = ctypes.cast(twice, ctypes.c_void_p).value
    assert address is not None
    code = target.load(target.compile(ir, target.host()), ("f",), {"g": address})
    assert ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(code.addresses["f"])(4.0) == 8.0
