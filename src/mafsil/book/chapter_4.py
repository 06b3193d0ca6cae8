"""Figures of chapter 4: planar motion and pole, frames, Euler angles, rotations, screws, twists and wrenches."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.gimbals import draw_gimbals
from mafsil.figures.moving_body import draw_displaced_body, draw_solid_ball, draw_space_velocity, draw_two_frames
from mafsil.figures.panel import ACCENT, BLUE, GREEN, INK, PALE, RED, SECOND, SOFT, Panel
from mafsil.figures.pole import draw_pole
from mafsil.geometry import planar, pose, rotation, screw, twist, wrench
from mafsil.geometry.logarithms import ball_points

ROOT = 0.5**0.5
TURN = Slider(-pi, pi, 0.5)


@draws("4.1", angle=Slider(-pi, pi, pi / 3))
def planar_motion_and_pole(angle: float) -> Drawing:
    """A body of the plane moved from {b} to {c}, and the pole of the motion."""
    T_sb, T_sc = _planar(pi / 6, 1.0, 2.0), _planar(angle, 2.0, 1.0)
    T = T_sc @ np.linalg.inv(T_sb)
    (theta, *_), (pole, exists) = planar.log(T), planar.finite_pole(T)
    facts = [Fact("angle", float(theta), unit="rad")]
    facts += [Fact("pole", pole, (3, 3), "m")] if exists else []
    return Drawing({}, {"T_sb": T_sb, "T_sc": T_sc, "T": T}, facts, picture=lambda: draw_pole(T, T_sb))


def _planar(angle: float, x: float, y: float) -> Floats:
    """(3, 3) pose in the plane."""
    return np.array([[np.cos(angle), -np.sin(angle), x], [np.sin(angle), np.cos(angle), y], [0, 0, 1]])


@draws("4.2", roll=TURN, pitch=Slider(-1.5, 1.5, 0.3), yaw=Slider(-pi, pi, 0.8))
def position_and_orientation(roll: float, pitch: float, yaw: float) -> Drawing:
    """A frame {b} in {s}: the place of its origin and the directions of its axes."""
    R, p = rotation.from_rpy([roll, pitch, yaw]), np.array([1.4, 1.0, 0.9])
    T = pose.from_rotation_translation(R, p)
    panel = Panel().frame(np.eye(4), 0.8, "s").frame(T, 0.8, "b").arrow((0, 0, 0), p, colour=ACCENT, name="p")
    panel.label(0.5 * p + [0, 0, 0.12], "$p$", ACCENT)
    return Drawing({"frames": panel}, {"T_sb": T}, [Fact("determinant", float(np.linalg.det(R)), 1)])


@draws("4.3", alpha=Slider(-pi, pi, 0.0), beta=Slider(-1.5, 1.5, 0.0), gamma=Slider(-pi, pi, 0.0))
def euler_wrist(alpha: float, beta: float, gamma: float) -> Drawing:
    """Three axes, each carried by the one before: ZYX Euler angles."""
    return _wrist(np.array([alpha, beta, gamma]))


@draws("4.4", alpha=Slider(-pi, pi, 0.4), gamma=Slider(-pi, pi, -0.3))
def locked_euler_wrist(alpha: float, gamma: float) -> Drawing:
    """The same wrist with its middle angle at a right angle: axes 1 and 3 are one line."""
    return _wrist(np.array([alpha, pi / 2, gamma]))


def _wrist(angles: Floats) -> Drawing:
    """Rings of ZYX angles, with the directions of their axes in {s}."""
    Rz, Ry = (rotation.from_axis_angle(np.eye(3)[k], a) for k, a in ((2, angles[0]), (1, angles[1])))
    axes = np.column_stack([np.eye(3)[2], Rz @ np.eye(3)[1], Rz @ Ry @ np.eye(3)[0]])
    facts = Fact("rank", int(np.linalg.matrix_rank(axes, tol=1e-9))), Fact("sense", float(axes[:, 0] @ axes[:, 2]))
    R = rotation.from_euler(angles, "ZYX")
    return Drawing({}, {"R": R, "axes": axes}, facts, picture=lambda: draw_gimbals(angles, "ZYX"))


@draws("4.5", roll=Slider(-pi, pi, 0.7), pitch=Slider(-pi, pi, 0.5), yaw=Slider(-pi, pi, 0.9))
def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Drawing:
    """Three successive rotations about fixed axes: x, then y, then z."""
    R, panels = np.eye(3), dict[str, Panel]()
    for k, (name, angle) in enumerate((("roll", roll), ("pitch", pitch), ("yaw", yaw))):
        axis = np.eye(3)[k]
        after = rotation.from_axis_angle(axis, angle) @ R
        panel = Panel(zoom=1.35).frame(_at_origin(R), 1.0, colour=PALE)
        panel.line([-0.3 * axis, 1.35 * axis], SECOND, "-.", name="axis").frame(_at_origin(after), 1.0, "b")
        sweep = rotation.from_axis_angle(axis, np.linspace(0, angle, 40))
        for column in range(3):
            panel.line(sweep @ R[:, column], SOFT, ":", name=f"sweep {column}")
        panels[name], R = panel, after
    return Drawing(panels, {"R": R}, [Fact("same", float(np.abs(R - rotation.from_rpy([roll, pitch, yaw])).max()))])


def _at_origin(R: Floats) -> Floats:
    return pose.from_rotation_translation(R, np.zeros(3))


@draws("4.6", theta=Slider(-2 * pi, 2 * pi, 1.9))
def rotated_vector(theta: float) -> Drawing:
    """A vector that rotates about an axis runs round a circle."""
    omega, p = np.array([0.2, 0.1, 1.0]) / np.linalg.norm([0.2, 0.1, 1.0]), np.array([0.9, 0.2, 0.7])
    path = rotation.from_axis_angle(omega, np.linspace(0.0, theta, 81)) @ p
    panel = Panel().line([-0.2 * omega, 1.4 * omega], SECOND, "-.", name="axis").frame(np.eye(4), 0.4, "s")
    panel.label(1.5 * omega, r"$\hat\omega$", SECOND).line(path, ACCENT, name="path")
    panel.arrow((0, 0, 0), p, "$p(0)$", colour=BLUE, name="before")
    panel.arrow((0, 0, 0), path[-1], r"$p(\theta)$", colour=GREEN, name="after")
    foot = omega * float(omega @ p)
    panel.line([p, foot, path[-1]], SOFT, "--", name="radii")
    facts = Fact("height", float(omega @ p), unit="m"), Fact("length", float(np.linalg.norm(path[-1])), unit="m")
    return Drawing({"rotation": panel}, {"omega": omega, "p": p, "after": path[-1]}, facts)


@draws("4.7", angle=Slider(0.1, pi, pi))
def solid_ball_of_rotations(angle: float) -> Drawing:
    """Rotations as points of a solid ball of radius pi: a half turn has two names on its surface."""
    axis = np.array([2.0, 1.0, 2.0]) / 3.0
    R = rotation.from_axis_angle(axis, angle)
    names = ball_points(R)
    facts = Fact("radius", float(np.linalg.norm(names[0])), unit="rad"), Fact("names", len(names))
    return Drawing({}, {"R": R, "points": names}, facts, picture=lambda: draw_solid_ball(R))


@draws("4.8", yaw=Slider(-pi, pi, 0.7))
def three_frames_and_a_point(yaw: float) -> Drawing:
    """Frames {a}, {b}, {c} and a point q: places add, poses multiply."""
    T_ab = pose.from_rotation_translation(rotation.from_rpy([0.2, 0.1, yaw]), [1.6, 0.3, 0.2])
    T_bc = pose.from_rotation_translation(rotation.from_rpy([-0.4, 0.3, 0.5]), [0.6, 1.1, 0.9])
    T_ac, q_c = T_ab @ T_bc, np.array([0.5, 0.4, 0.6])
    q_a = (T_ac @ np.append(q_c, 1.0))[:3]
    panel = Panel()
    for T, name in ((np.eye(4), "a"), (T_ab, "b"), (T_ac, "c")):
        panel.frame(T, 0.5, name)
    for start, end, text in ((np.eye(4), T_ab, "p_{ab}"), (T_ab, T_ac, "p_{bc}"), (np.eye(4), T_ac, "p_{ac}")):
        a, b = start[:3, 3], end[:3, 3]
        panel.arrow(a, b - a, colour=SOFT, width=1.4, name=text).label((a + b) / 2, f"${text}$", SECOND)
    panel.dots(q_a, RED, width=7.0, name="q").label(q_a, "$q$", RED).line([T_ac[:3, 3], q_a], RED, "--")
    facts = Fact("q_a", q_a, unit="m"), Fact("p_ac", T_ac[:3, 3], unit="m")
    return Drawing({"frames": panel}, {"T_ab": T_ab, "T_bc": T_bc, "T_ac": T_ac, "q_c": q_c}, facts)


T_AD = np.array([[0, 0, -1, 400], [0, -1, 0, 50], [-1, 0, 0, 300], [0, 0, 0, 1]], np.float64)
T_DB = np.array([[0, 0, -1, 250], [0, -1, 0, -150], [-1, 0, 0, 200], [0, 0, 0, 1]], np.float64)
T_DE = np.array([[0, 0, -1, 300], [0, -1, 0, 100], [-1, 0, 0, 120], [0, 0, 0, 1]], np.float64)
T_BC = np.array([[0, -ROOT, -ROOT, 30], [0, ROOT, -ROOT, -40], [1, 0, 0, 20], [0, 0, 0, 1]])


@draws("4.9", status=EntryStatus.REBUILT)
def camera_and_mobile_arm() -> Drawing:
    """Frames of room {a}, mobile base {b}, gripper {c}, camera {d} and object {e} by the given matrices."""
    poses = {"a": np.eye(4), "b": T_AD @ T_DB, "c": T_AD @ T_DB @ T_BC, "d": T_AD, "e": T_AD @ T_DE}
    panel = Panel(azimuth=-115.0)
    for name, T in poses.items():
        panel.frame(T, 45.0, name)
    b, c = poses["b"][:3, 3], poses["c"][:3, 3]
    elbow = (b + c) / 2 + [0, 0, 45.0]
    box = b - [0, 0, 25.0] + 28.0 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    panel.fill(box, SOFT, name="base").line([b, elbow, c], BLUE, width=4.0, name="arm").dots(elbow)
    for end in ("b", "e"):
        panel.line([poses["d"][:3, 3], poses[end][:3, 3]], SECOND, "--", 1.0, f"sight {end}")
    T_ce = np.linalg.inv(poses["c"]) @ poses["e"]
    facts = [Fact("p_ce", T_ce[:3, 3], (-75, -260 * ROOT, 130 * ROOT), "mm")]
    return Drawing({"scene": panel}, {**{f"T_a{name}": T for name, T in poses.items()}, "T_ce": T_ce}, facts)


@draws("4.10")
def displaced_body() -> Drawing:
    """A body before and after the motion Rot(x, -45 degrees), and the frame {b} that names it."""
    T_ba = pose.from_rotation_translation(rotation.from_axis_angle([1.0, 0, 0], -pi / 4), [0, -18.0, 0])
    X_ai = pose.from_rotation_translation(rotation.from_rpy([0.0, 0.0, 0.3]), [6.0, 12.0, 4.0])
    X_af = T_ba @ X_ai
    S, theta = screw.chasles(T_ba)
    facts = (
        Fact("theta", float(theta), pi / 4, "rad"), Fact("pitch", float(screw.pitch(S))),
        Fact("point", screw.nearest_point(S), (0, -9, 21.727922), "m"),
    )  # fmt: skip
    named = {"T_ba": T_ba, "X_ai": X_ai, "X_af": X_af, "S": S}
    return Drawing({}, named, facts, picture=lambda: draw_displaced_body(X_ai, X_af))


@draws("4.11", pitch=Slider(0.02, 0.5, 0.15, "m/rad"), theta=Slider(0.5, 6 * pi, 4 * pi))
def kinds_of_screw_motions(pitch: float, theta: float) -> Drawing:
    """Rotation, screw motion and translation of a point."""
    z, start = np.array([0.0, 0.0, 1.0]), np.array([0.8, 0.0, 0.0, 1.0])
    kinds = {"rotation": screw.from_axis(z, np.zeros(3), 0.0), "screw": screw.from_axis(z, np.zeros(3), pitch),
             "translation": np.array([0, 0, 0, *z])}  # fmt: skip
    panels, ends = dict[str, Panel](), dict[str, Floats]()
    for name, S in kinds.items():
        reach = min(theta, 2 * pi) if name == "rotation" else theta if name == "screw" else pitch * theta
        path = (screw.displacement(S, np.linspace(0, reach, 241)) @ start)[:, :3]
        panel = Panel().line([-0.3 * z, 2.2 * z], SECOND, "-.", name="axis").line(path, ACCENT, name="path")
        panels[name] = panel.arrow(path[-6], path[-1] - path[-6]).dots(path[0], INK)
        ends[name] = path[-1]
    advance = float(ends["screw"][2])
    return Drawing(panels, kinds, [Fact("advance", advance, unit="m"), Fact("expected", pitch * theta, unit="m")])


T_AB = pose.from_rotation_translation(rotation.from_rpy([0.4, -0.2, 0.9]), [1.2, 0.8, 0.5])


@draws("4.12", pitch=Slider(-0.5, 0.5, 0.2, "m/rad"))
def screw_from_another_frame(pitch: float) -> Drawing:
    """One screw with its coordinates in two frames."""
    S_b = screw.from_axis([0.0, 0.6, 0.8], [0.4, 0.1, 0.0], pitch)
    S_a = twist.transform(T_AB, S_b)
    facts = (
        Fact("pitch_a", float(screw.pitch(S_a)), unit="m/rad"),
        Fact("pitch_b", float(screw.pitch(S_b)), unit="m/rad"),
    )
    named = {"T_ab": T_AB, "S_a": S_a, "S_b": S_b}
    return Drawing({}, named, facts, picture=lambda: draw_two_frames(T_AB, S_b, is_wrench=False))


@draws("4.13", rate=Slider(0.1, 1.0, 0.5, "rad/s"))
def angular_velocity(rate: float) -> Drawing:
    """Axes of a body at t and t + dt, and the rate of its x axis as a tangent of a circle."""
    omega, R = np.array([0.3, -0.2, 0.93]), rotation.from_rpy([0.2, 0.3, 0.4])
    axis = omega / np.linalg.norm(omega)
    after, x = rotation.from_axis_angle(axis, rate) @ R, R[:, 0]
    turned = Panel(zoom=1.35).frame(_at_origin(R), 1.0, "b").frame(_at_origin(after), 1.0, colour=SOFT)
    turned.arrow((0, 0, 0), 1.3 * axis, r"$\omega$", colour=SECOND, name="omega")
    velocity = rate * np.cross(axis, x)
    way = rotation.from_axis_angle(axis, np.linspace(0, 2 * pi, 73)) @ x
    tangent = Panel(zoom=1.35).line(way, SOFT, ":", name="circle")
    tangent.arrow((0, 0, 0), x, r"$\hat x$", colour=RED, name="x")
    tangent.arrow(x, velocity, r"$\dot{\hat x} = \omega \times \hat x$", name="velocity", reach=1.6)
    tangent.arrow((0, 0, 0), 1.3 * axis, r"$\omega$", colour=SECOND, name="omega")
    facts = Fact("speed", float(np.linalg.norm(velocity)), unit="1/s"), Fact("along", float(velocity @ x))
    return Drawing({"a": turned, "b": tangent}, {"omega": rate * axis, "R": R}, facts)


@draws("4.14", omega=Slider(-1.0, 1.0, 0.6, "rad/s"))
def meaning_of_v_s(omega: float) -> Drawing:
    """The velocity of the point of the body, thought without limits, that is at the origin of {s}."""
    V_s = np.array([0.0, 0.3 * omega, omega, 0.4, -0.3, 0.1])
    p = T_AB[:3, 3]
    moved = twist.point_velocity(V_s, p)
    facts = Fact("v_s", V_s[3:], unit="m/s"), Fact("by_origin", moved - np.cross(V_s[:3], p), unit="m/s")
    return Drawing({}, {"T_sb": T_AB, "V_s": V_s}, facts, picture=lambda: draw_space_velocity(T_AB, V_s))


@draws("4.15", force=Slider(1.0, 20.0, 10.0, "N"))
def wrench_in_two_frames(force: float) -> Drawing:
    """One wrench with its coordinates in {a} and {b}."""
    F_b = force * np.array([0.1, -0.05, 0.08, 0.0, 0.6, 0.8])
    F_a = wrench.transform(pose.inverse(T_AB), F_b)
    V_b = np.array([0.3, -0.1, 0.4, 0.2, 0.5, -0.6])
    power_a, power_b = float(F_a @ twist.transform(T_AB, V_b)), float(F_b @ V_b)
    facts = Fact("power_a", power_a, unit="W"), Fact("power_b", power_b, unit="W")
    named = {"T_ab": T_AB, "F_a": F_a, "F_b": F_b}
    return Drawing({}, named, facts, picture=lambda: draw_two_frames(T_AB, F_b, is_wrench=True))
