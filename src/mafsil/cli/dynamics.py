"""`mafsil dynamics`: mass matrix, bias, gravity, efforts or accelerations of one state, or the motion from it.

Of a robot with loops the efforts are those of its driven joints. Quantities of the catalogue can be asked for by name.
With `--duration` the answer is what constant efforts make of the state over time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil.arrays import Floats, JointVector, positive
from mafsil.cli.answer import Answer, Toned
from mafsil.cli.state import (
    chain_at,
    degrees_remarks,
    efforts,
    joint_values,
    parse_numbers,
    require_open_chain,
    units,
    with_units,
)
from mafsil.cli.state import number as typed
from mafsil.cli.table import matrix, number, table
from mafsil.cli.tolerances import KEPT
from mafsil.csv_table import csv_text, joint_columns
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.mechanics.catalogue import quantity
from mafsil.messages import say
from mafsil.robot import Robot, load
from mafsil.whole_file import write_whole

if TYPE_CHECKING:
    import mafsil.simulation as simulation
else:
    simulation = lazily("mafsil.simulation")


PER_SECOND = 100
"""Rows of the file per second."""
PATIENCE = 60.0
"""Seconds after which the motion ends where it is."""


def dynamics(
    robot: str,
    q: list[str],
    qd: list[str] | None,
    qdd: list[str] | None,
    tau: list[str] | None,
    duration: str | None,
    out: str | None,
    frictionless: bool,
    quantities: list[str] | None,
    tip: str | None,
    degrees: bool,
) -> Answer:
    """Inverse dynamics for given accelerations (zero by default), or forward dynamics for given efforts.

    tau = M(q) qdd + c(q, qd) + g(q)

    Args:
        robot: name or file.
        q, qd, qdd: (n) coordinates, rates and accelerations as typed; rates and accelerations are zero if left out.
        tau: (n) efforts; asks for the accelerations.
        duration: of the motion under constant efforts, if that is asked for.
        out, frictionless: file of the motion, and whether the joints' friction is left out of it.
        quantities: names of the catalogue whose values at this state are given too.
        tip: another tip link.
        degrees: whether bare angles are degrees.

    Raises:
        MafsilError: no such robot, not one number per joint, both `qdd` and `tau`, `out` or `frictionless` without
            `duration`, `quantities` with it, a state so large that numbers overflow, or efforts that
            determine no accelerations.
    """
    if qdd is not None and (tau is not None or duration is not None):
        raise InputError("cli.dynamics_both")
    if duration is None and (out is not None or frictionless):
        raise InputError("cli.dynamics_over_time")
    if duration is not None and quantities:
        raise InputError("cli.dynamics_one_state")
    arm = load(robot, tip=tip)
    zero = np.zeros(arm.n)
    values = {
        name: zero if words is None else joint_values(name, words, arm.mechanism, degrees=degrees)
        for name, words in (("q", q), ("qd", qd), ("qdd", qdd))
    }
    if arm.mechanism.loops:
        if duration is not None or quantities:
            require_open_chain(arm.mechanism, "dynamics --duration" if quantities is None else "dynamics --quantities")
        given = None if tau is None else efforts("tau", tau, arm.mechanism)
        return closed_dynamics(arm, values, given, degrees_remarks(q, arm.mechanism, degrees=degrees))
    if duration is not None:
        constant_efforts = zero if tau is None else efforts("tau", tau, arm.mechanism)
        return motion(arm, values["q"], values["qd"], constant_efforts, duration, out, friction=not frictionless)
    if tau is None:
        values["tau"] = np.asarray(arm.inverse_dynamics(values["q"], values["qd"], values["qdd"]))
    else:
        values["tau"] = efforts("tau", tau, arm.mechanism)
        arm.mass_matrix_singularity(values["q"]).require_regular()
        values["qdd"] = np.asarray(arm.forward_dynamics(values["q"], values["qd"], values["tau"]))
    remarks = degrees_remarks(q, arm.mechanism, degrees=degrees)
    shown = _answer(arm, values, remarks, forward=tau is not None)
    if not quantities:
        return shown
    found = quantity_values(arm, quantities, values)
    _require_finite(arm, found)
    return Answer({**shown.data, "quantities": found}, (*shown.lines, *quantity_lines(found)), shown.refusal)


def _answer(arm: Robot, values: dict[str, Floats], remarks: list[str], *, forward: bool) -> Answer:
    q, qd = values["q"], values["qd"]
    M = np.asarray(arm.mass_matrix(q))
    c, g = np.asarray(arm.velocity_torque(q, qd)), np.asarray(arm.gravity_torque(q))
    friction = np.asarray(arm.friction_torque(qd))
    energy = {"kinetic": float(arm.kinetic_energy(q, qd)), "potential": float(arm.potential_energy(q))}
    shown = {"qdd": values["qdd"], "tau": values["tau"], "c(q,qd)": c, "g(q)": g}
    _require_finite(arm, {**shown, "energy": np.array(list(energy.values())), "M(q)": M})
    excess = [
        n for n, t, limit in zip(arm.joint_names, values["tau"], arm.limits.effort, strict=True) if abs(t) > limit
    ]
    data: dict[str, Any] = {
        "robot": arm.name,
        "question": "forward" if forward else "inverse",
        "joints": list(arm.joint_names),
        **values,
        "mass_matrix": M,
        "velocity_torque": c,
        "gravity_torque": g,
        "friction_torque": friction,
        "energy": energy,
        "beyond_effort_limit": excess,
    }
    columns = [values[name] for name in ("q", "qd", "qdd")] + [c, g, values["tau"]]
    head = (say("cli.joint"), "q", "qd", "qdd", "c(q,qd)", "g(q)", "tau")
    head = (say("cli.joint"), *with_units(arm.mechanism, head[1:]))
    rows = [(name, *(number(column[k]) for column in columns)) for k, name in enumerate(arm.joint_names)]
    lines = [say("cli.dynamics_forward_title" if forward else "cli.dynamics_inverse_title", robot=arm.name)]
    lines += [*table(head, rows), say("cli.mass_matrix", unit=units(arm.mechanism)["M"]), *matrix(M)]
    lines.append(say("cli.energy", kinetic=number(energy["kinetic"]), potential=number(energy["potential"])))
    if friction.any():
        lines.append(say("cli.dynamics_friction", values="  ".join(map(number, friction))))
    lines += [Toned(say("cli.beyond_effort", joint=name), "warning") for name in excess]
    return Answer(data, (*lines, *remarks))


def _require_finite(arm: Robot, results: dict[str, Floats]) -> None:
    """Refuses a state whose results overflow, naming the first of them.

    Raises:
        InputError: infinite or no number at all.
    """
    for name, result in results.items():
        for index in np.argwhere(~np.isfinite(result)):
            joint = arm.joint_names[int(index[0])] if result.shape[:1] == (arm.n,) else name
            raise InputError("cli.dynamics_overflow", quantity=name, joint=joint, value=float(result[tuple(index)]))


def quantity_values(arm: Robot, names: Sequence[str], state: Mapping[str, Floats]) -> dict[str, Floats]:
    """The named quantities at a state; framed ones belong to the tip.

    Args:
        arm: the robot.
        names: of the catalogue.
        state: q, qd, qdd, tau.

    Raises:
        InputError: no such quantity; the sentence lists what there is.
    """
    rows = [quantity(name) for name in dict.fromkeys(names)]
    return {row.name: np.asarray(arm.routine(row.name)(*(state[name] for name in row.inputs))) for row in rows}


def quantity_lines(values: Mapping[str, Floats]) -> list[str]:
    """Symbol, title and unit, then the numbers; of arrays with three indices one matrix for each first index.

    Args:
        values: of quantities by their names.
    """
    lines: list[str] = []
    for name, value in values.items():
        row = quantity(name)
        lines += ["", say("cli.quantity_title", name=name, symbol=row.symbol, title=row.title, unit=row.unit)]
        if not value.ndim:
            lines.append("  " + number(float(value)))
        elif value.ndim < 3:
            lines += matrix(np.atleast_2d(value))
        else:
            for index in np.ndindex(value.shape[:-2]):
                lines += [f"  {list(index)}", *matrix(value[index])]
    return lines


def closed_dynamics(arm: Robot, values: Mapping[str, Floats], tau: Floats | None, remarks: list[str]) -> Answer:
    """One state of a robot with loops.

    Args:
        arm: with loops.
        values: (n,) q, qd and qdd of all joints.
        tau: (n,) efforts that ask for accelerations; efforts are asked for if None.
        remarks: about what was typed.

    Raises:
        InputError: coordinates, rates or accelerations that open a loop.
    """
    given, qd, qdd = (values[name] for name in ("q", "qd", "qdd"))
    chain = chain_at(arm, given)
    q = np.asarray(chain.close_loops(given, tries=1).q)
    kept = chain.rates(q, qd, hold=chain.actuated)
    if np.abs(chain.terms(q).J @ qd).max(initial=0.0) > KEPT * (1.0 + np.abs(qd).max(initial=0.0)):
        raise InputError("cli.loops_rates", robot=arm.name, values=parse_numbers(kept))
    still = np.zeros(chain.n)
    gravity = chain.inverse_dynamics(q, still, still)
    if tau is None:
        found = chain.inverse_dynamics(q, kept, qdd)
        efforts, explained = found.tau, found
    else:
        moved = chain.forward_dynamics(q, kept, tau)
        qdd, efforts, explained = np.asarray(moved.qdd), tau[chain.actuated], moved
    actuated: list[int] = chain.actuated.tolist()
    driven = [arm.joint_names[k] for k in actuated]
    energy = {"kinetic": float(arm.kinetic_energy(q, kept)), "potential": float(arm.potential_energy(q))}
    data: dict[str, Any] = {
        "robot": arm.name, "question": "inverse" if tau is None else "forward", "joints": list(arm.joint_names),
        "q": q, "qd": kept, "qdd": qdd, "driven": driven, "tau": efforts, "gravity_torque": gravity.tau,
        "status": explained.status.name.lower(), "energy": energy,
    }  # fmt: skip
    lines = [say("cli.loops_inverse" if tau is None else "cli.loops_forward", robot=arm.name)]
    lines += _driven_table(arm, actuated, (q, kept, qdd), (gravity.tau, efforts))
    lines += explained.explain().splitlines()
    lines.append(say("cli.energy", kinetic=number(energy["kinetic"]), potential=number(energy["potential"])))
    return Answer(data, (*lines, *remarks), None if explained else explained.explain().splitlines()[0])


def _driven_table(
    arm: Robot, actuated: list[int], motion: tuple[Floats, ...], efforts: tuple[Floats, ...]
) -> list[str]:
    """Lines of a table, a row for each joint; efforts of the driven ones alone."""
    head = (say("cli.joint"), *with_units(arm.mechanism, ("q", "qd", "qdd", "g(q)", "tau")))
    rows: list[tuple[str, ...]] = []
    for k, name in enumerate(arm.joint_names):
        shown = [number(float(column[actuated.index(k)])) if k in actuated else "–" for column in efforts]
        rows.append((name, *(number(float(column[k])) for column in motion), *shown))
    return table(head, rows)


def motion(
    arm: Robot, q: JointVector, qd: JointVector, tau: JointVector, duration: str, out: str | None, *, friction: bool
) -> Answer:
    """The motion from a state under constant efforts; a table of its end, and a file of all of it.

    Args:
        arm: the robot.
        q, qd, tau: (n,) initial state and efforts.
        duration: as typed [s].
        out: CSV file with t, q[JOINT], qd[JOINT], qdd[JOINT], tau[JOINT].
        friction: whether the joints' friction acts.

    Raises:
        MafsilError: no duration, or a file that cannot be written.
    """
    end = positive("--duration", typed("--duration", duration))
    moved = simulation.forward_dynamics_trajectory(arm, q, qd, tau, duration=end, friction=friction, seconds=PATIENCE)
    if out is not None:
        _write(moved, tau, Path(out))
    first, last = float(moved.energy[0]), float(moved.energy[-1])
    data: dict[str, Any] = {
        "robot": arm.name,
        "question": "motion",
        "joints": list(arm.joint_names),
        "status": moved.outcome.status.name.lower(),
        "t": moved.duration,
        "q": moved.q[-1],
        "qd": moved.qd[-1],
        "qdd": moved.qdd[-1],
        "tau": tau,
        "steps": len(moved.t) - 1,
        "energy": {"start": first, "end": last},
        "out": out,
    }
    ends = zip(arm.joint_names, moved.q[-1], moved.qd[-1], moved.qdd[-1], strict=True)
    rows = [(name, *map(number, values)) for name, *values in ends]
    lines = [say("cli.motion_title", robot=arm.name, time=number(moved.duration))]
    lines += [moved.explain()] if moved.succeeded else []
    lines += table((say("cli.joint"), *with_units(arm.mechanism, ("q", "qd", "qdd"))), rows)
    lines.append(say("cli.motion_energy", first=number(first), last=number(last)))
    lines += [say("cli.motion_written", path=out)] if out is not None else []
    return Answer(data, tuple(lines), None if moved.succeeded else moved.explain())


def _write(moved: simulation.ForwardMotion, tau: JointVector, path: Path) -> None:
    """The motion on an even grid, in columns that `mafsil identify` reads."""
    t: Floats = np.linspace(0.0, moved.duration, 1 + max(1, ceil(moved.duration * PER_SECOND)))
    state = moved.at(t)
    columns = {"q": state.u, "qd": state.v, "qdd": state.a, "tau": np.broadcast_to(tau, state.u.shape)}
    columns_of_file = {"t": t, **joint_columns(tuple(columns), tuple(columns.values()), moved.robot.joint_names)}
    write_whole(path, lambda file: file.writelines(csv_text(columns_of_file)))
