"""R16: forward kinematics and back, on every arm and frame: no reachable pose is answered no, and no answer is wrong.

python -m tests.reliability.ik_round_trip --poses 1000 [--shard 50] [--robots panda ...] [--corpus DIR] [--frames 3]
    [--resume DIR]

Poses are those of random joint vectors within the limits, a third of them with joints at multiples of 45 degrees where
the limits allow, on every arm of the library, of example-robot-data and of the URDF files in the folder. Frames are the
tip and links with moving joints on the way to them, the farthest first (all of them with --frames 0); links with more
than `MOST` joints on the way are left out. Each pose is asked in a batch, and one of `SINGLE` alone. Every solution
within the limits is checked by forward kinematics, for URDF files by Pinocchio where it is installed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

import mafsil as mf
from mafsil.ik import inverse_kinematics
from mafsil.ik.chain import moving_part
from mafsil.ik.result import IKStatus
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.library import robots
from mafsil.robot import Robot, load
from tests.model.urdf.real_files import robots as real_files
from tests.reliability import figures

MOST = 8
"""Joints on the way to a frame."""

SINGLE = 20
"""One pose of so many is asked alone as well."""

WRONG = 1e-7
"""By how much a solution may miss its pose [m, or an element of the rotation], in units of the arm where it is long."""

NO = {IKStatus.OUT_OF_REACH, IKStatus.BEYOND_LIMITS, IKStatus.NOT_OF_THIS_ARM}
"""What must never be said of a reachable pose; NOT_FOUND is counted apart."""


def sources(corpus: Path | None = None) -> dict[str, Path | str]:
    """Names of the library and files, by what they are called here."""
    found: dict[str, Path | str] = {name: name for name in robots()}
    found |= {f"erd/{path.stem}": path for path in real_files()}
    if corpus is not None:
        found |= {str(path.relative_to(corpus)): path for path in sorted(corpus.rglob("*.urdf"))}
    return found


def frames(robot: Robot, most: int) -> list[str]:
    """Links with 1 to `MOST` moving joints on the way, no two with the same joints and place; the farthest first."""
    seen: dict[tuple[str, ...], str] = {}
    for link in robot.mechanism.link_names:
        on_the_way = any(joint.moves for joint in chain_to_tip(robot.mechanism.with_tip(link)))
        moving = moving_part(robot, link).robot.joint_names if on_the_way else ()
        if 1 <= len(moving) <= MOST:
            seen[moving] = link
    ordered = sorted(seen.items(), key=lambda item: -len(item[0]))
    return [link for _, link in ordered[: most or None]]


def sample(robot: Robot, rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, n) within the limits, a third of them with round angles."""
    lower, upper = np.clip(robot.limits.lower, -np.pi, None), np.clip(robot.limits.upper, None, np.pi)
    upper = np.maximum(lower, upper)
    q = rng.uniform(lower, upper, (count, robot.n))
    rounded = np.round(q / (np.pi / 4)) * (np.pi / 4)
    use = (rng.random((count, 1)) < 1 / 3) & (rng.random(q.shape) < 0.5) & (rounded >= lower) & (rounded <= upper)
    return np.where(use, rounded, q)


def of_frame(robot: Robot, path: Path | None, frame: str, rng: np.random.Generator, count: int) -> dict[str, int]:
    """Counts for one frame of one robot."""
    q = sample(robot, rng, count)
    T = robot.forward_kinematics(q, frame=frame)
    answer = inverse_kinematics(robot, T, frame=frame)
    status = answer.status
    refused = np.array([one in NO for one in status])
    lost = np.array([one in (IKStatus.NOT_FOUND, IKStatus.NOT_FOUND_WITHIN_LIMITS) for one in status])
    rows = np.argwhere(answer.within)
    solutions = answer.q[answer.within]
    size = max(1.0, float(np.abs(T[:, :3, 3]).max(initial=0.0)))
    wrong = _misses(robot, path, frame, solutions, T[rows[:, 0]]) > WRONG * size
    low, high = robot.limits.lower, robot.limits.upper
    outside = ((solutions < low - 1e-9) | (solutions > high + 1e-9))[:, moving_part(robot, frame).columns].any(axis=1)
    single_no = 0
    for k in range(0, count, SINGLE):
        one = inverse_kinematics(robot, T[k], frame=frame)
        single_no += not one or one.status in NO
    for k in np.flatnonzero(refused | lost)[:2]:
        print(f"# {robot.mechanism.name} {frame} {status[k].name} q={q[k].tolist()!r}", file=sys.stderr)
    return {
        "frames": 1,
        "poses": count,
        "solutions": len(solutions),
        "bad_answered_no": int(refused.sum()),
        "bad_not_found": int(lost.sum()),
        "bad_single_no": single_no,
        "bad_wrong": int(wrong.sum()),
        "bad_outside": int(outside.sum()),
    }


def _misses(robot: Robot, path: Path | None, frame: str, q: np.ndarray, T: np.ndarray) -> np.ndarray:
    """(k,) largest difference of the reached from the wanted poses."""
    other = None if path is None else _pinocchio(path)
    if other is None or not len(q):
        return np.abs(robot.forward_kinematics(q, frame=frame) - T).max(axis=(1, 2), initial=0.0)
    return np.array([np.abs(_reached(*other, robot, frame, row) - X).max() for row, X in zip(q, T, strict=True)])


def _reached(pin: Any, model: Any, data: Any, robot: Robot, frame: str, q: np.ndarray) -> np.ndarray:
    x = pin.neutral(model)
    for name, value in zip(robot.joint_names, q, strict=True):
        joint = model.joints[model.getJointId(name)]
        x[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
    pin.framesForwardKinematics(model, data, x)
    return data.oMf[model.getFrameId(frame, pin.FrameType.BODY)].homogeneous


@lru_cache(maxsize=2)
def _pinocchio(path: Path) -> tuple[Any, Any, Any] | None:
    """The model of another library, where it has the same joints; files with mimic joints are not asked of it."""
    try:
        import pinocchio as pin
    except ImportError:
        return None
    if "<mimic" in path.read_text(errors="replace"):
        return None
    try:
        model = pin.buildModelFromUrdf(str(path))
    except (RuntimeError, ValueError):
        return None
    return pin, model, model.createData()


def work(chosen: dict[str, Path | str], seed: int, poses: int, most: int) -> dict[str, int]:
    """A shard: so many poses of every frame of every robot."""
    total = {"robots": 0, "not_read": 0}
    for k, (name, source) in enumerate(chosen.items()):
        path = source if isinstance(source, Path) else None
        try:
            robot = load(source)
        except mf.MafsilError:
            total["not_read"] += 1
            continue
        total["robots"] += 1
        for j, found in enumerate(_found(robot, path, seed, k, poses, most)):
            for key, value in found.items():
                total[key] = total.get(key, 0) + value
            bad = {key: value for key, value in found.items() if key.startswith("bad_") and value}
            if bad:
                print(f"# {name} frame {j}: {bad}", file=sys.stderr)
    return total


def _found(robot: Robot, path: Path | None, seed: int, k: int, poses: int, most: int) -> Iterator[dict[str, int]]:
    for j, frame in enumerate(frames(robot, most)):
        yield of_frame(robot, path, frame, np.random.default_rng([seed, k, j]), poses)


def main() -> int:
    """Run all shards and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", dest="count", type=int, default=1000, help="poses of every frame")
    parser.add_argument("--shard", type=int, default=100, help="poses of every frame in a shard")
    parser.add_argument("--seed", type=int, default=0, help="first shard")
    parser.add_argument("--robots", nargs="*", default=[], help="names as listed; all if none")
    parser.add_argument("--corpus", type=Path, default=None, help="folder of further URDF files")
    parser.add_argument("--frames", type=int, default=1, help="frames of every robot, 0 for all")
    parser.add_argument("--resume", type=Path, default=None, help="directory of the shard files, which are kept")
    options = parser.parse_args()
    known = sources(options.corpus)
    chosen = {name: known[name] for name in options.robots} if options.robots else known
    return int(not figures.run("R16", options, lambda seed, n: work(chosen, seed, n, options.frames))["passed"])


if __name__ == "__main__":
    sys.exit(main())
