"""A linkage driven once round as a page: the replay of its motion, and its curves over time."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.messages import LANGUAGES
from mafsil.messages import language as current_language
from mafsil.mobility.linkages import CrankTurn
from mafsil.mobility.linkages.mechanism_linkage import mechanism_of, theta_of_tree
from mafsil.report.content import Finding, Page, Plot, Scene, Table
from mafsil.report.page import render
from mafsil.robot import Robot
from mafsil.scene import Drawing, compact
from mafsil.whole_file import write_whole

FRAMES = 240
"""Of the replay, at most."""
SECONDS = 6.0
"""That the replay takes, whatever the speed of the crank."""


def write_crank_turn(turn: CrankTurn, path: str | PathLike[str]) -> Path:
    """Write a page that needs no other file: the linkage moves, curves of joints, motor and forces run along.

    Args:
        turn: as `turn_crank` gives it.
        path: of the page.

    Raises:
        FileError: the place cannot be written.
    """
    first = current_language()
    robot = Robot(mechanism_of(replace(turn.linkage, couplings=())))
    scene = _scene(turn, robot)
    pages = [_page(turn, robot, scene, code) for code in (first, *(each for each in LANGUAGES if each != first))]
    file = Path(path)
    write_whole(file, render(*pages).encode())
    return file


def _scene(turn: CrankTurn, robot: Robot) -> Scene:
    rows = np.unique(np.linspace(0, len(turn.time) - 1, FRAMES).astype(np.intp))
    q = theta_of_tree(replace(turn.linkage, couplings=()), turn.theta[rows])
    poses = np.asarray(robot.link_poses(q))
    tips = np.asarray(robot.forward_kinematics(q))
    drawing = Drawing(robot.mechanism)
    centre, size, floor = drawing.extent(poses[:, :, :3, 3].reshape(-1, 3), poses[0])
    times = np.linspace(0.0, SECONDS, len(rows))
    return Scene(
        bodies=drawing.bodies(floor, poses[0]), period=SECONDS / max(len(rows) - 1, 1), times=times, q=q,
        tips=compact(tips), references=compact(tips), targets=(), carried=(), fixed=(), centre=centre, size=size,
        floor=floor,
    )  # fmt: skip


def _page(turn: CrankTurn, robot: Robot, scene: Scene, code: str) -> Page:
    heads, rows = turn.columns(code)
    sentences = turn.explain(code).split("\n")
    head = tuple(heads)
    shown = rows[:: max(1, len(rows) // 24)]
    plots = [Plot(f"c{k}", name, "", rows[:, k : k + 1], None, (name,), (name,)) for k, name in enumerate(heads) if k]
    return Page(
        language=code, title=turn.linkage.name or turn.crank, subtitle=sentences[0],
        verdict=Finding("good" if turn else "warning", sentences[0]), duration=SECONDS, robot=robot,
        recipe=("from mafsil.mobility.linkages import turn_crank",), scene=scene,
        times=np.linspace(0.0, SECONDS, len(rows)), joints=robot.joint_names, plots=tuple(plots), figures=(),
        findings=tuple(Finding("good", each) for each in sentences), steps=(),
        joint_table=Table(head, tuple(tuple(f"{x:.5g}" for x in row) for row in shown.tolist())),
        limit_table=Table((), ()),
    )  # fmt: skip
