"""Masses fixed to a link: tools, and what they hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.job.description import Grasp, Tool
from mafsil.job.poses import pose_matrix
from mafsil.model import Inertial, Mechanism


def with_tool(mechanism: Mechanism, tool: Tool, *, degrees: bool) -> Mechanism:
    """The mechanism with a tool on its flange: another tip frame, one more mass.

    Raises:
        ModelError: the tool's link does not exist.
    """
    link = tool.link or mechanism.tip
    if tool.offset is not None:
        mechanism = mechanism.with_tip(link, pose_matrix(tool.offset, degrees=degrees))
    elif tool.link is not None:
        mechanism = mechanism.with_tip(link)
    if tool.mass == 0.0:
        return mechanism
    return carrying(mechanism, link, Inertial(tool.mass, frozen(tool.com), frozen(np.zeros((3, 3)))))


def holding(mechanism: Mechanism, grasp: Grasp) -> Mechanism:
    """The mechanism with a box in its tool, aligned with the tip frame."""
    T = np.asarray(mechanism.T_lt) @ box_in_tip(grasp)
    a, b, c = (edge**2 for edge in grasp.size)
    inertia = grasp.mass / 12 * np.diag([b + c, a + c, a + b])
    R = T[:3, :3]
    body = Inertial(grasp.mass, frozen(T[:3, 3]), frozen(R @ inertia @ R.T))
    return carrying(mechanism, mechanism.tip, body)


def box_in_tip(grasp: Grasp) -> PoseMatrix:
    """(4, 4) pose of the box in the tip frame."""
    T = np.eye(4)
    T[:3, 3] = grasp.offset
    return T


def carrying(mechanism: Mechanism, link: str, body: Inertial) -> Mechanism:
    """The mechanism whose link carries one more rigid body.

    I = I_1 + m_1 (|d_1|^2 - d_1 d_1') + the same for the other, d_i from the common centre of mass

    Args:
        mechanism: any robot.
        link: name of the link.
        body: in the link's frame.
    """
    carrier = mechanism.link(link)
    heavier = replace(carrier, inertial=body if carrier.inertial is None else _joined(carrier.inertial, body))
    return replace(mechanism, links=tuple(heavier if item.name == link else item for item in mechanism.links))


def heavier(mechanism: Mechanism, error: float) -> Mechanism:
    """All masses and inertias larger by a relative error."""
    factor = 1.0 + error
    links = tuple(
        link if link.inertial is None else replace(link, inertial=replace(link.inertial, mass=link.inertial.mass * factor, inertia=frozen(link.inertial.inertia * factor)))  # fmt: skip
        for link in mechanism.links
    )
    return replace(mechanism, links=links)


def _joined(first: Inertial, second: Inertial) -> Inertial:
    mass = first.mass + second.mass
    if mass == 0.0:
        return first
    com = (first.mass * first.com + second.mass * second.com) / mass
    return Inertial(mass, frozen(com), frozen(_about(first, com) + _about(second, com)))


def _about(body: Inertial, point: Floats) -> Floats:
    """Inertia about another point than the centre of mass (Steiner)."""
    d = body.com - point
    return body.inertia + body.mass * ((d @ d) * np.eye(3) - np.outer(d, d))
