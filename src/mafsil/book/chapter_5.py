"""Figures of chapter 5: link frames and Denavit-Hartenberg parameters, arms at zero, products of exponentials."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.drawing import add_arm
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, PALE, RED, SECOND, SOFT, Panel
from mafsil.geometry import pose, rotation, screw
from mafsil.model.denavit_hartenberg import DHRow
from mafsil.model.dh_frames import four_motions, link_fit
from mafsil.model.library import textbook
from mafsil.robot import Robot


@draws("5.1", q1=Slider(-pi, pi, 0.5), q2=Slider(-pi, pi, 0.6), q3=Slider(-pi, pi, -0.9))
def planar_arm_with_frames(q1: float, q2: float, q3: float) -> Drawing:
    """A planar 3R arm with the frames of its links and of its tip."""
    robot, q = Robot(textbook.planar3r()), np.array([q1, q2, q3])
    panel = add_arm(Panel(), robot, q, flat=True, tip="")
    frames = [*robot.link_poses(q), np.asarray(robot.forward_kinematics(q))]
    for k, T in enumerate(frames):
        panel.frame(T[np.ix_([0, 1, 3], [0, 1, 3])], 0.28, str(k))
    tip = frames[-1][:2, 3]
    facts = Fact("tip", tip, unit="m"), Fact("angle", float(q.sum()), unit="rad")
    return Drawing({"arm": panel}, {"robot": robot, "q": q}, facts)


@draws("5.2", alpha=Slider(-pi, pi, 0.9), a=Slider(0.3, 1.5, 1.0, "m"), d=Slider(-0.8, 0.8, 0.5, "m"),
       theta=Slider(-pi, pi, 0.7))  # fmt: skip
def link_parameters(alpha: float, a: float, d: float, theta: float) -> Drawing:
    """The four parameters between two revolute axes: twist, length, offset, angle."""
    return _link(DHRow(alpha=alpha, a=a, d=d, theta=theta))


@draws("5.3", alpha=Slider(-pi, pi, 0.9), a=Slider(0.3, 1.5, 0.8, "m"), d=Slider(0.1, 1.2, 0.8, "m"),
       theta=Slider(-pi, pi, 0.5))  # fmt: skip
def link_to_a_prismatic_joint(alpha: float, a: float, d: float, theta: float) -> Drawing:
    """The frame of a prismatic joint: its offset is the coordinate, its angle a constant."""
    return _link(DHRow(alpha=alpha, a=a, d=0.0, theta=theta, kind="P"), d)


def _link(row: DHRow, q: float = 0.0) -> Drawing:
    """Frames {i-1} and {i}, the common normal and the offset between them."""
    T = four_motions(row, "modified", q)[-1].frame
    fit = link_fit(T)
    foot, z = np.array([row.a, 0.0, 0.0]), T[:3, 2]
    panel = Panel().frame(np.eye(4), 0.45, "i-1").frame(T, 0.45, "i")
    for name, point, axis in (("axis i-1", np.zeros(3), np.eye(3)[2]), ("axis i", foot, z)):
        panel.line([point - 0.6 * axis, point + 1.3 * axis], SOFT, "--" if row.kind == "P" else "-.", 1.2, name)
    panel.line([np.zeros(3), foot], ACCENT, width=3.0, name="a").label(foot / 2, "$a_{i-1}$", ACCENT)
    panel.line([foot, T[:3, 3]], SECOND, width=3.0, name="d").label((foot + T[:3, 3]) / 2, "$d_i$", SECOND)
    x, origin = np.eye(3)[0], T[:3, 3]
    twist = foot + 0.75 * rotation.from_axis_angle(x, np.linspace(0.0, row.alpha, 25)) @ np.eye(3)[2]
    angle = origin + 0.38 * rotation.from_axis_angle(z, np.linspace(-row.theta, 0.0, 25)) @ T[:3, 0]
    for centre, way, text, colour in ((foot, twist, r"$\alpha_{i-1}$", RED), (origin, angle, r"$\theta_i$", BLUE)):
        panel.line([centre, centre + 1.2 * (way[0] - centre)], PALE, "--").line(way, colour, name=text)
        panel.label(centre + 1.25 * (way[12] - centre), text, colour)
    found = np.array([fit.row.alpha, fit.row.a, fit.row.d, fit.row.theta])
    return Drawing({"link": panel}, {"row": row, "T": T, "fit": fit}, [Fact("parameters", found)])


@draws("5.4", status=EntryStatus.REBUILT, shift=Slider(0.2, 1.5, 0.8, "m"), tilt=Slider(0.2, 1.5, 0.6))
def frames_without_parameters(shift: float, tilt: float) -> Drawing:
    """A shift along y, and a rotation about y: neither is a row of a table; b to c is drawn beside."""
    T_ab = pose.from_rotation_translation(np.eye(3), [0.0, shift, 0.0])
    T_ac = pose.from_rotation_translation(rotation.from_axis_angle([0.0, 1.0, 0.0], tilt), [0.9, 0.0, 0.0])
    panel = Panel()
    for T, name in ((np.eye(4), "a"), (T_ab, "b"), (T_ac, "c")):
        panel.frame(T, 0.4, name)
    for name, T in (("ab", T_ab), ("ac", T_ac)):
        panel.line([np.zeros(3), T[:3, 3]], SOFT, "--", name=name)
    fits = {name: link_fit(T) for name, T in (("ab", T_ab), ("ac", T_ac))}
    facts = [Fact(name, int(bool(fit)), 0) for name, fit in fits.items()]
    return Drawing({"frames": panel}, {"T_ab": T_ab, "T_ac": T_ac, "fits": fits}, facts)


def _arm(robot: Robot, q: Floats, corners: list[tuple[int, tuple[float, ...]]] | None = None) -> Panel:
    return add_arm(Panel(), robot, q, through=corners)


@draws("5.5", q1=Slider(-pi, pi, 0.0), q2=Slider(-pi, pi, 0.0), q3=Slider(-pi, pi, 0.0))
def spatial_3r(q1: float, q2: float, q3: float) -> Drawing:
    """Axis 1 up, axis 2 across at a distance L1, link 2 hanging, axis 3 along x."""
    robot, q = Robot(textbook.spatial3r(1.0, 0.8)), np.array([q1, q2, q3])
    S = robot.jacobian_space(np.zeros(3)).T
    return Drawing({"arm": _arm(robot, q)}, {"robot": robot, "q": q}, [Fact("S3", S[2], (1, 0, 0, 0, 0.8, 0))])


@draws("5.6", status=EntryStatus.REBUILT, q3=Slider(-pi, pi, 0.0), q4=Slider(0.0, 1.0, 0.5, "m"))
def spatial_rrrp(q3: float, q4: float) -> Drawing:
    """Axes 2 and 3 parallel at a distance L2, the prismatic joint along x at zero."""
    robot, q = Robot(textbook.rrrp(1.0)), np.array([0.0, 0.0, q3, q4])
    S = robot.jacobian_space(np.zeros(4)).T
    return Drawing({"arm": _arm(robot, q)}, {"robot": robot, "q": q}, [Fact("S3", S[2], (0, -1, 0, 0, 0, -1))])


@draws("5.7", q2=Slider(-pi, pi, 0.0), q3=Slider(-pi, pi, 0.0), q5=Slider(-pi, pi, 0.0))
def elbow_arm(q2: float, q3: float, q5: float) -> Drawing:
    """Shoulder in the origin, elbow, and a wrist whose three axes meet."""
    robot, q = Robot(textbook.elbow6r(1.0, 0.9)), np.array([0.0, q2, q3, 0.0, q5, 0.0])
    J = robot.jacobian_space(q)
    facts = Fact("rank", int(np.linalg.matrix_rank(J, tol=1e-9))), Fact("wrist", meeting_point(J[:, 3:]), unit="m")
    return Drawing({"arm": _arm(robot, q)}, {"robot": robot, "q": q}, facts)


def meeting_point(columns: Floats) -> Floats:
    """(3,) the point nearest to some axes: where omega x p = -v for all of them, by least squares."""
    rows = np.vstack([rotation.hat(S[:3]) for S in columns.T])
    return np.asarray(np.linalg.lstsq(rows, -columns[3:].T.ravel(), rcond=None)[0], np.float64)


@draws("5.8", q1=Slider(-pi, pi, 0.6), q2=Slider(-pi, pi, 0.5), q3=Slider(-pi, pi, -0.7))
def product_of_exponentials(q1: float, q2: float, q3: float) -> Drawing:
    """From the last joint to the first: each exponential moves everything beyond its joint."""
    robot, q = Robot(textbook.spatial3r(1.0, 0.8)), np.array([q1, q2, q3])
    S, home = robot.jacobian_space(np.zeros(3)).T, np.asarray(robot.forward_kinematics(np.zeros(3)))
    panels = dict[str, Panel]()
    for k in range(4):
        moved = np.where(np.arange(3) >= 3 - k, q, 0.0)
        panels[f"step_{k}"] = add_arm(Panel(), robot, moved)
    T = home
    for axis, angle in zip(S[::-1], q[::-1], strict=True):
        T = screw.displacement(axis, angle) @ T
    gap = float(np.abs(T - np.asarray(robot.forward_kinematics(q))).max())
    return Drawing(panels, {"robot": robot, "q": q, "T": T}, [Fact("gap", gap)], 2)


@draws("5.9", q4=Slider(-pi, pi, 0.0), L=Slider(0.4, 1.5, 1.0, "m"))
def arm_6r_with_screws(q4: float, L: float) -> Drawing:
    """Three axes through the origin, two parallel ones, the last along the arm."""
    robot, q = Robot(textbook.arm6r(L)), np.array([0.0, 0.0, 0.0, q4, 0.0, 0.0])
    J = robot.jacobian_space(np.zeros(6))
    facts = (
        Fact("v4", J[3:, 3], (0, 0, -L), "m"), Fact("v5", J[3:, 4], (0, 0, -2 * L), "m"),
        Fact("rank", int(np.linalg.matrix_rank(J, tol=1e-9))),
    )  # fmt: skip
    return Drawing({"arm": _arm(robot, q)}, {"robot": robot, "q": q}, facts)


@draws("5.10", q2=Slider(-pi, pi, 0.0), q3=Slider(0.0, 1.0, 0.0, "m"))
def arm_rrprrr_with_screws(q2: float, q3: float) -> Drawing:
    """Two axes through the origin, a prismatic joint along y, a wrist at a distance L1."""
    robot, q = Robot(textbook.rrprrr(1.0, 0.6)), np.array([0.0, q2, q3, 0.0, 0.0, 0.0])
    J = robot.jacobian_space(np.zeros(6))
    facts = Fact("S5", J[:, 4], (1, 0, 0, 0, 0, -1)), Fact("rank", int(np.linalg.matrix_rank(J, tol=1e-9)))
    return Drawing({"arm": _arm(robot, q)}, {"robot": robot, "q": q}, facts)
