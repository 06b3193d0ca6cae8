"""The log of a controller laid over the plan of its job: offset, units and signs, arrivals, and why efforts differ.

1. Offset: the plan's and the log's speeds, whatever their signs and units, are correlated; then the residual is least.
2. Units and signs: slope of each joint's log over the plan.
3. Arrivals: where the arm was at the end of each move, by the tolerances of the job.
4. Efforts: the model with friction and a payload is fitted to what differs; a cause is named only if the fit without it
   leaves at least twice as much.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, frozen
from mafsil.csv_table import CsvTable, read_csv_table
from mafsil.errors import InputError
from mafsil.job.arrival import errors_of, goal_of
from mafsil.job.description import Job
from mafsil.job.plan import Plan
from mafsil.job.plan_simulation import loaded_robot
from mafsil.job.remark import Remark
from mafsil.job.tolerance import tolerances
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.simulation.joint_states import JointStates, joint_states

FACTORS = {1.0: "", 180.0 / np.pi: "degrees", 1000.0: "millimetres"}
"""Units of coordinates in logs, over ours."""
GRID, REFINEMENTS = 400, 6
"""Offsets that are tried over the length of the plan, and how often ten times as finely about the best."""
EXPLAINED = 0.5
"""Share of a residual that may be left once its cause is fitted."""
NOTABLE = 0.02
"""Share of the efforts that a difference must exceed to be explained."""
SAMPLES, STEP = 2000, 1e-4
"""Rows of efforts that are looked at, and the step of differences of the plan [s]."""
SMOOTH = 0.01
"""Speed below which dry friction is not fitted as a step [rad/s | m/s]."""


class LogStatus(Status):
    """Whether a log shows the job as it was planned."""

    AS_PLANNED = ("job.log_as_planned", True)
    DIFFERS = ("job.log_differs", False)


@dataclass(frozen=True, slots=True, repr=False)
class LogComparison(Answer, data="offset factors errors"):
    """True if every target of the job was reached within its tolerance by the log.

    Attributes:
        status: whether it was.
        offset: time in the log at which the plan begins [s].
        factors: (n,) of each joint's log over the plan: its unit, negative if the sign is reversed.
        errors: (n,) largest distance from the plan, in our units and signs [rad | m].
        remarks: what differs, and why as far as that is proved.
    """

    status: LogStatus
    offset: float
    factors: Floats
    errors: Floats
    remarks: tuple[Remark, ...]

    def explain(self, language: str | None = None) -> str:
        """The verdict, the offset, and each remark on its line."""
        head = self.status.sentence(language, offset=quantity(self.offset, "s"))
        return "\n".join([head, *(one.sentence(language) for one in self.remarks)])

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, the remarks in both languages."""
        said = [{"code": one.key, "en": one.sentence("en"), "ar": one.sentence("ar")} for one in self.remarks]
        return Answer.to_dict(self) | {"remarks": said}


def compare_with_log(job: Job, robot: Robot, plan: Plan, path: str | PathLike[str]) -> LogComparison:
    """What a controller's log says of a job that it drove.

    Args:
        job, robot, plan: of an arm without loops, as `prepare` gives them.
        path: ROS 2 bag in MCAP (`.mcap`) with `sensor_msgs/msg/JointState`, or CSV file with times `t`, `time` or
            `timestamp`, and per joint `q[NAME]`, `q1` or `actual_q_0`; if recorded efforts `tau[NAME]`, `tau1` or
            `actual_torque_0`.

    Raises:
        FileError: no such file, missing columns, times that do not increase.
        InputError: the log is shorter than half of the plan, or the plan stands still.
    """
    t, q, efforts = _read_log(Path(path), robot)
    # 1
    planned = np.linspace(0.0, plan.duration, GRID)
    u = positions(plan, planned)
    if t[-1] - t[0] < 0.5 * plan.duration or np.ptp(u, axis=0).max() == 0.0:
        raise InputError("job.log_short", duration=quantity(float(t[-1] - t[0]), "s"))
    offset = _offset(planned, u, t, q)
    here = _interpolate(offset + planned, t, q)
    # 2
    factors = np.array([_factor(ours, theirs) for ours, theirs in zip(u.T, here.T, strict=True)])
    q = q / factors
    errors = np.abs(here / factors - u).max(axis=0)
    remarks = list(_units(robot, factors))
    # 3
    missed = list(_missed_targets(job, plan, t - offset, q))
    # 4
    if efforts is not None and not plan.kinematic and not robot.mechanism.loops:
        remarks += _causes(plan, t - offset, efforts)
    status = LogStatus.DIFFERS if missed else LogStatus.AS_PLANNED
    return LogComparison(status, offset, frozen(factors), frozen(errors), (*missed, *remarks))


def _read_log(path: Path, robot: Robot) -> JointStates:
    """Times, positions and efforts of a log."""
    if path.suffix.lower() == ".mcap":
        return joint_states(path, robot.joint_names)
    table = read_csv_table(path)
    t = table.numbers([_column(table, "t", "time", "timestamp")])[:, 0]
    table.require_increasing(t)
    q = table.numbers(_columns(table, robot, "q", "actual_q") or [])
    efforts = _columns(table, robot, "tau", "actual_torque")
    return JointStates(t, q, None if efforts is None else table.numbers(efforts))


def positions(plan: Plan, t: Floats) -> Floats:
    """(k, n) where the plan is at times."""
    moments = zip(plan.legs_at(t), t.tolist(), strict=True)
    return np.stack([plan.legs[int(k)].trajectory.at(max(time - float(plan.starts[k]), 0.0)).u for k, time in moments])


def _column(table: CsvTable, *names: str) -> int:
    place = table.column(*names)
    if place is None:
        raise table.no_column(names[0])
    return place


def _columns(table: CsvTable, robot: Robot, ours: str, theirs: str) -> list[int] | None:
    """Columns of a signal for each joint: ours, or numbered from zero as RTDE names them."""
    numbered = [table.column(f"{theirs}_{k}") for k in range(robot.n)]
    found = [place for place in numbered if place is not None]
    return found if len(found) == robot.n else table.joint_columns(ours, robot.joint_names, required=ours == "q")


def _offset(planned: Floats, u: Floats, t: Floats, q: Floats) -> float:
    """Time in the log at which the plan begins [s]."""
    scale = np.maximum(np.ptp(u, axis=0), 1e-9)
    moving = np.ptp(u, axis=0) > 1e-3

    def residual(offset: float) -> float:
        here = _interpolate(offset + planned, t, q)
        left = 0.0
        for k in np.flatnonzero(moving):
            x, y = u[:, k] - u[:, k].mean(), here[:, k] - here[:, k].mean()
            left += float(y @ y - (x @ y) ** 2 / (x @ x)) / max(float(y @ y), (1e-6 * float(scale[k])) ** 2)
        return left

    span = float(planned[-1])
    low, high = float(t[0]) - 0.5 * span, float(t[-1]) - 0.5 * span
    tried = np.linspace(low, high, max(GRID, int((high - low) / span * GRID)))
    best, step = float(tried[np.argmin([residual(float(each)) for each in tried])]), float(tried[1] - tried[0])
    for _ in range(REFINEMENTS):
        tried = np.linspace(best - step, best + step, 21)
        best, step = float(tried[np.argmin([residual(float(each)) for each in tried])]), step / 10.0
    return best


def _interpolate(times: Floats, t: Floats, q: Floats) -> Floats:
    """(k, n) coordinates of a log at times."""
    found = np.empty((len(times), q.shape[1]))
    for k in range(q.shape[1]):
        found[:, k] = np.interp(times, t, q[:, k])
    return found


def _factor(ours: Floats, theirs: Floats) -> float:
    """Unit and sign of a joint's log: the factor that leaves least."""
    x, y = ours - ours.mean(), theirs - theirs.mean()
    if np.ptp(ours) < 1e-3:
        return 1.0
    slope = float(x @ y / (x @ x))
    return float(np.copysign(min(FACTORS, key=lambda one: abs(np.log(max(abs(slope), 1e-9) / one))), slope))


def _units(robot: Robot, factors: Floats) -> list[Remark]:
    remarks: list[Remark] = []
    for name, factor in zip(robot.joint_names, factors.tolist(), strict=True):
        if unit := FACTORS[abs(factor)]:
            remarks.append(Remark("warning", f"job.log_{unit}", {"joint": visible(name)}))
        if factor < 0.0:
            remarks.append(Remark("warning", "job.log_sign", {"joint": visible(name)}))
    return remarks


def _missed_targets(job: Job, plan: Plan, t: Floats, q: Floats) -> list[Remark]:
    """Targets that the log misses by more than their tolerance."""
    remarks: list[Remark] = []
    for leg, end in zip(plan.legs, plan.starts[1:].tolist(), strict=True):
        goal = goal_of(leg)
        if goal is None or not t[0] <= end <= t[-1]:
            continue
        here = _interpolate(np.array([end]), t, q)[0]
        allowed = tolerances(job, leg.load.robot, leg.index)
        position, turn, joints = errors_of(leg, here)
        share = max(float(position) / allowed.position, float(turn) / allowed.orientation)
        if goal == "joints":
            share = float((joints / allowed.joints).max())
        if not share <= 1.0:
            off = {"position": quantity(float(position), "m"), "angle": quantity(float(turn), "rad")}
            remarks.append(
                Remark("failure", "job.log_missed", {"move": visible(leg.name) or str(leg.index + 1), **off})
            )
    return remarks


def _causes(plan: Plan, t: Floats, tau: Floats) -> list[Remark]:
    """Why efforts differ from the model's: friction, a payload, or what neither proves."""
    inside = (t >= 0.0) & (t <= plan.duration)
    noise = float(np.sqrt((np.diff(tau[inside], n=2, axis=0) ** 2).mean() / 6.0))
    rows = np.unique(np.linspace(0, int(inside.sum()) - 1, SAMPLES).astype(np.intp))
    t, tau = t[inside][rows], tau[inside][rows]
    rates, model, payload = _model(plan, t)
    y = (tau - model).reshape(-1)
    power = float(np.sqrt((y**2).mean()))
    if power <= max(NOTABLE * float(np.sqrt((tau**2).mean())), 1.5 * noise):
        return []
    own = np.eye(tau.shape[1])
    friction = np.concatenate([rates[:, :, None] * own, np.tanh(rates / SMOOTH)[:, :, None] * own], axis=2)
    columns = {"friction": friction.reshape(len(y), -1), "payload": payload.reshape(-1, 1)}
    columns["both"] = np.hstack(list(columns.values()))
    shares, mass = dict[str, float](), 0.0
    for name, regressor in columns.items():
        fit = np.linalg.lstsq(regressor, y, rcond=None)[0]
        shares[name] = float(np.linalg.norm(y - regressor @ fit) / np.linalg.norm(y))
        mass = float(fit[-1])
    left = quantity(shares["both"], "share")
    if shares["both"] > EXPLAINED:
        return [Remark("warning", "job.log_unknown", {"left": left})]
    pairs = (("friction", "payload"), ("payload", "friction"))
    proved = [name for name, other in pairs if shares["both"] <= EXPLAINED * shares[other]]
    details = {"left": left, "mass": quantity(mass, "kg")}
    return [Remark("warning", f"job.log_{name}", details) for name in proved or ("unclear",)]


def _model(plan: Plan, t: Floats) -> tuple[Floats, Floats, Floats]:
    """Speeds of the plan, efforts of the model that carries what the plan says, those of one kilogram more; (k, n)."""
    before, now, after = (positions(plan, np.clip(t + shift, 0.0, plan.duration)) for shift in (-STEP, 0.0, STEP))
    qd, qdd = (after - before) / (2.0 * STEP), (after - 2.0 * now + before) / STEP**2
    model, payload = np.zeros_like(now), np.zeros_like(now)
    loads = [plan.legs[int(k)].load for k in plan.legs_at(t)]
    for load in dict.fromkeys(loads):
        rows = np.array([one == load for one in loads])
        robot, state = loaded_robot(load), (now[rows], qd[rows], qdd[rows])
        model[rows] = robot.inverse_dynamics(*state)
        payload[rows] = robot.with_payload(1.0).inverse_dynamics(*state) - model[rows]
    return qd, model, payload
