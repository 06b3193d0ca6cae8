"""The life of a kernel: compiled once and late, cached, proved by its canary, shipped by description."""

from __future__ import annotations

import copy
import ctypes
import json
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
import time
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from mafsil.code_store import CacheWarning
from mafsil.code_store import store as stores
from mafsil.errors import InputError, KernelError
from mafsil.kernels import (
    Kernel,
    Port,
    Signature,
    cache,
    call,
    compile,
    compiler,
    elf,
    fingerprint,
    identity,
    image,
    lower,
    small_batch,
    target,
    warm,
)
from mafsil.kernels.cache import Store
from mafsil.kernels.compiler import shared_code
from mafsil.kernels.layout import BATCH, LANE_COUNT, SINGLE
from tests.reliability import specimens

ROOT = Path(__file__).resolve().parents[2]
VECTOR = Signature("scaled", (Port("x", (4,)),), (Port("y", (4,)),))
builds: list[float] = []


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache, nothing loaded, nothing said."""
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(stores, "_warned", set())
    compiler._images.clear()
    builds.clear()
    return tmp_path / "cache"


def scaled(factor: float):
    import mafsil.expression as ex

    builds.append(factor)
    x = ex.symbol("x", 4)
    return ex.Function("scaled", [x], [factor * x + ex.sin(x)], ["x"], ["y"])


def scaled_kernel(factor: float) -> Kernel:
    return compile(VECTOR, partial(scaled, factor), key=f"scaled {factor}")


def again() -> None:
    """As if the process had just begun."""
    for kept in (compiler._images, compiler._shared, compiler._in_stores):
        kept.clear()


def object_key(k: Kernel, part: str) -> str:
    """Of the code of a part."""
    return k.order(Store(None)).object_key(part, k.image.hash)


X = np.array([0.1, -0.2, 0.3, 1.0])


def test_nothing_happens_before_the_first_use(folder):
    k = scaled_kernel(2.0)
    repr(k), copy.copy(k), pickle.dumps(k)
    assert not builds
    assert not folder.exists()
    k(X)
    assert builds == [2.0]
    k(X), scaled_kernel(2.0)(X)
    assert builds == [2.0]


def test_the_cache_spares_the_builder(folder):
    first = scaled_kernel(2.0)
    want = first(X)
    assert not first.provenance.cached
    del first
    again()
    second = scaled_kernel(2.0)
    assert (second(X) == want).all()
    assert second.provenance.cached
    assert builds == [2.0]
    assert len(list(folder.glob("*.tape"))) == 1
    assert (
        len(list(folder.glob("*.kernel"))) == 3
    )  # the single entry, what is the same for all kernels of this shape, and for all kernels


def test_a_start_from_the_cache_imports_neither_llvm_nor_expressions(folder):
    specimens.kernel(2)(np.zeros(2), 0.0)
    code = """
import sys
from tests.reliability import specimens
k = specimens.kernel(2)
k([0.0, 0.0], 0.0)
print(k.provenance.cached, "mafsil.expression" in sys.modules, "llvmlite" in sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.split() == ["True", "False", str(not elf._here())]


def test_importing_kernels_is_light():
    heavy = ("mafsil.expression", "llvmlite", "scipy", "numba", "matplotlib")
    code = f"import sys, mafsil.kernels; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_off_keeps_it_in_memory(folder, monkeypatch):
    monkeypatch.setenv("MAFSIL_CACHE", "off")
    cache._store.cache_clear()
    scaled_kernel(3.0)(X)
    again()
    scaled_kernel(3.0)(X)
    assert builds == [3.0]
    assert not folder.exists()
    cache._store.cache_clear()


def keys(k: Kernel, hash: str = "0" * 32) -> tuple[str, ...]:
    """Of the tape, and of every part of the code that a tape of that hash has."""
    order = k.order(Store(None))
    return order.key, *(order.object_key(part, hash) for part in image.ENTRIES)


@pytest.mark.parametrize(
    ("change", "tape", "code", "around"),
    [
        ("key", True, False, False),
        ("fingerprint", True, False, False),
        ("tracer", True, False, False),
        ("names", True, False, False),
        ("shapes", True, True, True),
        ("tape", False, True, False),
        ("target", False, True, True),
        ("toolchain", False, True, True),
        ("source", True, True, True),
    ],
)
def test_whatever_shapes_a_level_changes_its_key(change, tape, code, around, monkeypatch):
    base = compile(VECTOR, partial(scaled, 1.0), key="a", fingerprints=("f",))
    before = keys(base)
    assert len(set(before)) == 1 + len(image.ENTRIES)
    assert before == keys(compile(VECTOR, partial(scaled, 9.0), key="a", fingerprints=("f",), doc="other"))
    other = {
        "key": {"key": "b"},
        "names": {"signature": Signature("scaled", VECTOR.inputs, (Port("z", (4,)),))},
        "shapes": {"signature": Signature("scaled", VECTOR.inputs, (Port("y", (2, 2)),))},
        "fingerprint": {"fingerprints": ("g",)},
        "target": {"target": target.host("-avx")},
    }.get(change, {})
    for name in ("toolchain", "tracer"):
        if change == name:
            monkeypatch.setattr(identity, name, lambda: "another release")
    if change == "source":
        monkeypatch.setattr(identity, "fingerprint", lambda *_: "edited")
    given = {"signature": VECTOR, "key": "a", "fingerprints": ("f",), "target": None} | other
    signature = given.pop("signature")
    after = keys(compile(signature, partial(scaled, 1.0), **given), "1" * 32 if change == "tape" else "0" * 32)
    assert [a != b for a, b in zip(before, after, strict=True)] == [tape, code, code, code, around]


def test_fingerprint_follows_the_sources(tmp_path, monkeypatch):
    package = tmp_path / "somepackage"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "a.py").write_text("x = 1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    seen = set()
    for source in ("x = 1\n", "x = 2\n", "x = 2 \n"):
        (package / "a.py").write_text(source)
        fingerprint.cache_clear()
        seen.add(fingerprint("somepackage"))
    (package / "a.py").rename(package / "b.py")
    fingerprint.cache_clear()
    seen.add(fingerprint("somepackage"))
    assert len(seen) == 4
    assert fingerprint("no_such_package_here") != fingerprint("somepackage")
    assert "somepackage" not in sys.modules
    fingerprint.cache_clear()


@pytest.mark.parametrize("part", [SINGLE, BATCH])
def test_a_canary_that_falls_silent_means_compiling_again(part, folder):
    """A valid entry that holds another kernel's code: no checksum can tell, the stored answers do."""
    rows = np.stack([X, X])
    scaled_kernel(2.0)(X), scaled_kernel(5.0)(X)
    scaled_kernel(2.0)(rows), scaled_kernel(5.0)(rows)
    store = Store(folder)
    keys = [object_key(scaled_kernel(f), part) for f in (2.0, 5.0)]
    entries = [store.get(key) for key in keys]
    impostor = cache.Entry(entries[1].code, entries[0].inputs, entries[0].outputs, entries[0].provenance)
    store.put(keys[0], impostor)
    again()
    builds.clear()
    with pytest.warns(CacheWarning, match="does not repeat"):
        answer = scaled_kernel(2.0)(X if part == SINGLE else rows)
    np.testing.assert_allclose(answer, 2 * (X if part == SINGLE else rows) + np.sin(X))
    assert not builds  # the tape is still good
    assert store.get(keys[0]).outputs == entries[0].outputs


def test_parts_of_two_kernels_are_never_mixed(folder):
    """A cached part that is sound in itself, but answers otherwise than the part in use, is made again."""
    k, other = scaled_kernel(2.0), scaled_kernel(5.0)
    k(X), other(np.stack([X, X]))
    store = Store(folder)
    k.image.hash  # noqa: B018 - traced
    foreign = store.get(object_key(other, BATCH))
    store.put(object_key(k, BATCH), foreign)
    with pytest.warns(CacheWarning, match="does not repeat"):
        answer = k(np.stack([X, X]))
    np.testing.assert_allclose(answer[1], 2 * X + np.sin(X))


ONES = """
define dso_local void @mafsil_single(ptr %x, ptr %y) {
  store double 1.0, ptr %y, align 8
  ret void
}
"""


@pytest.mark.parametrize("loaded", [True, False])
def test_code_whose_entries_disagree_is_never_used(loaded, monkeypatch, folder):
    """The batch entry is in memory, or in the cache only, when a single entry is made that contradicts it."""
    k = scaled_kernel(2.0)
    k(np.stack([X, X]))
    if not loaded:
        del k
        again()
    honest = lower.translate
    monkeypatch.setattr(lower, "translate", lambda part, *rest: ONES if part == SINGLE else honest(part, *rest))
    k = scaled_kernel(2.0)
    for _ in range(2):
        with pytest.raises(KernelError, match="different bits"):
            k(X)
    assert not (folder / f"{object_key(k, SINGLE)}.kernel").exists()
    assert (k(np.stack([X, X])) == k(np.stack([X, X, X]))[:2]).all()


def test_same_bits_means_bits():
    a = np.array([1.0, np.nan, 0.0, np.inf])
    other_nan = a.copy()
    other_nan.view(np.int64)[1] ^= np.int64(5 - (1 << 63))
    assert image.same_bits(a.tobytes(), other_nan.tobytes())
    for index, value in ((0, np.nextafter(1.0, 2)), (1, 1.0), (2, -0.0), (3, -np.inf)):
        b = a.copy()
        b[index] = value
        assert not image.same_bits(a.tobytes(), b.tobytes())
    assert not image.same_bits(a.tobytes(), a[:2].tobytes())


def test_threads_compile_a_kernel_once():
    barrier = threading.Barrier(8)
    kernels = [scaled_kernel(4.0) for _ in range(8)]
    answers = []

    def use(k: Kernel) -> None:
        barrier.wait()
        answers.append(k(X).tobytes())

    threads = [threading.Thread(target=use, args=(k,)) for k in kernels]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert builds == [4.0]
    assert len(set(answers)) == 1
    assert len({k.image for k in kernels}) == 1


def test_a_failing_builder_fails_each_time_and_locks_nothing():
    def fail():
        builds.append(0.0)
        raise KernelError("call.unequal", name="x")

    k = compile(VECTOR, fail, key="fails")
    for _ in range(2):
        with pytest.raises(KernelError):
            k(X)
    assert len(builds) == 2


def test_each_part_is_compiled_when_it_is_needed(folder):
    k = scaled_kernel(7.0)
    k(X), k(x=X), k(X.tolist()), k(X, out=np.empty(4)), k(X[::-1])
    assert k.image.parts.keys() == {call.CALL, SINGLE}
    with pytest.raises(InputError):
        k(np.full(4, np.nan))
    assert k.image.parts.keys() == {call.CALL, SINGLE}
    again()
    k = scaled_kernel(7.0)
    rows = np.stack([X] * 600)
    k(rows[:2]), k(rows), k(rows[:0]), k(rows[:, None]), k(rows, threads=2), k(rows[:9].tolist())
    assert k.image.parts.keys() == {call.CALL, BATCH}
    assert (k(X) == k(rows)[-1]).all()
    assert (k(rows[:3]) == k(rows)[:3]).all()
    assert k.image.parts.keys() == set(image.FROM_PYTHON)
    assert builds == [7.0]


def test_lanes_are_compiled_once_rows_one_after_another_took_as_long(folder, monkeypatch):
    """Whatever a few rows look like, they come from the single entry with the bits of lanes."""
    rows = np.random.default_rng(0).normal(size=(5, 3, 4)) * 1e3
    wide = np.zeros((5, 3, 8))[..., ::2]
    wide[:] = rows
    forms = [rows, rows[::-2], rows[0, :1], rows.swapaxes(0, 1), np.broadcast_to(rows[0, 0], (7, 4)), wide, rows[:0]]
    k = scaled_kernel(9.0)
    monkeypatch.setattr(small_batch, "SINGLY", 200)
    single = [k(form) for form in forms]
    assert k.image.parts.keys() == {call.CALL, SINGLE}
    out = np.empty((3, 5, 4))
    assert k(rows.swapaxes(0, 1), out=out) is out
    assert k.image.parts.keys() == {call.CALL, SINGLE}
    with pytest.raises(InputError):
        k(rows, threads=0)
    k(rows, out=np.empty((5, 3, 8))[..., ::2])
    assert BATCH in k.image.parts
    assert np.isfinite(single[0]).all()
    assert [x.tobytes() for x in single] == [k(form).tobytes() for form in forms]
    assert out.tobytes() == single[3].tobytes()


def test_many_small_batches_get_lanes_and_so_does_whoever_finds_them_in_the_store(folder, monkeypatch):
    k = scaled_kernel(7.0)
    monkeypatch.setattr(small_batch, "SINGLY", 10)
    for _ in range(4):
        assert BATCH not in k.image.parts
        k(np.stack([X] * 3))
    assert BATCH in k.image.parts
    again()
    k = scaled_kernel(7.0)
    k(np.stack([X] * 3))
    assert k.image.parts.keys() == {call.CALL, BATCH}
    assert k.provenance.cached


def test_rows_in_lanes_give_the_bits_of_a_batch(folder):
    """Eight rows side by side go in and come out without being transposed."""
    k = scaled_kernel(7.0)
    rows = np.random.default_rng(0).normal(size=(LANE_COUNT, 4)) * 1e3
    x, y = (np.empty(4 * LANE_COUNT + 8) for _ in range(2))
    x, y = (room[-(room.ctypes.data // 8) % 8 :][: 4 * LANE_COUNT].reshape(4, LANE_COUNT) for room in (x, y))
    x[:] = rows.T
    ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(k.addresses.lanes)(x.ctypes.data, y.ctypes.data)
    assert (y.T == k(rows)).all()


def test_one_row_of_a_batch_takes_the_single_entry_where_it_is(folder):
    """Compiled loops call the batch entry with one row: its bits are the same with and without the single entry."""
    k = scaled_kernel(7.0)
    alone = k(X[None])
    assert SINGLE not in k.image.parts
    want = k(X)
    assert alone.tobytes() == want.tobytes() == k(X[None]).tobytes()


def test_threads_compile_both_parts_once(monkeypatch):
    made = []
    honest = lower.translate
    monkeypatch.setattr(lower, "translate", lambda part, *rest: made.append(part) or honest(part, *rest))
    k = scaled_kernel(8.0)
    barrier = threading.Barrier(8)

    def use(i: int) -> None:
        barrier.wait()
        k(X) if i % 2 else k(np.stack([X, X]))

    threads = [threading.Thread(target=use, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(made) == sorted(image.FROM_PYTHON)
    assert builds == [8.0]


def test_an_edit_that_changes_no_operation_costs_tracing_only(folder, monkeypatch):
    """Other words, the same tape: the code is found; another tape: it is compiled."""
    made = []
    honest = lower.translate
    monkeypatch.setattr(lower, "translate", lambda part, *rest: made.append(part) or honest(part, *rest))
    warm([compile(VECTOR, partial(scaled, 2.0), key="scaled", fingerprints=("before",))])
    assert sorted(made) == sorted(image.FROM_PYTHON)
    made.clear()
    edited = compile(VECTOR, partial(scaled, 2.0), key="scaled", fingerprints=("after",))
    warm([edited])
    assert builds == [2.0, 2.0]
    assert not made
    assert edited.provenance.cached
    warm([compile(VECTOR, partial(scaled, 3.0), key="scaled", fingerprints=("later",))])
    assert sorted(made) == sorted((BATCH, SINGLE))  # what lies around them knows shapes only
    assert len(list(folder.glob("*.tape"))) == 3
    assert len(list(folder.glob("*.kernel"))) == 6  # what all kernels call among them


def test_a_tape_that_is_not_its_hash_is_traced_again(folder):
    """Sealed as it should be, but the text is another's, or no text: nothing is compiled of it."""
    store = Store(folder)
    k = scaled_kernel(2.0)
    k(X)
    key = k.order(store).key
    entry = store.get_tape(key)
    other = scaled_kernel(3.0)
    other(X)
    for wrong in (store.get_tape(other.order(store).key).packed, b"", b"no text", entry.packed[:-4]):
        store.put_tape(key, replace(entry, packed=wrong))
        store._codes.discard(object_key(k, BATCH))
        again()
        builds.clear()
        np.testing.assert_allclose(scaled_kernel(2.0)(np.stack([X, X]))[0], 2 * X + np.sin(X))
        assert builds == [2.0]
        assert store.get_tape(key).text() == entry.text()


def test_a_tape_that_is_swept_away_is_traced_again(folder):
    k = scaled_kernel(2.0)
    k(X)
    for path in folder.glob("*.tape"):
        path.unlink()
    np.testing.assert_allclose(k(np.stack([X, X]))[0], 2 * X + np.sin(X))
    assert builds == [2.0, 2.0]


def test_warm_readies_several(folder):
    kernels = [scaled_kernel(float(f)) for f in range(4)]
    warm(kernels, workers=3)
    assert sorted(builds) == [0.0, 1.0, 2.0, 3.0]
    assert all("image" in vars(k) for k in kernels)
    assert len(list(folder.glob("*.kernel"))) == 2 * 4 + 2
    warm(kernels)
    assert len(builds) == 4


def test_provenance_prints_what_was_compiled():
    k = specimens.kernel(3)
    text = str(k)
    assert "planar_arm: " in text
    assert "3 sin" in text
    assert f"{k.provenance.lanes} lanes" in text
    assert "cached" not in text
    assert repr(k) == "<Kernel planar_arm: (3),()->(4,4),(2,3),()>"
    again()
    assert "from the cache" in str(specimens.kernel(3))
    assert k.provenance.total == sum(k.provenance.operations.values())
    assert json.loads(k.provenance.as_json())["key"] == k.provenance.key


def test_addresses_are_the_entries():
    import ctypes

    k = scaled_kernel(2.0)
    y = np.empty(4)
    ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(k.addresses.single)(X.ctypes.data, y.ctypes.data)
    assert (y == k(X)).all()
    assert k.addresses.batch != k.addresses.single


@pytest.mark.row("C2")
@pytest.mark.parametrize("protocol", range(2, 6))
def test_pickle(protocol):
    for k in (specimens.kernel(3), scaled_kernel(2.0)):
        clone = pickle.loads(pickle.dumps(k, protocol))
        used = pickle.loads(pickle.dumps((k(*([X] if k.signature is VECTOR else [X[:3], 0.5])), k)[1], protocol))
        args = [X] if k.signature == VECTOR else [X[:3], 0.5]
        assert specimens.bits(clone(*args)) == specimens.bits(k(*args)) == specimens.bits(used(*args))
        assert clone.signature == k.signature
        assert clone.image is k.image


@pytest.mark.row("C2")
def test_copies_are_the_kernel_itself():
    k = specimens.kernel(3)
    assert copy.copy(k) is k
    assert copy.deepcopy({"k": [k]})["k"][0] is k


@pytest.mark.row("C2")
@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_kernels_travel_to_worker_processes(method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {method} here")
    k = specimens.kernel(3)
    args = specimens.states(3, 50)
    want = specimens.bits(k(*args))
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.starmap(specimens.answer, [(k, args)] * 4) == [want] * 4


@pytest.mark.row("C2")
def test_another_processor_gives_the_same_numbers(tmp_path):
    k = specimens.kernel(3)
    args = specimens.states(3, 50)
    (tmp_path / "kernel").write_bytes(pickle.dumps((k, args)))
    code = f"""
import pickle, sys
k, args = pickle.load(open({str(tmp_path / "kernel")!r}, "rb"))
answer = k(*args)
pickle.dump((answer, k.provenance.lanes), sys.stdout.buffer)
"""
    for features in ("-avx512f", "-avx,-avx2,-fma"):
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=ROOT, capture_output=True, check=True, timeout=120,
            env={**os.environ, "MAFSIL_FEATURES": features},
        )  # fmt: skip
        answer, lanes = pickle.loads(done.stdout)
        assert lanes <= 4
        for a, b in zip(answer, k(*args), strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=4e-16 * 4)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_in_the_middle_of_compiling_is_safe():
    """Another thread compiles while this one forks; the child compiles, too."""
    busy = threading.Thread(target=lambda: [scaled_kernel(float(f))(X) for f in range(10, 16)])
    busy.start()
    children = []
    while busy.is_alive():
        pid = os.fork()
        if pid == 0:
            ok = np.allclose(scaled_kernel(99.0)(X), 99 * X + np.sin(X))
            os._exit(0 if ok else 1)
        children.append(pid)
        time.sleep(0.02)
    busy.join()
    assert children
    assert [os.waitpid(pid, 0)[1] for pid in children] == [0] * len(children)


@pytest.mark.skipif(not elf._here(), reason="the small linker is for Linux on x86-64")
def test_the_small_linker_loads_what_llvm_loads():
    k = specimens.kernel(3)
    k(*specimens.states(3, 2)), k(*specimens.states(3, 1)[0], 0.1)
    for part in (BATCH, SINGLE):
        entry = Store(cache.default().directory).get(object_key(k, part))
        ours, llvm = (link(entry.code, image.ENTRIES[part], shared_code()) for link in (elf.load, target.load))
        assert ours is not None
        answers = [image.canary_outputs(c, part, k.signature, entry.inputs) for c in (ours, llvm)]
        assert answers == [entry.outputs] * 2


@pytest.mark.skipif(not elf._here(), reason="the small linker is for Linux on x86-64")
def test_the_small_linker_takes_code_that_refers_to_an_empty_constant():
    """As the calls of kernels without one do: all of LLVM was loaded for them."""
    empty = "@none = private constant [0 x i64] zeroinitializer\ndefine ptr @f() {\n ret ptr @none\n}\n"
    assert elf.load(target.compile(empty, target.host()), ("f",)) is not None


@pytest.mark.skipif(not elf._here(), reason="the small linker is for Linux on x86-64")
def test_the_small_linker_declines_what_it_does_not_know():
    calls_out = """
declare double @cos(double)
define double @f(double %x) {
  %y = call double @cos(double %x)
  ret double %y
}
"""
    code = target.compile(calls_out, target.host())
    assert elf.load(code, ("f",)) is None
    plain = target.compile("define double @f(double %x) {\n ret double %x\n}\n", target.host())
    assert elf.load(plain, ("f",)) is not None
    assert elf.load(plain, ("g",)) is None
    for damaged in (b"", b"\x7fELF", plain[:100], b"MZ" + plain[2:], plain[:18] + b"\xb7" + plain[19:]):
        assert elf.load(damaged, ("f",)) is None


@pytest.mark.skipif(not elf._here(), reason="reads the process's own map")
def test_code_is_never_writable():
    k = specimens.kernel(3)
    k(*specimens.states(3, 2))
    at = k.addresses.batch
    for line in Path("/proc/self/maps").read_text().splitlines():
        low, high = (int(x, 16) for x in line.split()[0].split("-"))
        if low <= at < high:
            assert line.split()[1].startswith("r-x")
            return
    pytest.fail("the code is nowhere")


@pytest.mark.parametrize("level", ["tape", "kernel"])
def test_a_damaged_file_is_made_again(level, folder):
    k = scaled_kernel(2.0)
    want = k(X)
    for path in folder.glob(f"*.{level}"):  # of code what all kernels call, too
        path.write_bytes(path.read_bytes()[:-3])
    del k
    again()
    with pytest.warns(CacheWarning):
        assert (scaled_kernel(2.0)(X) == want).all()
    again()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert (scaled_kernel(2.0)(X) == want).all()
    assert len(builds) == (2 if level == "tape" else 1)


def test_llvm_loads_where_the_small_linker_declines(monkeypatch):
    warm([scaled_kernel(2.0)])
    want = scaled_kernel(2.0)(X)
    again()
    monkeypatch.setattr(elf, "load", lambda *_: None)
    k = scaled_kernel(2.0)
    assert (k(X) == want).all()
    assert (k(np.stack([X, X])) == want).all()
    assert k.image.parts.keys() == set(image.FROM_PYTHON)
    assert k.provenance.cached


def test_kernels_in_cycles_are_collected_in_any_order():
    """The collector may empty a builtin's owner first: what it reads of the builtin after that is still there.

    Freed memory is overwritten at once here, as it is elsewhere sooner or later.
    """
    program = (
        "import gc, mafsil as mf\n"
        "for k in range(8):\n"
        "    rows = [mf.DHRow(a=0.3 + 0.01 * k, alpha=0.1, d=0.0), mf.DHRow(a=0.2, alpha=0.3, d=0.1)]\n"
        "    robot = mf.Robot.from_dh(rows, 'classic')\n"
        "    robot.forward_kinematics([0.1, 0.2])\n"
        "    del robot\n"
        "    gc.collect()\n"
    )
    environment = {**os.environ, "PYTHONMALLOC": "malloc", "MALLOC_PERTURB_": "255"}
    done = subprocess.run([sys.executable, "-X", "faulthandler", "-c", program], env=environment, check=False)
    assert done.returncode == 0
