"""Live objects as elements of a panel: linkages, arms with their joint axes, circles and solids."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3
from mafsil.control.analysis.block_diagram import BlockDiagram
from mafsil.figures.panel import ACCENT, BLUE, COLOURS, GREEN, INK, SOFT, Panel
from mafsil.grasp import Grasp
from mafsil.messages import in_line, say
from mafsil.mobility.linkages import Kind, Linkage, body_poses
from mafsil.robot import Robot

MARKERS = {Kind.PRISMATIC: "s", Kind.SPHERICAL: "o", Kind.UNIVERSAL: "P", Kind.CYLINDRICAL: "D", Kind.PIN_IN_SLOT: "d"}


def add_linkage(panel: Panel, linkage: Linkage, theta: ArrayLike | None = None, *, letters: bool = True) -> Panel:
    """Bodies as lines or polygons through their joints, named by the bodies; joints as markers, driven ones in green.

    Args:
        panel: in the plane, for a linkage that moves in it; else in space.
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m]; as drawn if None.
        letters: write the names of the joints.
    """
    T = body_poses(linkage, np.zeros(linkage.coordinates) if theta is None else np.asarray(theta, np.float64))
    size = 2 if linkage.planar else 3
    for k, body in enumerate(linkage.bodies):
        own = [joint for joint in linkage.joints if body in (joint.parent, joint.child)]
        points = np.array([T[k, :3, :3] @ joint.point + T[k, :3, 3] for joint in own])[:, :size]
        points = order_around(points)
        if body == linkage.ground:
            panel.dots(points, SOFT, "^" if size == 2 else "s", 12.0 if size == 2 else 5.0, body)
        elif len(points) > 2:
            panel.fill(points, COLOURS[k % 6], name=body)
        else:
            panel.line(points, COLOURS[k % 6], width=3.0, name=body)
    for joint in linkage.joints:
        parent = T[linkage.bodies.index(joint.parent)]
        point = (parent[:3, :3] @ joint.point + parent[:3, 3])[:size]
        panel.dots(point, BLUE if joint.actuated else INK, MARKERS.get(joint.kind, "o"), 7.0, f"joint {joint.name}")
        if size == 3 and joint.kind is Kind.UNIVERSAL:
            half = 0.1 * linkage.size * parent[:3, :3] @ joint.axis
            panel.line([point - half, point + half], INK, width=3.0, name=f"axis {joint.name}")
        if letters:
            grounded = linkage.ground in (joint.parent, joint.child)
            panel.label(point, f"${joint.name}$", offset=(0.0, -14.0) if grounded else (9.0, 9.0))
    return panel


def add_arm(
    panel: Panel,
    robot: Robot,
    q: ArrayLike | None = None,
    *,
    through: Sequence[tuple[int, ArrayLike]] | None = None,
    letters: str = "S",
    flat: bool = False,
    colour: str = BLUE,
    tip: str = "b",
) -> Panel:
    """An arm: a line named `arm` to its tip, joint axes `axis 1`, ... with their letters, frames of base and tip.

    Args:
        panel: in space, in the plane if the arm is drawn flat.
        robot: a serial arm.
        q: (n,) configuration [rad | m]; zero if None.
        through: corners of the line as (number of the link, place at zero); the origins of the links if None.
        letters: of the axes; none are drawn if empty.
        flat: leave z out.
        colour: of the line.
        tip: name of the tip frame; it is not drawn if empty.
    """
    values = np.zeros(robot.n) if q is None else np.asarray(q, np.float64)
    points, size = arm_points(robot, values, through), 2 if flat else 3
    extent = max(float(np.ptp(points, axis=0).max()), 1e-3)
    panel.line(points[:, :size], colour, width=4.5, name="arm").dots(points[:-1, :size], width=5.5, name="joints")
    for k, S in enumerate(robot.jacobian_space(values).T if letters and not flat else ()):
        omega = S[:3] if S[:3].any() else S[3:]
        off = [float(np.linalg.norm(np.cross(S[:3], p) + S[3:])) for p in points]  # Zero on the axis of a rotation.
        near = points[int(np.argmin(off))] if S[:3].any() else points[-1]
        ends = near + 0.2 * extent * np.array([[-1.0], [1.15]]) * omega
        panel.line(ends, ACCENT if S[:3].any() else GREEN, "-.", 1.2, f"axis {k + 1}")
        panel.label(near + 0.27 * extent * omega, f"${letters}_{k + 1}$", ACCENT if S[:3].any() else GREEN)
    if tip:
        T = np.asarray(robot.forward_kinematics(values))
        keep = [0, 1, 3] if flat else [0, 1, 2, 3]
        panel.frame(T[np.ix_(keep, keep)], 0.22 * extent, tip)
        panel.frame(np.eye(size + 1), 0.22 * extent, "s")
    return panel


def add_contacts(panel: Panel, grasp: Grasp, scale: float, *, letters: bool = True) -> Panel:
    """Contacts with their normals `normal 0`, ... and, with friction, their cones `cone 0`, ...; numbers beside them.

    Args:
        panel: of the dimension of the grasp.
        grasp: whose contacts are drawn.
        scale: length of cones and normals [m].
        letters: write the numbers.
    """
    for k, contact in enumerate(grasp.contacts):
        p, n = contact.point, contact.normal
        if contact.mu and grasp.dimension == 2:
            edges = [n + side * contact.mu * contact.tangents[0] for side in (-1, 1)]
            ends = [p + scale * edge / np.linalg.norm(edge) for edge in edges]
            panel.fill([p, *ends], BLUE, name=f"cone {k}")
        elif contact.mu:
            panel.surface(tube(p, p + scale * n, 0.0, scale * contact.mu), BLUE, 0.35, f"cone {k}")
        panel.arrow(p - 0.8 * scale * n, 0.8 * scale * n, name=f"normal {k}").dots(p, name=f"contact {k}")
        if letters:
            panel.label(p - 1.0 * scale * n, str(k + 1))
    return panel


def arm_points(robot: Robot, q: Floats, through: Sequence[tuple[int, ArrayLike]] | None = None) -> Floats:
    """(k, 3) corners of the line that stands for an arm, then its tip; arguments as for `add_arm`."""
    poses, tip = robot.link_poses(q), np.asarray(robot.forward_kinematics(q))[:3, 3]
    if through is None:
        return np.vstack([poses[:, :3, 3], tip])
    at_zero = np.linalg.inv(robot.link_poses(np.zeros(robot.n)))
    corners = [(poses[k] @ at_zero[k] @ np.append(np.asarray(place, np.float64), 1.0))[:3] for k, place in through]
    return np.array([*corners, tip])


def order_around(points: Floats) -> Floats:
    """Points in order around their middle, in the plane that fits them best."""
    middle = points - points.mean(axis=0)
    flat = middle @ np.linalg.svd(middle, full_matrices=False)[2][:2].T
    return points[np.argsort(np.arctan2(flat[:, -1], flat[:, 0]))]


def rim(radius: float, angle: float | None = None) -> Floats:
    """(73, 2) points of a circle about the origin of the plane, or (2,) the one at an angle [rad]."""
    t = np.linspace(0, 2 * np.pi, 73) if angle is None else np.asarray(angle)
    return radius * np.stack([np.cos(t), np.sin(t)], axis=-1)


def circle(centre: ArrayLike, normal: ArrayLike, radius: float, span: tuple[float, float] = (0.0, 2 * np.pi)) -> Floats:
    """(73, 3) points of a circle in space, or of its part between two angles [rad].

    Args:
        centre: (3,) [m].
        normal: (3,) of its plane.
        radius: [m].
        span: first and last angle, from a direction across the normal.
    """
    across = frame_about(np.asarray(normal, np.float64))
    t = np.linspace(*span, 73)
    return np.asarray(centre) + radius * (np.cos(t)[:, None] * across[:, 0] + np.sin(t)[:, None] * across[:, 1])


def frame_about(axis: Vector3) -> Floats:
    """(3, 3) a rotation whose z axis is a direction."""
    z = axis / np.linalg.norm(axis)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def tube(start: ArrayLike, end: ArrayLike, radius: float, tip: float | None = None, corners: int = 25) -> Floats:
    """(2, corners, 3) mantle of a cylinder, or of a cone where the radius at its end differs.

    Args:
        start, end: (3,) of its axis [m].
        radius: at the start [m].
        tip: radius at the end [m]; the same if None.
        corners: of its edge, the last one is the first; 5 for a square bar.
    """
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    R, t = frame_about(b - a), np.linspace(0, 2 * np.pi, corners)
    edge = np.cos(t)[:, None] * R[:, 0] + np.sin(t)[:, None] * R[:, 1]
    return np.stack([a + radius * edge, b + (radius if tip is None else tip) * edge])


def sphere(radius: float, centre: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """(25, 37, 3) points of a sphere."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 37), np.linspace(0, np.pi, 25))
    unit = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    return np.asarray(centre) + radius * unit


def add_blocks(panel: Panel, diagram: BlockDiagram) -> Panel:
    """Blocks of a closed loop as boxes named by the blocks, signals as arrows named `start > end`.

    Args:
        panel: in the plane.
        diagram: of `mafsil.control.block_diagram`.
    """
    words = {block.name: _block_words(block.name, block.text) for block in diagram.blocks}
    half = [0.0] * (1 + max(block.column for block in diagram.blocks))
    for block in diagram.blocks:
        longest = max(map(len, words[block.name].split("\n")))
        half[block.column] = max(half[block.column], 0.4 + 0.11 * longest)
    x = [half[0] + 2 * sum(half[:k]) - half[0] + half[k] + 1.1 * k for k in range(len(half))]
    centre = {block.name: np.array([x[block.column], -1.5 * block.row]) for block in diagram.blocks}
    wide = {block.name: np.array([half[block.column], 0.0]) for block in diagram.blocks}
    high, low = np.array([0.0, 0.5]), min(place[1] for place in centre.values()) - 1.3
    for name, place in centre.items():
        corners = [place - wide[name] + high, place + wide[name] + high, place + wide[name] - high]
        panel.fill([*corners, place - wide[name] - high], BLUE, 0.08, name=name).label(place, words[name], width=7.5)
    for arrow in diagram.arrows:
        a, b, name = centre[arrow.start], centre[arrow.end], f"{arrow.start} > {arrow.end}"
        if a[0] == b[0]:
            ends = [a - high, b + high]
        elif a[0] < b[0]:
            ends = [a + wide[arrow.start], b - wide[arrow.end]]
        else:
            y, entry = (low, b - wide[arrow.end]) if arrow.start == "sensors" else (a[1] - 0.9, b - high)
            corner = entry[0] - (0.6 if arrow.start == "sensors" else 0.0)
            panel.line([a - high, [a[0], y], [corner, y], [corner, entry[1]]], SOFT, width=1.2)
            ends = [np.array([corner, min(entry[1], y) if corner == entry[0] else entry[1]]), entry]
        panel.arrow(ends[0], ends[1] - ends[0], colour=SOFT, width=1.2, name=name)
        if arrow.signal and a[0] <= b[0] and arrow.start != "trajectory":
            panel.label((ends[0] + ends[1]) / 2, arrow.signal, width=7.0)
    return panel


def _block_words(name: str, text: str) -> str:
    known = "" if name == "sum" or name.startswith("term") else in_line(say(f"pictures.block_{name}"))
    return "\n".join(part for part in (known, text) if part)
