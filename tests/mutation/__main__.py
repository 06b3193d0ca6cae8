"""The command: breaks one public thing after the other, each in a process of its own, and lists what nobody noticed."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.mutation.collection import run, tests_of_capabilities
from tests.mutation.mutants import break_target
from tests.mutation.tracing import calls_of

TARGETS = Path(__file__).with_name("targets.toml")


def main() -> int:
    """0 when every mutation was noticed."""
    options = _options()
    if options.no_cache:
        os.environ["MAFSIL_CACHE"] = "off"
    with contextlib.redirect_stdout(sys.stderr):
        tests = tests_of_capabilities()
    chosen = _share([name for name in tests if _is_asked_for(name, options)], options.shard)
    if options.trace:
        for name in chosen:
            print(json.dumps({name: _in_child(lambda name=name: calls_of(tests[name]), options.limit)}), flush=True)
        return 0
    targets = tomllib.loads(TARGETS.read_text("utf-8"))
    verdicts = {name: _verdict(name, targets, tests, options.limit) for name in chosen}
    print(dict(Counter(verdicts.values())))
    return int(any(verdict != "noticed" for verdict in verdicts.values()))


def _verdict(name: str, targets: dict[str, str], tests: dict[str, list[str]], limit: float) -> str:
    """`noticed`, `survived`, or why the mutation could not be tried."""
    began = time.monotonic()
    if name not in targets:
        verdict = "no target"
    else:
        answer = _in_child(lambda: _survives(targets[name], tests[name]), limit)
        verdict = {True: "survived", False: "noticed"}.get(answer, str(answer))
    print(f"{name:7}{verdict:12}{targets.get(name, ''):70}{time.monotonic() - began:6.1f} s", flush=True)
    return verdict


def _survives(target: str, tests: list[str]) -> bool | str:
    try:
        break_target(target)
    except (AttributeError, ImportError) as error:
        return f"no such target: {error}"
    return run(tests)


def _in_child(work: Callable[[], Any], limit: float = 600.0) -> Any:
    """What `work` returns in a forked process; a process that dies or takes too long has noticed: False."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(1, 2)
        with os.fdopen(writer, "w") as pipe:
            pipe.write(json.dumps(work()))
        os._exit(0)
    os.close(writer)
    os.set_blocking(reader, False)
    text = _read(reader, child, time.monotonic() + limit)
    return json.loads(text) if text else False


def _read(reader: int, child: int, deadline: float) -> str:
    parts: list[bytes] = []
    while time.monotonic() < deadline:
        with contextlib.suppress(BlockingIOError):
            part = os.read(reader, 1 << 16)
            if not part:
                break
            parts.append(part)
            continue
        time.sleep(0.02)
    else:
        os.kill(child, 9)
    os.waitpid(child, 0)
    os.close(reader)
    return b"".join(parts).decode()


def _share(names: list[str], shard: str) -> list[str]:
    part, count = (int(number) for number in shard.split("/"))
    return names[part - 1 :: count]


def _is_asked_for(name: str, options: argparse.Namespace) -> bool:
    return name in options.capability or (not options.capability and name[:2] in options.parts)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation")
    parts = ["02", "03", "04", "05", "07", "08", "09", "10", "11"]
    parser.add_argument("--parts", nargs="+", default=parts, help="parts of the specification")
    parser.add_argument("--capability", nargs="+", default=[], help="only these")
    parser.add_argument("--shard", default="1/1", help="K/N: every N-th capability, from the K-th on")
    parser.add_argument("--limit", type=float, default=600.0, help="seconds for each")
    parser.add_argument("--trace", action="store_true", help="print what the tests of each capability call")
    parser.add_argument("--no-cache", action="store_true", help="keep compiled code of mutants in memory")
    return parser.parse_args()


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    # With all oracles in one process their libraries can crash while the interpreter goes down: that would be the code.
    os._exit(code)
