"""Calibration of platforms on rods from poses, points, probe heights or distances: Deltas, hexapods, five-bars and all.

Of a leg may be off: the zero of its motor, the length of its rod and crank, place and lean of its motor, the end on the
platform. By the rod, with V = (omega, p') and u along it,

    A V = u . dC + dl - u . dB,

which gives the change of the pose by each parameter without differences.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.identification.geometric_calibration import ANGLE, LENGTH, GeometricCalibration, Measured, fit_geometry
from mafsil.parallel.legs.rod_library import OnRods, as_rod_robot
from mafsil.parallel.legs.rod_robot import LegDrive, RodRobot

GROUPS = ("zeros", "rods", "arms", "bases", "ends", "leans")
"""Kinds of parameters; `leans` turn a motor about both axes across its own."""
USUAL = ("zeros", "rods", "arms", "bases", "ends")
AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class _Parameter:
    """One number of one leg.

    Attributes:
        name: such as `rod 2` or `base 1 x`.
        leg: index.
        group: which kind.
        direction: (3,) of a displacement, or of an axis of rotation.
    """

    name: str
    leg: int
    group: str
    direction: Floats


def calibrate_rods(
    robot: OnRods, q: ArrayLike, measured: Measured, *, near: ArrayLike | None = None,
    parameters: Sequence[str] = USUAL, held_out: float = 0.2, angle_tolerance: float = 2e-2,
    length_tolerance: float = 1e-2,
) -> GeometricCalibration:  # fmt: skip
    """Calibrate a parallel robot whose legs are rods; `corrected` is a RodRobot.

    Args:
        robot: as described: a RodRobot, StewartPlatform, DeltaRobot, FiveBar, PlanarThreeRPR or PlanarThreeRRR.
        q: (k, m) coordinates of the motors at which was measured [rad | m].
        measured: what was measured of the platform.
        near: poses or short coordinates near those of the rows, such as the commanded ones; measured poses if None, of
            points, heights and distances a first pose of the description.
        parameters: kinds that may be off, of `GROUPS`.
        held_out: share of the rows that are predicted, not fitted.
        angle_tolerance, length_tolerance: how far they may be off as described [rad, m].

    Raises:
        InputError: numbers that do not fit, or motors at which the described robot has no pose.
    """
    nominal = as_rod_robot(robot)
    value = as_batch("q", q, (nominal.m,), finite=True)
    if value.shape != (measured.rows, nominal.m):
        raise InputError("input.shape", name="q", expected=(measured.rows, nominal.m), got=value.shape, hint="")
    for each in parameters:
        if each not in GROUPS:
            raise InputError("input.choice", name="parameters", value=each, known=", ".join(GROUPS))
    start = _start(nominal, value, measured, near)
    every = _parameters(nominal, parameters)
    angle, length = ANGLE("angle_tolerance", angle_tolerance), LENGTH("length_tolerance", length_tolerance)
    turns = nominal.drive is LegDrive.CRANK
    scale = np.array([
        angle if each.group == "leans" or (each.group == "zeros" and turns) else length for each in every
    ])  # fmt: skip

    def predict(theta: Floats) -> tuple[Floats, Floats]:
        here = _correct(nominal, every, theta)
        T = here.forward_near(value, start).T[:, 0]
        if not np.isfinite(T).all():
            raise InputError("parallel.calibration_pose", row=int(np.argmin(np.isfinite(T[:, 0, 0]))))
        start[...] = T
        return T, _changes(here, T, value, every)

    def correct(theta: Floats) -> RodRobot:
        return _correct(nominal, every, theta)

    return fit_geometry(tuple(each.name for each in every), scale, predict, measured, correct, held_out)


def _start(robot: RodRobot, q: Floats, measured: Measured, near: ArrayLike | None) -> Floats:
    """(k, 4, 4) poses from which the first ones are looked for."""
    if near is not None:
        return np.broadcast_to(robot.poses(near), (len(q), 4, 4)).copy()
    if measured.poses is not None:
        # Without what only the noise turns: a Delta stays level.
        return np.array(robot.poses(robot.coordinates(np.asarray(measured.poses))))
    found = robot.forward_kinematics(q)
    if not found:
        raise InputError("parallel.calibration_pose", row=int(np.argmin(found.count)))
    return found.T[:, 0].copy()


def _parameters(robot: RodRobot, groups: Sequence[str]) -> list[_Parameter]:
    """Those that a robot has: lengths of cranks of cranks alone, places in a plane with two numbers."""
    flat = [AXES.index(axis) for axis in ("xy" if robot.is_flat else "xyz")]
    found: list[_Parameter] = []
    for leg in range(robot.m):
        title = str(leg + 1)
        axis = robot.axes[leg]
        if "zeros" in groups and robot.drive is LegDrive.CRANK:
            found.append(_Parameter(f"zero {title}", leg, "zeros", axis))
        if "rods" in groups:
            found.append(_Parameter(f"rod {title}", leg, "rods", axis))
        if "arms" in groups and robot.drive is LegDrive.CRANK:
            found.append(_Parameter(f"arm {title}", leg, "arms", axis))
        for name, group in (("base", "bases"), ("end", "ends")):
            if group in groups:
                found += [_Parameter(f"{name} {title} {AXES[k]}", leg, group, np.eye(3)[k]) for k in flat]
        if "leans" in groups and robot.drive is not LegDrive.EXTEND and not robot.is_flat:
            across = np.linalg.svd(axis[None])[2][1:]
            found += [_Parameter(f"lean {title} {k}", leg, "leans", w) for k, w in enumerate(across, start=1)]
    return found


def _correct(robot: RodRobot, every: Sequence[_Parameter], theta: Floats) -> RodRobot:
    """The robot with corrections (P,)."""
    rods, arms, base, fixed, rotating = (
        np.array(v) for v in (robot.rods, robot.arms, robot.base, robot.fixed, robot.rotating)
    )
    turns = np.zeros((robot.m, 3))
    ends = rotating if robot.motion.angles else fixed
    change: dict[str, Callable[[int, Floats, float], None]] = {
        "rods": lambda leg, _, v: _add(rods, leg, v), "arms": lambda leg, _, v: _add(arms, leg, v),
        "bases": lambda leg, d, v: _add(base, leg, d * v), "ends": lambda leg, d, v: _add(ends, leg, d * v),
        "zeros": lambda leg, d, v: _add(turns, leg, d * v), "leans": lambda leg, d, v: _add(turns, leg, d * v),
    }  # fmt: skip
    for each, value in zip(every, theta.tolist(), strict=True):
        change[each.group](each.leg, each.direction, value)
    R = rotation.exp(turns)
    axes, zeros = (np.einsum("mij,mj->mi", R, v) for v in (robot.axes, robot.zeros))
    return replace(robot, rods=rods, arms=arms, base=base, fixed=fixed, rotating=rotating, axes=axes, zeros=zeros)


def _add(array: Floats, leg: int, value: Floats | float) -> None:
    array[leg] += value


def _changes(robot: RodRobot, T: Floats, q: Floats, every: Sequence[_Parameter]) -> Floats:
    """(k, 6, P) changes (omega, p') of the pose by the parameters."""
    C = robot.carriers(q)
    d = robot.ends(T) - C
    u = d / np.linalg.norm(d, axis=-1, keepdims=True)
    arm = robot.rotating @ np.swapaxes(T[:, :3, :3], -1, -2)
    A = np.concatenate([np.cross(arm, u), u], axis=-1)[..., robot.motion.columns]
    G = np.zeros((len(q), robot.m, len(every)))
    for p, each in enumerate(every):
        along, w = u[:, each.leg], each.direction
        match each.group:
            case "rods":
                G[:, each.leg, p] = 1.0
            case "bases":
                G[:, each.leg, p] = along @ w
            case "ends":
                moved = T[:, :3, :3] @ w if robot.motion.angles else np.broadcast_to(w, along.shape)
                G[:, each.leg, p] = -(along * moved).sum(axis=1)
            case "arms":
                out = (C[:, each.leg] - robot.base[each.leg]) / robot.arms[each.leg]
                G[:, each.leg, p] = (along * out).sum(axis=1)
            case _:
                G[:, each.leg, p] = (along * np.cross(w, C[:, each.leg] - robot.base[each.leg])).sum(axis=1)
    D = np.zeros((len(q), 6, len(every)))
    D[:, robot.motion.columns] = np.linalg.solve(A, G)
    return D
