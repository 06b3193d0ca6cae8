"""`mafsil parallel`: motors at a pose, poses for motors, singularities and forces of a parallel robot."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import Answer, draw_picture
from mafsil.cli.parallel_kinds import ANGLES, ParallelCommand, wrap_robot
from mafsil.cli.state import coordinate
from mafsil.cli.state import number as typed
from mafsil.cli.table import number, table
from mafsil.errors import InputError
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.parallel.robot_file import read_parallel


def parallel(
    file: str,
    pose: Sequence[str] | None,
    motors: Sequence[str] | None,
    load: Sequence[str] | None,
    ways: bool,
    degrees: bool,
    picture: str | None,
) -> Answer:
    """What a file of a parallel robot answers.

    Args:
        file: TOML, as `mafsil.parallel.robot_file` says.
        pose: numbers of a pose: which motors it takes, what is singular there.
        motors: lengths or angles: which poses they allow.
        load: wrench that the platform exerts at the pose: which efforts it takes.
        ways: which of the poses are joined without a singular one between.
        degrees: whether bare angles are degrees.
        picture: file to draw into.

    Raises:
        MafsilError: no such file, no parallel robot, numbers that do not fit it.
    """
    robot = wrap_robot(read_parallel(file))
    if (pose is None) == (motors is None):
        raise InputError("cli.parallel_either", pose=" ".join(robot.pose), count=robot.count)
    if pose is not None:
        F = None if load is None else _typed("load", load, robot.wrench, False)
        return _at_pose(robot, _typed("pose", pose, robot.pose, degrees), F, picture)
    names = tuple(("q" if robot.rotary else "s") + str(k + 1) for k in range(robot.count))
    return _for_motors(robot, _typed("motors", motors or (), names, degrees and robot.rotary), ways, picture)


def _typed(name: str, words: Sequence[str], places: tuple[str, ...], degrees: bool) -> Floats:
    """The numbers of an argument; bare angles may be degrees."""
    if len(words) != len(places):
        raise InputError("cli.parallel_count", name=f"--{name}", expected=" ".join(places), got=len(words))
    found: list[float] = []
    for place, word in zip(places, words, strict=True):
        if place in ANGLES or place.startswith("q"):
            value, marked = coordinate(f"{name}[{place}]", str(word))
            found.append(float(np.radians(value)) if degrees and not marked else value)
        else:
            found.append(typed(f"{name}[{place}]", str(word)))
        if not np.isfinite(found[-1]):
            raise InputError("input.finite", name=name, value=found[-1], index=place)
    return np.array(found)


def _at_pose(robot: ParallelCommand, x: Floats, F: Floats | None, picture: str | None) -> Answer:
    motors = robot.motors(x)
    unit, scale = ("deg", float(np.degrees(1.0))) if robot.rotary else ("m", 1.0)
    head = (say("cli.parallel_motor"), *(f"{k + 1} [{unit}]" for k in range(motors.shape[1])))
    misfit = robot.misfit(x)
    off = np.zeros(len(motors)) if misfit is None else misfit
    shown = np.where(off[:, None] == 0.0, scale * motors, np.nan)
    lines = table(head, [(str(k + 1), *map(_cell, row)) for k, row in enumerate(shown)])
    data: dict[str, Any] = {"pose": x, "motors": motors}
    missed = [str(k + 1) for k in np.flatnonzero(off).tolist()]
    if missed:
        data["misfit"] = off
        lines += [_missed(k + 1, value) for k, value in enumerate(off.tolist()) if value]
        return Answer(data, tuple(lines), say("cli.parallel_out_of_reach", motors=", ".join(missed)))
    found = robot.singularity(x)
    if found is not None:
        data["singularity"] = found.to_dict()
        lines.append(found.explain())
    if found is None or found:
        near = robot.nearest(x)
        if near is not None:
            data["nearest_singularity"] = near.to_dict()
            lines.append(near.explain())
        refusal = None if F is None else _efforts(robot, x, F, data, lines)
    else:
        refusal = None if F is None else found.explain()
    _picture(robot, x, picture, data, lines)
    return Answer(data, tuple(lines), refusal)


def _efforts(robot: ParallelCommand, x: Floats, F: Floats, data: dict[str, Any], lines: list[str]) -> str | None:
    """Add the efforts; why the load cannot be carried, or None."""
    held, efforts = robot.efforts(x, F)
    data["efforts"] = efforts
    unit = "N m" if robot.rotary else "N"
    lines += table((say("cli.parallel_motor"), unit), [(str(k + 1), _cell(each)) for k, each in enumerate(efforts)])
    if held is None:
        return None
    data["held"] = held.to_dict()
    lines.append(held.explain())
    return None if held else held.explain()


def _for_motors(robot: ParallelCommand, motors: Floats, ways: bool, picture: str | None) -> Answer:
    found, poses = robot.poses(motors)
    data: dict[str, Any] = {"motors": motors, "poses": poses}
    lines: list[str] = []
    if found is not None:
        data["found"] = found.to_dict()
        lines.append(found.explain())
    if not len(poses):
        return Answer(data, tuple(lines), say("cli.parallel_no_pose"))
    turned = [name in ANGLES for name in robot.pose]
    units = [f"{name} [{'deg' if angle else 'm'}]" for name, angle in zip(robot.pose, turned, strict=True)]
    shown = np.where(turned, np.degrees(poses), poses)
    rows = [(str(k + 1), *map(_cell, row)) for k, row in enumerate(shown)]
    lines += table((say("mobility.mode_head"), *units), rows)
    if ways:
        _ways(robot, poses, data, lines)
    _picture(robot, poses[0], picture, data, lines)
    return Answer(data, tuple(lines))


def _ways(robot: ParallelCommand, poses: Floats, data: dict[str, Any], lines: list[str]) -> None:
    """Add which pairs of poses are joined."""
    every: list[dict[str, Any]] = []
    for (i, x), (j, y) in combinations(enumerate(poses, start=1), 2):
        way = robot.way(x, y)
        if way is None:
            raise InputError("cli.parallel_no_ways")
        every.append({"from": i, "to": j, **way.to_dict()})
        lines.append(f"{i} - {j}: {way.explain()}")
    data["ways"] = every


def _missed(motor: int, misfit: float) -> str:
    return say(f"parallel.rod_{'short' if misfit > 0.0 else 'long'}", motor=motor, length=abs(misfit))


def _cell(value: float) -> str:
    return number(float(value)) if np.isfinite(value) else "-"


def _picture(robot: ParallelCommand, x: Floats, picture: str | None, data: dict[str, Any], lines: list[str]) -> None:
    """Draw into a file, if one is asked for, and say so."""
    if picture is not None:
        lines.append(draw_picture(lambda path: robot.draw(x, str(picture_file(path))), picture, data))
