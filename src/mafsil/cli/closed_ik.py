"""`mafsil ik` of a mechanism with loops: configurations that close them, or how near the nearest comes."""

from __future__ import annotations

from typing import Any

from mafsil.arrays import PoseMatrix
from mafsil.cli.answer import Answer
from mafsil.cli.state import shown, unit
from mafsil.cli.table import number as printed
from mafsil.cli.table import table
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.parallel import ClosedChain, ClosedPoses, closed_inverse_kinematics
from mafsil.robot import Robot

TASKS = ("pose", "axis", "position")
ROUNDED = 1e-6
"""How far the tip may be from a typed pose that is not met exactly [m, rad]."""


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
    lines = [say("cli.ik_title", robot=arm.name), *_rows(robot, found, rows, degrees=degrees), *explanation]
    solutions = [{"q": found.q[k], "within_limits": bool(found.within[k])} for k in rows]
    data: dict[str, Any] = {
        "robot": arm.name, "pose": T, "task": task, "status": found.status.name.lower(), "explanation": explanation,
        "complete": False, "method": "closed_inverse_kinematics", "solutions": solutions, "freedom": found.freedom,
        "nearest": None if found else {"q": found.nearest, "pose": robot.forward_kinematics(found.nearest)},
    }  # fmt: skip
    return Answer(data, tuple(lines), None if found else explanation[0])


def _rows(robot: Robot, found: ClosedPoses, rows: list[int], *, degrees: bool) -> list[str]:
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
