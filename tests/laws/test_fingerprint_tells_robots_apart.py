"""A cached kernel is found by the content of its robot: every number that enters the mechanics must change the key."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism, Mimic
from mafsil.robot import Robot

T = np.eye(4)
T[:3, 3] = 0.1, 0.2, 0.3


def robot(
    *,
    mass: float = 1.0,
    com: float = 0.1,
    inertia: float = 0.02,
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0),
    kind: JointKind = JointKind.HELICAL,
    pitch: float = 0.05,
    armature: float = 0.2,
    ratio: float = 0.5,
    offset: float = 0.1,
    leader: str = "a",
    shift: float = 0.3,
) -> Mechanism:
    body = Inertial(mass, np.array([com, 0, 0]), np.diag([0.01, 0.01, inertia]))
    links = [Link("base"), *(Link(name, body) for name in "ABC")]
    T_pj = T.copy()
    T_pj[2, 3] = shift
    joints = [
        Joint("a", JointKind.REVOLUTE, "base", "A", T_pj=T_pj, actuator=Actuator(armature=armature)),
        Joint("b", kind, "A", "B", T_pj=T, axis=np.array(axis), pitch=pitch if kind is JointKind.HELICAL else 0.0),
        Joint("c", JointKind.REVOLUTE, "B", "C", T_pj=T, mimic=Mimic(leader, ratio, offset)),
    ]
    return Mechanism.assemble("robot", links, joints)


CHANGES: dict[str, Callable[[], Mechanism]] = {
    "mass": lambda: robot(mass=float(np.nextafter(1.0, 2))),
    "centre": lambda: robot(com=float(np.nextafter(0.1, 2))),
    "inertia": lambda: robot(inertia=float(np.nextafter(0.02, 2))),
    "axis": lambda: robot(axis=(0.0, -1.0, 0.0)),
    "kind": lambda: robot(kind=JointKind.PRISMATIC),
    "pitch": lambda: robot(pitch=float(np.nextafter(0.05, 2))),
    "armature": lambda: robot(armature=float(np.nextafter(0.2, 2))),
    "ratio": lambda: robot(ratio=-0.5),
    "offset": lambda: robot(offset=0.0),
    "leader": lambda: robot(leader="b"),
    "placement": lambda: robot(shift=float(np.nextafter(0.3, 2))),
    "gravity": lambda: robot().with_gravity(np.array([0.0, 0.0, 9.81])),
    "tip": lambda: robot().with_tip("B"),
    "tool": lambda: robot().with_tip("C", T),
    "base": lambda: replace(robot(), T_sb=T),
}


@pytest.mark.row("K2")
@pytest.mark.parametrize("change", CHANGES)
def test_every_number_of_the_mechanics_is_in_the_key(change: str) -> None:
    plain, changed = Robot(robot()), Robot(CHANGES[change]())
    assert plain.kernel("inverse_dynamics").key != changed.kernel("inverse_dynamics").key


def test_the_same_numbers_give_the_same_key() -> None:
    assert Robot(robot()).kernel("mass_matrix").key == Robot(robot()).kernel("mass_matrix").key
    framed = Robot(robot()).kernel("forward_kinematics", "A")
    assert framed.key != Robot(robot()).kernel("forward_kinematics", "B").key
    assert framed.key != Robot(robot()).kernel("forward_kinematics").key
