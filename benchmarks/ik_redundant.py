"""How fast are arms with joints to spare, planar arms and partial tasks, in the calls that users make?

python benchmarks/ik_redundant.py [--seven iiwa7 panda] [--frankik FOLDER] [--poses 1000] [--json FILE]

Seven joints beside ssik (C++), whose `solve` sweeps one free parameter over sixteen values and returns the
configurations within the limits. Two calls of ours stand beside it: `redundancy(robot).sweep` does the same work
(sixteen values, all configurations, judged and wound into the limits), `inverse_kinematics` answers with the locked
joint at its preferred value or at the nearest that leads within the limits. Of a Panda ssik spreads its values over
what is feasible for the pose, ours lie over the whole range of the joint: it finds more configurations within the
limits. At a given last joint of a Panda beside frankik where it is installed (`--frankik FOLDER` where it is
unpacked): `free=` and `redundancy(robot, joint).solve`. Then, without a rival, every other kind of arm that holds
joints, is planar, or is asked for a part of the pose.

Results are compared first: every configuration of a rival has to be among ours at its own value of the parameter,
ours have to reach the pose by the rival's forward kinematics, and batches have to equal single calls. All on one
thread; single calls go through many poses in turn.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import Timing, machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik import inverse_kinematics, redundancy  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402

SEVEN = {"iiwa7": "kuka.iiwa7_ik", "panda": "franka.panda_ik"}
VALUES, FEW = 16, 32
SINGLE, BATCH, FIXED = 5.0, 20.0, 10.0
"""Targets: single and batch beside ssik, batch at a fixed value beside frankik."""

X, Y, Z = np.eye(3)


def main() -> None:
    arguments = _arguments()
    os.environ["MAFSIL_THREADS"] = "1"
    if arguments.frankik:
        sys.path.insert(0, arguments.frankik)
    found = Comparisons()
    rows = [_seven(name, arguments.poses, found) for name in arguments.seven] if find_spec("ssik") else []
    rows += [_fixed(arguments.poses, found)] if find_spec("frankik") else []
    rows += [_kind(name, made, arguments.poses) for name, made in KINDS.items()]
    rows.append(_without_shape())
    details = machine("numpy", *(["ssik"] if find_spec("ssik") else []))
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    print(f"targets: ssik single {SINGLE:g} times, batch {BATCH:g} times; frankik batch {FIXED:g} times")
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()))
    if arguments.json:
        Path(arguments.json).write_text(
            json.dumps({"machine": details, "rows": rows, "comparisons": found.plain()}, indent=2)
        )


def _seven(name: str, poses: int, found: Comparisons) -> dict[str, str]:
    rival = import_module(f"ssik.prebuilt.{SEVEN[name]}")
    robot = _read(name, rival.fk)
    form = redundancy(robot)
    q, T = _planted(robot, rival.fk, poses)
    theirs = [np.array([one.q for one in rival.solve(one)]) for one in T[:100]]
    details = {
        "robot": name,
        "ssik configurations": f"{np.mean([len(one) for one in theirs]):.1f}",
        "ours": f"{form.sweep(T[:100], VALUES).within.sum() / 100:.1f}",
        "lost": f"{_lost(form, T, q[:, None])} of {poses}",
        "ssik's lost": f"{sum(_lost(form, T[i : i + 1], x[None]) for i, x in enumerate(theirs) if len(x))}",
        "worst": f"{_worst(rival.fk, form.sweep(T[:20], VALUES), T):.0e}",
        "batch differs": f"{_differing(robot, T[:100], 'pose')}",
    }
    ring = _ring(min(poses, 500))
    times = race(
        {
            "ssik": lambda: rival.solve(T[ring()]),
            "single": lambda: inverse_kinematics(robot, T[ring()]),
            "few": lambda: inverse_kinematics(robot, T[:FEW]),
            "batch": lambda: inverse_kinematics(robot, T),
            "sweep single": lambda: form.sweep(T[ring()], VALUES),
            "sweep few": lambda: form.sweep(T[:FEW], VALUES),
            "sweep batch": lambda: form.sweep(T, VALUES),
        },
        repeats=12,
        seconds=0.03,
    )
    each = {key: _per_pose(key, time, poses) for key, time in times.items()}
    goals = {"single": SINGLE, "batch": BATCH, "sweep single": SINGLE, "sweep batch": BATCH}
    names = {"few": f"{FEW} poses", "batch": f"{poses:,} poses", "single": "one pose"}
    for key, x in each.items():
        if key != "ssik":
            *swept, size = key.split()
            call = f"{'redundancy(robot).sweep' if swept else 'mf.inverse_kinematics'}, {names[size]}"
            found.add(call, name, x, "ssik's sweep", each["ssik"], goals.get(key))
    shown = {key: f"{x:.2f} us ({each['ssik'] / x:.1f})" for key, x in each.items() if key != "ssik"}
    return details | {"ssik": f"{each['ssik']:.0f} us"} | shown


def _fixed(poses: int, found: Comparisons) -> dict[str, str]:
    """All configurations at one value of the last joint of a Panda."""
    frankik: Any = import_module("frankik")
    # Its inverse takes the pose of a frame that its forward kinematics is a hand's offset away from.
    hand = pose.inverse(pose.exp(np.array([0.0, 0.0, -np.pi / 4, 0.0, 0.0, 0.1034])))
    rival = SimpleNamespace(fk=lambda x: frankik.fk(x) @ hand)
    robot = _read("panda", rival.fk)
    form = redundancy(robot, robot.joint_names[6])
    q, T = _planted(robot, rival.fk, poses)
    values, name = [float(x) for x in q[:, 6]], robot.joint_names[6]
    theirs = [np.asarray(frankik.ik_full(one, x, x[6])).reshape(-1, 7) for one, x in zip(T, q, strict=True)]
    ring = _ring(min(poses, 500))

    def named() -> Any:
        i = ring()
        return inverse_kinematics(robot, T[i], free={name: values[i]})

    def plain() -> Any:
        i = ring()
        return inverse_kinematics(robot, T[i], free=values[i])

    def one() -> Any:
        i = ring()
        return frankik.ik_full(T[i], q[i], values[i])

    times = race(
        {
            "frankik": one,
            "free= single": plain,
            "free={name: value} single": named,
            "solve few": lambda: form.solve(T[:FEW], q[:FEW, 6:]),
            "solve batch": lambda: form.solve(T, q[:, 6:]),
        },
        repeats=30,
        seconds=0.01,
    )
    each = {key: _per_pose(key, time, poses) for key, time in times.items()}
    for key, x in each.items():
        if key != "frankik":
            found.add(f"redundancy, {key}", "panda", x, "frankik", each["frankik"], FIXED if "batch" in key else None)
    shown = {key: f"{x:.3f} us ({each['frankik'] / x:.1f})" for key, x in each.items() if key != "frankik"}
    known = sum(_lost(form, T[i : i + 1], x[None]) for i, x in enumerate(theirs) if np.isfinite(x).all())
    details = {
        "robot": "panda at a given joint 7",
        "lost": f"{_lost(form, T, q[:, None])} of {poses}",
        "frankik's lost": str(known),
    }
    return details | {"frankik": f"{each['frankik']:.2f} us"} | shown


def _kind(name: str, made: Callable[[], tuple[Robot, str]], poses: int) -> dict[str, str]:
    """An arm without a rival: single call, small and large batch."""
    robot, task = made()
    low, high = np.maximum(robot.limits.lower, -2.5), np.minimum(robot.limits.upper, 2.5)
    T = robot.forward_kinematics(np.random.default_rng(1).uniform(low, high, (poses, robot.n)))
    asked: dict[str, Any] = {"task": task}
    different = _differing(robot, T[:FEW], task)
    ring = _ring(min(poses, 200))
    times = race(
        {
            "single": lambda: inverse_kinematics(robot, T[ring()], **asked),
            "few": lambda: inverse_kinematics(robot, T[:FEW], **asked),
            "batch": lambda: inverse_kinematics(robot, T, **asked),
        },
        repeats=7,
        seconds=0.02,
    )
    found = inverse_kinematics(robot, T, **asked)
    details = {"arm": name, "task": task, "joints": str(robot.n), "solved": f"{int(found.solved.sum())} of {poses}"}  # pyright: ignore[reportAttributeAccessIssue]
    each = {key: f"{_per_pose(key, time, poses):.2f} us" for key, time in times.items()}
    return details | {"batch differs": str(different)} | each


def _without_shape() -> dict[str, str]:
    """Seven axes anywhere: one held, six by elimination; poses within the limits, beyond them and out of reach."""
    robot = _narrow(_arm_of(np.random.default_rng(6)))
    rng = np.random.default_rng(3)
    spans = {"within the limits": (-1.0, 1.0), "beyond them": (1.5, 3.0), "out of reach": (-1.0, 1.0)}
    row = {"arm": "seven axes anywhere", "task": "pose", "joints": "7"}
    for name, span in spans.items():
        T = robot.forward_kinematics(rng.uniform(*span, (2 * FEW, 7)))
        T[:, :3, 3] *= 30.0 if name == "out of reach" else 1.0
        ring = _ring(8)
        tasks: dict[str, Callable[[], Any]] = {
            "single": lambda T=T, ring=ring: inverse_kinematics(robot, T[ring()]),
            "few": lambda T=T: inverse_kinematics(robot, T[:FEW]),
        }
        times = race(tasks, repeats=3, seconds=0.01)
        each = ", ".join(f"{key} {_per_pose(key, time, 1) / 1e3:.2f} ms" for key, time in times.items())
        solved = int(np.sum(inverse_kinematics(robot, T[:FEW]).solved))  # pyright: ignore[reportAttributeAccessIssue]
        row[name] = f"{each}, solved {solved} of {FEW}"
    return row


def _arm_of(rng: np.random.Generator) -> Robot:
    w, r = rng.normal(size=(2, 7, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    return Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), pose.exp(rng.normal(size=6)))


def _narrow(robot: Robot) -> Robot:
    """The same arm, no joint turning farther than one radian."""
    joints = [
        replace(joint, limits=replace(joint.limits, lower=-1.0, upper=1.0)) if joint.moves else joint
        for joint in robot.mechanism.joints
    ]
    return Robot(replace(robot.mechanism, joints=tuple(joints)))


def _per_pose(key: str, time: Timing, poses: int) -> float:
    """Microseconds a pose."""
    return time.least * 1e6 / (poses if key.endswith("batch") else FEW if key.endswith("few") else 1)


def _ring(length: int) -> Callable[[], int]:
    """Indices of poses in turn."""
    turn = count()
    return lambda: next(turn) % length


def _planted(robot: Robot, forward: Callable[[Floats], Floats], poses: int) -> tuple[Floats, Floats]:
    """Random configurations within the limits, and their poses by the rival's forward kinematics."""
    q = np.random.default_rng(1).uniform(robot.limits.lower, robot.limits.upper, (poses, robot.n))
    return q, np.array([forward(x) for x in q])


def _lost(form: Any, T: Floats, q: Floats) -> int:
    """How many of some configurations (k, m, 7) of poses (k, 4, 4) are not among ours at their own parameter values."""
    value = form.value(q)
    usable = np.isfinite(value)
    found = form.solve(T, np.where(usable, value, 0.0))
    away = np.abs((found.q - q[:, :, None] + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
    return int((np.where(np.isnan(away), np.inf, away).min(axis=-1)[usable] > 1e-6).sum())


def _worst(forward: Callable[[Floats], Floats], swept: Any, T: Floats) -> float:
    """By how much the rival's forward kinematics misses the poses with our configurations."""
    rows = np.argwhere(swept.within)
    return max(float(np.abs(forward(swept.q[tuple(row)]) - T[row[0]]).max()) for row in rows)


def _differing(robot: Robot, T: Floats, task: Any) -> int:
    """How many poses of a batch have other solutions or another status than their single calls."""
    many: Any = inverse_kinematics(robot, T, task=task)
    wrong = 0
    for i, one in enumerate(T):
        answer: Any = inverse_kinematics(robot, one, task=task)
        rows = many.q[i][many.valid[i]]
        same = rows.shape == answer.q.shape and np.abs(rows - answer.q).max(initial=0.0) < 1e-9
        wrong += not (same and answer.status is many.status[i])
    return wrong


def _read(name: str, forward: Callable[[Floats], Floats]) -> Robot:
    """An arm read from its forward kinematics, with the limits of the library."""
    home = np.asarray(forward(np.zeros(7)))
    moved = np.array([forward(0.5 * np.eye(7)[k]) for k in range(7)])
    mechanism = Robot.from_screws(pose.log(moved @ pose.inverse(home)) / 0.5, home).mechanism
    limits = load(name).limits
    bounds = iter(zip(limits.lower, limits.upper, strict=True))
    joints = [
        replace(joint, limits=replace(joint.limits, lower=bound[0], upper=bound[1]))
        if joint.moves and (bound := next(bounds))
        else joint
        for joint in mechanism.joints
    ]
    return Robot(replace(mechanism, joints=tuple(joints)))


def _arm(axes: list[Floats], points: list[Floats], tip: Floats, slides: int = 0) -> Robot:
    """Axes w through points r, the first `slides` of them sliding; the tip beyond the last point."""
    rows = [
        np.concatenate([0 * w, w]) if k < slides else np.concatenate([w, np.cross(r, w)])
        for k, (w, r) in enumerate(zip(axes, points, strict=True))
    ]
    home = np.eye(4)
    home[:3, 3] = points[-1] + tip
    return Robot.from_screws(np.array(rows), home)


def _planar(joints: int) -> Robot:
    return _arm([Z] * joints, [0.5 * k * X for k in range(joints)], 0.4 * X)


def _on_rails(rails: int) -> Robot:
    """Three axes that meet, an elbow and three that meet, on one rail or two."""
    points = [0 * X] * (3 + rails) + [0.4 * Z] + [0.8 * Z] * 3
    return _arm([*[X, Y][:rails], Z, Y, Z, -Y, Z, Y, Z], points, 0.1 * Z, slides=rails)


def _five() -> Robot:
    return _arm([Z, Y, Y, Y, X], [0 * Z, 0.3 * Z, 0.7 * Z, Z, Z], 0.15 * X)


KINDS: dict[str, Callable[[], tuple[Robot, str]]] = {
    "planar 2R": lambda: (_planar(2), "position"),
    "planar 3R": lambda: (_planar(3), "pose"),
    "planar 3R ": lambda: (_planar(3), "position"),
    "planar 4R": lambda: (_planar(4), "pose"),
    "scara": lambda: (load("scara_rrrp"), "pose"),
    "scara ": lambda: (load("scara_rrrp"), "position"),
    "3R": lambda: (_arm([Z, Y, Y], [0 * Z, 0.3 * Z, 0.7 * Z], 0.4 * Z), "position"),
    "5R": lambda: (_five(), "axis"),
    "ur5e": lambda: (load("ur5e"), "axis"),
    "ur5e ": lambda: (load("ur5e"), "position"),
    "panda": lambda: (load("panda"), "axis"),
    "panda ": lambda: (load("panda"), "position"),
    "rail and 7R": lambda: (_on_rails(1), "pose"),
    "two rails and 7R": lambda: (_on_rails(2), "pose"),
}


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seven", nargs="*", default=list(SEVEN))
    parser.add_argument("--frankik", help="folder of an unpacked frankik")
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
