"""Families of exercises for whole arms, chapters 5 to 10: frames, closed chains, equations of motion, laws."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.exercises_of_mechanisms import LEGS
from mafsil.book.family import Draw, Task, asks
from mafsil.book.judging import ask
from mafsil.geometry import Pose, Rotation, ScrewAxis, Twist
from mafsil.mobility import gruebler_count
from mafsil.model.denavit_hartenberg import DHRow, dh_parameters


def _pose_about_z(angle: float, p: Floats) -> Floats:
    """A pose turned about z [degrees]."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.exp([0.0, 0.0, np.radians(angle)]), p
    return T


def _columns(draw: Draw) -> Floats:
    """A 2x2 Jacobian far from singular."""
    J = draw.numbers(4, -1, 1).reshape(2, 2)
    return J if abs(np.linalg.det(J)) > 0.2 else J + np.eye(2) * np.sign(np.trace(J) or 1.0) * 1.5


@asks("5.1.3 condition")
def condition(draw: Draw) -> Task:
    """The twist of a link in a rotation matrix, and whether four numbers describe another one."""
    alpha, theta, tilt = draw.degrees(20, 70), draw.degrees(20, 70), draw.choice((0, 20))
    R = DHRow(0.0, np.radians(alpha), 0.0, np.radians(theta)).transform("modified")
    other = R.copy()
    other[:3, :3] = np.asarray(Rotation.exp([0.0, np.radians(tilt), 0.0])) @ R[:3, :3]
    a = float(np.radians(alpha))
    return Task(
        {"R": R[:3, :3], "other": other[:3, :3], "r23": R[1, 2], "r33": R[2, 2], "r13": other[0, 2]},
        [
            ask("alpha", a, "rad", sine_cosine=pi / 2 - a, alpha_sign=-a),
            ask("four_enough", dh_parameters(other) is not None),
        ],
    )


@asks("5.1.4 scara")
def scara(draw: Draw) -> Task:
    """Tip of a SCARA arm from its table."""
    L, h, d = draw.numbers(2, 0.2, 0.8), draw.number(0.4, 0.9), draw.number(0.05, 0.3, 0.05)
    first, second = draw.degrees(), draw.degrees()
    a, b = np.radians([first, second])
    rows = (DHRow(0.0, 0.0, h, a), DHRow(L[0], 0.0, 0.0, b), DHRow(L[1], pi, d, 0.0))
    p = np.linalg.multi_dot([row.transform("modified") for row in rows])[:3, 3]
    flat = [*(L[0] * np.array([np.cos(a), np.sin(a)]) + L[1] * np.array([np.cos(b), np.sin(b)])), p[2]]
    return Task(
        {"L": L, "h": h, "d": d, "t1": first, "t2": second, "sum": first + second, "p": p},
        [ask("p", p, "m", angles_not_summed=flat, stroke_up=[*p[:2], h + d], height_left_out=[*p[:2], -d])],
    )


@asks("5.2.1 product")
def product(draw: Draw) -> Task:
    """Tip of a chain of a revolute and a prismatic joint by the product of exponentials."""
    q, m, (theta, d) = draw.numbers(3, -1, 1), draw.numbers(3, -1, 1), (draw.degrees(), draw.number(0.1, 0.9))
    along = np.eye(3)[draw.whole(0, 1)]
    turn = np.asarray(ScrewAxis.of([0.0, 0.0, 1.0], q, 0.0))

    def tip(angle: float, stroke: float) -> Floats:
        T = Pose.exp(turn * angle) @ Pose.exp(np.concatenate([np.zeros(3), along]) * stroke) @ Pose.of(np.eye(3), m)
        return np.asarray(T)[:3, 3]

    t = float(np.radians(theta))
    return Task(
        {"q": q, "along": along, "m": m, "theta": theta, "d": d, "S": turn, "moved": m + d * along, "p": tip(t, d)},
        [ask("p", tip(t, d), "m", order=tip(t, 0.0) + d * along, rotation_reversed=tip(-t, d),
             home_left_out=tip(t, d) - Rotation.exp([0.0, 0.0, t]).turn(m), degrees=tip(theta % (2 * pi), d))],
    )  # fmt: skip


@asks("5.2.3 table to screw")
def table_to_screw(draw: Draw) -> Task:
    """The screw of the second joint at zero from the row of a table."""
    alpha, a, d = draw.choice((-90, -60, 30, 60, 90)), draw.number(0.2, 0.9), draw.number(0.2, 0.9)
    first = DHRow(0.0, 0.0, d, 0.0).transform("modified") @ DHRow(a, np.radians(alpha), 0.0, 0.0).transform("modified")
    w, q = first[:3, 2], first[:3, 3]
    S = np.asarray(Twist(np.eye(6)[2]).seen_from(Pose(first)))
    mirrored = w * [1.0, -1.0, 1.0]
    return Task(
        {"alpha": alpha, "a": a, "d": d, "w": w, "q": q, "cross": np.cross(w, q)},
        [ask("S", S, cross_order=[*w, *np.cross(w, q)], point_as_moment=[*w, *q],
             alpha_sign=[*mirrored, *-np.cross(mirrored, q)])],
    )  # fmt: skip


@asks("5.2.4 body screw")
def body_screw(draw: Draw) -> Task:
    """A space screw in the tip frame at zero."""
    angle, p, q = draw.degrees(), draw.numbers(3, -1, 1), draw.numbers(3, -1, 1)
    w, M = np.eye(3)[draw.whole(0, 2)], _pose_about_z(angle, p)
    S, R = np.asarray(ScrewAxis.of(w, q, 0.0)), M[:3, :3]
    B = np.asarray(Pose(M).inverse().adjoint() @ S)
    return Task(
        {"angle": angle, "p": p, "S": S, "w_b": R.T @ w, "point": R.T @ (q - p), "B": B},
        [ask("B", B, not_inverted=np.asarray(Pose(M).adjoint()) @ S, only_turned=[*(R.T @ w), *(R.T @ S[3:])],
             only_shifted=[*w, *-np.cross(w, q - p)])],
    )  # fmt: skip


@asks("6.1.3 columns")
def columns(draw: Draw) -> Task:
    """A column of the body Jacobian of a planar arm in the space frame."""
    angle, p, B = draw.degrees(), draw.numbers(2, -1, 1), np.array([1.0, *draw.numbers(2, -1, 1)])
    pose = Pose(_pose_about_z(angle, np.array([*p, 0.0])))

    def seen(A: Floats) -> Floats:
        return (A @ [0.0, 0.0, *B, 0.0])[2:5]

    right, R = seen(np.asarray(pose.adjoint())), np.asarray(pose)[:2, :2]
    return Task(
        {"angle": angle, "p": p, "B": B, "turned": R @ B[1:], "shift": np.array([p[1], -p[0]]), "S": right},
        [ask("space_column", right, not_inverted=seen(np.asarray(pose.inverse().adjoint())),
             only_turned=[1.0, *(R @ B[1:])], only_shifted=[1.0, B[1] + p[1], B[2] - p[0]])],
    )  # fmt: skip


@asks("6.2.1 wrench to torques")
def wrench_to_torques(draw: Draw) -> Task:
    """Torques that hold a planar wrench."""
    J, F = np.vstack([[1.0, 1.0], draw.numbers(4, -1, 1).reshape(2, 2)]), draw.numbers(3, -9, 9, 1.0)
    return Task(
        {"J": J, "F": F, "Jt": J.T, "tau": J.T @ F},
        [ask("tau", J.T @ F, "N m", moment_left_out=J[1:].T @ F[1:], moment_last=J.T @ np.roll(F, 1),
             force_left_out=[F[0], F[0]])],
    )  # fmt: skip


@asks("6.2.2 torques to force")
def torques_to_force(draw: Draw) -> Task:
    """The force at the tip from the torques of two joints."""
    J, tau = _columns(draw), draw.numbers(2, -9, 9, 1.0)
    f = np.linalg.solve(J.T, tau)
    return Task(
        {"J": J, "tau": tau, "Jt": J.T, "f": f},
        [ask("tip_force", f, "N", transpose_left_out=np.linalg.solve(J, tau), no_solve=J @ tau)],
    )


@asks("7.1.2 circle and sphere")
def circle_and_sphere(draw: Draw) -> Task | None:
    """Angles that bring a point of a circle to a given distance from another point."""
    r, q = draw.number(0.4, 1.2), draw.numbers(3, -1, 1)
    c = draw.number(0.4, 1.8)
    side = float(np.hypot(q[0], q[1]))
    D = (r * r + float(q @ q) - c * c) / (2 * r * side)
    if abs(D) > 0.9 or min(abs(q[0]), abs(q[1])) < 0.15:
        return None
    middle, half = float(np.arctan2(q[1], q[0])), float(np.arccos(D))
    wrong = float(np.arctan2(q[0], q[1]))
    return Task(
        {"r": r, "q": q, "c": c, "side": side, "D": D, "middle": middle, "half": half},
        [ask("angles", [[middle + half], [middle - half]], "rad", unordered=True, middle_left_out=[[half], [-half]],
             quotient_inverted=[[wrong + half], [wrong - half]],
             sine_for_cosine=[[middle + pi / 2 - half], [middle - pi / 2 + half]])],
    )  # fmt: skip


@asks("8.0 passive joints")
def passive_joints(draw: Draw) -> Task | None:
    """Driven and passive freedoms of a platform."""
    legs, kind = draw.choice((3, 4, 6)), draw.choice(sorted(set(LEGS) - {"SPS"}))
    each, links = sum(LEGS[kind]), 2 + 2 * legs
    driven = int(gruebler_count(links, list(LEGS[kind]) * legs, "spatial").mobility)
    if driven < 1:
        return None
    return Task(
        {"legs": legs, "kind": kind, "each": each, "total": legs * each, "driven": driven, "loops": legs - 1},
        [
            ask("driven", driven, ground_moves=driven + 6, ground_left_out=driven - 6),
            ask("passive", legs * each - driven, joints_for_freedoms=3 * legs - driven, driven_included=legs * each),
        ],
    )


@asks("8.1.2 leg")
def stewart_leg(draw: Draw) -> Task:
    """Length of a leg of a Stewart-Gough platform."""
    angle, p = draw.degrees(15, 75), draw.numbers(3, -0.4, 0.4) + np.array([0.0, 0.0, 1.0])
    a, b = np.append(draw.numbers(2, -1, 1), 0.0), np.append(draw.numbers(2, -0.5, 0.5), 0.0)
    R = _pose_about_z(angle, p)[:3, :3]
    tip = np.asarray(Pose(_pose_about_z(angle, p))) @ np.append(b, 1.0)
    length = float(np.linalg.norm(tip[:3] - a))
    return Task(
        {"angle": angle, "p": p, "a": a, "b": b, "turned": R @ b, "leg": tip[:3] - a},
        [ask("leg_length", length, "m", not_turned=np.linalg.norm(p + b - a),
             transposed=np.linalg.norm(p + R.T @ b - a), squared=length**2, base_left_out=np.linalg.norm(p + R @ b))],
    )  # fmt: skip


@asks("8.1.3 conditions")
def conditions(draw: Draw) -> Task:
    """Conditions of closure and freedoms of a mechanism of several legs."""
    legs, each = draw.whole(3, 3 + draw.level), draw.whole(5, 6)
    d = legs * each - 6 * (legs - 1)
    return Task(
        {"legs": legs, "each": each, "total": legs * each, "closure": 6 * (legs - 1)},
        [
            ask("closure_conditions", 6 * (legs - 1), loop_of_each_leg=6 * legs, planar_rule=3 * (legs - 1)),
            ask("freedoms", d, loop_of_each_leg=d - 6, planar_rule=legs * each - 3 * (legs - 1)),
        ],
    )


@asks("8.2.2 passive rates")
def passive_rates(draw: Draw) -> Task:
    """Rates of passive joints from the closure differentiated."""
    H_p, H_a, rate = _columns(draw), draw.numbers(2, -1, 1), draw.number(0.5, 3, 0.5)
    rates = -np.linalg.solve(H_p, H_a * rate)
    return Task(
        {"H_p": H_p, "H_a": H_a, "rate": rate, "right": -H_a * rate, "rates": rates},
        [ask("passive_rates", rates, no_solve=-H_p @ H_a * rate, transposed=-np.linalg.solve(H_p.T, H_a * rate),
             rate_left_out=rates / rate)],
    )  # fmt: skip


@asks("9.0 equation")
def equation(draw: Draw) -> Task:
    """Torques of two joints from mass matrix, velocity terms and acceleration."""
    M = np.array([[draw.number(3, 6, 0.5), draw.number(0.3, 1)], [0.0, draw.number(1, 2.5, 0.5)]])
    M[1, 0] = M[0, 1]
    h, qdd = draw.numbers(2, -9, 9, 0.5), draw.numbers(2, -3, 3, 0.5)
    tau = M @ qdd + h
    return Task(
        {"M": M, "h": h, "qdd": qdd, "inertial": M @ qdd, "tau": tau},
        [ask("tau", tau, "N m", no_velocity_terms=M @ qdd, velocity_sign=M @ qdd - h,
             cross_left_out=np.diag(M) * qdd + h, forward_for_inverse=np.linalg.solve(M, h - qdd))],
    )  # fmt: skip


@asks("9.3 outward pass")
def outward_pass(draw: Draw) -> Task:
    """Acceleration of the end of a link as the recursion carries it: gravity as an upward acceleration of the base."""
    L, angle, qd, qdd = draw.number(0.4, 1.2), draw.degrees(20, 70), draw.number(0.5, 3, 0.5), draw.number(-4, 4, 0.5)
    t = np.radians(angle)
    out, across, up = np.array([np.cos(t), np.sin(t)]), np.array([-np.sin(t), np.cos(t)]), np.array([0.0, 9.81])
    inward = -L * qd**2 * out
    a = L * qdd * across + inward + up
    return Task(
        {"L": L, "angle": angle, "qd": qd, "qdd": qdd, "across": L * qdd * across, "inward": inward, "a": a},
        [ask("elbow_acceleration", a, no_gravity=a - up, gravity_sign=a - 2 * up, centripetal_left_out=a - inward,
             centripetal_sign=a - 2 * inward)],
    )  # fmt: skip


@asks("9.4 rate of M", unknown="rate")
def rate_of_mass_matrix(draw: Draw) -> Task:
    """Rate of the first entry of the mass matrix of a 2R arm with point masses."""
    m, (a, b), angle, rate = (
        draw.number(0.5, 3),
        draw.numbers(2, 0.4, 1),
        abs(draw.degrees(20, 80)),
        draw.number(0.5, 3),
    )
    value = -2 * m * a * b * np.sin(np.radians(angle)) * rate
    return Task(
        {"m": m, "l1": a, "l2": b, "angle": angle, "rate": rate, "h": m * a * b * np.sin(np.radians(angle))},
        [ask("M_rate", value, half_coriolis=value / 2, rate_left_out=value / rate,
             sine_cosine=-2 * m * a * b * np.cos(np.radians(angle)) * rate)],
    )  # fmt: skip


@asks("9.6 tip mass", unknown="inertia r")
def tip_mass(draw: Draw) -> Task:
    """Mass that a polar arm shows at its tip across its direction."""
    inertia, m, r = draw.number(0.5, 4), draw.number(1, 5, 0.5), draw.number(0.3, 1.5, 0.05)
    whole = inertia + m * r * r
    return Task(
        {"inertia": inertia, "m": m, "r": r, "whole": whole, "across": whole / r**2},
        [ask("tip_mass", whole / r**2, "kg", mass_left_out=inertia / r**2, not_inverted=whole * r**2,
             shift_not_squared=whole / r)],
    )  # fmt: skip


@asks("10.1 encoder", unknown="period")
def encoder(draw: Draw) -> Task:
    """Least step of the angle and of the velocity that an encoder behind a gear sees."""
    lines, ratio, period = draw.choice((500, 1000, 2000)), draw.choice((10, 50, 100)), draw.number(1, 9, 0.5)
    step = 2 * pi / (4 * lines * ratio)
    return Task(
        {"lines": lines, "ratio": ratio, "period": period, "counts": 4 * lines * ratio, "step": step},
        [
            ask("angle_step", step, fourfold_left_out=4 * step, gear_left_out=ratio * step),
            ask("rate_step", 1000 * step / period, period_times=step * period / 1000, milliseconds=step / period,
                gear_left_out=1000 * ratio * step / period),
        ],
    )  # fmt: skip


@asks("10.2.2 certificate")
def certificate(draw: Draw) -> Task:
    """An energy function of a PD loop of two joints, and its rate."""
    kp, kd, M = draw.numbers(2, 5, 40, 5.0), draw.numbers(2, 1, 6, 0.5), draw.numbers(2, 0.5, 3, 0.5)
    e, qd = draw.numbers(2, -1, 1), draw.numbers(2, -2, 2, 0.5)
    spring, motion = float(kp @ e**2) / 2, float(M @ qd**2) / 2
    return Task(
        {"kp": kp, "kd": kd, "M": M, "e": e, "qd": qd, "spring": spring, "motion": motion},
        [
            ask("certificate", spring + motion, not_halved=2 * (spring + motion), motion_left_out=spring,
                spring_left_out=motion),
            ask("certificate_rate", -float(kd @ qd**2), halved=-float(kd @ qd**2) / 2,
                rates_not_squared=-float(kd @ qd)),
        ],
    )  # fmt: skip


@asks("10.2.3 tip law")
def tip_law(draw: Draw) -> Task:
    """Torques of a PD law at the tip."""
    J, kp, kd = _columns(draw), draw.number(20, 200, 10.0), draw.number(5, 30, 5.0)
    e, ed = draw.numbers(2, -0.2, 0.2, 0.02), draw.numbers(2, -0.5, 0.5)
    f = kp * e + kd * ed
    return Task(
        {"J": J, "kp": kp, "kd": kd, "e": e, "ed": ed, "f": f, "Jt": J.T, "tau": J.T @ f},
        [ask("tau", J.T @ f, "N m", not_transposed=J @ f, damping_left_out=J.T @ (kp * e),
             velocity_sign=J.T @ (kp * e - kd * ed))],
    )  # fmt: skip


@asks("10.4.1 counting")
def counting(draw: Draw) -> Task | None:
    """How many natural and artificial constraints a contact task has."""
    n = draw.choice((3, 6))
    k = draw.whole(1, n - 1)
    return None if 2 * k == n else Task(
        {"n": n, "k": k, "free": n - k},
        [
            ask("natural_forces", n - k, fixed_directions=k, other_space=9 - n - k),
            ask("artificial", n, natural_counted=2 * n, free_directions=n - k),
        ],
    )  # fmt: skip


@asks("10.4.2 projector")
def projector(draw: Draw) -> Task | None:
    """The matrix that keeps the part of a force that moves the tip along a surface."""
    a, inertia = draw.numbers(2, -2, 2, 0.5), draw.numbers(2, 1, 5, 0.5)
    inverse = np.diag(1 / inertia)

    def part(weight: Floats) -> Floats:
        return np.eye(2) - np.outer(a, a @ weight) / (a @ weight @ a)

    P = part(inverse)
    return None if inertia[0] == inertia[1] else Task(
        {"a": a, "inertia": np.diag(inertia), "inverse": inverse, "scale": a @ inverse @ a, "P": P},
        [ask("projector", P, metric_left_out=part(np.eye(2)), other_part=np.eye(2) - P,
             metric_inverted=part(np.diag(inertia)))],
    )  # fmt: skip


@asks("10.6 repetition", unknown="share")
def repetition(draw: Draw) -> Task:
    """Error of a law that learns from each repetition of a motion."""
    error, share, count = draw.number(2, 20, 0.5), draw.number(0.2, 0.8, 0.05), draw.whole(2, 3 + draw.level)
    left = error * (1 - share) ** count
    return Task(
        {"error": error, "share": share, "count": count, "rest": 1 - share, "left": left},
        [ask("error_left", left, "mm", share_for_rest=error * share**count, one_too_few=left / (1 - share),
             gone=error - left)],
    )  # fmt: skip
