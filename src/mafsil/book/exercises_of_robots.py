"""Families of exercises for chapters 5 to 8: link parameters, tips, Jacobians, all solutions, assembly modes."""

from __future__ import annotations

from functools import cache, partial
from math import pi
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.family import Draw, Task, asks
from mafsil.book.judging import ask
from mafsil.derivation import Derivation
from mafsil.mobility import FourBar
from mafsil.model.denavit_hartenberg import DHRow, dh_parameters
from mafsil.model.library.textbook import planar2r, planar3r
from mafsil.parallel import PlanarThreeRPR
from mafsil.robot import Robot, as_robot

LENGTHS = (0.5, 0.8, 1.0)
"""Of links; few, so that few robots are compiled."""


@cache
def _arm(*lengths: float) -> Robot:
    return as_robot((planar2r if len(lengths) == 2 else planar3r)(lengths))


@cache
def _derivation(name: str, *lengths: float) -> Derivation:
    return _arm(*lengths).derive(name)


def _links(draw: Draw, count: int) -> tuple[float, ...]:
    return tuple(draw.choice(LENGTHS) for _ in range(count))


def _row(draw: Draw) -> tuple[DHRow, tuple[int, int]]:
    """A row of a table with its angles in degrees."""
    alpha, theta = draw.choice((-90, 90) if draw.level == 1 else (-90, 30, 60, 90)), draw.degrees(20, 150)
    row = DHRow(draw.number(0.1, 0.9), np.radians(alpha), draw.number(0.1, 0.9), np.radians(theta))
    return row, (alpha, theta)


@asks("5.1.1 link")
def link(draw: Draw) -> Task | None:
    """Link parameters of a pose between neighbouring frames."""
    row, (alpha, theta) = _row(draw)
    if row.a == row.d:
        return None
    T = row.transform("modified")
    seen = dh_parameters(T)
    assert seen is not None
    right = np.array([seen.alpha, seen.a, seen.d, seen.theta])
    return Task(
        {"T": T, "alpha": alpha, "theta": theta, "a": row.a, "d": row.d, "r23": T[1, 2], "r33": T[2, 2], "r11": T[0, 0],
         "r12": T[0, 1], "y": T[1, 3], "z": T[2, 3]},
        [ask("link", right, turns=[True, False, False, True], angles_swapped=right[[3, 1, 2, 0]],
               lengths_swapped=right[[0, 2, 1, 3]], alpha_sign=right * [-1, 1, 1, 1], theta_sign=right * [1, 1, 1, -1],
               depth_for_offset=[right[0], right[1], T[2, 3], right[3]])],
    )  # fmt: skip


@asks("5.1.2 table")
def table(draw: Draw) -> Task | None:
    """Tip of an arm from its table of link parameters."""
    drawn = [_row(draw) for _ in range(2 if draw.level == 1 else 3)]
    rows, q = [row for row, _ in drawn], [theta for _, (_, theta) in drawn]

    def tip(convention: str, turned: list[DHRow]) -> Floats:
        T = np.eye(4)
        for row in turned:
            T = T @ row.transform(convention)
        return T[:3, 3]

    raw = [DHRow(row.a, row.alpha, row.d, float(theta % (2 * pi))) for row, theta in zip(rows, q, strict=True)]
    listed = [
        [str(k + 1), str(alpha), str(row.a), str(row.d), str(theta)] for k, (row, (alpha, theta)) in enumerate(drawn)
    ]
    T = [row.transform("modified") for row in rows]
    return Task(
        {"rows": "; ".join(f"i = {i}: α = {al}°, a = {a} m, d = {d} m, θ = {th}°" for i, al, a, d, th in listed),
         "T1": T[0], "T2": T[1], "p": tip("modified", rows)},
        [ask("p", tip("modified", rows), "m", convention=tip("classic", rows), order=tip("modified", rows[::-1]),
               degrees=tip("modified", raw))],
    )  # fmt: skip


def _tip(lengths: Floats, q: Floats) -> Floats:
    at = np.cumsum(q)
    return np.array([lengths @ np.cos(at), lengths @ np.sin(at)])


@asks("5.0 planar arm")
def planar_arm(draw: Draw) -> Task:
    """Place and direction of the tip of a planar 3R arm."""
    lengths, angles = _links(draw, 3), np.array([draw.degrees(15, 120) for _ in range(3)])
    robot, q, L = _arm(*lengths), np.radians(angles), np.array(lengths)
    T, at = robot.forward_kinematics(q), np.cumsum(angles)
    p, raw = T[:2, 3], angles % (2 * pi)
    return Task(
        {"L": L, "angles": angles, "sum2": at[1], "sum3": at[2], "x": p[0], "y": p[1]},
        [
            ask("tip", p, "m", angles_not_summed=[L @ np.cos(q), L @ np.sin(q)], sine_cosine=p[::-1],
                  degrees=_tip(L, raw)),
            ask("phi", np.radians(at[2]), "rad", last_angle=q[2]),
        ],
        partial(_derivation, "fk", *lengths),
    )  # fmt: skip


def _point_jacobian(robot: Robot, q: Floats) -> Floats:
    """(2, n) of the tip point of a planar arm."""
    J, p = robot.jacobian_space(q), robot.forward_kinematics(q)[:3, 3]
    return (J[3:] + np.cross(J[:3].T, p).T)[:2]


@asks("6.1.1 jacobian")
def jacobian(draw: Draw) -> Task:
    """Jacobian of the tip point of a planar 2R arm, and the velocity."""
    lengths, angles, rates = _links(draw, 2), np.array([draw.degrees(), draw.degrees()]), draw.numbers(2, -2, 2, 0.5)
    robot, q = _arm(*lengths), np.radians(angles)
    J, raw = _point_jacobian(robot, q), angles % (2 * pi)
    (l1, l2), (c1, s1) = lengths, (np.cos(q[0]), np.sin(q[0]))
    p = robot.forward_kinematics(q)[:2, 3]
    one = np.column_stack([[-l1 * s1, l1 * c1], J[:, 1]])
    return Task(
        {"L1": l1, "L2": l2, "t1": angles[0], "t2": angles[1], "sum": angles.sum(), "rates": rates, "J": J,
         "v": J @ rates},
        [
            ask("J", J, last_link_left_out=one, sine_cosine=J[::-1] * [[-1], [1]], term_sign=J * [[-1], [1]],
                  position_for_column=np.column_stack([p, p - [l1 * c1, l1 * s1]]), degrees=_point_jacobian(robot,
                  raw)),
            ask("v", J @ rates, transposed=J.T @ rates, last_link_left_out=one @ rates,
                  rates_swapped=J @ rates[::-1]),
        ],
        partial(_derivation, "jacobian", *lengths),
    )  # fmt: skip


@asks("6.2 statics")
def statics(draw: Draw) -> Task:
    """Torques that hold a force at the tip of a planar 2R arm."""
    lengths, angles, f = _links(draw, 2), np.array([draw.degrees(), draw.degrees()]), draw.numbers(2, -20, 20, 1.0)
    robot, q = _arm(*lengths), np.radians(angles)
    J = _point_jacobian(robot, q)
    inverse = np.linalg.solve(J, f) if abs(np.linalg.det(J)) > 1e-6 else f
    return Task(
        {"L1": lengths[0], "L2": lengths[1], "t1": angles[0], "t2": angles[1], "f": f, "J": J, "tau": J.T @ f},
        [ask("tau", J.T @ f, "N m", not_transposed=J @ f, inverse_for_transpose=inverse,
               degrees=_point_jacobian(robot, angles % (2 * pi)).T @ f, force_swapped=J.T @ f[::-1])],
    )  # fmt: skip


@asks("6.3 singular")
def singular(draw: Draw) -> Task:
    """Manipulability of a planar 2R arm, and its singular angles."""
    lengths, angle = _links(draw, 2), draw.degrees()
    J = _point_jacobian(_arm(*lengths), np.radians([0.0, angle]))
    measure, product = abs(float(np.linalg.det(J))), float(np.prod(lengths))
    return Task(
        {"L1": lengths[0], "L2": lengths[1], "t2": angle, "w": measure, "product": product},
        [
            ask("measure", measure, "m²", sine_cosine=product * abs(np.cos(np.radians(angle))), squared=measure**2,
                  degrees=product * abs(np.sin(angle)), lengths_added=sum(lengths) * abs(np.sin(np.radians(angle)))),
            ask("singular_angles", [[0.0], [pi]], "rad", unordered=True, quarter_turns=[[pi / 2], [-pi / 2]]),
        ],
    )  # fmt: skip


@asks("6.4 ellipse")
def ellipse(draw: Draw) -> Task | None:
    """Semi-axes of the velocity ellipse of a planar 2R arm."""
    lengths, angles = _links(draw, 2), np.array([draw.degrees(), draw.degrees()])
    J = _point_jacobian(_arm(*lengths), np.radians(angles))
    axes = np.linalg.svd(J, compute_uv=False)
    if axes[1] < 0.1:
        return None
    column = axes[:, None]
    return Task(
        {"L1": lengths[0], "L2": lengths[1], "t1": angles[0], "t2": angles[1], "J": J, "JJ": J @ J.T,
         "squares": axes**2,
         "axes": axes},
        [
            ask("semi_axes", column, unordered=True, root_left_out=column**2, reciprocal=1 / column),
            ask("condition", axes[0] / axes[1], root_left_out=(axes[0] / axes[1]) ** 2, reciprocal=axes[1] / axes[0]),
        ],
    )  # fmt: skip


@asks("7.0 all solutions")
def all_solutions(draw: Draw) -> Task | None:
    """All configurations of a planar 3R arm for a pose of its tip."""
    lengths, angles = _links(draw, 3), np.array([draw.degrees(15, 120) for _ in range(3)])
    robot = _arm(*lengths)
    T = robot.forward_kinematics(np.radians(angles))
    rows = np.asarray(robot.ik_all(T).q).reshape(-1, 3)
    phi, (l1, l2, l3) = float(np.radians(angles.sum())), lengths
    w = T[:2, 3] - l3 * np.array([np.cos(phi), np.sin(phi)])
    reach = float(np.hypot(*w))
    if len(rows) != 2 or reach < 0.2 or abs(rows[0, 1]) < 0.3:
        return None
    inner = pi - np.abs(rows[:, 1]) * np.sign(rows[:, 1])
    tangent = np.column_stack([rows[:, 0] + pi, rows[:, 1], rows[:, 2] + pi])
    return Task(
        {"L": np.array(lengths), "x": T[0, 3], "y": T[1, 3], "phi": np.degrees(phi), "w": w, "reach": reach,
         "D": (reach**2 - l1**2 - l2**2) / (2 * l1 * l2), "q_1": rows[0], "q_2": rows[1]},
        [ask("solutions", rows, "rad", unordered=True, inner_angle=np.column_stack([rows[:, 0], inner, rows[:, 2]]),
               quadrant=tangent, last_angle=np.column_stack([rows[:, :2], [phi, phi]]),
               tip_for_wrist=_as_wrist(lengths, T, phi))],
        partial(_derivation, "ik", *lengths),
    )  # fmt: skip


def _as_wrist(lengths: tuple[float, ...], T: Floats, phi: float) -> Floats:
    """Two-link solutions if the tip were the wrist; where it is out of reach, nothing."""
    (l1, l2, _), (x, y) = lengths, T[:2, 3]
    D = (x * x + y * y - l1**2 - l2**2) / (2 * l1 * l2)
    if abs(D) > 1:
        return np.zeros((0, 3))
    t2 = np.arccos(D) * np.array([1.0, -1.0])
    t1 = np.arctan2(y, x) - np.arctan2(l2 * np.sin(t2), l1 + l2 * np.cos(t2))
    return np.column_stack([t1, t2, phi - t1 - t2])


@asks("7.1.1 shoulder and elbow")
def shoulder_and_elbow(draw: Draw) -> Task | None:
    """Shoulder and elbow angles of a PUMA arm without offset for a wrist centre."""
    h, a1, a2 = draw.number(0.3, 0.7), draw.number(0.4, 0.9), draw.number(0.4, 0.9)
    p = draw.numbers(3, -1, 1)
    r, s = float(np.hypot(p[0], p[1])), float(p[2] - h)

    def cosine(height: float) -> float:
        return (r * r + height * height - a1 * a1 - a2 * a2) / (2 * a1 * a2)

    D, low = cosine(s), cosine(float(p[2]))
    if abs(D) > 0.95:
        return None
    first, bend = float(np.arctan2(p[1], p[0])), float(np.arccos(D))
    wrong = float(np.arctan(p[0] / p[1]))
    left_out: dict[str, Any] = {"height_left_out": [[np.arccos(low)], [-np.arccos(low)]]} if abs(low) < 1 else {}
    return Task(
        {"h": h, "a1": a1, "a2": a2, "p": p, "r": r, "s": s, "D": D, "t1": first, "t3": bend},
        [
            ask("theta_1", [[first], [first + pi]], "rad", unordered=True, quotient_inverted=[[wrong], [wrong + pi]]),
            ask("theta_3", [[bend], [-bend]], "rad", unordered=True, inner_angle=[[pi - bend], [bend - pi]],
                  sine_for_cosine=[[np.arcsin(D)], [-np.arcsin(D)]], **left_out),
        ],
    )  # fmt: skip


@asks("7.2 newton")
def newton(draw: Draw) -> Task | None:
    """One step of Newton's method for a planar 2R arm."""
    lengths, angles, e = (
        _links(draw, 2),
        np.array([draw.degrees(), draw.degrees(30, 150)]),
        draw.numbers(2, -0.2, 0.2, 0.05),
    )
    robot, q = _arm(*lengths), np.radians(angles)
    J, p = _point_jacobian(robot, q), robot.forward_kinematics(q)[:2, 3]
    if abs(np.linalg.det(J)) < 0.1:
        return None
    goal = np.round(p + e, 4)
    step = np.linalg.solve(J, goal - p)
    return Task(
        {"L1": lengths[0], "L2": lengths[1], "t1": angles[0], "t2": angles[1], "goal": goal, "p": p, "e": goal - p,
         "J": J,
         "step": step, "q": q + step},
        [ask("q_next", q + step, "rad", step_sign=q - step, step_alone=step,
               transpose_for_inverse=q + J.T @ (goal - p),
               not_inverted=q + J @ (goal - p))],
    )  # fmt: skip


@asks("8.1.1 legs")
def legs(draw: Draw) -> Task:
    """Leg lengths of a planar 3xRPR platform at a pose."""
    side, small, angle = draw.number(1.0, 2.0), draw.number(0.2, 0.5), draw.degrees(15, 75)
    base = np.array([[0.0, 0.0], [side, 0.0], [0.0, side]])
    plate = np.array([[0.0, 0.0], [small, 0.0], [0.0, small]])
    p, t = draw.numbers(2, 0.2, 0.9), np.radians(angle)
    robot = PlanarThreeRPR(base, plate)
    lengths = np.asarray(robot.inverse_kinematics([*p, t]))

    def wrong(c: float, s: float) -> Floats:
        return np.linalg.norm(p + plate @ np.array([[c, s], [-s, c]]) - base, axis=1)

    return Task(
        {"side": side, "small": small, "p": p, "angle": angle, "b2": (plate @ np.array([[np.cos(t), np.sin(t)],
         [-np.sin(t), np.cos(t)]]))[1],
         "s": lengths},
        [ask("leg_lengths", lengths, "m", transposed=wrong(np.cos(t), -np.sin(t)), not_turned=wrong(1.0, 0.0),
               degrees=wrong(np.cos(angle), np.sin(angle)), squared=lengths**2)],
    )  # fmt: skip


@asks("8.3 assembly modes")
def assembly_modes(draw: Draw) -> Task | None:
    """Where the coupler of a four-bar can meet its rocker at an angle of the crank."""
    bars, angle = draw.numbers(4, 0.5, 2.0, 0.25), draw.degrees(20, 150)
    crank, coupler, rocker, ground = (float(bar) for bar in bars)
    modes = FourBar(crank, coupler, rocker, ground).positions([np.radians(angle)])
    points = np.asarray(modes.C)[0] if np.asarray(modes.C).ndim == 3 else np.asarray(modes.C)
    B, D = crank * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))]), np.array([ground, 0.0])
    if not bool(modes) or np.linalg.norm(points[0] - points[1]) < 0.2:
        return None
    d = float(np.linalg.norm(D - B))
    along = (coupler**2 - rocker**2 + d**2) / (2 * d)
    exchanged = _meeting(B, D, rocker, coupler)
    return Task(
        {"crank": crank, "coupler": coupler, "rocker": rocker, "ground": ground, "angle": angle, "B": B, "d": d,
         "along": along, "h": np.sqrt(coupler**2 - along**2), "C_1": points[0], "C_2": points[1]},
        [ask("meeting_points", points, "m", unordered=True, radii_swapped=exchanged,
               mirrored=points * [1.0, -1.0])],
    )  # fmt: skip


def _meeting(a: Floats, b: Floats, r: float, s: float) -> Floats:
    """Where two circles meet."""
    d = float(np.linalg.norm(b - a))
    x = (r * r - s * s + d * d) / (2 * d)
    e = (b - a) / d
    h = np.sqrt(max(r * r - x * x, 0.0)) * np.array([-e[1], e[0]])
    return np.array([a + x * e + h, a + x * e - h])


@asks("5.2.2 joint screw")
def joint_screw(draw: Draw) -> Task:
    """The screw of a revolute joint at zero, and of a prismatic one."""
    w, q = np.eye(3)[draw.whole(0, 2)] * draw.choice((1, -1)), draw.numbers(3, -1, 1)
    along, v = np.eye(3)[draw.whole(0, 2)], -np.cross(w, q)
    return Task(
        {"w": w, "q": q, "along": along, "cross": np.cross(w, q), "v": v},
        [
            ask("S", [*w, *v], cross_order=[*w, *-v], point_as_moment=[*w, *q]),
            ask("S_along", [0.0, 0.0, 0.0, *along]),
        ],
    )


@asks("6.1.2 body twist")
def body_twist(draw: Draw) -> Task:
    """The twist of the tip of a planar 2R arm in the frame of the tip: (omega, v_x, v_y)."""
    lengths, angles, rates = _links(draw, 2), np.array([draw.degrees(), draw.degrees()]), draw.numbers(2, -2, 2, 0.5)
    robot, q = _arm(*lengths), np.radians(angles)
    V_b, V_s = (J[2:5] @ rates for J in (robot.jacobian_body(q), robot.jacobian_space(q)))
    still, short = [V_b[0], *(_point_jacobian(robot, q) @ rates)], V_b - [0, 0, lengths[1] * V_b[0]]
    return Task(
        {"L1": lengths[0], "L2": lengths[1], "t1": angles[0], "t2": angles[1], "rates": rates, "w": V_b[0],
         "vx": lengths[0] * np.sin(q[1]) * rates[0], "vy": V_b[2]},
        [ask("planar_V_b", V_b, space_form=V_s, not_turned=still, last_link_left_out=short)],
    )  # fmt: skip


@asks("7.1.3 polar arm", unknown="a")
def polar_arm(draw: Draw) -> Task:
    """Heading, elevation and stroke of an arm with a prismatic joint in the place of the elbow."""
    p, h, a = draw.numbers(3, -1.5, 1.5), draw.number(0.3, 0.9), draw.number(0.1, 0.4)
    r, s, heading = np.hypot(p[0], p[1]), p[2] - h, np.arctan2(p[1], p[0])
    return Task(
        {"p": p, "h": h, "a": a, "r": r, "s": s, "theta_1": heading},
        [
            ask("heading", heading, "rad", quotient_inverted=np.arctan2(p[0], p[1])),
            ask("elevation", np.arctan2(s, r), "rad", height_left_out=np.arctan2(p[2], r)),
            ask("stroke", np.hypot(r, s) - a, "m", arm_not_subtracted=np.hypot(r, s), height_left_out=np.hypot(r, p[2])
                  - a),
        ],
    )  # fmt: skip


@asks("7.3 weighted rates")
def weighted_rates(draw: Draw) -> Task:
    """The cheapest rates of three joints for one component of the velocity."""
    J, weights, v = draw.numbers(3, -1, 1), draw.numbers(3, 1, 5, 1.0), draw.number(-2, 2, 0.5)

    def rates(W: Floats) -> Floats:
        return W * J * v / (W * J @ J)

    return Task(
        {"J": J, "weights": weights, "v": v, "scale": J / weights @ J, "rates": rates(1 / weights)},
        [ask("rates", rates(1 / weights), weight_times=rates(weights), weight_left_out=rates(np.ones(3)))],
    )


@asks("8.2.1 two legs")
def two_legs(draw: Draw) -> Task | None:
    """Forces of two legs that carry a load at the point where they meet."""
    left, right = np.radians(np.abs([draw.degrees(20, 70), draw.degrees(20, 70)]))
    load = np.array([draw.number(-50, 50, 10.0), -draw.number(50, 200, 10.0)])
    if left == right:
        return None
    U = np.array([[np.cos(left), -np.cos(right)], [np.sin(left), np.sin(right)]])
    f = np.linalg.solve(U, -load)
    return Task(
        {"left": round(np.degrees(left)), "right": round(np.degrees(right)), "load": load, "U": U, "f": f},
        [ask("leg_forces", f, "N", negated=-f, sine_cosine=np.linalg.solve(U[::-1] * [[1, 1], [1, -1]], -load),
               transposed=np.linalg.solve(U.T, -load), no_solve=U.T @ -load)],
    )  # fmt: skip
