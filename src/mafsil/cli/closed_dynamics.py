"""`mafsil dynamics` of a robot with loops: efforts of the driven joints, or accelerations, of the closed chain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import Answer
from mafsil.cli.loops import chain_at, parse_numbers
from mafsil.cli.state import with_units
from mafsil.cli.table import number, table
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.robot import Robot

KEPT = 1e-4
"""Share of given rates by which they may open a loop."""


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
    lines += _table(arm, actuated, (q, kept, qdd), (gravity.tau, efforts))
    lines += explained.explain().splitlines()
    lines.append(say("cli.energy", kinetic=number(energy["kinetic"]), potential=number(energy["potential"])))
    return Answer(data, (*lines, *remarks), None if explained else explained.explain().splitlines()[0])


def _table(arm: Robot, actuated: list[int], motion: tuple[Floats, ...], efforts: tuple[Floats, ...]) -> list[str]:
    """Lines of a table, a row for each joint; efforts of the driven ones alone."""
    head = (say("cli.joint"), *with_units(arm.mechanism, ("q", "qd", "qdd", "g(q)", "tau")))
    rows: list[tuple[str, ...]] = []
    for k, name in enumerate(arm.joint_names):
        shown = [number(float(column[actuated.index(k)])) if k in actuated else "–" for column in efforts]
        rows.append((name, *(number(float(column[k])) for column in motion), *shown))
    return table(head, rows)
