"""The life of a kernel: compiled once and late, cached, proved by its canary, shipped by description."""

from __future__ import annotations

import copy
import json
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
import time
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from mafsil.code_store import CacheWarning
from mafsil.code_store import store as stores
from mafsil.errors import KernelError
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
    target,
    warm,
)
from mafsil.kernels.cache import Store
from tests.reliability import specimens

ROOT = Path(__file__).resolve().parents[2]
VECTOR = Signature("scaled", (Port("x", (4,)),), (Port("y", (4,)),))
builds: list[float] = []


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache, nothing loaded, nothing said."""
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(stores, "_told", set())
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
    compiler._images.clear()


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
    assert len(list(folder.glob("*.kernel"))) == 1


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


@pytest.mark.parametrize("change", ["key", "signature", "fingerprint", "target", "toolchain", "source"])
def test_whatever_shapes_the_code_changes_the_key(change, monkeypatch):
    store = Store(None)
    base = compile(VECTOR, partial(scaled, 1.0), key="a", fingerprints=("f",))
    key = base.order(store).key
    assert key == compile(VECTOR, partial(scaled, 9.0), key="a", fingerprints=("f",), doc="other").order(store).key
    other = {
        "key": {"key": "b"},
        "signature": {"signature": Signature("scaled", VECTOR.inputs, (Port("z", (4,)),))},
        "fingerprint": {"fingerprints": ("g",)},
        "target": {"target": target.host("-avx")},
    }.get(change, {})
    if change == "toolchain":
        monkeypatch.setattr(identity, "toolchain", lambda: "another llvmlite")
    if change == "source":
        monkeypatch.setattr(identity, "fingerprint", lambda *_: "edited")
    given = {"signature": VECTOR, "key": "a", "fingerprints": ("f",), "target": None} | other
    signature = given.pop("signature")
    assert compile(signature, partial(scaled, 1.0), **given).order(store).key != key


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


def test_a_canary_that_falls_silent_means_compiling_again(folder):
    """A valid entry that holds another kernel's code: no checksum can tell, the stored answers do."""
    scaled_kernel(2.0)(X), scaled_kernel(5.0)(X)
    store = Store(folder)
    keys = [scaled_kernel(f).order(store).key for f in (2.0, 5.0)]
    entries = [store.get(key) for key in keys]
    impostor = cache.Entry(entries[1].code, entries[0].inputs, entries[0].outputs, entries[0].provenance)
    store.put(keys[0], impostor)
    again()
    builds.clear()
    with pytest.warns(CacheWarning, match="does not repeat"):
        answer = scaled_kernel(2.0)(X)
    np.testing.assert_allclose(answer, 2 * X + np.sin(X))
    assert builds == [2.0]
    assert store.get(keys[0]) == entries[0] or store.get(keys[0]).outputs == entries[0].outputs


SILENT_BATCH = """
define void @mafsil_batch(ptr %args, ptr %dims, ptr %steps, ptr %data) {
  ret void
}
define void @mafsil_single(ptr %x, ptr %y) {
  store double 1.0, ptr %y, align 8
  ret void
}
"""


def test_code_whose_entries_disagree_is_never_used(monkeypatch, folder):
    def translate(_function, signature, machine):
        return SILENT_BATCH + call.wrapper(signature, machine.triple), {}

    monkeypatch.setattr(compiler, "translate", translate)
    with pytest.raises(KernelError, match="different bits"):
        scaled_kernel(2.0)(X)
    assert not list(folder.glob("*.kernel"))


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


def test_warm_readies_several(folder):
    kernels = [scaled_kernel(float(f)) for f in range(4)]
    warm(kernels, workers=3)
    assert sorted(builds) == [0.0, 1.0, 2.0, 3.0]
    assert all("image" in vars(k) for k in kernels)
    assert len(list(folder.glob("*.kernel"))) == 4
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
    k(*specimens.states(3, 2))
    entry = Store(cache.default().directory).get(k.provenance.key)
    ours, llvm = elf.load(entry.code, image.ENTRIES), target.load(entry.code, image.ENTRIES)
    assert ours is not None
    answers = [
        image.canary_outputs(image.Image(c.addresses, b"", False, c), k.signature, entry.inputs) for c in (ours, llvm)
    ]
    assert answers == [entry.outputs] * 2


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


def test_a_damaged_file_is_compiled_again(folder):
    k = scaled_kernel(2.0)
    want = k(X)
    path = next(folder.glob("*.kernel"))
    path.write_bytes(path.read_bytes()[:-3])
    del k
    again()
    with pytest.warns(CacheWarning):
        assert (scaled_kernel(2.0)(X) == want).all()
    again()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert (scaled_kernel(2.0)(X) == want).all()
    assert len(builds) == 2


def test_llvm_loads_where_the_small_linker_declines(monkeypatch):
    want = scaled_kernel(2.0)(X)
    again()
    monkeypatch.setattr(elf, "load", lambda *_: None)
    k = scaled_kernel(2.0)
    assert (k(X) == want).all()
    assert (k(np.stack([X, X])) == want).all()
    assert k.provenance.cached
