"""K1: writers of the kernel cache are killed at random instants; whatever they leave is whole or absent.

`python -m tests.reliability.kill_cache --kills 100000 --resume DIR`
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from mafsil.code_store import CACHE_VARIABLE
from mafsil.kernels import compiler
from mafsil.kernels.cache import TAPE, Entry, Store, TapeEntry, decode, encode
from mafsil.kernels.image import FROM_PYTHON
from tests.reliability import figures, specimens

SPECIMENS = tuple((links, 0) for links in (1, 2, 3, 4, 6))
CHECK_EVERY = 100
COMPILE_EVERY = 25


def work(seed: int, kills: int) -> dict[str, int]:
    """Kill `kills` writers on one directory and look at every file after every kill."""
    dice = random.Random(seed)
    count = dict.fromkeys(
        ("kills", "bad_torn", "bad_loads", "bad_restarts", "bad_orphans", "orphans", "compile_kills"), 0
    )
    entries = _compiled()
    with tempfile.TemporaryDirectory(prefix="mafsil-K1-") as folder:
        os.environ[CACHE_VARIABLE] = folder
        for kill in range(kills):
            compiling = kill % COMPILE_EVERY == COMPILE_EVERY - 1
            if compiling:
                _killed(lambda: _compile_again(folder), dice.uniform(0.0, 0.25))
                count["compile_kills"] += 1
            else:
                _killed(lambda: _write_for_ever(folder, entries), dice.uniform(0.0, 0.006))
            count["kills"] += 1
            count["bad_torn"] += _torn(folder, entries)
            if kill % CHECK_EVERY == CHECK_EVERY - 1 or kill == kills - 1:
                count["bad_loads"] += _child(_load_all) != 0
                count["bad_restarts"] += _child(lambda: _write_once(folder, entries)) != 0
                count["orphans"] += len(_orphans(folder))
                Store(Path(folder)).sweep(now=time.time() + 3601)
                count["bad_orphans"] += len(_orphans(folder))
    return count


Entries = dict[str, tuple[TapeEntry, dict[str, Entry]]]


def _compiled() -> Entries:
    """Real entries, compiled once in this process: of every tape, and of the code that is made of it."""
    with tempfile.TemporaryDirectory(prefix="mafsil-K1-") as folder:
        os.environ[CACHE_VARIABLE] = folder
        store = Store(Path(folder))
        found: Entries = {}
        for links, seed in SPECIMENS:
            tape, codes = specimens.keys(specimens.kernel(links, seed))
            entry, kept = store.get_tape(tape), {key: store.get(key) for key in codes}
            assert entry is not None
            found[tape] = entry, {key: code for key, code in kept.items() if code is not None}
            assert len(found[tape][1]) == len(codes)
        every = {path.stem: store.get(path.stem) for path in Path(folder).glob("*.kernel")}
        # What all kernels call has no tape of its own.
        found[tape][1].update({key: code for key, code in every.items() if code is not None})
        return found


def _killed(action, after: float) -> None:
    pid = _fork(action)
    time.sleep(after)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)


def _child(action) -> int:
    """Exit status of a child that runs `action`; a crash is not 0."""
    return os.waitpid(_fork(action), 0)[1]


def _fork(action) -> int:
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return pid
    status = 1
    try:
        action()
        status = 0
    finally:
        os._exit(status)


def _write_for_ever(folder: str, entries: Entries) -> None:
    store = Store(Path(folder))
    while True:
        for key, (entry, codes) in entries.items():
            store.put_tape(key, entry)
            for code_key, code in codes.items():
                store.put(code_key, code)


def _write_once(folder: str, entries: Entries) -> None:
    store = Store(Path(folder))
    for key, (entry, codes) in entries.items():
        store.put_tape(key, entry)
        assert store.get_tape(key) == entry
        for code_key, code in codes.items():
            store.put(code_key, code)
            assert store.get(code_key) == code


def _compile_again(folder: str) -> None:
    """Compile into the cache from nothing, holding the compile lock."""
    compiler._images.clear()
    for links, seed in SPECIMENS:
        kernel = specimens.kernel(links, seed)
        order = kernel.order(Store(Path(folder)))
        for part in FROM_PYTHON:
            order.store.discard(order.object_key(part, kernel.image.hash))
        order.store.discard(order.key)
        compiler._images.clear()
        kernel = specimens.kernel(links, seed)
        kernel(*specimens.states(links, 3))
        kernel(*(x[0] for x in specimens.states(links, 1)))


def _load_all() -> None:
    """A next start: every kernel comes up, from the cache or compiled again, and is right."""
    compiler._images.clear()
    for links, seed in SPECIMENS:
        assert not specimens.wrong(links, seed, specimens.kernel(links, seed))


def _torn(folder: str, entries: Entries) -> int:
    """Files under their final name that are not, to the byte, an entry that was written."""
    bad = 0
    codes = {key: code for _, kept in entries.values() for key, code in kept.items()}
    for path in Path(folder).glob("*.kernel"):
        data, key = path.read_bytes(), bytes.fromhex(path.stem)
        entry = decode(key, data)
        bad += entry is None or encode(key, entry) != data or entry.outputs != codes[path.stem].outputs
    for path in Path(folder).glob("*.tape"):
        found = Store(Path(folder)).get_tape(path.stem)
        whole = TAPE.unseal(bytes.fromhex(path.stem), path.read_bytes()) is not None
        bad += not whole or found is None or found.text() != entries[path.stem][0].text()
    return bad


def _orphans(folder: str) -> list[Path]:
    return list(Path(folder).glob("*.tmp"))


if __name__ == "__main__":
    sys.exit(not figures.run("K1", figures.arguments(__doc__ or "", "kills", 500, 1000), work)["passed"])
