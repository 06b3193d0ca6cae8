"""`mafsil identify`: from a log to a better model of the robot, or to the load that it carries."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mafsil.cli.answer import Answer
from mafsil.cli.state import number, require_open_chain, units
from mafsil.cli.table import brief, table
from mafsil.errors import FileError, InputError
from mafsil.identification import Identification, Payload, estimate_payload, read_log
from mafsil.identification import identify as identified
from mafsil.identification.torque_model import save
from mafsil.messages import say
from mafsil.model import JointKind
from mafsil.robot import Robot, load

_ENDINGS = (".urdf", ".toml")
_UNITS_OF_JOINTS = {
    "viscous": ("N m s/rad", "N s/m"),
    "coulomb": ("N m", "N"),
    "offset": ("N m", "N"),
    "rotor": ("kg m²", "kg"),
}
"""Of a revolute and of a prismatic joint."""


def identify(
    robot: str,
    log: str,
    out: str | None,
    payload: bool,
    at_rest: bool,
    rotor_inertia: bool,
    validation: str | None,
    held_out: str | None,
    bandwidth: str | None,
    tip: str | None,
    degrees: bool,
) -> Answer:
    """Masses, inertias and friction, or the load at the tip, from recorded motion and efforts.

    Args:
        robot: name or file.
        log: CSV file.
        out: .urdf or .toml file for the robot that was found.
        payload: the robot is known, its load is not.
        at_rest: the rows are poses at rest (loads only).
        rotor_inertia: look for inertias of rotors too.
        validation: another log, to try the new model on.
        held_out: fraction of the log that is held out otherwise.
        bandwidth: highest frequency of the motion [Hz].
        tip: another tip link.
        degrees: revolute joints are in degrees.

    Raises:
        MafsilError: no such robot or log, a wrong line in the log, a place that cannot be written.
    """
    if at_rest and not payload:
        raise InputError("identification.at_rest_needs_payload")
    if out is not None and Path(out).suffix.lower() not in _ENDINGS:
        raise FileError("identification.suffix", path=out)
    arm = load(robot, tip=tip)
    require_open_chain(arm.mechanism, "identify")
    band = None if bandwidth is None else number("--bandwidth", bandwidth)
    if payload:
        return _payload_answer(estimate_payload(arm, log, at_rest=at_rest, bandwidth=band, degrees=degrees), out)
    found = identified(
        arm,
        log,
        validation=None if validation is None else read_log(validation, arm, degrees=degrees),
        held_out=0.2 if held_out is None else number("--held-out", held_out),
        rotor_inertia=True if rotor_inertia else None,
        bandwidth=band,
        degrees=degrees,
    )
    return _answer(found, out)


def _answer(found: Identification, out: str | None) -> Answer:
    lines = [found.explain().splitlines()[0], *(fault.sentence() for fault in found.faults)]
    lines += [*_parameters(found), *_errors(found)]
    lines.append(say("identification.condition", condition_number=found.condition_number))
    lines += [item.sentence() for item in found.unidentifiable]
    lines += [remark.sentence() for remark in found.remarks]
    data, written = _written(found.robot, out)
    refusal = None if found else found.status.sentence()
    return Answer({**found.to_dict(), **data}, (*lines, *written), refusal)


def _parameters(found: Identification) -> list[str]:
    head = [say(f"identification.head_{name}") for name in ("parameter", "before", "value", "error", "after")]
    prismatic = {j.name for j in found.robot.mechanism.coordinates if j.kind is JointKind.PRISMATIC}
    rows = [
        (
            p.label,
            *(brief(p.before), brief(p.value), f"{p.standard_error:.2g}", brief(p.after)),
            _unit(p.label, prismatic),
        )
        for p in found.parameters
    ]
    return [say("identification.parameters"), *table([*head, say("cli.unit")], rows)]


def _unit(label: str, prismatic: set[str]) -> str:
    """Unit of a parameter such as `link3.Ixx` or `joint2.coulomb`."""
    owner, _, name = label.rpartition(".")
    if name in _UNITS_OF_JOINTS:
        return _UNITS_OF_JOINTS[name][owner in prismatic]
    return "kg" if name == "m" else "kg m" if name.startswith("h") else "kg m²"


def _errors(found: Identification) -> list[str]:
    v = found.validation
    head = [
        say("identification.head_joint"),
        say("identification.head_effort", unit=units(found.robot.mechanism)["effort"]),
    ]
    head += [say(f"identification.head_{name}") for name in ("before_percent", "after_percent")]
    rows = [
        (joint, brief(effort), f"{before:.2f}", f"{after:.2f}")
        for joint, effort, before, after in zip(v.joints, v.effort, v.before, v.after, strict=True)
    ]
    return [
        say("identification.errors_held_out" if v.held_out else "identification.errors_training"),
        *table(head, rows),
    ]


def _payload_answer(found: Payload, out: str | None) -> Answer:
    data, written = _written(found.robot, out) if found.certain else ({"out": None}, [])
    lines = found.explain().splitlines()
    refusal = None if found.certain else lines.pop(0)
    return Answer({**found.to_dict(), **data}, (*lines, *written), refusal)


def _written(robot: Robot, out: str | None) -> tuple[dict[str, Any], list[str]]:
    """Data and lines about the file that was written."""
    if out is None:
        return {"out": None}, []
    lost = [remark.sentence() for remark in save(robot.mechanism, Path(out))]
    return {"out": out, "not_in_file": lost}, [say("identification.written", path=out), *lost]
