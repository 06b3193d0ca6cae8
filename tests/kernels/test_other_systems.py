"""What rests on Linux or on x86-64 has a second way: here Linux is taken away, and the answers are the same bits."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.code_store import store as stores
from mafsil.kernels import elf, identity, target
from mafsil.kernels.cache import Entry, Store
from mafsil.report import results

ADD = "define double @f(double %x) { %y = fadd double %x, 1.0 ret double %y }"

BARE = """
import importlib.util, json, mmap, os, sys
for name in ("fork", "register_at_fork", "geteuid", "getuid", "uname", "sched_getaffinity", "sysconf", "O_NOFOLLOW",
             "O_NONBLOCK", "O_CLOEXEC"):
    delattr(os, name)
for name in ("MADV_FREE", "MADV_HUGEPAGE", "MAP_PRIVATE", "MAP_ANONYMOUS"):
    delattr(mmap, name)
sys.modules["fcntl"] = sys.modules["resource"] = None
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name == "fcntl" else found(name, *more)
sys.platform = "another"
import numpy as np, mafsil as mf
from mafsil.kernels import identity
identity._CPUINFO = "/no/such/file"
arm = mf.load("puma560")
q = np.linspace(-1.0, 1.0, 6)
T = arm.forward_kinematics(q)
many = np.tile(q, (200_000, 1))
print(json.dumps({
    "pose": T.tolist(), "torque": arm.inverse_dynamics(many, many, many)[-1].tolist(),
    "answer": mf.solve_ik(arm, T, q0=q + 0.1, seed=1).q.tolist(),
}))
"""


def asked(folder: Path, **more: str) -> dict[str, object]:
    """Answers of a process without Linux."""
    environment = os.environ | {"MAFSIL_CACHE": str(folder)} | more
    run = subprocess.run([sys.executable, "-c", BARE], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "Warning" not in run.stderr
    return json.loads(run.stdout)


def test_a_system_without_posix_gives_the_same_bits_fresh_and_from_its_store(tmp_path: Path) -> None:
    fresh = asked(tmp_path / "store")
    kept = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "store").glob("*.kernel")}
    assert kept
    assert asked(tmp_path / "store") == fresh
    assert {path.name: path.stat().st_mtime_ns for path in (tmp_path / "store").glob("*.kernel")} == kept
    arm, q = mf.load("puma560"), np.linspace(-1.0, 1.0, 6)
    T = arm.forward_kinematics(q)
    assert fresh["pose"] == T.tolist()
    assert fresh["torque"] == arm.inverse_dynamics(q, q, q).tolist()
    assert fresh["answer"] == mf.solve_ik(arm, T, q0=q + 0.1, seed=1).q.tolist()


def test_llvm_links_where_it_is_asked_to(monkeypatch: pytest.MonkeyPatch) -> None:
    code = target.compile(ADD, target.host())
    monkeypatch.setenv(elf.LINKER_VARIABLE, "llvm")
    assert elf.load(code, ("f",)) is None
    assert target.load(code, ("f",)).addresses["f"]


def test_without_locks_the_store_is_bounded_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stores, "HAS_LOCKS", False)
    monkeypatch.setitem(sys.modules, "fcntl", None)
    store = Store(tmp_path)
    for digit in "abcdef":
        store.put(digit * 64, Entry(bytes(1000), b"", b"", b""))
    with store.compiling("a" * 64) as waited:
        assert not waited
    assert store.sweep(limit=3000) >= 3
    assert len(list(tmp_path.glob("*.kernel"))) <= 3


def test_results_are_replaced_where_directories_cannot_be_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = os.open

    def refuse(path, flags, *more, **options):
        if Path(path).is_dir():
            raise PermissionError(13, "as on Windows")
        return opened(path, flags, *more, **options)

    monkeypatch.setattr(os, "open", refuse)
    monkeypatch.setattr(shutil, "_use_fd_functions", False)
    monkeypatch.setattr(results, "_exchange", lambda first, second: False)
    for text in ("old", "new"):
        results.write_folder(tmp_path / "out", lambda partial, text=text: (partial / "report.html").write_text(text))
    assert (tmp_path / "out" / "report.html").read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_processor_that_linux_does_not_describe_is_named_by_llvm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identity, "_CPUINFO", "/no/such/file")
    identity._processor.cache_clear()
    try:
        assert target.host("").identity in identity.machine()
    finally:
        identity._processor.cache_clear()
