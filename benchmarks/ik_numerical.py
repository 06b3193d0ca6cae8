"""How fast and how sure is numerical inverse kinematics, beside Robotics Toolbox's ik_LM in C++, in the same run?

python benchmarks/ik_numerical.py [--robots panda ur5e ...] [--poses 10000] [--rtb PYTHON] [--json FILE]

Random reachable poses within the limits, no seed given, every answer rechecked by forward kinematics. Ours: tolerance
1e-10 [m, rad]; `solve_ik` of all poses at once on one core, of 32 at once, and one by one. The rival gets the same
chains and poses, starts of its own, 30 iterations, 100 searches, limits on; its tolerance E = |e|^2 / 2 is 1e-12, so
its errors are near 1e-6. Both sides take turns of 500 poses, several rounds of them; each turn counts with its quickest
round, by the clock; means of the thread's processor time stand beside. `--rtb` names the interpreter of an environment
with roboticstoolbox-python (its dependencies need not fit ours); without it only ours is measured. What TRAC-IK
published of the same arms (other machine, errors 1e-5) stands beside.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik import solve_ik  # noqa: E402
from mafsil.model import JointKind  # noqa: E402
from mafsil.model.exponentials import chain_to_tip  # noqa: E402
from mafsil.robot import Robot  # noqa: E402
from tests.reliability.ik_arms import ARMS, arm  # noqa: E402
from tests.reliability.ik_numerical import PUBLISHED, targets  # noqa: E402

ROBOTS = ("panda", "fr3", "iiwa7", "ur5e", "puma560", "stanford_arm", "kinova", "baxter", "pr2", "tiago", "talos", "z1")
BATCH_TARGET, SINGLE_TARGET = 30.0, 6.0
"""Ratios that are wanted."""


TURN, ROUNDS, SMALL = 500, 5, 32
"""Poses of one turn, rounds, and poses of a small batch."""


def main() -> None:
    arguments = _arguments()
    found = Comparisons()
    rows = [_row(name, arguments, found) for name in arguments.robots if arm(name) is not None]
    details = machine("numpy", "llvmlite")
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    print(f"targets: batch {BATCH_TARGET:g} times, single {SINGLE_TARGET:g} times ik_LM")
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
    if arguments.json:
        Path(arguments.json).write_text(
            json.dumps({"machine": details, "rows": rows, "comparisons": found.plain()}, indent=2)
        )


def _row(name: str, arguments: argparse.Namespace, found: Comparisons) -> dict[str, str]:
    robot = arm(name)
    assert robot is not None
    T = targets(robot, arguments.poses, 9)
    answer = solve_ik(robot, T)
    solve_ik(robot, T[0])
    with ExitStack() as stack:
        rival = None if arguments.rtb is None else stack.enter_context(_Rival(robot, T, arguments.rtb))
        times = _turns(robot, T, min(arguments.rival_poses, len(T)), rival)
    batch, small, single = times["batch"][0].min(), times["small"][0].mean(), times["single"][0].mean()
    row = {
        "robot": name,
        "joints": str(robot.n),
        "poses": str(len(T)),
        "solved": f"{answer.solved.mean():.4%}",
        "worst error": f"{_errors(robot, answer.q, T).max():.1e}",
        "batch": f"{batch:.2f} us",
        f"batch of {SMALL}": f"{small:.2f} us",
        "single mean": f"{single:.1f} us",
        "attempts": f"{answer.attempts.mean():.2f}",
    }
    for solver, (share, mean) in PUBLISHED.get(name, {}).items():
        row[f"{solver} published"] = f"{share:.2%} {mean:.0f} us"
    if rival is None:
        return row
    theirs = times["rival"][0].mean()
    solved = f"{name}, {answer.solved.mean():.2%} solved"
    found.add(f"mf.solve_ik(robot, T), {len(T):,} poses", solved, batch, "ik_LM", theirs, BATCH_TARGET)
    found.add(f"mf.solve_ik(robot, T), {SMALL} poses", name, small, "ik_LM", theirs)
    found.add("mf.solve_ik(robot, T), one pose", name, single, "ik_LM", theirs, SINGLE_TARGET)
    return row | {
        f"ik_LM {rival.version}": f"{_solved(robot, rival.q, T):.2%}",
        "mean": f"{theirs:.0f} us",
        "batch ratio": f"{theirs / batch:.0f}",
        f"ratio of {SMALL}": f"{theirs / small:.0f}",
        "single ratio": f"{theirs / single:.1f}",
        "processor ratios": f"{times['rival'][1].mean() / times['batch'][1].min():.0f} "
        f"{times['rival'][1].mean() / times['single'][1].mean():.1f}",
    }


def _turns(robot: Robot, T: Floats, count: int, rival: _Rival | None) -> dict[str, Floats]:
    """Least microseconds of a pose in every turn: (2, turns) by the clock and of the processor, for all who play."""
    edges = [(first, min(first + TURN, count)) for first in range(0, count, TURN)]
    least: dict[str, Floats] = {}

    def note(player: str, turn: int, clock: float, work: float, poses: int) -> None:
        of = least.setdefault(player, np.full((2, len(edges)), np.inf))
        of[:, turn] = np.minimum(of[:, turn], np.array([clock, work]) / poses * 1e6)

    for _ in range(ROUNDS):
        for turn, (first, last) in enumerate(edges):
            rows, some = T[first:last], T[first : first + SMALL]
            if rival is not None:
                note("rival", turn, *rival.solve(first, last), last - first)
            note("single", turn, *_timed(partial(_one_by_one, robot, rows)), last - first)
            note("small", turn, *_timed(partial(solve_ik, robot, some)), len(some))
            note("batch", turn, *_timed(partial(solve_ik, robot, T)), len(T))
    return least


def _one_by_one(robot: Robot, T: Floats) -> None:
    for wanted in T:
        solve_ik(robot, wanted)


def _timed(task: Callable[[], object]) -> tuple[float, float]:
    begin, worked = perf_counter(), thread_time()
    task()
    work = thread_time() - worked
    return perf_counter() - begin, work


def _solved(robot: Robot, q: dict[int, list[float] | None], T: Floats) -> float:
    """Share of the rival's poses that it solved, within 1e-4 and the limits."""
    found = {k: row for k, row in q.items() if row is not None}
    if not found:
        return 0.0
    rows = np.array(list(found.values()))
    inside = ((rows >= robot.limits.lower - 1e-9) & (rows <= robot.limits.upper + 1e-9)).all(axis=1)
    return float(((_errors(robot, rows, T[list(found)]) < 1e-4) & inside).sum() / len(q))


def _errors(robot: Robot, q: Floats, T: Floats) -> Floats:
    e = pose.error(robot.forward_kinematics(q), T)
    return np.maximum(np.linalg.norm(e[:, :3], axis=1), np.linalg.norm(e[:, 3:], axis=1))


class _Rival:
    """ik_LM for the same chain and poses, in a process of its own that waits between turns.

    Args:
        robot: whose chain it gets.
        T: (k, 4, 4) poses.
        python: its interpreter.
    """

    def __init__(self, robot: Robot, T: Floats, python: str) -> None:
        lower, upper = np.array(robot.limits.lower), np.array(robot.limits.upper)
        self.folder = tempfile.TemporaryDirectory()
        path = Path(self.folder.name) / "chain.npz"
        np.savez(
            path,
            constants=_constants(robot),
            slides=[joint.kind is JointKind.PRISMATIC for joint in robot.mechanism.coordinates],
            lower=np.where(np.isfinite(lower), lower, -np.pi),
            upper=np.where(np.isfinite(upper), upper, np.pi),
            T=T,
            tolerance=1e-12,
        )
        script = str(Path(__file__).with_name("ik_rival_rtb.py"))
        environment = {name: x for name, x in os.environ.items() if not name.startswith("PYTHON")}
        self.process = subprocess.Popen(
            [python, script, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )
        self.version = self._line()["version"]
        self.q: dict[int, list[float] | None] = {}

    def __enter__(self) -> _Rival:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.process.communicate()
        self.folder.cleanup()

    def solve(self, first: int, last: int) -> tuple[float, float]:
        """Seconds that some poses take, by the clock and of its processor."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{first} {last}\n")
        self.process.stdin.flush()
        answer = self._line()
        self.q.update(zip(range(first, last), answer["q"], strict=True))
        return sum(answer["seconds"]), sum(answer["work"])

    def _line(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        return json.loads(self.process.stdout.readline())


def _constants(robot: Robot) -> Floats:
    """(n + 1, 4, 4) poses between the joints, whose axes are made the z axes."""
    mechanism = robot.mechanism
    constants, T = [], np.array(mechanism.T_sb)
    for joint in chain_to_tip(mechanism):
        T = T @ joint.T_pj
        if joint.moves:
            A = np.eye(4)
            A[:3, :3] = _towards(np.asarray(joint.axis, dtype=np.float64))
            constants.append(T @ A)
            T = A.T
    return np.array([*constants, T @ mechanism.T_lt])


def _towards(axis: Floats) -> Floats:
    """(3, 3) a rotation whose z axis is the given one."""
    x = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=ROBOTS, choices=list(ARMS))
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--rival-poses", type=int, default=1000)
    parser.add_argument("--rtb", help="interpreter with roboticstoolbox-python")
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
