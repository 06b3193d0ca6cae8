"""`mafsil convert`: one rotation or pose in every representation, with all its names and its singular cases."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from math import pi
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import PLAIN, Answer, draw_picture, require_kind
from mafsil.cli.motion_input import Motion, bare_angles, read
from mafsil.cli.state import angle_remarks
from mafsil.cli.table import label_lines, matrix, number
from mafsil.cli.tolerances import ROUNDOFF
from mafsil.geometry import euler, logarithms, planar, pose, quaternion, rotation, screw
from mafsil.geometry.tolerances import SPECIAL
from mafsil.messages import say

_SHOWN = ("xyz", "ZYX", "ZYZ", "XYZ")
"""Sequences listed by default; `xyz` is roll, pitch, yaw."""


def convert(
    rpy: list[str] | None,
    quaternion: list[str] | None,
    matrix: list[str] | None,
    axis_angle: list[str] | None,
    euler: list[str] | None,
    rotation_vector: list[str] | None,
    gibbs: list[str] | None,
    pose: list[str] | None,
    exponential: list[str] | None,
    screw: list[str] | None,
    planar: list[str] | None,
    position: list[str] | None,
    all_sequences: bool,
    picture: str | None,
    project: bool,
    degrees: bool,
) -> Answer:
    """One motion in every representation.

    Args:
        rpy, quaternion, matrix, axis_angle, euler, rotation_vector, gibbs: words of a rotation; exactly one source.
        pose, exponential, screw, planar: words of a pose; likewise.
        position: origin that goes with a rotation.
        all_sequences: list all 24 Euler sequences.
        picture: file to draw into.
        project: take the nearest rotation of what is none.
        degrees: bare angles are degrees, typed and printed.

    Raises:
        MafsilError: not one source, wrong numbers, no rotation, a file that cannot be written.
    """
    given = {
        "rpy": rpy, "quaternion": quaternion, "matrix": matrix, "axis_angle": axis_angle, "euler": euler,
        "rotation_vector": rotation_vector, "gibbs": gibbs, "pose": pose, "exponential": exponential, "screw": screw,
        "planar": planar,
    }  # fmt: skip
    if picture is not None:
        require_kind(picture, PLAIN)
    motion = read(given, position, degrees=degrees, project=project)
    data = representations(motion, all_sequences=all_sequences)
    shown = [*lines(data, degrees=degrees), *angle_remarks([] if degrees else bare_angles(given))]
    if picture is not None:
        from mafsil.figures import plot_motion

        draw = partial(plot_motion, motion.T, kind=motion.kind, sequence=motion.sequence)
        shown.append(draw_picture(draw, picture, data))
    return Answer(data, tuple(shown))


def representations(motion: Motion, *, all_sequences: bool = False) -> dict[str, Any]:
    """Every representation as plain data: radians, metres, None where a number is infinite or there is no axis.

    Args:
        motion: what was typed.
        all_sequences: all 24 sequences of angles, not only the usual ones.
    """
    R = np.asarray(motion.T[:3, :3])
    sequences = euler.SEQUENCES if all_sequences else dict.fromkeys([*_SHOWN, motion.sequence or "xyz"])
    q = np.asarray(quaternion.to_quaternion(R))
    U = quaternion.to_su2(q)
    data: dict[str, Any] = {
        "kind": motion.kind,
        "source": motion.source,
        "projected_by": motion.moved,
        "matrix": R,
        "quaternion_wxyz": [q, -q],
        "su2": [[[z.real, z.imag] for z in row] for row in U.tolist()],
        "axis_angle": [{"axis": x.axis, "angle": x.angle} for x in logarithms.logarithms(R, 0.0, 2 * pi)],
        "rotation_vector": logarithms.ball_points(R),
        "angle_sequences": {name: _angles(R, name) for name in sequences},
        "gibbs": None if pi - float(rotation.angle(R)) <= SPECIAL else quaternion.to_gibbs(q),
        "modified_rodrigues": quaternion.to_modified_rodrigues(q),
    }
    if motion.kind != "rotation":
        data |= _pose_data(motion)
    return data


def _angles(R: Floats, sequence: str) -> dict[str, Any]:
    """Both triples, or at a gimbal lock one triple and the direction of its family."""
    found = euler.solutions(R, sequence)
    if found.locked:
        return {"locked": True, "triples": found.angles[:1], "family": found.direction}
    return {"locked": False, "triples": found.angles, "family": None}


def _pose_data(motion: Motion) -> dict[str, Any]:
    T = motion.T
    S, amount = screw.chasles(T)
    turns, moves = bool(np.any(S[:3])), bool(amount)
    axis = {
        "axis": S if moves else None,
        "direction": (S[:3] if turns else S[3:]) if moves else None,
        "point": screw.nearest_point(S) if turns else None,
        "pitch": float(screw.pitch(S)) if turns else None,
        "amount": float(amount),
        "turns": turns,
    }
    data: dict[str, Any] = {"pose": T, "position": T[:3, 3], "exponential": pose.log(T), "screw": axis}
    if motion.kind == "planar":
        data["planar"] = _planar_data(T)
    return data


def _planar_data(T: Floats) -> dict[str, Any]:
    flat = np.eye(3)
    flat[:2, :2], flat[:2, 2] = T[:2, :2], T[:2, 3]
    point, exists = planar.finite_pole(flat)
    return {
        "coordinates": planar.coordinates(flat),
        "twist": planar.log(flat),
        "pole": point if exists else None,
        "homogeneous_pole": planar.pole(flat),
    }


def lines(data: dict[str, Any], *, degrees: bool) -> list[str]:
    """Title, matrix, table of representations and remarks on singular cases.

    Args:
        data: as `representations` gives it.
        degrees: print angles in degrees.
    """
    unit, factor = ("°", 180 / pi) if degrees else ("rad", 1.0)
    rows = [*_rotation_rows(data, unit, factor), *_pose_rows(data, unit, factor)]
    shown = [say(f"convert.title_{data['kind']}", source=data["source"])]
    if data["projected_by"] is not None:
        shown.append(say("convert.projected", distance=f"{data['projected_by']:.3g}"))
    shown += matrix(data.get("pose", data["matrix"]))
    shown += ["", *label_lines(rows)]
    remarks = _remarks(data, factor, unit)
    return [*shown, *(["", *remarks] if remarks else [])]


def _row(label: str, values: Iterable[float], factor: float = 1.0) -> list[str]:
    return [label, *(number(factor * float(x)) for x in values)]


def _rows(label: str, names: Iterable[Iterable[float]], factor: float = 1.0) -> list[list[str]]:
    """Several names of one thing: the first with its label, the others as "or"."""
    return [_row(say("convert.or") if k else label, values, factor) for k, values in enumerate(names)]


def _rotation_rows(data: dict[str, Any], unit: str, factor: float) -> list[list[str]]:
    rows = _rows(say("convert.quaternion"), data["quaternion_wxyz"])
    turns = [turn for turn in data["axis_angle"] if turn["axis"] is not None]
    label = say("convert.axis_angle", unit=unit)
    for k, turn in enumerate(turns):
        rows.append([*_row(say("convert.or") if k else label, turn["axis"]), number(factor * turn["angle"])])
    rows += _rows(say("convert.rotation_vector", unit=unit), data["rotation_vector"], factor)
    for name, found in data["angle_sequences"].items():
        rows += _rows(_sequence_label(name, unit), found["triples"], factor)
    gibbs = data["gibbs"]
    rows.append([say("convert.gibbs"), "∞"] if gibbs is None else _row(say("convert.gibbs"), gibbs))
    rows.append(_row(say("convert.modified_rodrigues"), data["modified_rodrigues"]))
    a, b = data["su2"][0]
    rows.append(_row(say("convert.su2"), [*a, *b]))
    return rows


def _sequence_label(name: str, unit: str) -> str:
    if name == "xyz":
        return say("convert.rpy", unit=unit)
    return say("convert.fixed_angles" if name.islower() else "convert.euler_angles", sequence=name, unit=unit)


def _pose_rows(data: dict[str, Any], unit: str, factor: float) -> list[list[str]]:
    if "pose" not in data:
        return []
    turned = np.concatenate([factor * np.asarray(data["exponential"][:3]), data["exponential"][3:]])
    rows = [_row(say("convert.position"), data["position"]), _row(say("convert.exponential", unit=unit), turned)]
    axis = data["screw"]
    if axis["axis"] is not None:
        rows += [_row(say("convert.screw"), axis["axis"]), _row(say("convert.direction"), axis["direction"])]
    if axis["turns"]:
        rows += [
            _row(say("convert.point"), axis["point"]),
            _row(say("convert.pitch"), [axis["pitch"]]),
            _row(say("convert.turn", unit=unit), [axis["amount"]], factor),
        ]
    elif axis["axis"] is not None:
        rows.append(_row(say("convert.distance"), [axis["amount"]]))
    return rows + _planar_rows(data, unit, factor)


def _planar_rows(data: dict[str, Any], unit: str, factor: float) -> list[list[str]]:
    if "planar" not in data:
        return []
    theta, *p = data["planar"]["coordinates"]
    omega, *v = data["planar"]["twist"]
    rows = [
        _row(say("convert.planar", unit=unit), [factor * theta, *p]),
        _row(say("convert.planar_twist", unit=unit), [factor * omega, *v]),
    ]
    pole = data["planar"]["pole"]
    if pole is not None:
        rows.append(_row(say("convert.pole"), pole))
    return rows


def _remarks(data: dict[str, Any], factor: float, unit: str) -> list[str]:
    remarks = [
        _lock_remark(name, found, factor, unit) for name, found in data["angle_sequences"].items() if found["locked"]
    ]
    if len(data["rotation_vector"]) == 2:
        remarks.append(say("convert.half_turn"))
    if data["axis_angle"][0]["axis"] is None:
        remarks.append(say("convert.no_turn"))
    if "pose" in data and data["screw"]["axis"] is None:
        remarks.append(say("convert.no_motion"))
    elif "pose" in data and not data["screw"]["turns"]:
        remarks.append(say("convert.translation"))
    if "planar" in data and data["planar"]["pole"] is None:
        remarks.append(say("convert.pole_at_infinity"))
    return remarks


def _lock_remark(name: str, found: dict[str, Any], factor: float, unit: str) -> str:
    a, b, c = (factor * float(x) for x in found["triples"][0])
    agree = found["family"][2] < 0
    family = f"({_shift(a, '+')}, {number(b, 4)}, {_shift(c, '-' if agree else '+')})"
    sequence = say("convert.rpy_name") if name == "xyz" else name
    return say("convert.lock", sequence=sequence, family=family, fixed="a + c" if agree else "a - c", unit=unit)


def _shift(value: float, sign: str) -> str:
    """`value + t` or `value - t`, without a zero in front."""
    if abs(value) < ROUNDOFF:
        return "t" if sign == "+" else "-t"
    return f"{number(value, 4)} {sign} t"
