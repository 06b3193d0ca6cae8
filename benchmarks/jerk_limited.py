"""How fast are jerk-limited motions between states, by their public names, beside Ruckig (C++), in the same run?

python benchmarks/jerk_limited.py [--problems 1000] [--json FILE]

Seven joints, random problems from rest to rest and between arbitrary states, one thread. Single: `mf.trajectory
.jerk_limited(...)` with its `duration` read, beside Ruckig's `calculate` with its six states set before, which is what
a program does. Batch: one call of many problems, for each problem, beside Ruckig's `calculate` alone. Then one step of
`mf.trajectory.online` whose goal changes in every cycle, beside Ruckig's `update`; a whole trajectory sampled; motions
through points.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from tests.reliability.jerk_limited import random_problems, solve  # noqa: E402

JOINTS = 7
BATCH_TARGET, SINGLE_TARGET = 4.0, 1.0
DISTINCT = 64
"""Problems that single calls take in turn."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=256)
    parser.add_argument("--points", type=int, nargs="+", default=[100, 1000], help="of motions through via points")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    details = machine("numpy")
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    found = Comparisons()
    for kind in ("rest", "arbitrary"):
        _compare(kind, arguments.problems, found)
    for row in found.rows:
        goal = f"  goal {row.goal:g}" if row.goal else ""
        print(
            f"{row.case:10} {row.call:40} {row.ours:9.2f} us  {row.peer:28} {row.theirs:9.2f} us  "
            f"ratio {row.ratio:6.2f}{goal}"
        )
    for points, least in _through(arguments.points):
        print(f"jerk_limited_through {points:6} points {1e3 * least:10.2f} ms, {1e6 * least / points:8.1f} us a point")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"machine": details, "comparisons": found.plain()}, indent=2))


def _compare(kind: str, count: int, found: Comparisons) -> None:
    x, limits = random_problems(np.random.default_rng(7), count, JOINTS, kind)
    ours = {
        "single": _in_turn(lambda s: _planned(s, limits).duration, x),
        "batch": lambda: solve(x, limits).duration,
    }
    motion = _planned(x[0], limits)
    times = np.arange(0.0, motion.duration, 1e-3)
    online = mf.trajectory.online(x[0, :, 0], limits, 1e-3)
    goals = cycle([np.ascontiguousarray(row[:, 3]) for row in x[:DISTINCT]])
    ours |= {"online": lambda: online.step(next(goals)), "sampled": lambda: motion.at(times)}
    theirs = _ruckig(x, limits, times)
    if not theirs:
        print("ruckig is not installed")
        return
    taken = race(ours | theirs, repeats=40, seconds=0.002)
    us = {name: 1e6 * time.least for name, time in taken.items()}
    each = us["batch"] / count
    found.add(
        "jerk_limited, single", kind, us["single"], "ruckig calculate, states set", us["ruckig set"], SINGLE_TARGET
    )
    found.add(f"jerk_limited, each of {count}", kind, each, "ruckig calculate", us["ruckig"], BATCH_TARGET)
    found.add("online, a new goal in every cycle", kind, us["online"], "ruckig update", us["ruckig online"], None)
    found.add(
        f"motion.at of {len(times)} times", kind, us["sampled"], "ruckig at_time of each", us["ruckig sampled"], None
    )


def _through(counts: list[int]) -> Iterator[tuple[int, float]]:
    """Seconds that motions through so many points take; Ruckig sends via points to a server."""
    limits = mf.trajectory.MotionLimits.of(JOINTS, velocity=1.5, acceleration=3.0, jerk=30.0)
    for count in counts:
        points = np.cumsum(np.random.default_rng(0).uniform(-0.2, 0.2, (count, JOINTS)), axis=0)
        call = partial(mf.trajectory.jerk_limited_through, points, limits)
        yield count, race({"through": call}, repeats=3)["through"].least


def _planned(s: Floats, limits: mf.trajectory.MotionLimits) -> mf.trajectory.jerk.JerkLimitedMotion:
    motion = mf.trajectory.jerk_limited(
        s[:, 0],
        s[:, 3],
        limits,
        start_velocity=s[:, 1],
        start_acceleration=s[:, 2],
        goal_velocity=s[:, 4],
        goal_acceleration=s[:, 5],
    )
    assert isinstance(motion, mf.trajectory.jerk.JerkLimitedMotion)
    return motion


def _in_turn(call: Callable[[Floats], object], x: Floats) -> Callable[[], object]:
    rows = cycle([np.asfortranarray(row) for row in x[:DISTINCT]])
    return lambda: call(next(rows))


def _ruckig(x: Floats, limits: mf.trajectory.MotionLimits, times: Floats) -> dict[str, Callable[[], object]]:
    try:
        import ruckig
    except ImportError:
        return {}
    solver, answer = ruckig.Ruckig(JOINTS), ruckig.Trajectory(JOINTS)
    asks: list[Any] = []
    for s in x[:DISTINCT]:
        ask = ruckig.InputParameter(JOINTS)
        _set(ask, s)
        ask.max_velocity, ask.max_acceleration = limits.velocity[1], limits.acceleration[1]
        ask.max_jerk = limits.jerk[1]
        asks.append(ask)
    ready, one, states = cycle(asks), asks[0], cycle([np.asfortranarray(s) for s in x[:DISTINCT]])
    whole = ruckig.Trajectory(JOINTS)
    solver.calculate(asks[0], whole)
    online, out, moving = ruckig.Ruckig(JOINTS, 1e-3), ruckig.OutputParameter(JOINTS), ruckig.InputParameter(JOINTS)
    _set(moving, x[0])
    moving.max_velocity, moving.max_acceleration = limits.velocity[1], limits.acceleration[1]
    moving.max_jerk = limits.jerk[1]
    moving.current_velocity = moving.current_acceleration = moving.target_velocity = np.zeros(JOINTS)
    moving.target_acceleration = np.zeros(JOINTS)
    goals = cycle([np.ascontiguousarray(row[:, 3]) for row in x[:DISTINCT]])

    def with_states() -> float:
        _set(one, next(states))
        solver.calculate(one, answer)
        return answer.duration

    def cycled() -> None:
        moving.target_position = next(goals)
        online.update(moving, out)
        out.pass_to_input(moving)

    return {
        "ruckig set": with_states,
        "ruckig": lambda: solver.calculate(next(ready), answer),
        "ruckig online": cycled,
        "ruckig sampled": lambda: [whole.at_time(t) for t in times.tolist()],
    }


def _set(ask: Any, s: Floats) -> None:
    ask.current_position, ask.current_velocity, ask.current_acceleration = s[:, 0], s[:, 1], s[:, 2]
    ask.target_position, ask.target_velocity, ask.target_acceleration = s[:, 3], s[:, 4], s[:, 5]


if __name__ == "__main__":
    main()
