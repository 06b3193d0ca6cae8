"""The representations of one motion as lines for people."""

from __future__ import annotations

from collections.abc import Iterable
from math import pi
from typing import Any

import numpy as np

from mafsil.cli.table import label_lines, matrix, number
from mafsil.messages import say


def lines(data: dict[str, Any], *, degrees: bool) -> list[str]:
    """Title, matrix, table of representations and remarks on singular cases.

    Args:
        data: as `mafsil.cli.convert.representations` gives it.
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
    if abs(value) < 1e-12:
        return "t" if sign == "+" else "-t"
    return f"{number(value, 4)} {sign} t"
