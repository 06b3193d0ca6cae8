"""What a controller has to do for a plan: tools, loads, motions, signals and rests, whatever its language."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mafsil.arrays import Floats
from mafsil.job.language.description import Job, Move, Pose
from mafsil.job.language.units import centre_of_mass
from mafsil.job.planning.equipment import Load
from mafsil.job.planning.plan import Leg, Plan
from mafsil.job.remark import Remark
from mafsil.messages.visible import visible
from mafsil.trajectory import Trajectory
from mafsil.trajectory.paths import arc_path

CHORD = 0.02
"""Of a path that languages do not have, points are so far apart at most [rad | m]."""
PATHS = ("line", "arc", "joint")
"""That all languages have."""
CORNER = 1e-3
"""Zone of the points of a sampled path, at which the arm need not stop [m]."""
NOT_CARRIED = ("outputs", "until", "until_force", "process_wrench")
"""Keys of moves for which controllers have no instruction, or each another one."""


@dataclass(frozen=True, eq=False, slots=True)
class Instruction:
    """One step of a program, in SI units.

    Attributes:
        kind: `tool`, `load`, `joints`, `line`, `arc`, `set`, `wait` or `pause`.
        values: of the tool and of a line a pose (4, 4); of an arc (2, 4, 4) one on it and its end; of a load mass and
            centre in the flange frame; coordinates of joints; 0 or 1 of a signal; seconds of a pause.
        number: of a signal.
        time, speed, zone: of a motion: duration, zero if it is not known; of the tip; radius of the corner [s, m/s, m].
    """

    kind: str
    values: Floats
    number: int = 0
    time: float = 0.0
    speed: float = 0.0
    zone: float = 0.0


def instructions(job: Job, plan: Plan) -> tuple[list[Instruction], list[Remark]]:
    """What a plan does, one after the other, and what of it no language carries."""
    lost: list[Remark] = []
    steps, load = [Instruction("joints", plan.start)], None
    for leg in plan.legs:
        if leg.load != load:
            steps += _load(leg.load, changed=load is None or load.equipment is not leg.load.equipment)
            load = leg.load
        steps += _steps(job, leg, lost)
    return steps, lost


def _load(load: Load, *, changed: bool) -> Iterator[Instruction]:
    """The tool, if it changed, and what hangs on the flange: masses and their common centre."""
    tool, T = load.equipment.tool, load.equipment.T_of_flange
    if changed:
        yield Instruction("tool", T)
    masses, centres = [tool.mass], [np.asarray(tool.com)]
    if load.carried is not None:
        masses.append(load.carried.mass)
        centres.append(T[:3, :3] @ centre_of_mass(load.carried) + T[:3, 3])
    total = sum(masses)
    yield Instruction("load", np.append(total, np.dot(masses, centres) / total if total > 0.0 else np.zeros(3)))


def _steps(job: Job, leg: Leg, lost: list[Remark]) -> Iterator[Instruction]:
    move, name = job.move[leg.index], visible(leg.name) or str(leg.index + 1)
    motion = leg.trajectory
    lost += lost_keys(job, leg)
    if leg.frame:
        lost.append(Remark("warning", "job.program_key", {"move": name, "key": f"frame {visible(leg.frame)}"}))
    end = motion.at(motion.duration).u
    if leg.kind in ("pause", "pick", "place", "tool") and not leg.frame:
        yield Instruction("pause", np.array([motion.duration]))
        if leg.kind != "pause":
            lost.append(Remark("warning", "job.program_gripper", {"move": name}))
    elif leg.kind in ("set", "wait"):
        yield from _signal_steps(job, leg.kind, move, name, lost)
    elif leg.kind == "if":
        lost.append(Remark("warning", "job.program_choice", {"move": name}))
    elif leg.kind == "joint" and leg.way is None and not move.via and not leg.frame:
        yield Instruction("joints", end, time=motion.duration)
    elif leg.targets and all(one.path in PATHS for one in _moves_of(job, leg)) and not leg.frame:
        yield from _tip_paths(job, leg)
    elif leg.kind != "settle":
        sampled = _sample(motion)
        yield from sampled
        lost.append(Remark("warning", "job.program_sampled", {"move": name, "count": len(sampled)}))


def _signal_steps(job: Job, kind: str, move: Move, name: str, lost: list[Remark]) -> Iterator[Instruction]:
    """Digital signals that are set or waited for, by their numbers."""
    signals = list(job.output if kind == "set" else job.input)
    for signal, value in (move.set if kind == "set" else move.wait).items():
        if isinstance(value, bool):
            number = signals.index(signal) if signal in signals else len(signals)
            yield Instruction(kind, np.array([float(value)]), number)
        else:
            lost.append(Remark("warning", "job.program_signal", {"move": name, "signal": visible(signal)}))


def _sample(motion: Trajectory) -> list[Instruction]:
    """Moves of the joints from point to point along a motion that no single instruction makes."""
    way = motion.at(np.linspace(0.0, motion.duration, 1001)).u
    far = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(way, axis=0)).max(axis=1))])
    count = int(np.ceil(far[-1] / CHORD)) + 1
    places = [float(far[-1]) * k / (count - 1) for k in range(count)] if count > 1 else []
    rows = [int(np.searchsorted(far, place)) for place in places]
    return [
        Instruction("joints", way[row], time=(row - before) / 1000.0 * motion.duration,
                    zone=0.0 if row == rows[-1] else CORNER)
        for before, row in pairwise(rows)
    ]  # fmt: skip


def _moves_of(job: Job, leg: Leg) -> tuple[Move, ...]:
    """The moves that a leg makes without a stop between."""
    return job.move[leg.index + 1 - max(len(leg.targets), 1) : leg.index + 1]


def _tip_paths(job: Job, leg: Leg) -> Iterator[Instruction]:
    """The lines and arcs of a leg, their corners rounded within zones; its duration only where it is one of them."""
    motion, here = leg.trajectory, np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(0.0).u))
    time = motion.duration if len(leg.targets) == 1 else 0.0
    for k, (move, goal) in enumerate(zip(_moves_of(job, leg), leg.targets, strict=True)):
        speed = move.speed * (move.tip_speed or job.limits.tip_speed)
        if move.path == "joint":
            yield Instruction("joints", leg.goals[k], zone=move.blend)
        elif move.path == "line":
            yield Instruction("line", goal, time=time, speed=speed, zone=move.blend)
        else:
            point = move.via[0]
            assert isinstance(point, Pose)
            ends = np.stack([arc_path(here, point.position, goal).poses(0.5), goal])
            yield Instruction("arc", ends, time=time, speed=speed, zone=move.blend)
        here = goal


def lost_keys(job: Job, leg: Leg, keys: tuple[str, ...] = NOT_CARRIED) -> Iterator[Remark]:
    """Keys of moves for which a language has no instruction, or another one on each controller.

    Args:
        job: with the moves.
        leg: of its plan.
        keys: that the language does not have.
    """
    name = visible(leg.name) or str(leg.index + 1)
    for move in _moves_of(job, leg):
        for key in keys:
            if getattr(move, key):
                yield Remark("warning", "job.program_key", {"move": name, "key": key})
