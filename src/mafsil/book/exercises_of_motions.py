"""Families of exercises for chapters 2 to 4: mobility, grasps, rotations, rigid motions, screws, wrenches."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.exercise import Draw, Task, asks
from mafsil.book.judging import ask
from mafsil.geometry import Pose, Rotation, ScrewAxis, Twist, Wrench, planar
from mafsil.grasp import Contact, Grasp, two_fingers
from mafsil.mobility import gruebler_count

LEGS = {
    "UPS": (2, 1, 3), "SPS": (3, 1, 3), "UPU": (2, 1, 2), "RUS": (1, 2, 3), "PUS": (1, 2, 3), "RPS": (1, 1, 3),
    "PRS": (1, 1, 3),
}  # fmt: skip
"""Freedoms of the three joints of a leg by its kind."""
AXES = ((1, 2, 2), (2, -1, 2), (-2, 2, 1), (2, 3, 6), (6, -2, 3), (1, -4, 8))
"""Vectors of whole length."""


@asks("2.2.1 linkage")
def linkage(draw: Draw) -> Task | None:
    """Mobility of a planar linkage."""
    links, slots, mobility = draw.whole(4, 5 + 2 * draw.level), draw.whole(0, 2 * draw.level - 2), draw.whole(1, 3)
    pins, odd = divmod(3 * (links - 1) - slots - mobility, 2)
    if odd or pins + slots < links - 1:
        return None
    sliders = draw.whole(0, min(pins, 2))
    freedoms = [1] * pins + [2] * slots
    M = int(gruebler_count(links, freedoms, "planar").mobility)
    joints = pins + slots
    inner = links - 1 - joints
    mistakes: dict[str, Any] = ({"two_as_one": M - slots} if slots else {}) | (
        {"spatial_rule": M + 3 * inner} if inner < -1 else {}
    )
    return Task(
        {"links": links, "pins": pins - sliders, "sliders": sliders, "slots": slots, "joints": joints,
         "total": sum(freedoms), "inner": inner, "M": M},
        [
            ask("mobility", M, ground_moves=M + 3, ground_left_out=M - 3, **mistakes),
            ask("loops", -inner, ground_left_out=1 - inner, loops_no_one=-inner - 1),
        ],
    )  # fmt: skip


@asks("2.2.1 platform")
def platform(draw: Draw) -> Task:
    """Mobility of a platform on equal legs, and its idle freedoms."""
    legs, kind = draw.choice((3, 6) if draw.level == 1 else (3, 4, 5, 6)), draw.choice(sorted(LEGS))
    freedoms, links = LEGS[kind], 2 + 2 * legs
    M = int(gruebler_count(links, list(freedoms) * legs, "spatial").mobility)
    idle = legs if kind == "SPS" else 0
    mistakes: dict[str, Any] = {} if legs == 3 else {"planar_rule": M - 3 * (1 - legs)}
    return Task(
        {"legs": legs, "kind": kind, "links": links, "joints": 3 * legs, "total": legs * sum(freedoms), "M": M,
         "idle": idle, "each": sum(freedoms)},
        [
            ask("mobility", M, ground_moves=M + 6, ground_left_out=M - 6, **mistakes),
            ask("idle", idle),
        ],
    )  # fmt: skip


@asks("3.2.2 four contacts")
def four_contacts(draw: Draw) -> Task:
    """A rectangle between four frictionless pins: one wrench, and force closure."""
    w, h = draw.number(0.4, 1.2), draw.number(0.3, 0.9)
    x, y = draw.numbers(2, 0.1, w - 0.1, 0.05), draw.numbers(2, 0.1, h - 0.1, 0.05)
    points = np.array([[x[0], 0.0], [w, y[0]], [x[1], h], [0.0, y[1]]])
    normals = np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]])
    grasp = Grasp([Contact(p, n) for p, n in zip(points, normals, strict=True)])
    wrenches, k = np.asarray(grasp.matrix()).T, draw.whole(0, 3)
    (m, fx, fy), (px, py), (nx, ny) = wrenches[k], points[k], normals[k]
    return Task(
        {"w": w, "h": h, **{f"p{i + 1}": point for i, point in enumerate(points)}, "k": k + 1, "n": normals[k],
         "moments": wrenches[:, 0], "F": wrenches[k]},
        [
            ask("contact_wrench", wrenches[k], cross_order=[-m, fx, fy], outward=[-m, -fx, -fy],
                  dot_for_cross=[px * nx + py * ny, fx, fy], moment_last=[fx, fy, m]),
            ask("closure", bool(grasp.closure())),
        ],
    )  # fmt: skip


@asks("3.3.3 two fingers")
def two_contacts(draw: Draw) -> Task:
    """Two fingers with friction: friction angle and Nguyen's test."""
    mu, width, shift = draw.number(0.3, 1.0, 0.05), draw.number(0.4, 1.0), draw.number(-0.5, 0.5, 0.05)
    tilt = 0 if draw.level == 1 else draw.whole(-6, 6) * 5
    normal = np.array([-np.cos(np.radians(tilt)), -np.sin(np.radians(tilt))])
    verdict = two_fingers(Contact([0.0, 0.0], [1.0, 0.0], mu), Contact([width, shift], normal, mu))
    line = np.degrees(np.arctan2(shift, width))
    beta = float(np.arctan(mu))
    return Task(
        {"mu": mu, "width": width, "shift": shift, "tilt": tilt, "line": line, "off": line - tilt,
         "beta": np.degrees(beta)},
        [
            ask("friction_angle", beta, "rad", sine_for_tangent=np.arcsin(min(mu, 1.0)), mu_as_angle=mu,
                  cone_width=2 * beta),
            ask("closure", bool(verdict)),
        ],
    )  # fmt: skip


def _longer_way(r: Floats) -> Floats:
    """The same rotation the longer way round."""
    return r - 2 * pi * r / np.linalg.norm(r)


def _about(order: str, angles: Floats) -> Floats:
    return np.asarray(Rotation.from_euler(angles, order))


@asks("4.1 pole")
def pole(draw: Draw) -> Task:
    """The pole of a planar motion."""
    theta, p = draw.degrees(20, 150), draw.numbers(2, -3, 3, 0.5)
    t = np.radians(theta)

    def fixed_point(c: float, s: float) -> Floats:
        return np.asarray(np.linalg.solve([[1 - c, s], [-s, 1 - c]], p), dtype=np.float64)

    T = np.array([[np.cos(t), -np.sin(t), p[0]], [np.sin(t), np.cos(t), p[1]], [0.0, 0.0, 1.0]])
    x, y, w = planar.pole(T)
    q = np.array([x, y]) / w
    return Task(
        {"theta": theta, "p": p, "matrix": np.eye(2) - T[:2, :2], "q": q},
        [ask("pole", q, "m", not_inverted=p - T[:2, :2] @ p, rotation_reversed=fixed_point(np.cos(t), -np.sin(t)),
               middle=p / 2,
               degrees=fixed_point(np.cos(theta), np.sin(theta)))],
    )  # fmt: skip


@asks("4.2.3 five forms")
def five_forms(draw: Draw) -> Task:
    """ZYX Euler angles as a matrix, a quaternion, exponential coordinates and ZYZ angles."""
    angles = np.array([draw.degrees(20, 150), draw.degrees(20, 75), draw.degrees(20, 150)])
    turns = np.radians(angles)
    R, reverse, raw = _about("ZYX", turns), _about("XYZ", turns[::-1]), _about("ZYX", angles % (2 * pi))
    q, r = np.asarray(Rotation(R).quaternion()), np.asarray(Rotation(R).log())
    q_reverse, theta = np.asarray(Rotation(reverse).quaternion()), float(np.linalg.norm(r))
    a, b, c = Rotation(R).euler("ZYZ")
    whole = np.concatenate([[np.cos(theta)], np.sin(theta) * r / theta])
    return Task(
        {"alpha": angles[0], "beta": angles[1], "gamma": angles[2], "R": R, "q": q, "theta": theta, "r": r,
         "c": (np.trace(R) - 1) / 2},
        [
            ask("R", R, rotations_reversed=reverse, transposed=R.T, degrees=raw),
            ask("q", q, twin=np.negative, rotations_reversed=q_reverse, transposed=q * [1, -1, -1, -1],
                  scalar_last=np.roll(q, -1), full_angle=whole),
            ask("r", r, twin=_longer_way, transposed=-r, axis_only=r / theta,
                  degrees=np.degrees(r)),
            ask("zyz", [a, b, c], "rad", twin=lambda e: [e[0] + pi, -e[1], e[2] + pi], transposed=[-c, -b, -a],
                  angles_reversed=[c, b, a]),
        ],
    )  # fmt: skip


def _direction(draw: Draw) -> Floats:
    axis = np.array(draw.choice(AXES)[:: draw.choice((1, -1))], float)
    return axis / np.linalg.norm(axis)


@asks("4.2.5.2 exponential")
def exponential(draw: Draw) -> Task:
    """Rodrigues' formula: the matrix of a rotation about an axis."""
    w, theta = _direction(draw), draw.degrees(20, 150)
    t = np.radians(theta)
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])

    def rodrigues(s: float, c: float) -> Floats:
        return np.eye(3) + s * K + c * K @ K

    R = np.asarray(Rotation.exp(t * w))
    return Task(
        {"axis": w, "theta": theta, "K": K, "K2": K @ K,
         "s": np.sin(t), "v": 1 - np.cos(t), "R": R},
        [ask("R", R, transposed=R.T, not_squared=R - (1 - np.cos(t)) * (K @ K - K), cosine_sign=rodrigues(np.sin(t),
               1 + np.cos(t)),
               term_sign=rodrigues(np.sin(t), np.cos(t) - 1), sine_cosine=rodrigues(np.cos(t), 1 - np.sin(t)),
               degrees=rodrigues(np.sin(theta), 1 - np.cos(theta)))],
    )  # fmt: skip


@asks("4.2.5.3 logarithm")
def logarithm(draw: Draw) -> Task:
    """Exponential coordinates of a rotation matrix."""
    w, theta = _direction(draw), abs(draw.degrees(30, 150))
    t = np.radians(theta)
    R = np.asarray(Rotation.exp(t * w))
    r = np.asarray(Rotation(R).log())
    return Task(
        {"R": R, "trace": np.trace(R), "theta": t, "s": 2 * np.sin(t), "w": w, "r": r},
        [
            ask("angle", t, "rad", twin=np.negative, half_trace=np.arccos(np.clip(np.trace(R) / 2, -1, 1)),
                  sine_for_cosine=np.arcsin(np.clip((np.trace(R) - 1) / 2, -1, 1))),
            ask("r", r, twin=_longer_way, transposed=-r, axis_only=w, no_half=2 * np.sin(t) * r,
                  degrees=theta * w),
        ],
    )  # fmt: skip


def _pose(draw: Draw) -> tuple[Floats, int, Floats]:
    """A pose in the plane (level 1) or about a random axis of the frame, its angle [degrees] and origin."""
    theta, p = draw.degrees(), draw.numbers(3, -1.5, 1.5) * [1.0, 1.0, draw.level > 1]
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.exp(np.radians(theta) * np.array([0.0, 0.0, 1.0])), p
    return T, theta, p


@asks("4.3.2 frames")
def frames(draw: Draw) -> Task:
    """A frame seen from another one: T_bc from T_ab and T_ac."""
    (T_ab, beta, p_b), (T_ac, gamma, p_c) = _pose(draw), _pose(draw)
    T_bc = np.asarray(Pose(T_ab).inverse() @ Pose(T_ac))
    R, p = T_bc[:3, :3], T_bc[:3, 3]
    forward, turned, back = (T_ab @ T_ac)[:3], T_ab[:3, :3].T @ p_c - p_b, (T_ac @ np.linalg.inv(T_ab))[:3]
    return Task(
        {"beta": beta, "gamma": gamma, "p_b": p_b, "p_c": p_c, "d": p_c - p_b, "R": R, "p": p,
         "Rt": T_ab[:3, :3].T, "turn": gamma - beta},
        [
            ask("p", p, "m", not_inverted=forward[:, 3], origin_not_turned=turned, order=back[:, 3],
                  not_turned=p_c - p_b,
                  transposed=T_ab[:3, :3] @ (p_c - p_b)),
            ask("R", R, not_inverted=forward[:, :3], transposed=R.T),
        ],
    )  # fmt: skip


@asks("4.3.3.1 screw")
def screw(draw: Draw) -> Task:
    """The six numbers of a screw from direction, point and pitch."""
    w = np.eye(3)[draw.whole(0, 2)] * draw.choice((1, -1)) if draw.level == 1 else _direction(draw)
    q, h = draw.numbers(3, -2, 2, 0.5), draw.number(0.1, 0.9)
    S = np.asarray(ScrewAxis.of(w, q, h))
    moment = np.cross(w, q)
    return Task(
        {"w": w, "q": q, "h": h, "cross": -moment, "hw": h * w, "S": S},
        [ask("S", S, cross_order=[*w, *(moment + h * w)], point_as_moment=[*w, *q], no_pitch=[*w, *-moment],
               pitch_sign=[*w, *(-moment - h * w)], pitch_alone=[*w, *(h * w)])],
    )  # fmt: skip


@asks("4.4.2 twist")
def twist(draw: Draw) -> Task:
    """The twist of a moving frame in two frames."""
    w, rate, (T, theta, p) = draw.numbers(3, -2, 2, 0.5), draw.numbers(3, -2, 2, 0.5), _pose(draw)
    R = T[:3, :3]
    V_s = np.concatenate([w, rate - np.cross(w, p)])
    V_b = np.asarray(Twist(V_s).seen_from(Pose(T).inverse()))
    return Task(
        {"w": w, "rate": rate, "p": p, "theta": theta, "cross": np.cross(w, p), "V_s": V_s, "V_b": V_b},
        [
            ask("V_s", V_s, rate_of_origin=[*w, *rate], cross_order=[*w, *(rate + np.cross(w, p))]),
            ask("V_b", V_b, transposed=[*(R @ w), *(R @ rate)], not_turned=[*w, *rate],
                  only_turned=[*(R.T @ w), *(R.T @ V_s[3:])]),
        ],
    )  # fmt: skip


@asks("4.4.3 wrench")
def wrench(draw: Draw) -> Task:
    """The wrench of a force in two frames."""
    f, r, (T, theta, p) = draw.numbers(3, -9, 9, 1.0), draw.numbers(3, -1, 1), _pose(draw)
    F_s = np.concatenate([np.cross(r, f), f])
    F_b = np.asarray(Wrench(F_s).seen_from(Pose(T).inverse()))
    inverse = np.asarray(Pose(T).inverse().adjoint())
    R = T[:3, :3]
    return Task(
        {"f": f, "r": r, "theta": theta, "p": p, "m": F_s[:3], "F_s": F_s, "F_b": F_b, "arm": r - p},
        [
            ask("F_s", F_s, cross_order=[*np.cross(f, r), *f], no_moment=[0.0, 0.0, 0.0, *f]),
            ask("F_b", F_b, twist_rule=inverse @ F_s, not_inverted=inverse.T @ F_s, only_turned=[*(R.T @ F_s[:3]),
                  *(R.T @ f)],
                  only_shifted=[*np.cross(r - p, f), *f]),
        ],
    )  # fmt: skip
