"""Families of exercises for chapter 4: rotations, rigid motions, screws, wrenches."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.family import Draw, Task, asks
from mafsil.book.judging import ask
from mafsil.geometry import Pose, Rotation, ScrewAxis, Twist, Wrench, planar
from mafsil.geometry.matrix_exponential import exponential as matrix_exponential

AXES = ((1, 2, 2), (2, -1, 2), (-2, 2, 1), (2, 3, 6), (6, -2, 3), (1, -4, 8))
"""Vectors of whole length."""


def _longer_way(r: Floats) -> Floats:
    """The same rotation the longer way round."""
    return r - 2 * pi * r / np.linalg.norm(r)


def _about_axis(axis: str, angle: float) -> Floats:
    return np.asarray(Rotation.exp(angle * np.eye(3)["XYZ".index(axis)]))


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


@asks("4.2.2 product")
def product(draw: Draw) -> Task:
    """Two rotations about different axes of the moving frame."""
    axes, angles = draw.choice(("XY", "YX", "XZ", "ZX", "YZ", "ZY")), np.array([draw.degrees(), draw.degrees()])
    R_ab, R_bc = (_about_axis(axis, turn) for axis, turn in zip(axes, np.radians(angles), strict=True))
    raw = _about_axis(axes[0], angles[0]) @ _about_axis(axes[1], angles[1])
    facts = {"first": axes[0].lower(), "second": axes[1].lower(), "t1": angles[0], "t2": angles[1]}
    return Task(
        facts | {"R_ab": R_ab, "R_bc": R_bc, "R": R_ab @ R_bc},
        [ask("R", R_ab @ R_bc, order=R_bc @ R_ab, transposed=(R_ab @ R_bc).T, degrees=raw)],
    )


@asks("4.2.4 fixed axes")
def fixed_axes(draw: Draw) -> Task:
    """Roll, pitch and yaw as a matrix."""
    angles = np.array([draw.degrees(20, 150), draw.degrees(20, 75), draw.degrees(20, 150)])
    R = np.asarray(Rotation.from_rpy(np.radians(angles)))
    return Task(
        {"roll": angles[0], "pitch": angles[1], "yaw": angles[2], "R": R,
         "Rx": _about_axis("X", np.radians(angles[0]))},
        [ask("R", R, rotations_reversed=_about("XYZ", np.radians(angles)), angles_reversed=_about("ZYX",
               np.radians(angles)), degrees=_about("ZYX", angles[::-1] % (2 * pi)))],
    )  # fmt: skip


@asks("4.2.6 quaternions")
def quaternions(draw: Draw) -> Task:
    """The quaternion of a rotation about an axis, and of another one after it about z."""
    w, theta, turn = _direction(draw), draw.degrees(20, 150), draw.degrees(20, 150)
    first, second = Rotation.exp(np.radians(theta) * w), Rotation.exp([0.0, 0.0, np.radians(turn)])
    q, both, reverse = (np.asarray(R.quaternion()) for R in (first, first @ second, second @ first))
    t = np.radians(theta)
    return Task(
        {"w": w, "theta": theta, "turn": turn, "c": np.cos(t / 2), "s": np.sin(t / 2), "q": q, "both": both},
        [
            ask("q", q, twin=np.negative, full_angle=[np.cos(t), *(np.sin(t) * w)], scalar_last=np.roll(q, -1)),
            ask("q_product", both, twin=np.negative, order=reverse),
        ],
    )


@asks("4.3.1 point")
def point(draw: Draw) -> Task:
    """A point known in one frame, in another."""
    (T, theta, p), x = _pose(draw), draw.numbers(3, -2, 2, 0.5)
    R = T[:3, :3]
    return Task(
        {"theta": theta, "p": p, "x": x, "turned": R @ x, "R": R},
        [ask("p", R @ x + p, "m", not_turned=x + p, transposed=R.T @ x + p, origin_left_out=R @ x,
               not_inverted=R.T @ (x - p))],
    )  # fmt: skip


@asks("4.3.3.2 pitch", unknown="theta")
def pitch(draw: Draw) -> Task:
    """Pitch and a point of the axis of a pose turned about z."""
    theta, p = draw.degrees(20, 150), draw.numbers(3, -1.5, 1.5)
    t = np.radians(theta)
    q = planar_pole(t, p[:2])
    return Task(
        {"theta": theta, "p": p, "t": t, "q": q, "h": p[2] / t},
        [
            ask("pitch", p[2] / t, degrees=p[2] / theta, turns_a_second=p[2] / t * 2 * pi),
            ask("axis_point", q, "m", rotation_reversed=planar_pole(-t, p[:2]), middle=p[:2] / 2),
        ],
    )


def planar_pole(angle: float, p: Floats) -> Floats:
    """The point that a rotation and a displacement of the plane leave where it is."""
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.asarray(np.linalg.solve(np.eye(2) - R, p), np.float64)


@asks("4.3.3.3 change of frame")
def change_of_frame(draw: Draw) -> Task:
    """A joint screw seen from another frame."""
    (T, theta, p), q = _pose(draw), draw.numbers(3, -1, 1)
    w = np.eye(3)[draw.whole(0, 2)]
    S_b, R = np.concatenate([w, -np.cross(w, q)]), T[:3, :3]
    S_a = np.asarray(Pose(T).adjoint()) @ S_b
    back = np.asarray(Pose(T).inverse().adjoint()) @ S_b
    return Task(
        {"theta": theta, "p": p, "S_b": S_b, "w_a": R @ w, "shift": np.cross(p, R @ w), "S_a": S_a},
        [ask("S_a", S_a, not_inverted=back, only_turned=[*(R @ w), *(R @ S_b[3:])], cross_order=[*(R @ w),
               *(R @ S_b[3:] - np.cross(p, R @ w))])],
    )  # fmt: skip


@asks("4.4.1 body rate")
def body_rate(draw: Draw) -> Task:
    """An angular velocity in the moving frame."""
    axis, theta, w = draw.choice("XYZ"), draw.degrees(), draw.numbers(3, -2, 2, 0.5)
    R = _about_axis(axis, np.radians(theta))
    return Task(
        {"axis": axis.lower(), "theta": theta, "w": w, "R": R, "Rt": R.T},
        [ask("omega_b", R.T @ w, transposed=R @ w, not_turned=w)],
    )


@asks("4.2.1 third column")
def third_column(draw: Draw) -> Task:
    """The third column of a rotation matrix from the first two."""
    R = _about("ZYX", np.radians([draw.degrees(20, 150), draw.degrees(20, 75), draw.degrees(20, 150)]))
    x, y, z = R.T
    return Task(
        {"x": x, "y": y, "z": z},
        [ask("column", z, cross_order=np.cross(y, x), row_for_column=R[2], columns_added=x + y)],
    )


@asks("4.2.5.1 oscillator")
def oscillator(draw: Draw) -> Task:
    """State of a linear differential equation after a time."""
    w, t, x0 = draw.number(0.5, 3, 0.5), draw.number(0.2, 1.5), draw.numbers(2, -2, 2, 0.5)
    A = np.array([[0.0, 1.0], [-w * w, 0.0]])
    return Task(
        {"A": A, "w": w, "t": t, "x0": x0, "c": np.cos(w * t), "s": np.sin(w * t), "E": matrix_exponential(A, t)},
        [ask("state", matrix_exponential(A, t) @ x0, first_order=x0 + t * A @ x0,
             time_reversed=matrix_exponential(A, -t) @ x0, transposed=matrix_exponential(A, t).T @ x0,
             entrywise=np.exp(A * t) @ x0)],
    )  # fmt: skip
