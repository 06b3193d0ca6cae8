"""F1: damaged robot files never crash a reader, hang it, swell it, or pass as sound.

`python -m tests.reliability.fuzz_reader --files 50000000 --shard 20000 --resume DIR`; the environment variable
MAFSIL_FUZZ_KINDS chooses formats: `xacro sdf`.
"""

from __future__ import annotations

import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mafsil.errors import FileError, ModelError
from mafsil.model import mjcf, sdf, urdf
from mafsil.model.diagnostics import Report
from mafsil.model.faults import TOO_BIG
from tests.reliability import figures
from tests.reliability.file_mutation import mutated
from tests.reliability.model_invariants import violations
from tests.reliability.robot_files import SEEDS

ROOT = Path(__file__).resolve().parents[2]
MEMORY = 256 << 20
ADDRESS_SPACE = 1 << 30
SLOW = 2.0
REPAIR_EVERY = 10
COUNTS = (
    "files",
    "accepted",
    "refused",
    "repaired",
    "bad_crash",
    "bad_exception",
    "bad_slow",
    "bad_model",
    "bad_memory",
)


def work(seed: int, files: int) -> dict[str, int]:
    """One child reads `files` mutants."""
    return in_child("tests.reliability.fuzz_reader", seed, files, COUNTS)


def in_child(module: str, seed: int, files: int, counts: tuple[str, ...]) -> dict[str, int]:
    """What a child of `module` counts; one that dies leaves its last file behind.

    Args:
        module: that is started with `--child SEED FILES LAST`.
        seed, files: of the shard.
        counts: names that it counts, `bad_crash` and `bad_slow` among them.
    """
    with tempfile.TemporaryDirectory(prefix="mafsil-fuzz-") as folder:
        last = Path(folder) / "last"
        command = [sys.executable, "-m", module, "--child", str(seed), str(files), str(last)]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": f"{ROOT / 'src'}{os.pathsep}{ROOT}"}
        limit = 120 + files * 0.1
        try:
            done = subprocess.run(
                command, check=False, capture_output=True, text=True, env=environment, cwd=folder, timeout=limit
            )
        except subprocess.TimeoutExpired:
            print(f"seed {seed}: not done in {limit:.0f} s; last file {last.read_bytes()[:2000]!r}")
            return {**dict.fromkeys(counts, 0), "files": files, "bad_slow": 1}
        if done.returncode == 0:
            print(done.stderr[-4000:], end="", file=sys.stderr)
            return json.loads(done.stdout.splitlines()[-1])
        said = last.read_bytes()[:2000] if last.exists() else b""
        print(f"seed {seed}: exit {done.returncode}; {done.stderr[-1500:]}; last file {said!r}")
        return {**dict.fromkeys(counts, 0), "files": files, "bad_crash": 1}


def child(seed: int, files: int, last: Path) -> dict[str, int]:
    """Read mutants under a limit of memory; what goes wrong is printed with its file."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    dice = random.Random(seed)
    kinds = tuple(os.environ.get("MAFSIL_FUZZ_KINDS", " ".join(SEEDS)).split())
    count = dict.fromkeys(COUNTS, 0)
    with last.open("wb", buffering=0) as record:
        for k in range(files):
            kind = dice.choice(kinds)
            data = mutated(dice, dice.choice(SEEDS[kind]))
            record.seek(0)
            record.truncate()
            record.write(data)
            _judge(kind, data, count, repair=k % REPAIR_EVERY == 0)
    count["files"] = files
    count["bad_memory"] = int(peak_memory() > MEMORY)
    return count


def peak_memory() -> int:
    """Largest resident set of this program [bytes]; `ru_maxrss` would count the parent's from before the exec."""
    status = Path("/proc/self/status").read_text()
    return 1024 * int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1])


def _judge(kind: str, data: bytes, count: dict[str, int], *, repair: bool) -> None:
    started = time.perf_counter()
    try:
        bad = _read(kind, data, count, repair=repair)
    except Exception as error:  # the row's question: does anything foreign come out
        count["bad_exception"] += 1
        print(f"{type(error).__name__}: {error}: {data!r}", file=sys.stderr)
    else:
        count["bad_model"] += bool(bad)
        if bad:
            print(f"{bad}: {data!r}", file=sys.stderr)
    if time.perf_counter() - started > SLOW:
        count["bad_slow"] += 1
        print(f"slow: {data!r}", file=sys.stderr)


def _read(kind: str, data: bytes, count: dict[str, int], *, repair: bool) -> list[str]:
    """Diagnose, say everything in both languages, write what was accepted and read it back."""
    reader = READERS[kind]
    report: Report = reader.diagnose(data)
    for diagnostic in report:
        diagnostic.to_dict()
    if repair:
        count["repaired"] += _repair(reader, data)
    if report.mechanism is None:
        count["refused"] += 1
        return [] if report.errors else ["refused without an error"]
    count["accepted"] += 1
    bad = violations(report.mechanism)
    try:
        text = urdf.write(report.mechanism, without=urdf.LOSSES)
    except ModelError:
        return bad
    refused = [d.line_of_text("en") for d in urdf.diagnose(text).errors if d.fault is not TOO_BIG]
    return bad + [f"written and refused: {line}" for line in refused]


def _repair(reader: object, data: bytes) -> bool:
    try:
        text, _ = reader.repair(data)
    except FileError:
        return False
    return reader.diagnose(text).ok


READERS = {"urdf": urdf, "mjcf": mjcf, "xacro": urdf, "sdf": sdf}

if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(child(int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))))
    else:
        figures.run("F1", figures.arguments(__doc__ or "", "files", 10_000, 5_000), work)
