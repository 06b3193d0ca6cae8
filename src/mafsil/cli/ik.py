"""`mafsil ik`: joint coordinates for a pose, one or all, with the reason where there are none."""

from __future__ import annotations

from collections.abc import Iterable
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mafsil.cli.answer import Answer
from mafsil.cli.closed_ik import closed_ik
from mafsil.cli.picture import PLAIN, drawn, require_kind
from mafsil.cli.state import angle_remarks, joint_values, shown, unit
from mafsil.cli.table import number as printed
from mafsil.cli.table import table
from mafsil.cli.typed_pose import PLACES, typed_pose
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.messages import say
from mafsil.robot import Robot, load


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
        _draw(arm, answer, rows, picture)
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    return Answer(data, tuple(lines), None if answer else explanation[0])


def _draw(arm: Robot, answer: SolutionSet, rows: list[int], picture: str) -> None:
    """Solutions as the page of the robot draws them where a browser can; as plots are in other files."""
    from mafsil.figures import plot_configurations
    from mafsil.page.show import chromium, show

    names = [answer.branches[k].label() for k in rows]
    if Path(picture).suffix.lower() == ".png" and chromium() is not None:
        sides = [say("cli.ik_inside" if answer.within[k] else "cli.ik_outside") for k in rows]
        words = [f"{k + 1} · {name} · {side}" for k, name, side in zip(rows, names, sides, strict=True)]
        show(arm).photograph(picture, postures=dict(zip(words, answer.q[rows].tolist(), strict=True)))
    else:
        drawn(lambda path: plot_configurations(arm, answer.q[rows], path, names, answer.within[rows]), picture)


def _bare_angles(words: list[str], *, degrees: bool) -> Iterable[tuple[str, str]]:
    return () if degrees or len(words) != len(PLACES) else zip(PLACES[3:], words[3:], strict=True)


def _chosen(answer: SolutionSet, everything: bool) -> list[int]:
    """Indices to print: all, or the best one within the limits."""
    if everything:
        return list(range(len(answer)))
    return sorted(range(len(answer)), key=lambda k: (not answer.within[k], -answer.conditioning[k]))[:1]


def _turn_count(answer: SolutionSet, k: int) -> int:
    """In how many ways whole turns of its joints keep a solution within the limits; joints without are not turned."""
    first = np.ceil((answer.lower - answer.q[k]) / (2 * pi) - 1e-12)
    last = np.floor((answer.upper - answer.q[k]) / (2 * pi) + 1e-12)
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
