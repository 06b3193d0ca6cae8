"""Is a batch ever slower by default than on one thread? From 500 to 200,000 rows, fresh arrays, in the same run.

python benchmarks/threads.py [--robot panda] [--json FILE]

A batch is shared among threads where its estimated time pays for waking them (`kernels.cost`). Least and median of many
short turns; on a machine whose other cores are busy a second thread comes late, so the load is printed too.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil import threads  # noqa: E402
from mafsil.mechanics.catalogue import quantity  # noqa: E402
from mafsil.model import library  # noqa: E402
from mafsil.robot import Robot  # noqa: E402
from tests.oracles.states import sample  # noqa: E402

SIZES = (500, 1000, 2000, 3000, 5000, 8000, 12_000, 20_000, 40_000, 100_000, 200_000)
ROUTINES = ("forward_kinematics", "jacobian_body", "inverse_dynamics", "mass_matrix")
NOISE = 0.95


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda", choices=library.robots())
    parser.add_argument("--json", type=Path, help="file for the figures")
    options = parser.parse_args()
    details = machine("mafsil", "numpy") | {"threads": str(threads.available()), "load": str(os.getloadavg()[0])}
    print(" | ".join(f"{key} {value}" for key, value in details.items()), flush=True)
    rows = list(measured(Robot(library.load(options.robot))))
    slower = [row for row in rows if row["ratio"] < NOISE]
    print(f"{len(slower)} of {len(rows)} batches are slower by default than on one thread, beyond {1 - NOISE:.0%}")
    if options.json:
        options.json.write_text(json.dumps({"machine": details, "rows": rows}, indent=1))


def measured(robot: Robot) -> Any:
    """One row for each routine and size."""
    states = sample(robot.mechanism, max(SIZES), np.random.default_rng(1))
    print(f"{'routine':22}{'rows':>8}{'one thread us':>16}{'default us':>16}{'x':>7}{'x medians':>11}")
    for name in ROUTINES:
        inputs = quantity(name).inputs
        evaluate = getattr(robot, name)
        for count in SIZES:
            arrays = [x[:count] for x in states.arguments(inputs)]
            one = evaluate(*arrays, threads=1)
            assert (evaluate(*arrays) == one).all(), (name, count)
            tasks = {"one": partial(evaluate, *arrays, threads=1), "default": partial(evaluate, *arrays)}
            taken = race(tasks, repeats=40, seconds=0.003)
            alone, default = taken["one"], taken["default"]
            ratio, middle = alone.least / default.least, alone.median / default.median
            print(
                f"{name:22}{count:8}{1e6 * alone.least:16.1f}{1e6 * default.least:16.1f}{ratio:7.2f}{middle:11.2f}",
                flush=True,
            )
            yield {"routine": name, "rows": count, "ratio": ratio, "ratio_of_medians": middle}


if __name__ == "__main__":
    main()
