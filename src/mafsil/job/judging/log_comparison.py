"""The log of a controller laid over the plan of its job: offset, units and signs, arrivals, and why efforts differ.

1. Offset: the plan's and the log's speeds, whatever their signs and units, are correlated; then the residual is least.
2. Units and signs: slope of each joint's log over the plan; the plan begins where the joints that lag least have it.
3. Arrivals: where the arm was at the end of each move, by the tolerances of the job.
4. Tracking: each joint's error is fitted by a zero offset, a lag (its speed) and a compliance (its effort).
5. Efforts: the model with friction and a payload is fitted to what differs.

Of 4 and 5 a cause is named only if the fit without it leaves at least twice as much.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, frozen
from mafsil.csv_table import CsvTable, read_csv_table
from mafsil.errors import InputError
from mafsil.job.driving.arrival import errors_of, goal_of
from mafsil.job.driving.plan_simulation import loaded_robot
from mafsil.job.language.description import Job
from mafsil.job.language.units import tolerances
from mafsil.job.planning.plan import Plan
from mafsil.job.remark import Remark
from mafsil.job.tolerances import FLAT_SHARE, STILL_LOG
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.simulation.log_reading import JointStates, joint_states

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
OFF, LATE = 1e-4, 2e-3
"""Tracking errors that are looked at [rad | m], and a lag behind the other joints that is named [s]."""
SMOOTH = 0.01
"""Speed below which dry friction is not fitted as a step [rad/s | m/s]."""


class LogStatus(Status):
    """Whether a log shows the job as it was planned."""

    AS_PLANNED = ("job.log_as_planned", True)
    DIFFERS = ("job.log_differs", False)


@dataclass(frozen=True, slots=True, repr=False)
class LogComparison(Answer, data="offset factors errors lags zeros compliances payload"):
    """True if every target of the job was reached within its tolerance by the log.

    Attributes:
        status: whether it was.
        offset: time in the log at which the plan begins [s].
        factors: (n,) of each joint's log over the plan: its unit, negative if the sign is reversed.
        errors: (n,) largest distance from the plan, in our units and signs [rad | m].
        lags, zeros, compliances: (n,) of the joints, zero where none is proved [s, rad | m, rad/(N m) | m/N].
        payload: at the TCP, besides what the job has there; 0 where none is proved [kg].
        remarks: what differs, and why as far as that is proved.
    """

    status: LogStatus
    offset: float
    factors: Floats
    errors: Floats
    lags: Floats
    zeros: Floats
    compliances: Floats
    payload: float
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
    laid = None if robot.mechanism.loops else _laid_over(plan, t - offset, q, efforts, np.zeros(robot.n))
    if laid is not None and np.ptp(lags := _lags(laid)) >= LATE:
        offset += float(lags.min())
        laid = _laid_over(plan, t - offset, q, efforts, lags - lags.min())
    errors = np.abs(_interpolate(offset + planned, t, q) - u).max(axis=0)
    remarks = list(_units(robot, factors))
    # 3
    missed = list(missed_targets(job, plan, t - offset, q))
    tracking, payload = np.zeros((3, robot.n)), 0.0
    if laid is not None:
        # 4
        tracking = _tracking(laid)
        remarks += _tracking_remarks(robot, laid, tracking)
        # 5
        if laid.tau is not None and laid.model is not None:
            causes, payload = _causes(laid, laid.tau, *laid.model)
            remarks += causes
    status = LogStatus.DIFFERS if missed else LogStatus.AS_PLANNED
    said = (*missed, *remarks)
    lags, zeros, compliances = (frozen(row) for row in tracking)
    return LogComparison(status, offset, frozen(factors), frozen(errors), lags, zeros, compliances, payload, said)


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
    legs, q = plan.legs_at(t), np.empty((len(t), len(plan.start)))
    for k, leg in enumerate(plan.legs):
        rows = legs == k
        if rows.any():
            q[rows] = leg.trajectory.at(np.maximum(t[rows] - plan.starts[k], 0.0)).u
    return q


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
    scale = np.maximum(np.ptp(u, axis=0), STILL_LOG)
    moving = np.ptp(u, axis=0) > 1e-3

    def residual(offset: float) -> float:
        here = _interpolate(offset + planned, t, q)
        left = 0.0
        for k in np.flatnonzero(moving):
            x, y = u[:, k] - u[:, k].mean(), here[:, k] - here[:, k].mean()
            left += float(y @ y - (x @ y) ** 2 / (x @ x)) / max(float(y @ y), (FLAT_SHARE * float(scale[k])) ** 2)
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
    return float(np.copysign(min(FACTORS, key=lambda one: abs(np.log(max(abs(slope), STILL_LOG) / one))), slope))


def _units(robot: Robot, factors: Floats) -> list[Remark]:
    remarks: list[Remark] = []
    for name, factor in zip(robot.joint_names, factors.tolist(), strict=True):
        if unit := FACTORS[abs(factor)]:
            remarks.append(Remark("warning", f"job.log_{unit}", {"joint": visible(name)}))
        if factor < 0.0:
            remarks.append(Remark("warning", "job.log_sign", {"joint": visible(name)}))
    return remarks


def missed_targets(job: Job, plan: Plan, t: Floats, q: Floats) -> list[Remark]:
    """Targets that a log misses by more than their tolerance.

    Args:
        job, plan: that were driven.
        t: (k,) in the time of the plan [s].
        q: (k, n) coordinates then [rad | m].
    """
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


@dataclass(frozen=True, eq=False, slots=True)
class _Laid:
    """Rows of a log within the plan, and the plan at their times; (k, n).

    Attributes:
        off: the log's coordinates less the plan's.
        lag: what they would be for each joint a second late, as far as a first lag shows it.
        tau: efforts of the log; None if it has none.
        noise: (n,) of `off`, and of `tau` all together.
        rates: of the plan.
        model: efforts of the plan, and of one kilogram more; None of a robot without masses.
    """

    off: Floats
    lag: Floats
    tau: Floats | None
    noise: tuple[Floats, float]
    rates: Floats
    model: tuple[Floats, Floats] | None


def _laid_over(plan: Plan, t: Floats, q: Floats, efforts: Floats | None, lags: Floats) -> _Laid:
    """The log over the plan, its joints so much late at first guess (n,) [s]."""
    inside = np.flatnonzero((t >= 0.0) & (t <= plan.duration))
    rows = inside[np.unique(np.linspace(0, len(inside) - 1, SAMPLES).astype(np.intp))]
    at = {shift: positions(plan, np.clip(t[rows] + shift, 0.0, plan.duration)) for shift in (-STEP, 0.0, STEP)}
    now, rates = at[0.0], (at[STEP] - at[-STEP]) / (2.0 * STEP)
    lag = -rates
    for k in np.flatnonzero(lags):
        late = positions(plan, np.clip(t[rows] - lags[k], 0.0, plan.duration))
        lag[:, k] = (late[:, k] - now[:, k]) / lags[k]
    off = q[rows] - now
    noise = np.sqrt((np.diff(off, n=2, axis=0) ** 2).mean(axis=0) / 6.0)
    jitter = 0.0 if efforts is None else float(np.sqrt((np.diff(efforts[inside], n=2, axis=0) ** 2).mean() / 6.0))
    tau = None if efforts is None else efforts[rows]
    if plan.kinematic:
        return _Laid(off, lag, tau, (noise, jitter), rates, None)
    state = now, rates, (at[STEP] - 2.0 * now + at[-STEP]) / STEP**2
    return _Laid(off, lag, tau, (noise, jitter), rates, model_efforts(plan, t[rows], state))


def model_efforts(plan: Plan, t: Floats, state: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
    """Efforts of the model that carries what the plan says, and those of one kilogram more; (k, n).

    Args:
        plan: with its loads.
        t: (k,) times of it [s].
        state: (k, n) coordinates, rates and accelerations there.
    """
    model, payload = np.zeros_like(state[0]), np.zeros_like(state[0])
    loads = [plan.legs[int(k)].load for k in plan.legs_at(t)]
    for load in dict.fromkeys(loads):
        rows = np.array([one == load for one in loads])
        robot, here = loaded_robot(load), tuple(part[rows] for part in state)
        model[rows] = robot.inverse_dynamics(*here)
        payload[rows] = robot.with_payload(1.0).inverse_dynamics(*here) - model[rows]
    return model, payload


def _prove_causes(columns: dict[str, Floats], y: Floats) -> tuple[dict[str, Floats], float]:
    """What is fitted to each cause without which twice as much would be left, and the share that is left with all."""
    fits, left = dict[str, Floats](), dict[str, float]()
    for name in ("", *columns):
        parts = {other: column for other, column in columns.items() if other != name}
        matrix = np.hstack(list(parts.values())) if parts else np.zeros((len(y), 1))
        fit = np.asarray(np.linalg.lstsq(matrix, y, rcond=None)[0], dtype=np.float64)
        left[name] = float(np.linalg.norm(y - matrix @ fit) / np.linalg.norm(y))
        if not name:
            ends: list[int] = np.cumsum([column.shape[1] for column in parts.values()]).tolist()
            fits = {
                other: fit[end - column.shape[1] : end]
                for (other, column), end in zip(parts.items(), ends, strict=True)
            }
    return {name: fit for name, fit in fits.items() if left[""] <= EXPLAINED * left[name]}, left[""]


def _errors_of_joints(laid: _Laid) -> Iterator[tuple[dict[str, Floats], Floats]]:
    """Of each joint that the log has elsewhere: columns of zero, lag and compliance, and its error."""
    for k, off in enumerate(laid.off.T):
        columns = {"zero": np.ones((len(off), 1)), "lag": laid.lag[:, k : k + 1]}
        if laid.model is not None:
            columns["gain"] = -laid.model[0][:, k : k + 1]
        seen = float(np.sqrt((off**2).mean())) > max(OFF, 3.0 * float(laid.noise[0][k]))
        yield columns if seen else {}, off


def _lags(laid: _Laid) -> Floats:
    """(n,) how late each joint is [s]."""
    lags = np.zeros(laid.off.shape[1])
    for k, (columns, off) in enumerate(_errors_of_joints(laid)):
        if columns and np.ptp(columns["lag"]) > SMOOTH:
            lags[k] = np.linalg.lstsq(np.hstack(list(columns.values())), off, rcond=None)[0][1]
    return lags


def _tracking(laid: _Laid) -> Floats:
    """(3, n) how late joints are, their zero offsets, and how they yield to efforts, as far as that is proved."""
    found = np.zeros((3, laid.off.shape[1]))
    for k, (columns, off) in enumerate(_errors_of_joints(laid)):
        fit, left = _prove_causes(columns, off) if columns else ({}, 1.0)
        if left <= EXPLAINED:
            found[:, k] = [float(fit[cause][0]) if cause in fit else 0.0 for cause in ("lag", "zero", "gain")]
    return found


def _tracking_remarks(robot: Robot, laid: _Laid, tracking: Floats) -> list[Remark]:
    """Joints that the log has elsewhere than the plan: by a zero offset, later than others, or yielding to efforts."""
    remarks: list[Remark] = []
    for k, (lag, zero, softness) in enumerate(tracking.T.tolist()):
        name, angular = visible(robot.joint_names[k]), bool(robot.mechanism.angular[k])
        if abs(zero) >= OFF:
            value = quantity(zero, "rad" if angular else "m")
            remarks.append(Remark("warning", "job.log_zero", {"joint": name, "value": value}))
        if lag >= LATE:
            remarks.append(Remark("warning", "job.log_lag", {"joint": name, "lag": quantity(lag, "s")}))
        if laid.model is not None and softness * np.abs(laid.model[0][:, k]).max() >= OFF:
            gain = f"{1.0 / softness:.3g} {'N m/rad' if angular else 'N/m'}"
            remarks.append(Remark("warning", "job.log_gain", {"joint": name, "gain": gain}))
    return remarks


def _causes(laid: _Laid, tau: Floats, model: Floats, payload: Floats) -> tuple[list[Remark], float]:
    """Why efforts differ from the model's: friction, a payload, or what neither proves; the payload [kg]."""
    y, own = (tau - model).reshape(-1), np.eye(tau.shape[1])
    power, size = (float(np.sqrt((x**2).mean())) for x in (y, tau))
    if power <= max(NOTABLE * size, 1.5 * laid.noise[1]):
        return [], 0.0
    dry = np.tanh(laid.rates / SMOOTH)
    friction = np.concatenate([laid.rates[:, :, None] * own, dry[:, :, None] * own], axis=2).reshape(len(y), -1)
    fits, left = _prove_causes({"friction": friction, "payload": payload.reshape(-1, 1)}, y)
    if left > EXPLAINED:
        return [Remark("warning", "job.log_unknown", {"left": quantity(left, "share")})], 0.0
    mass = float(fits["payload"][0]) if "payload" in fits else 0.0
    details = {"left": quantity(left, "share"), "mass": quantity(mass, "kg")}
    return [Remark("warning", f"job.log_{name}", details) for name in fits or ("unclear",)], mass
