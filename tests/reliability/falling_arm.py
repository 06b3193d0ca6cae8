"""R10: energy of arms of six joints that fall freely for 100 s, by each way to keep it.

python -m tests.reliability.falling_arm [--robots ur5e puma560] [--duration 100]

Prints the drift relative to the largest kinetic energy, its maximum in each tenth of the time (a drift would grow), and
the trend of a straight line through it over the whole time.
"""

from __future__ import annotations

import argparse
import sys
from time import perf_counter
from typing import Any

import numpy as np

from mafsil.robot import load
from mafsil.simulation import forward_dynamics_trajectory

FALL = np.array([0.2, -0.4, 0.6, 0.3, -0.5, 0.1])
WAYS: dict[str, dict[str, Any]] = {
    "dop853, tolerance 1e-13": {"method": "dop853", "tolerance": 1e-13},
    "dop853 in momenta, tolerance 1e-13": {"method": "dop853", "tolerance": 1e-13, "momenta": True},
    "variational, 1 ms": {"method": "variational", "step": 1e-3},
    "variational4, 1 ms": {"method": "variational4", "step": 1e-3},
}
LIMIT = 1e-9


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=["ur5e", "puma560"])
    parser.add_argument("--duration", type=float, default=100.0)
    options = parser.parse_args()
    worst = 0.0
    for name in options.robots:
        robot = load(name)
        for way, settings in WAYS.items():
            began = perf_counter()
            moved = forward_dynamics_trajectory(robot, FALL, duration=options.duration, friction=False, **settings)
            error = (moved.energy - moved.energy[0]) / robot.kinetic_energy(moved.q, moved.qd).max()
            tenths = " ".join(f"{np.abs(part).max():.0e}" for part in np.array_split(error, 10))
            trend = np.polyfit(moved.t, error, 1)[0] * moved.duration
            print(
                f"{name}, {way}: drift {moved.energy_drift:.1e} in {len(moved.t)} steps, {perf_counter() - began:.0f} s"
            )
            print(f"  tenths {tenths}, trend {trend:+.0e}", flush=True)
            if "tolerance" in settings:
                worst = max(worst, moved.energy_drift)
    return int(worst > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
