"""The store of compiled objects: whole or absent, private, bounded, and never a reason to fail."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil.code_store import CacheWarning
from mafsil.code_store import store as stores
from mafsil.kernels import cache
from mafsil.kernels.cache import Entry, Store, decode, encode
from mafsil.messages import keys, say, template

KEY = "ab" * 32
ENTRY = Entry(code=b"code" * 300, inputs=b"\1" * 64, outputs=b"\2" * 128, provenance=b'{"name": "x"}')


@pytest.fixture(autouse=True)
def _unwarned(monkeypatch):
    monkeypatch.setattr(stores, "_warned", set())


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "cache")


blobs = st.binary(max_size=200)


@given(blobs, blobs, blobs, blobs, st.binary(min_size=32, max_size=32))
def test_encoding_is_lossless_and_bound_to_its_key(code, inputs, outputs, provenance, key):
    entry = Entry(code, inputs, outputs, provenance)
    data = encode(key, entry)
    assert decode(key, data) == entry
    assert decode(bytes(32) if any(key) else b"\1" * 32, data) is None


def test_every_single_bit_is_watched():
    key = bytes.fromhex(KEY)
    data = encode(key, Entry(b"c" * 20, b"i" * 8, b"o" * 8, b"p"))
    for bit in range(8 * len(data)):
        damaged = bytearray(data)
        damaged[bit // 8] ^= 1 << bit % 8
        assert decode(key, bytes(damaged)) is None, bit
    assert all(decode(key, data[:n]) is None for n in range(len(data)))


def test_put_and_get(store):
    assert store.get(KEY) is None
    store.put(KEY, ENTRY)
    assert store.get(KEY) == ENTRY
    assert Store(store.directory).get(KEY) == ENTRY
    store.discard(KEY)
    store.discard(KEY)
    assert store.get(KEY) is None


def test_directory_and_files_are_private(store):
    usual = os.umask(0)
    try:
        store.put(KEY, ENTRY)
    finally:
        os.umask(usual)
    assert stat.S_IMODE(store.directory.stat().st_mode) == 0o700
    assert all(stat.S_IMODE(p.stat().st_mode) == 0o600 for p in store.directory.iterdir() if p.suffix == ".kernel")


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o770, 0o722])
def test_a_directory_where_others_may_write_is_refused_and_left_as_it_is(tmp_path, mode):
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(mode)
    store = Store(tmp_path / "open")
    with pytest.warns(CacheWarning, match="others may write"):
        store.put(KEY, ENTRY)
    assert store.get(KEY) == ENTRY  # in memory
    assert stat.S_IMODE((tmp_path / "open").stat().st_mode) == mode
    assert not list((tmp_path / "open").iterdir())


def test_a_directory_of_ours_that_others_may_only_read_is_used_and_left_as_it_is(tmp_path):
    (tmp_path / "seen").mkdir()
    (tmp_path / "seen").chmod(0o755)
    Store(tmp_path / "seen").put(KEY, ENTRY)
    assert Store(tmp_path / "seen").get(KEY) == ENTRY
    assert stat.S_IMODE((tmp_path / "seen").stat().st_mode) == 0o755


def test_a_link_is_refused_and_its_target_left_as_it_is(tmp_path):
    (tmp_path / "target").mkdir()
    (tmp_path / "target").chmod(0o755)
    (tmp_path / "link").symlink_to(tmp_path / "target")
    store = Store(tmp_path / "link")
    with pytest.warns(CacheWarning, match="it is a link"):
        store.put(KEY, ENTRY)
    assert not list((tmp_path / "target").iterdir())
    assert stat.S_IMODE((tmp_path / "target").stat().st_mode) == 0o755


def test_a_parent_where_others_could_exchange_the_directory_is_refused(tmp_path):
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o777)
    store = Store(tmp_path / "shared" / "mine")
    with pytest.warns(CacheWarning, match="exchange"):
        store.put(KEY, ENTRY)
    (tmp_path / "shared").chmod(0o1777)
    Store(tmp_path / "shared" / "mine").put(KEY, ENTRY)
    assert Store(tmp_path / "shared" / "mine").get(KEY) == ENTRY


def _planted_link(path: Path, data: bytes) -> None:
    elsewhere = path.with_name("elsewhere")
    elsewhere.write_bytes(data)
    path.symlink_to(elsewhere)


def _planted_open(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    path.chmod(0o666)


def _planted_pipe(path: Path, _data: bytes) -> None:
    os.mkfifo(path)


@pytest.mark.parametrize("plant", [_planted_link, _planted_open, _planted_pipe])
def test_what_others_may_have_written_is_not_read_nor_waited_for(store, plant):
    """The bytes are right: only who could have written them is not."""
    store.put(KEY, ENTRY)
    path = store.directory / f"{KEY}.kernel"
    data = path.read_bytes()
    path.unlink()
    plant(path, data)
    with pytest.warns(CacheWarning, match="damaged"):
        assert store.get(KEY) is None
    assert not path.is_symlink()
    assert not path.exists()


def test_a_file_of_another_user_is_not_read(store, monkeypatch):
    store.put(KEY, ENTRY)
    assert store.get(KEY) == ENTRY
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    with pytest.warns(CacheWarning, match="damaged"):
        assert store.get(KEY) is None


def test_a_foreign_directory_is_refused(store, monkeypatch):
    store.put(KEY, ENTRY)
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    fresh = Store(store.directory)
    with pytest.warns(CacheWarning, match="another user"):
        assert fresh.get(KEY) is None
    fresh.put(KEY, ENTRY)
    assert fresh.get(KEY) == ENTRY  # in memory
    assert Store(None).get(KEY) is None


def test_damage_is_removed_with_one_warning(store):
    path = store.directory / f"{KEY}.kernel"

    def damage_and_ask() -> None:
        store.put(KEY, ENTRY)
        path.write_bytes(path.read_bytes()[:-1])
        assert store.get(KEY) is None
        assert not path.exists()

    with pytest.warns(CacheWarning, match="damaged"):
        damage_and_ask()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        damage_and_ask()


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EDQUOT])
@pytest.mark.parametrize("place", ["fsync", "replace", "open"])
def test_a_full_or_read_only_disk_leaves_memory(store, monkeypatch, number, place):
    assert store.get(KEY) is None

    def refuse(*_args, **_named):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, place, refuse)
    with pytest.warns(CacheWarning, match="memory only"):
        store.put(KEY, ENTRY)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        store.put("cd" * 32, ENTRY)
    monkeypatch.undo()
    assert store.get(KEY) == ENTRY
    assert not list(store.directory.glob("*.tmp"))


def test_a_directory_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("in the way")
    store = Store(tmp_path / "file" / "cache")
    with pytest.warns(CacheWarning, match="cannot be used"):
        store.put(KEY, ENTRY)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert store.get(KEY) == ENTRY


def test_memory_is_bounded():
    store = Store(None)
    for number in range(300):
        store.put(f"{number:064x}", ENTRY)
    assert store.get(f"{0:064x}") is None
    assert store.get(f"{299:064x}") == ENTRY


def test_environment_chooses_the_place(tmp_path, monkeypatch):
    monkeypatch.setenv("MAFSIL_CACHE", "OFF")
    assert cache.default().directory is None
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "مخزن with spaces"))
    cache.default().put(KEY, ENTRY)
    assert cache.default().get(KEY) == ENTRY
    assert (tmp_path / "مخزن with spaces" / f"{KEY}.kernel").exists()
    monkeypatch.delenv("MAFSIL_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.default().directory == tmp_path / "mafsil"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative/is/invalid")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache.default().directory == tmp_path / "home" / ".cache" / "mafsil"


def test_no_home_at_all(monkeypatch):
    for name in ("MAFSIL_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    cache._store.cache_clear()
    with pytest.warns(CacheWarning, match="no home"):
        assert cache.default().directory is None
    cache._store.cache_clear()


def test_orphans_go_after_an_hour(store):
    store.put(KEY, ENTRY)
    fresh, old = store.directory / "fresh.tmp", store.directory / "old.tmp"
    lock, other = store.directory / "x.lock", store.directory / "readme.txt"
    for path in (fresh, old, lock, other):
        path.write_bytes(b"half")
    for path in (old, lock, other):
        os.utime(path, (time.time() - 3700,) * 2)
    assert store.sweep() == 2
    assert fresh.exists()
    assert other.exists()
    assert not old.exists()
    assert store.get(KEY) == ENTRY


def test_size_is_bounded_by_last_use(store):
    size = len(encode(bytes.fromhex(KEY), ENTRY))
    for number in range(10):
        key = f"{number:064x}"
        store.put(key, ENTRY)
        os.utime(store.directory / f"{key}.kernel", (time.time() - 1e6 + number,) * 2)
    assert store.get(f"{0:064x}") == ENTRY  # reading it makes it young
    assert store.sweep(limit=3 * size) == 7
    assert [store.get(f"{n:064x}") is not None for n in (0, 1, 7, 8, 9)] == [True, False, False, True, True]


def test_limit_from_the_environment(store, monkeypatch):
    monkeypatch.setenv("MAFSIL_CACHE_LIMIT", "0")
    store.put(KEY, ENTRY)  # the first write sweeps
    assert store.get(KEY) is None
    monkeypatch.setenv("MAFSIL_CACHE_LIMIT", "no number")
    assert stores._limit() == 1 << 30


def test_sweeping_is_exclusive(store):
    store.put(KEY, ENTRY)
    handle = stores._lock(store.directory / "sweep.lock", 0.0)
    assert handle is not None
    assert store.sweep(limit=0) == 0
    os.close(handle)
    assert store.sweep(limit=0) == 1


def test_compile_lock_passes_from_hand_to_hand(store):
    inside, most, waits = 0, 0, []
    barrier = threading.Barrier(6)

    def enter() -> None:
        nonlocal inside, most
        mine = Store(store.directory)
        barrier.wait()
        with mine.compiling(KEY) as waited:
            waits.append(waited)
            if not waited:
                inside += 1
                most = max(most, inside)
                time.sleep(0.05)
                inside -= 1

    threads = [threading.Thread(target=enter) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert waits.count(False) == 1
    assert not list(store.directory.glob(f"{KEY}.lock"))


def test_compile_lock_is_not_waited_for_for_ever(store):
    assert store.get(KEY) is None
    handle = stores._lock(store.directory / f"{KEY}.lock", 0.0)
    assert handle is not None
    started = time.monotonic()
    with store.compiling(KEY, patience=0.1) as waited:
        assert waited
    assert 0.1 <= time.monotonic() - started < 2.0
    os.close(handle)


@pytest.mark.skipif(sys.platform != "linux", reason="kills with SIGKILL")
def test_compile_lock_dies_with_its_holder(store):
    assert store.get(KEY) is None
    code = f"""
from pathlib import Path
import os, signal
from mafsil.kernels.cache import Store
with Store(Path({str(store.directory)!r})).compiling({KEY!r}):
    os.kill(os.getpid(), signal.SIGKILL)
"""
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == -9
    with store.compiling(KEY) as waited:
        assert not waited


def test_nothing_is_warned_of_when_all_is_well(store):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        store.put(KEY, ENTRY)
        assert store.get(KEY) == ENTRY


@pytest.mark.parametrize("area", ["cache", "call"])
def test_both_languages_say_the_same(area):
    assert keys("en", area) == keys("ar", area)
    for key in keys("en", area):
        fields = [
            {word.split("}")[0] for word in template(f"{area}.{key}", code).split("{")[1:]} for code in ("en", "ar")
        ]
        assert fields[0] == fields[1]
    assert say("cache.foreign", language="ar") != say("cache.foreign", language="en")
