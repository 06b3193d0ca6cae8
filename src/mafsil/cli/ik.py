"""`mafsil ik`: joint coordinates for a pose, with the reason where there are none; `mafsil fk`: where the tip is.

Of a mechanism with loops: configurations that close them, or how near the nearest comes.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from math import degrees as to_degrees
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.cli.answer import PLAIN, Answer, Toned, draw_picture, require_kind
from mafsil.cli.motion_input import PLACES, typed_pose
from mafsil.cli.state import angle_remarks, chain_at, degrees_remarks, joint_values, shown, unit
from mafsil.cli.table import matrix, number, table
from mafsil.cli.table import number as printed
from mafsil.cli.tolerances import ROUNDED, ROUNDOFF
from mafsil.errors import InputError
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.messages import say
from mafsil.parallel import ClosedChain, ClosedPoses, closed_inverse_kinematics
from mafsil.robot import Robot, load

TASKS = ("pose", "axis", "position")


def ik(
    robot: str,
    pose: list[str],
    all: bool,
    near: list[str] | None,
    task: str | None,
    frame: str | None,
    tip: str | None,
    degrees: bool,
    picture: str | None,
) -> Answer:
    """Joint coordinates that bring the tip to a pose; of mechanisms with loops those that close them, without pictures.

    Args:
        robot: name or file.
        pose: x, y, z [m] and, unless only the position is asked for, roll, pitch, yaw about fixed axes or a quaternion
            w, x, y, z; or the rows of a matrix; as typed.
        all: print all solutions; else the one within the limits that is farthest from singular configurations.
        near: (n) coordinates as typed: the solution and the turns nearest to them are printed too.
        task: `pose`, `position` or `axis`; `position` if only three numbers are given.
        frame: a link; the tip frame if None.
        tip: another tip link.
        degrees: whether bare angles are degrees, and angles are printed so.
        picture: file for a picture of the configurations printed, or None.

    Raises:
        MafsilError: no such robot or frame, not three or six finite numbers.
    """
    if picture is not None:
        require_kind(picture, PLAIN)
    arm = load(robot, tip=tip)
    T = typed_pose("pose", pose, degrees=degrees)
    requested = task or ("position" if len(pose) == 3 else "pose")
    if arm.mechanism.loops:
        return closed_ik(arm, T, requested, frame, everything=all, degrees=degrees)
    answer = inverse_kinematics(arm, T, frame=frame, task=requested)  # pyright: ignore[reportArgumentType]
    assert isinstance(answer, SolutionSet)
    explanation = answer.explain().splitlines()
    rows = _chosen(answer, all)
    lines = [say("cli.ik_title", robot=arm.name), *_rows(arm, answer, rows, degrees=degrees), *explanation]
    data = {
        "robot": arm.name,
        "pose": T,
        "task": requested,
        "status": answer.status.name.lower(),
        "explanation": explanation,
        "complete": answer.complete,
        "method": answer.method,
        "solutions": [
            {
                "q": answer.q[k],
                "branch": str(answer.branches[k]),
                "residual": float(answer.residual[k]),
                "conditioning": float(answer.conditioning[k]),
                "within_limits": bool(answer.within[k]),
                "turn_count": _turn_count(answer, k),
                "beyond": [vars(one) for one in answer.violations(k)],
            }
            for k in rows
        ],
        "families": [{"solution": f.solution, "joint": f.joint, "moving": f.moving} for f in answer.families],
        "nearest": None if answer else {"q": answer.q_nearest, "pose": answer.T_nearest},
    }
    lines += angle_remarks((f"{name} = {word}", word) for name, word in _bare_angles(pose, degrees=degrees))
    if near is not None and answer:
        nearest = answer.nearest(joint_values("near", near, arm.mechanism, degrees=degrees))
        data["near"] = nearest
        typed = zip(arm.mechanism.coordinates, nearest, strict=True)
        shown_near = "  ".join(printed(shown(float(x), joint.kind, degrees=degrees)) for joint, x in typed)
        lines.append(say("cli.ik_near_answer", values=shown_near))
    if picture is not None and rows:
        lines.append(draw_picture(partial(_draw, arm, answer, rows), picture, data))
    return Answer(data, tuple(lines), None if answer else explanation[0])


def _draw(arm: Robot, answer: SolutionSet, rows: list[int], picture: Path) -> None:
    """Solutions as the page of the robot draws them where a browser can; as plots are in other files."""
    from mafsil.figures import plot_configurations
    from mafsil.page.show import chromium, show

    names = [answer.branches[k].label() for k in rows]
    if picture.suffix.lower() == ".png" and chromium() is not None:
        sides = [say("cli.ik_inside" if answer.within[k] else "cli.ik_outside") for k in rows]
        words = [f"{k + 1} · {name} · {side}" for k, name, side in zip(rows, names, sides, strict=True)]
        show(arm).photograph(picture, postures=dict(zip(words, answer.q[rows].tolist(), strict=True)))
    else:
        plot_configurations(arm, answer.q[rows], picture, names, answer.within[rows])


def _bare_angles(words: list[str], *, degrees: bool) -> Iterable[tuple[str, str]]:
    return () if degrees or len(words) != len(PLACES) else zip(PLACES[3:], words[3:], strict=True)


def _chosen(answer: SolutionSet, everything: bool) -> list[int]:
    """Indices to print: all, or the best one within the limits."""
    if everything:
        return list(range(len(answer)))
    return sorted(range(len(answer)), key=lambda k: (not answer.within[k], -answer.conditioning[k]))[:1]


def _turn_count(answer: SolutionSet, k: int) -> int:
    """In how many ways whole turns of its joints keep a solution within the limits; joints without are not turned."""
    first = np.ceil((answer.lower - answer.q[k]) / (2 * pi) - ROUNDOFF)
    last = np.floor((answer.upper - answer.q[k]) / (2 * pi) + ROUNDOFF)
    turned = answer.revolute & np.isfinite(first) & np.isfinite(last)
    ways: NDArray[np.float64] = (last - first + 1)[turned]
    return int(float(np.prod(ways))) if answer.within[k] else 0


def _rows(arm: Robot, answer: SolutionSet, rows: list[int], *, degrees: bool) -> list[str]:
    """Lines of a table of solutions."""
    if not rows:
        return []
    joints = arm.mechanism.coordinates
    # Explanations speak of solutions by their numbers.
    head = ["#", *(say(f"cli.ik_{name}") for name in ("branch", "residual", "limits", "turns"))]
    body = [
        [
            str(k + 1),
            answer.branches[k].label(),
            f"{answer.residual[k]:.1e}",
            say("cli.ik_inside" if answer.within[k] else "cli.ik_outside"),
            str(_turn_count(answer, k)),
        ]
        for k in rows
    ]
    names = ["#", *(f"{j.name} [{unit(j.kind, degrees=degrees)}]" for j in joints), say("cli.ik_conditioning")]
    values: list[list[str]] = []
    for k in rows:
        q = [shown(float(x), joint.kind, degrees=degrees) for x, joint in zip(answer.q[k], joints, strict=True)]
        values.append([str(k + 1), *map(printed, q), f"{answer.conditioning[k]:.3f}"])
    return [*table(head, body, words=(1,)), "", *table(names, values)]


def closed_ik(arm: Robot, T: PoseMatrix, task: str, frame: str | None, *, everything: bool, degrees: bool) -> Answer:
    """Configurations with closed loops for a pose.

    Args:
        arm: with loops.
        T: (4, 4) of the tip, or of the frame.
        task: what of it counts.
        frame: a link; the tip if None.
        everything: print all of them; else the first within the limits.
        degrees: whether angles are printed in degrees.

    Raises:
        InputError: a task that is not searched with loops.
    """
    if task not in TASKS:
        raise InputError("input.choice", name="task", value=task, known=", ".join(TASKS))
    robot = arm if frame is None else Robot(arm.mechanism.with_tip(frame))
    chain = ClosedChain(robot)
    found = closed_inverse_kinematics(chain, T, task=task)
    if not len(found):
        found = closed_inverse_kinematics(chain, T, task=task, tolerance=ROUNDED, rotation_tolerance=ROUNDED)
    rows = list(range(len(found)))[: None if everything else 1]
    explanation = found.explain().splitlines()
    lines = [say("cli.ik_title", robot=arm.name), *_closed_rows(robot, found, rows, degrees=degrees), *explanation]
    solutions = [{"q": found.q[k], "within_limits": bool(found.within[k])} for k in rows]
    data: dict[str, Any] = {
        "robot": arm.name, "pose": T, "task": task, "status": found.status.name.lower(), "explanation": explanation,
        "complete": False, "method": "closed_inverse_kinematics", "solutions": solutions, "freedom": found.freedom,
        "nearest": None if found else {"q": found.nearest, "pose": robot.forward_kinematics(found.nearest)},
    }  # fmt: skip
    return Answer(data, tuple(lines), None if found else explanation[0])


def _closed_rows(robot: Robot, found: ClosedPoses, rows: list[int], *, degrees: bool) -> list[str]:
    """Lines of a table of configurations."""
    joints = robot.mechanism.coordinates
    names = ["#", *(f"{j.name} [{unit(j.kind, degrees=degrees)}]" for j in joints), say("cli.ik_limits")]
    body = [
        [
            str(k + 1),
            *(printed(shown(float(x), j.kind, degrees=degrees)) for x, j in zip(found.q[k], joints, strict=True)),
            say("cli.ik_inside" if found.within[k] else "cli.ik_outside"),
        ]
        for k in rows
    ]
    return table(names, body, words=(len(names) - 1,)) if rows else []


def fk(robot: str, q: list[str], frame: str | None, tip: str | None, degrees: bool) -> Answer:
    """Pose of the tip or of a link in {s}.

    Args:
        robot: name or file.
        q: (n) coordinates as typed.
        frame: a link; the tip frame if None.
        tip: another tip link.
        degrees: whether bare angles are degrees.

    Raises:
        MafsilError: no such robot or frame, not one number per joint.
    """
    arm = load(robot, tip=tip)
    values = joint_values("q", q, arm.mechanism, degrees=degrees)
    if arm.mechanism.loops:
        chain_at(arm, values)
    T = np.asarray(arm.forward_kinematics(values) if frame is None else arm.forward_kinematics(values, frame=frame))
    quaternion, rpy = orientation(T[:3, :3])
    outside = _outside(values, arm.limits.lower, arm.limits.upper, arm.joint_names)
    data = {
        "robot": arm.name,
        "frame": frame or arm.mechanism.tip,
        "q": values,
        "pose": T,
        "position": T[:3, 3],
        "quaternion_wxyz": quaternion,
        "rpy": rpy,
        "outside_limits": outside,
    }
    lines = [say("cli.fk_title", robot=arm.name, frame=frame or say("cli.tip_frame", link=arm.mechanism.tip))]
    lines += matrix(T)
    lines.append(say("cli.fk_position", values="  ".join(number(x) for x in T[:3, 3])))
    lines.append(say("cli.fk_quaternion", values="  ".join(number(x) for x in quaternion)))
    turned = [to_degrees(x) for x in rpy] if degrees else rpy
    lines.append(say("cli.fk_rpy", unit="°" if degrees else "rad", values="  ".join(number(float(x)) for x in turned)))
    lines += [Toned(say("cli.outside", joint=item), "warning") for item in outside]
    lines += degrees_remarks(q, arm.mechanism, degrees=degrees)
    return Answer(data, tuple(lines))


def orientation(R: Floats) -> tuple[Floats, Floats]:
    """Quaternion (w, x, y, z) with w >= 0, and roll, pitch, yaw about fixed x, y, z [rad]."""
    from mafsil.geometry import rotation

    quaternion = np.asarray(rotation.to_quaternion(R))
    return (quaternion if quaternion[0] >= 0 else -quaternion), np.asarray(rotation.to_rpy(R))


def _outside(q: Floats, lower: Floats, upper: Floats, names: tuple[str, ...]) -> list[str]:
    return [name for name, x, a, b in zip(names, q, lower, upper, strict=True) if not a <= x <= b]
