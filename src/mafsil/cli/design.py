"""`mafsil design`: a parametric arm or platform in a file: its robot, its tasks, its accuracy, its drives, a search."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, cast

from mafsil.cli.answer import PLAIN, Answer, draw_picture, require_kind
from mafsil.cli.state import count, number
from mafsil.design import (
    ArmDesign,
    Catalogue,
    Evaluation,
    ParametricArm,
    ParametricPlatform,
    PlatformDesign,
    TaskSet,
    Tolerances,
    accuracy,
    allocate,
    evaluate,
    fit_drives,
    optimise,
    payload_map,
    pick_drives,
    reach_map,
)
from mafsil.design.tasks import cycle_motion
from mafsil.errors import FileError, InputError
from mafsil.job import task_set
from mafsil.messages import say
from mafsil.model.saving import save
from mafsil.robot import Robot
from mafsil.simulation.many_runs import cluster_executor
from mafsil.toml_source import read_toml

Family: TypeAlias = ParametricArm | ParametricPlatform
Reply: TypeAlias = tuple[dict[str, Any], list[str], bool, Robot | None]
"""Data, lines, whether the answer is yes, and the robot that `--out` writes; none of platforms."""
TABLES = ("arm", "platform", "tasks", "tolerances", "costs", "search", "payload", "reach")
TOLERANCES = tuple(Tolerances.__dataclass_fields__)
PAGES = ("payload", "reach", "report")
"""Questions whose `--out` is no robot, but a picture or a page."""
OF_PLATFORMS = ("tasks", "search")
"""Questions that are answered for platforms too."""
SLICE = ("plane", "at", "cell", "rpy")
SAMPLES = 10_000
"""Arms with drawn errors that the first order is held against."""


@dataclass(frozen=True, eq=False)
class _File:
    """A file of a design.

    Attributes:
        path: of it.
        tables: that it holds.
        any_design: the arm or platform with the chosen values.
        seed: of whatever is random.
        catalogue: file of drives, or None.
        out: file for what is written, or None.
    """

    path: str
    tables: Mapping[str, Any]
    any_design: ArmDesign | PlatformDesign
    seed: int
    catalogue: str | None
    out: str | None

    def table(self, name: str) -> dict[str, Any]:
        """One that is needed.

        Raises:
            FileError: it is missing.
        """
        if not isinstance(self.tables.get(name), dict):
            raise FileError("design.no_part", path=self.path, name=name)
        return dict(cast("dict[str, Any]", self.tables[name]))

    @property
    def design(self) -> ArmDesign:
        """The arm with the chosen values.

        Raises:
            InputError: it is a platform, of which only `tasks` and `search` are answered.
        """
        if isinstance(self.any_design, ArmDesign):
            return self.any_design
        raise InputError("cli.design_arms_only")

    @property
    def robot(self) -> Robot | None:
        """What `--out` writes; none of a platform."""
        return self.any_design.robot if isinstance(self.any_design, ArmDesign) else None

    @cached_property
    def tasks(self) -> TaskSet:
        """What it shall do: the entries of `[tasks]`, or what the job file does that `job` names there."""
        table = self.table("tasks")
        if set(table) != {"job"}:
            return TaskSet.of(table, self.path)
        return task_set(Path(self.path).parent / str(table["job"]))

    def evaluation(self) -> Evaluation:
        """How the design does its tasks."""
        return evaluate(self.any_design, self.tasks, seed=self.seed)

    def reached_evaluation(self) -> Evaluation:
        """The same, with every pose reached.

        Raises:
            InputError: a pose is missed: what is asked for has no meaning there.
        """
        judged = self.evaluation()
        if not judged.reached.all():
            raise InputError("design.needs_all_poses", sentence=judged.explain().split("\n")[0])
        return judged


def design(
    what: str, file: str, values: list[str] | None, catalogue: str | None, seed: str | None, out: str | None
) -> Answer:
    """One of the questions about a parametric arm.

    Args:
        what: `tasks`, `report`, `payload`, `reach`, `accuracy`, `allocate`, `drives`, `search` or `robot`.
        file: TOML with `[arm]` or `[platform]`, and a table for what is asked: one of `TABLES`.
        values: NAME=VALUE of parameters.
        catalogue: CSV or TOML file of drives.
        seed: of the random numbers, as typed.
        out: file for the robot in any format; of `payload` and `reach` a picture, of `report` the page.

    Raises:
        MafsilError: no such file, a missing table, numbers out of range.
    """
    tables = read_toml(file)
    if "arm" not in tables and "joint" in tables:
        tables = {"arm": tables}
    for name in tables:
        if name not in TABLES:
            raise FileError("design.unknown_key", path=file, place=name, known=", ".join(TABLES))
    part, family = ("platform", ParametricPlatform) if "platform" in tables else ("arm", ParametricArm)
    if not isinstance(tables.get(part), dict):
        raise FileError("design.no_part", path=file, name=part)
    arm: Family = family.of(tables[part])
    chosen = dict(_value(word) for word in values or [])
    if what in ("payload", "reach") and out is not None:
        require_kind(out, PLAIN)
    given = _File(file, tables, arm.at(**chosen), 0 if seed is None else count("--seed", seed), catalogue, out)
    if what not in OF_PLATFORMS and given.robot is None:
        raise InputError("cli.design_arms_only")
    data, lines, answer, robot = QUESTIONS[what](given, arm)
    if out is not None and what not in PAGES:
        if robot is None:
            raise InputError("cli.design_arms_only")
        save(robot.mechanism, Path(out))
        data["out"] = out
        lines.append(say("cli.design_written", path=out))
    refusal = None if answer else lines.pop(0)
    return Answer({"design": dict(given.any_design.values), **data}, tuple(lines), refusal)


def _value(word: str) -> tuple[str, float]:
    name, sign, value = word.partition("=")
    if not sign:
        raise InputError("cli.design_value", value=word)
    return name.strip(), number(name.strip(), value)


def _shown(answer: Any, robot: Robot | None) -> Reply:
    return answer.to_dict(), answer.explain().split("\n"), bool(answer), robot


def _tasks(given: _File, arm: Family) -> Reply:
    return _shown(given.evaluation(), given.robot)


def _accuracy(given: _File, arm: Family) -> Reply:
    """At every pose of the tasks; the worst in words."""
    judged, tolerances = given.reached_evaluation(), Tolerances(**_known(given, "tolerances"))
    payload = given.tasks.payload
    found = [accuracy(given.design, q, tolerances, payload=payload, samples=SAMPLES, seed=given.seed) for q in judged.q]
    worst = max(range(len(found)), key=lambda k: found[k].rms)
    lines = found[worst].explain().split("\n")
    data = {"poses": [one.to_dict() for one in found], "worst": worst}
    return data, [say("cli.design_worst_pose", number=worst), *lines], all(found), given.design.robot


def _allocate(given: _File, arm: Family) -> Reply:
    costs = given.table("costs")
    wanted = costs.pop("wanted", None)
    if wanted is None:
        raise FileError("design.missing_key", path=given.path, place="costs", name="wanted")
    fixed = Tolerances(**(_known(given, "tolerances") if "tolerances" in given.tables else {}))
    return _shown(allocate(given.design, given.reached_evaluation().q, wanted, costs, fixed=fixed), given.design.robot)


def _drives(given: _File, arm: Family) -> Reply:
    tasks = given.tasks
    if given.catalogue is None or tasks.period is None:
        raise InputError("cli.design_drives_need")
    motion = (
        part.reshape(-1, given.design.robot.n) for part in cycle_motion(given.reached_evaluation().q, tasks.period)
    )
    q, qd, qdd = motion
    catalogue = Catalogue.of(given.catalogue)
    choice = pick_drives(given.design, catalogue, q, qd, qdd, payload=tasks.payload, centre=tasks.centre)
    robot = given.design.robot
    if choice and isinstance(arm, ParametricArm):
        robot = fit_drives(arm, choice).robot(**given.design.values)
    return _shown(choice, robot)


def _search(given: _File, arm: Family) -> Reply:
    known = ("goals", "limits", "points", "population", "generations", "starts", "resume", "cluster")
    entries = _known(given, "search", known)
    goals, cluster = entries.pop("goals", []), entries.pop("cluster", None)
    if "resume" in entries:
        entries["resume"] = Path(given.path).parent / str(entries["resume"])
    with cluster_executor(None if cluster is None else str(cluster)) as executor:
        limits = entries.pop("limits", None)
        front = optimise(arm, given.tasks, goals, limits, seed=given.seed, executor=executor, **entries)
    return _shown(front, front.points[0].design.robot if front and given.robot is not None else given.robot)


def _robot(given: _File, arm: Family) -> Reply:
    robot = given.design.robot
    parts = [
        say(
            "cli.design_part",
            joint=joint.name,
            tube="-" if tube is None else tube.section,
            drive="-" if drive is None else f"{drive.mass:.4g}",
        )
        for joint, tube, drive in zip(robot.mechanism.joints, given.design.tubes, given.design.drives, strict=True)
    ]
    return {"mass": given.design.mass, "joints": robot.n}, [*str(robot).split("\n"), *parts], True, robot


def _payload(given: _File, arm: Family) -> Reply:
    """What it holds over the slice of `[payload]`, and a picture of it."""
    held = payload_map(given.design, **_known(given, "payload", (*SLICE, "centre")))
    return _drawn(given, held, "plot_payload_map")


def _reach(given: _File, arm: Family) -> Reply:
    """Where the tool gets in the slice of `[reach]`, its voids, and a picture of it."""
    return _drawn(given, reach_map(given.design, **_known(given, "reach", SLICE)), "plot_reach_map")


def _drawn(given: _File, values: Any, plot: str) -> Reply:
    reply = _shown(values, given.design.robot)
    if given.out is not None:
        import mafsil.figures as figures

        reply[1].append(draw_picture(lambda path: getattr(figures, plot)(values, path), given.out, reply[0]))
    return reply


def _report(given: _File, arm: Family) -> Reply:
    """The tasks, and a page of them; with `[tolerances]` also the accuracy at every pose."""
    if given.out is None:
        raise InputError("cli.design_report_needs")
    from mafsil.report.design_report import write_design

    judged, payload = given.reached_evaluation(), given.tasks.payload
    tolerances = Tolerances(**_known(given, "tolerances")) if "tolerances" in given.tables else None
    errors = [] if tolerances is None else [accuracy(given.design, q, tolerances, payload=payload) for q in judged.q]
    write_design(judged, given.tasks, given.out, tolerances=tolerances, errors=errors)
    data, lines, answer, robot = _shown(judged, given.design.robot)
    return data | {"page": given.out}, [*lines, say("cli.page_written", path=given.out)], answer, robot


def _known(given: _File, name: str, known: tuple[str, ...] = TOLERANCES) -> dict[str, Any]:
    entries = given.table(name)
    for key in entries:
        if key not in known:
            raise FileError("design.unknown_key", path=given.path, place=f"{name}.{key}", known=", ".join(known))
    return entries


QUESTIONS: dict[str, Callable[[_File, Family], Reply]] = {
    "robot": _robot, "tasks": _tasks, "accuracy": _accuracy, "allocate": _allocate, "drives": _drives,
    "search": _search, "payload": _payload,
    "reach": _reach, "report": _report,
}  # fmt: skip
