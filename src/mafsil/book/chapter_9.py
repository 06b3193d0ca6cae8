"""Figure of chapter 9: a link cut free."""

from __future__ import annotations

import numpy as np

from mafsil.book.entry import Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, GREEN, RED, SOFT, Panel
from mafsil.performance.statics import joint_reactions
from mafsil.robot import as_robot


@draws("9.1", elbow=Slider(-2.5, 2.5, 0.9))
def free_body_of_a_link(elbow: float) -> Drawing:
    """The second link of a planar 3R arm with the wrenches at its two joints and its weight."""
    robot = as_robot("planar3r")
    q = np.array([0.4, elbow, -0.5])
    places = np.array([robot.forward_kinematics(q, frame=link.name)[:3, 3] for link in robot.mechanism.links[-3:]])
    start, end = places[1, :2], places[2, :2]
    reactions = joint_reactions(robot, q)
    panel = Panel().line([start, end], BLUE, width=9.0, name="link").dots([start, end], "#2a2a2a", width=8.0)
    middle = (start + end) / 2
    along = (end - start) / np.linalg.norm(end - start)
    T = np.eye(3)
    T[:2, :2], T[:2, 2] = np.column_stack([along, [-along[1], along[0]]]), middle
    panel.frame(T, 0.25, "i").arrow(middle, [0, -0.35], r"$m_i g$", colour=RED, name="weight")
    panel.arrow(start - 0.45 * along, 0.4 * along, r"$F_i$", colour=ACCENT, reach=-0.15, name="wrench i")
    panel.arrow(
        end + 0.45 * along, -0.4 * along, r"$-\mathrm{Ad}^\top F_{i+1}$", colour=GREEN, reach=-0.35, name="wrench i+1"
    )
    panel.arc(start, 0.14, (1.0, 4.0), colour=SOFT, head=True, name="torque")
    return Drawing({"a": panel}, {"robot": robot, "q": q, "reactions": reactions}, [Fact("links", robot.n)])
