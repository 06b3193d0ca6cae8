"""Robots without acceleration, without joints, without mass: the right number, or the reason why there is none."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from mafsil.errors import ModelError
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism, Mimic, library
from mafsil.robot import Robot
from mafsil.robot.compiled_robot import Answered

BRICK = Inertial(1.0, np.array([0.1, 0.0, 0.0]), np.eye(3) * 0.01)
POINT = Inertial(1.0)


def chain(*parts: tuple[JointKind, Inertial | None], **options: object) -> Robot:
    """Joints along one z axis, links `link1`, ... behind them."""
    links = [Link("link0"), *(Link(f"link{k}", inertial) for k, (_, inertial) in enumerate(parts, 1))]
    joints = [
        Joint(f"joint{k}", kind, f"link{k - 1}", f"link{k}", **options)  # type: ignore[arg-type]
        for k, (kind, _) in enumerate(parts, 1)
    ]
    return Robot(Mechanism.assemble("chain", links, joints))


TURN, SLIDE = JointKind.REVOLUTE, JointKind.PRISMATIC


@pytest.mark.capability("09-5")
@pytest.mark.parametrize(
    ("robot", "named"),
    [
        (chain((TURN, POINT)), ["joint1"]),
        (chain((TURN, BRICK), (SLIDE, None)), ["joint2"]),
        (chain((TURN, None), (SLIDE, POINT)), ["joint1"]),
        (chain((TURN, None), (TURN, BRICK)), ["joint1", "joint2"]),
        (chain((SLIDE, None), (SLIDE, BRICK), (TURN, BRICK)), ["joint1", "joint2"]),
        (chain(*[(TURN, None)] * 20, (TURN, BRICK)), []),
    ],
    ids=["point on the axis", "massless end", "turn before a point", "coaxial", "parallel slides", "long"],
)
def test_joints_that_move_no_inertia_are_named(robot: Robot, named: list[str]) -> None:
    zero = np.zeros(robot.n)
    with pytest.raises(ModelError) as caught:
        robot.forward_dynamics(zero, zero, zero)
    assert caught.value.key in ("mechanics.no_inertia", "mechanics.singular")
    assert all(name in str(caught.value) for name in named)
    assert caught.value.message("ar") != str(caught.value)
    assert np.isfinite(robot.inverse_dynamics(zero, zero, zero)).all()


def fingers(leader: Inertial | None, follower: Inertial | None) -> Robot:
    """Two fingers on a palm, the second one driven by the first."""
    x = np.array([1.0, 0.0, 0.0])
    links = [Link("palm"), Link("left", leader), Link("right", follower)]
    joints = [
        Joint("right", SLIDE, "palm", "right", axis=-x, mimic=Mimic("left")),
        Joint("left", SLIDE, "palm", "left", axis=x),
    ]
    return Robot(Mechanism.assemble("gripper", links, joints))


@pytest.mark.parametrize("masses", [(POINT, None), (None, POINT), (POINT, BRICK)])
def test_one_finger_with_mass_determines_the_acceleration_of_both(masses: tuple[Inertial | None, Inertial | None]):
    mass = sum(body.mass for body in masses if body is not None)
    found = fingers(*masses).forward_dynamics([0.0], [0.0], [3.0])
    np.testing.assert_allclose(found, [3.0 / mass])


def test_the_coordinate_of_fingers_without_mass_is_named() -> None:
    hand = fingers(None, None).mechanism
    turning = Joint("turning", TURN, "base", "palm")
    links = [Link("base"), Link("palm", BRICK), *hand.links[1:]]
    robot = Robot(Mechanism.assemble("hand", links, [turning, *hand.joints]))
    with pytest.raises(ModelError, match="joint 'left'"):
        robot.forward_dynamics([0.0, 0.0], [0.0, 0.0], [0.0, 1.0])


def elbow_without_mass() -> Robot:
    """The planar arm with a point mass at its end only: stretched out or folded, one motion moves nothing."""
    arm = library.load("planar2r_point_masses")
    return Robot(replace(arm, links=tuple(replace(x, inertial=None) if x.name == "link1" else x for x in arm.links)))


@pytest.mark.capability("09-5", "09-63")
@pytest.mark.parametrize(("angle", "motion"), [(0.0, "joint1: -0.5, joint2: 1"), (np.pi, "joint1: 1")])
def test_a_position_without_an_answer_gives_the_reason(angle: float, motion: str) -> None:
    """One state raises and names the motion that moves no inertia; in batches that row is NaN and the others stay."""
    robot, rest = elbow_without_mass(), np.zeros(2)
    for routine in (robot.forward_dynamics, pickle.loads(pickle.dumps(robot.forward_dynamics_derivatives))):
        with pytest.raises(ModelError, match=motion) as caught:
            routine([0.3, angle], rest, [1.0, 0.0])
        assert caught.value.key == "dynamics.degenerate"
        assert np.isfinite(routine(np.array([0.3, 0.5]), rest, np.array([1.0, 0.0]))).all()
    rows = robot.forward_dynamics([[0.3, 0.5], [0.3, angle]], rest, [1.0, 0.0])
    np.testing.assert_array_equal(np.isnan(rows), [[False] * 2, [True] * 2])


def test_only_arms_that_can_be_singular_are_watched() -> None:
    """A rod turned about its end moves matter of its own."""
    assert not any(isinstance(Robot(library.load(name)).forward_dynamics, Answered) for name in ("panda", "planar2r"))
    assert isinstance(elbow_without_mass().forward_dynamics, Answered)


def test_an_armature_is_inertia_enough() -> None:
    robot = chain((TURN, None), (TURN, None), actuator=Actuator(armature=0.5))
    found = robot.forward_dynamics([0, 0], [0, 0], [1.0, 2.0])
    np.testing.assert_allclose(found, [2.0, 4.0], rtol=1e-15)


@pytest.mark.parametrize("name", sorted(name for name, row in CATALOGUE.items() if row.needs_joints))
def test_a_robot_without_joints_says_so(name: str) -> None:
    robot = Robot(Mechanism.assemble("table", [Link("top", POINT)], []))
    with pytest.raises(ModelError, match="no moving joint"):
        getattr(robot, name)(*(np.zeros(0) for _ in CATALOGUE[name].inputs))


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_robot_without_mass_has_kinematics_and_says_that_it_has_no_dynamics(name: str) -> None:
    robot = chain((TURN, None), (SLIDE, None))
    inputs = [np.ones((3, 2)) for _ in CATALOGUE[name].inputs]
    if CATALOGUE[name].needs_mass:
        with pytest.raises(ModelError) as caught:
            getattr(robot, name)(*inputs)
        assert caught.value.key == "robot.massless"
    else:
        assert np.isfinite(getattr(robot, name)(*inputs)).all()


@pytest.mark.capability("05-49")
def test_a_tip_on_the_base_moves_with_no_joint() -> None:
    robot = Robot(chain((TURN, BRICK), (SLIDE, BRICK)).mechanism.with_tip("link0"))
    q = np.ones(2)
    assert (robot.forward_kinematics(q) == np.eye(4)).all()
    for J in (robot.jacobian_space(q), robot.jacobian_body(q), robot.jacobian_body_rate(q, q)):
        assert (J == 0).all()
    assert (robot.inverse_dynamics(q, q, q, np.ones(6)) == robot.inverse_dynamics(q, q, q)).all()


def test_a_follower_with_ratio_zero_stands_still() -> None:
    links = [Link("a"), Link("b", BRICK), Link("c", BRICK)]
    joints = [
        Joint("held", TURN, "a", "b", mimic=Mimic("free", 0.0, 0.3)),
        Joint("free", TURN, "b", "c"),
    ]
    robot = Robot(Mechanism.assemble("held", links, joints))
    alone = chain((TURN, BRICK))
    np.testing.assert_allclose(robot.mass_matrix([0.4]), alone.mass_matrix([0.4]), rtol=1e-14)
    np.testing.assert_allclose(robot.forward_dynamics([0.4], [1.0], [2.0]), alone.forward_dynamics([0.4], [1.0], [2.0]))
