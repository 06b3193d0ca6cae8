"""Figures of the reliability rows: written by the harness as JSON, one file per shard, so that long runs resume."""

from __future__ import annotations

import argparse
import json
import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path


def arguments(description: str, unit: str, default: int, shard: int) -> argparse.Namespace:
    """Command line of one harness module: `--<unit> N --shard N --seed N --resume DIR`."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument(f"--{unit}", dest="count", type=int, default=default)
    parser.add_argument("--shard", type=int, default=shard, help=f"{unit} per shard")
    parser.add_argument("--seed", type=int, default=0, help="first shard")
    parser.add_argument(
        "--resume", type=Path, default=None, help="directory of the shard files; finished ones are kept"
    )
    return parser.parse_args()


def run(row: str, options: argparse.Namespace, work: Callable[[int, int], dict[str, int]]) -> dict[str, object]:
    """Do all shards that are not yet done, add up and print; `work(seed, count)` counts things by name.

    A name that begins with `bad_` must stay zero.
    """
    folder = options.resume or Path(tempfile.mkdtemp(prefix=f"mafsil-{row}-"))
    folder.mkdir(parents=True, exist_ok=True)
    total: dict[str, float] = {}
    shards = -(-options.count // options.shard)
    for seed in range(options.seed, options.seed + shards):
        path = folder / f"{row}-{seed:06d}.json"
        if not path.exists():
            count = min(options.shard, options.count - (seed - options.seed) * options.shard)
            started = time.perf_counter()
            found = {**work(seed, count), "seconds": time.perf_counter() - started}
            path.write_text(json.dumps({"row": row, "seed": seed, **found}))
        for name, value in json.loads(path.read_text()).items():
            if name not in ("row", "seed"):
                total[name] = total.get(name, 0) + value
    figures = {
        "row": row,
        "shards": shards,
        "machine": platform.machine(),
        "python": platform.python_version(),
        **total,
    }
    figures["passed"] = not any(value for name, value in total.items() if name.startswith("bad_"))
    (folder / f"{row}.json").write_text(json.dumps(figures, indent=1))
    print(json.dumps(figures))
    return figures
