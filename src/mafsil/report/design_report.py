"""A design as a page: the arm going through its tasks, its measures with their sources, its sheet joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.design import Accuracy, ArmDesign, Evaluation, TaskSet, Tolerances
from mafsil.design.accuracy import for_frames
from mafsil.design.tasks import cycle_motion
from mafsil.errors import InputError
from mafsil.messages import LANGUAGES, say
from mafsil.messages import language as current_language
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.report.content import Details, Figure, Finding, Page, Plot, Scene, Table
from mafsil.report.page import render
from mafsil.scene import Drawing, compact
from mafsil.whole_file import write_whole

SECONDS = 6.0
"""That the replay takes where the tasks have no cycle time."""
UNITS = {
    "condition": "", "utilisation": "", "static_torque": "N m | N", "peak_torque": "N m | N", "rms_torque": "N m | N",
    "speed": "rad/s | m/s", "energy": "J", "mass": "kg", "deflection": "m", "frequency": "Hz", "payload": "kg",
}  # fmt: skip


def write_design(
    judged: Evaluation,
    tasks: TaskSet,
    path: str | PathLike[str],
    *,
    tolerances: Tolerances | None = None,
    errors: Sequence[Accuracy] = (),
) -> Path:
    """Write a page that needs no other file, in Arabic and English: what a design is, does and how that is known.

    Args:
        judged: how it does its tasks, all poses reached.
        tasks: of it.
        path: of the page.
        tolerances: for its sheet.
        errors: of the tool at the poses of the tasks.

    Raises:
        FileError: the place cannot be written.
        InputError: a design that is no arm.
    """
    design, first = judged.design, current_language()
    if not isinstance(design, ArmDesign):
        raise InputError("design.no_chain", robot=type(design.robot).__name__)
    q, qd, qdd = (
        part.reshape(-1, part.shape[-1]) for part in cycle_motion(np.asarray(judged.q), tasks.period or SECONDS)
    )
    scene = _scene(judged, q, tasks)
    torque = _torque(judged, tasks, q, qd, qdd)
    pages = [
        _page(design, judged, tasks, code, scene, (q, qd, torque), tolerances, errors)
        for code in (first, *(other for other in LANGUAGES if other != first))
    ]
    file = Path(path)
    write_whole(file, render(*pages).encode())
    return file


def _torque(judged: Evaluation, tasks: TaskSet, q: JointVector, qd: JointVector, qdd: JointVector) -> JointVector:
    """(T, n) efforts with the payload; at rest without a cycle time, NaN of an arm without masses."""
    if not np.isfinite(judged.torque).all() or not judged.torque.any():
        return np.full_like(q, np.nan)
    moves = float(tasks.period is not None)
    return np.asarray(tasks.loaded(judged.design.robot).inverse_dynamics(q, moves * qd, moves * qdd))


def _scene(judged: Evaluation, q: JointVector, tasks: TaskSet) -> Scene:
    robot = judged.design.robot
    poses, tips = np.asarray(robot.link_poses(q)), np.asarray(robot.forward_kinematics(q))
    drawing = Drawing(robot.mechanism)
    centre, size, floor = drawing.extent(poses[:, :, :3, 3].reshape(-1, 3), poses[0])
    times = np.linspace(0.0, tasks.period or SECONDS, len(q))
    targets = tuple((str(k), row) for k, row in enumerate(compact(tasks.poses)))
    return Scene(
        bodies=drawing.bodies(floor, poses[0]), period=float(times[1]), times=times, q=q, tips=compact(tips),
        references=compact(tips), targets=targets, carried=(), fixed=(), centre=centre, size=size, floor=floor,
    )  # fmt: skip


def _page(
    design: ArmDesign,
    judged: Evaluation,
    tasks: TaskSet,
    code: str,
    scene: Scene,
    motion: tuple[Floats, Floats, Floats],
    tolerances: Tolerances | None,
    errors: Sequence[Accuracy],
) -> Page:
    robot, sentences = design.robot, judged.explain(code).split("\n")

    def words(key: str, **details: object) -> str:
        return say(f"design.{key}", language=code, **details)

    findings = [Finding("good" if judged else "failure", sentences[0])]
    if errors:
        worst = max(errors, key=lambda error: error.rms)
        findings += [Finding("good" if worst else "warning", line) for line in worst.explain(code).split("\n")]
    plots = [
        Plot(column, words(f"plot_{column}"), unit, values)
        for (column, unit), values in zip(
            (("q", "rad | m"), ("qd", "rad/s | m/s"), ("tau", "N m | N")), motion, strict=True
        )
        if np.isfinite(values).all()
    ]
    source = (words("sources"), tuple((words(f"name_{name}"), words(f"source_{name}")) for name in UNITS))
    chosen = (words("values"), tuple((name, f"{value:.6g}") for name, value in design.values.items()))
    return Page(
        language=code, title=words("title", robot=robot.name), subtitle=words("subtitle", poses=len(judged.q)),
        verdict=findings[0], duration=float(scene.times[-1]), robot=robot,
        recipe=("from mafsil.design import ParametricArm, TaskSet, evaluate",), scene=scene, times=scene.times,
        joints=robot.joint_names, plots=tuple(plots), figures=_figures(judged, code), findings=tuple(findings),
        steps=(), joint_table=_sheet(design, judged, code, tolerances), limit_table=Table((), ()),
        details=(Details(*chosen), Details(*source)),
    )  # fmt: skip


def _figures(judged: Evaluation, code: str) -> tuple[Figure, ...]:
    """Each measure that has a value, with where it comes from."""
    cards: list[Figure] = []
    for name, value in judged.measures.items():
        if name in UNITS and np.isfinite(value):
            level = "warning" if name == "utilisation" and value > 1.0 else "good"
            label, note = (say(f"design.{kind}_{name}", language=code) for kind in ("name", "source"))
            cards.append(Figure(label, f"{value:.4g}", UNITS[name], note, level))
    return tuple(cards)


def _sheet(design: ArmDesign, judged: Evaluation, code: str, tolerances: Tolerances | None) -> Table:
    """The drawing in numbers: rows of the Denavit-Hartenberg table with tolerances, and what each joint is made of."""
    robot = design.robot
    rows = dh_from_mechanism(robot).rows
    length, angle = (for_frames(name, getattr(tolerances, name, 0.0), len(rows)) for name in ("length", "angle"))
    zero = np.broadcast_to(getattr(tolerances, "zero", 0.0), len(rows))
    named = ("joint", "a", "d", "alpha", "theta", "tube", "drive", "peak", "rms", "limit")
    cells: list[tuple[str, ...]] = []
    for k, (row, tube, drive) in enumerate(zip(rows, design.tubes, design.drives, strict=True)):
        carried = "-" if drive is None else f"{drive.mass:.4g} kg"
        numbers = (judged.peak[k], judged.rms[k], robot.limits.effort[k])
        cells.append((
            robot.joint_names[k], _toleranced(1e3 * row.a, 1e3 * length[k], "mm"),
            _toleranced(1e3 * row.d, 1e3 * length[k], "mm"), _toleranced(row.alpha, angle[k], "rad"),
            _toleranced(row.theta, zero[k], "rad"), "-" if tube is None else tube.section, carried,
            *(f"{value:.4g}" if np.isfinite(value) else "-" for value in numbers),
        ))  # fmt: skip
    return Table(tuple(say(f"design.sheet_{name}", language=code) for name in named), tuple(cells))


def _toleranced(value: float, tolerance: float, unit: str) -> str:
    return f"{value:.6g} ± {tolerance:.3g} {unit}" if tolerance else f"{value:.6g} {unit}"
