"""`mafsil convert`: one rotation or pose in every representation, with all its names and its singular cases."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import Answer
from mafsil.cli.motion_input import Motion, bare_angles, read
from mafsil.cli.motion_table import lines
from mafsil.cli.picture import PLAIN, drawn, require_kind
from mafsil.cli.state import angle_remarks
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

        drawn(lambda path: plot_motion(motion.T, path, motion.kind, motion.sequence), picture)
        shown.append(say("cli.picture_written", path=picture))
        data["picture"] = picture
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
