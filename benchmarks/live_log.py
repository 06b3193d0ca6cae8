"""What does a live log cost a run at 1 kHz? The same run with and without, in turns.

python benchmarks/live_log.py [--robot panda] [--steps 1000] [--json FILE]

Computed torque, quintic reference, steps of 1 ms. Step by step (law and loop in Python) and compiled as a whole. Beside
it, the same arrays written afterwards as a compressed npz file, which a killed process would never have begun.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.control import computed_torque  # noqa: E402
from mafsil.robot import load  # noqa: E402
from mafsil.simulation import Recording, Scenario, simulate  # noqa: E402
from mafsil.trajectory import quintic  # noqa: E402

STEP = 1e-3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--json")
    arguments = parser.parse_args()
    robot, count = load(arguments.robot), arguments.steps
    middle = (robot.limits.lower + robot.limits.upper) / 2
    path = quintic(middle, middle + 0.2 * (robot.limits.upper - middle), count * STEP)
    scenario = Scenario(robot=robot, trajectory=path, law=computed_torque(robot), step=STEP)
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.mcap"
        times = race(
            {
                "plain": lambda: simulate(scenario, fused=False),
                "plain, logged": lambda: simulate(scenario, fused=False, log=log),
                "compiled": lambda: simulate(scenario, fused=True),
                "compiled, logged": lambda: simulate(scenario, fused=True, log=log),
                "read": lambda: Recording.load(log),
                "npz afterwards": lambda: np.savez_compressed(Path(folder) / "run.npz", **simulated.arrays()),
            }
            if (simulated := simulate(scenario, fused=True, log=log))
            else {},
            repeats=9,
            seconds=0.05,
        )
        size = log.stat().st_size
    per = {name: timing.least / count for name, timing in times.items()}
    print(", ".join(f"{key} {value}" for key, value in machine("numpy", "mcap").items()))
    for name, seconds in per.items():
        print(f"{name}: {seconds * 1e6:.2f} us a tick, {100 * seconds / STEP:.2g} % of 1 ms")
    for kind in ("plain", "compiled"):
        print(f"{kind}: with the log {per[f'{kind}, logged'] / per[kind]:.2f} times as long as without")
    print(f"{size / count:.0f} bytes a tick")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"seconds a tick": per, "bytes a tick": size / count}, indent=2))


if __name__ == "__main__":
    main()
