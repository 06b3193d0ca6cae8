"""Every construct of compiled loops: bit for bit what plain Python finds, or refused with its place."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from mafsil.errors import KernelError
from mafsil.kernels import runtime
from mafsil.kernels.loops import compiled, hold, reordered
from mafsil.kernels.loops.kinds import kind_of
from mafsil.kernels.loops.loop import Loop
from mafsil.kernels.loops.specialisation import specialise
from tests.kernels import language_loops as language


def same(found, wanted):
    """Equal bits, kinds and sizes; NaN equals itself."""
    if isinstance(wanted, tuple):
        assert type(found) is type(wanted)
        assert len(found) == len(wanted)
        for a, b in zip(found, wanted, strict=True):
            same(a, b)
    elif isinstance(wanted, np.ndarray):
        assert (found.shape, found.dtype) == (wanted.shape, wanted.dtype)
        assert found.tobytes() == np.ascontiguousarray(wanted).tobytes()
    elif isinstance(wanted, bool | np.bool_):
        assert found is bool(wanted)
    elif isinstance(wanted, complex):
        same((found.real, found.imag), (wanted.real, wanted.imag))
    else:
        assert type(found) is (int if isinstance(wanted, int | np.integer) else float), (found, wanted)
        assert np.float64(found).tobytes() == np.float64(wanted).tobytes(), (found, wanted)


def both(loop, *arguments):
    """What the loop and its Python find for the same arguments."""
    copies = [x.copy() if isinstance(x, np.ndarray) else x for x in arguments]
    same(loop(*arguments), loop.definition.function(*copies))


@pytest.mark.parametrize("seed", range(5))
def test_numbers_and_functions_are_those_of_python(seed):
    rng = np.random.default_rng(seed)
    for _ in range(200):
        a, b = (float(x) for x in rng.normal(size=2) * 10.0 ** rng.integers(-3, 4, 2))
        m, n = (int(k) for k in rng.integers(1, 40, 2) * rng.choice([-1, 1], 2))
        both(language.numbers, abs(a), b, m, n)
        both(language.functions, a, b)
    both(language.widened, int(rng.integers(0, 30)))


def test_whole_powers_are_products():
    """By squaring: within an ulp of the system's power for each product."""
    for a in np.random.default_rng(1).normal(size=200).tolist():
        np.testing.assert_allclose(
            language.powers(a), (a**-2, a**3, a**7, abs(a) ** 0.5, np.hypot(a, 0.3)), rtol=8 * np.finfo(float).eps
        )


@pytest.mark.parametrize("a", [np.arange(5.0) + 0.5, np.arange(10.0)[::2], np.arange(12.0).reshape(4, 3)[:, 1]])
def test_arrays_of_any_order_are_those_of_numpy(a):
    for i in (0, 1, 3, -2):
        both(language.arrays, a, i)


def test_whole_arrays_tuples_and_complex_numbers():
    rng = np.random.default_rng(3)
    a, b = rng.uniform(1.0, 2.0, (2, 4))
    both(language.whole_arrays, a, b)
    point = language.Point(0.7, a, 4)
    both(language.tuples, point, 0)
    both(language.tuples, point, 2)
    for _ in range(20):
        z, w = (complex(*x) for x in rng.normal(size=(2, 2)))
        both(language.complexes, z, w)
        both(language.complexes, z, z)


def test_division_by_zero_follows_ieee_and_whole_numbers_give_zero():
    whole, real, _ = language.numbers(1.0, 0.0, 5, 0)
    assert whole[:2] == (0, 0)
    assert real[3] == np.inf


def test_held_values_are_written_through():
    point = language.Point(1.5, np.zeros(3), 4)
    assert language.held(hold(point), 1) == 7.0
    assert point.row.tolist() == [0.0, 3.0, 0.0]


def test_results_may_be_views_of_arguments_and_keep_them_alive():
    given = np.arange(4.0)
    part, whole = language.views(given)
    assert np.shares_memory(part, given)
    assert np.shares_memory(whole, given)
    del given, whole
    junk = [np.full(4, np.nan) for _ in range(1000)]
    assert part.tolist() == [1.0, 2.0, 3.0]
    assert len(junk) == 1000


def test_memory_of_results_belongs_to_them_and_goes_with_them():
    kept = [language.arrays(np.arange(5.0), 0)[0] for _ in range(100)]
    assert all(np.array_equal(each[0], np.arange(5.0)) for each in kept)


@pytest.mark.parametrize("linker", ["", "llvm"])
def test_memory_of_results_may_go_after_all_modules(linker):
    """A result in a cycle is collected at the very end of the interpreter, after all modules were emptied."""
    program = (
        "import numpy as np; from tests.kernels import language_loops as language\n"
        "cycle = [language.arrays(np.arange(5.0), 0)[0], language.arrays]; cycle.append(cycle)\n"
        "def keep(): return cycle\n"
        "keep.cycle = [keep, cycle]\n"
    )
    environment = {**os.environ, "MAFSIL_LINKER": linker}
    done = subprocess.run([sys.executable, "-X", "faulthandler", "-c", program], env=environment, check=False)
    assert done.returncode == 0


@pytest.mark.parametrize("n", [10**7, 1 << 40, -1])
def test_lack_of_memory_is_an_error_of_python(n):
    with pytest.raises(MemoryError):
        language.too_much(n)


@pytest.mark.parametrize(
    ("loop", "words"),
    [(language.sets, ("language_loops.py:", "{1, 2}")), (language.two_kinds, ("language_loops.py:", "y"))],
)
def test_what_is_not_of_the_language_is_refused_with_its_place(loop, words):
    with pytest.raises(KernelError) as error:
        loop(1.0)
    assert all(word in str(error.value) for word in words)


@pytest.mark.parametrize("argument", [[1.0, 2.0], "text", {1: 2}, np.array(["a"]), np.zeros(3, ">f8"), object()])
def test_arguments_of_other_types_are_refused(argument):
    with pytest.raises(KernelError):
        language.views(argument)


def test_other_counts_of_arguments_are_refused_and_names_are_taken():
    with pytest.raises(TypeError):
        language.widened()
    assert language.widened(n=4) == language.widened(4)


def test_threads_may_meet_at_the_first_call():
    found: list[object] = []
    threads = [threading.Thread(target=lambda: found.append(language.widened(9))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(found)) == 1
    assert len(found) == 8


@pytest.mark.parametrize(
    "switch", [{"MAFSIL_LOOPS": "python"}, {"MAFSIL_LINKER": "llvm"}, {"MAFSIL_FEATURES": "-avx2"}]
)
def test_loops_run_as_python_with_the_other_loader_and_on_lesser_processors(switch, tmp_path):
    program = (
        "import numpy as np; from tests.kernels.language_loops import *;"
        "print(widened(9), arrays(np.arange(5.0), 1)[5:8], held(hold(Point(1.5, np.zeros(3), 4)), 1),"
        "type(widened).__name__)"
    )
    run = [
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "MAFSIL_CACHE": str(tmp_path), **extra},
            capture_output=True, text=True, check=True, timeout=240,
        ).stdout.replace("np.float64(", "").replace(")", "")
        for extra in ({}, switch)
    ]  # fmt: skip
    kinds = [text.split()[-1] for text in run]
    assert kinds == ["Loop", "function" if "MAFSIL_LOOPS" in switch else "Loop"]
    assert run[0].rsplit(" ", 1)[0].replace("(", "") == run[1].rsplit(" ", 1)[0].replace("(", "")


def test_loops_run_as_python_where_objects_lie_elsewhere(monkeypatch):
    monkeypatch.setattr(runtime, "available", lambda: False)
    loop = Loop(language.widened.definition)
    assert loop(9) == language.widened(9)
    point = hold(language.Point(1.5, np.zeros(3), 4))
    Loop(language.held.definition)(point, 1)
    assert point.value.row.any()


@pytest.mark.parametrize(
    ("loop", "wide"),
    [
        (compiled(language.doubled), False),
        (compiled(language.doubled_in_groups), True),
        (reordered(language.doubled), True),
    ],
)
def test_vectors_are_filled_where_turns_are_a_constant_or_sums_may_be_reordered(loop, wide):
    row = kind_of(np.zeros(64))
    lines = specialise(loop, (row, row)).module()[0].splitlines()
    marks = [line.split("!llvm.loop ")[1] for line in lines if "!llvm.loop " in line]
    scalar = next(line.split(" = ")[0] for line in lines if '"llvm.loop.vectorize.enable", i1 false' in line)
    refused = [mark for mark in marks if any(line.startswith(f"{mark} = ") and scalar in line for line in lines)]
    assert bool(refused) is not wide
    a, out = np.arange(64.0), np.empty(64)
    loop(a, out)
    assert (out == 2.0 * a).all()
