"""Round surfaces, holes, doors, faces of points and guides: work, dissipation, limits, and the laws that meet them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.control import Gains, TaskCoordinates, Wall, gravity_compensation, hybrid_control
from mafsil.control.contact import (
    AtPoints,
    Door,
    Hole,
    RoundSurface,
    TipDamping,
    TipForceSensor,
    VirtualEnvironment,
    guiding_line,
    guiding_plane,
    stiffest_wall,
    virtual_environment,
)
from mafsil.control.laws import TipMotion
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.simulation import Plant, Scenario, simulate
from mafsil.trajectory import screw_path, time_law
from mafsil.trajectory.profiles import rest

HANDLE = pose.exp(np.array([0.3, -0.2, 0.4, 0.5, 0.3, 0.2]))
SHAPES = {
    "ball": RoundSurface([0.1, 0.2, 0.0], 0.5, 900.0),
    "hollow ball": RoundSurface([0.1, 0.2, 0.0], 0.2, 900.0, hollow=True),
    "cylinder": RoundSurface([0.1, 0.2, 0.0], 0.5, 900.0, axis=[1.0, 1.0, 0.2]),
    "hole": Hole([0.4, 0.2, 0.3], [0.1, 0.0, 1.0], clearance=0.05, depth=0.1, chamfer=0.03, stiffness=900.0),
    "door": Door([0.1, -0.3, 0.1], [0.1, 0.0, 1.0], HANDLE, 900.0, rotational_stiffness=30.0, closer=4.0),
    "corners": AtPoints(RoundSurface([0.1, 0.2, 0.0], 0.5, 900.0), [[0.1, 0, 0], [0, 0.1, 0.05]]),
}


def potential(shape, T):
    """The energy of the springs, found by walking from afar: none is asked of the code that is tested."""
    p = T[:3, 3]
    if isinstance(shape, AtPoints):
        return sum(potential(shape.environment, T @ pose.exp(np.r_[0, 0, 0, x])) for x in shape.points)
    if isinstance(shape, RoundSurface):
        away = p - shape.centre
        away = away if shape.axis is None else away - (away @ shape.axis) * shape.axis
        depth = (np.linalg.norm(away) - shape.radius) * (1 if shape.hollow else -1)
        return 0.5 * shape.stiffness * max(depth, 0.0) ** 2
    if isinstance(shape, Door):
        away, first = p - shape.hinge, HANDLE[:3, 3] - shape.hinge
        across = [x - (x @ shape.axis) * shape.axis for x in (away, first)]
        r, r0 = map(np.linalg.norm, across)
        angle = np.arctan2(np.cross(across[1], across[0]) @ shape.axis, across[0] @ across[1])
        twisted = rotation.log(T[:3, :3] @ (rotation.exp(angle * shape.axis) @ HANDLE[:3, :3]).T)
        tie = (r - r0) ** 2 + ((away - first) @ shape.axis) ** 2
        return 0.5 * (shape.stiffness * tie + shape.rotational_stiffness * twisted @ twisted + shape.closer * angle**2)
    height = (p - shape.mouth) @ shape.axis
    off = np.linalg.norm(p - shape.mouth - height * shape.axis)
    depths = (-height, off - shape.clearance, (off - shape.clearance - height - shape.chamfer) / np.sqrt(2))
    return 0.5 * shape.stiffness * (max(min(depths), 0.0) ** 2 + max(-height - shape.depth, 0.0) ** 2)


@pytest.mark.parametrize("name", SHAPES)
@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_without_damping_the_wrench_is_the_slope_of_the_springs_energy(name, seed):
    rng, shape, h = np.random.default_rng(seed), SHAPES[name], 1e-6
    centre = HANDLE if isinstance(shape, Door) else pose.exp(np.r_[0.3 * rng.normal(size=3), 0.35, 0.2, 0.2])
    T = centre @ pose.exp(0.15 * rng.normal(size=6))
    V = rng.normal(size=6)
    rise = (potential(shape, T @ pose.exp(h * V)) - potential(shape, T @ pose.exp(-h * V))) / (2 * h)
    assert shape.wrench(T, V) @ V == pytest.approx(-rise, abs=2e-3, rel=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_damping_and_friction_take_energy_and_give_none(name):
    rng = np.random.default_rng(5)
    plain = SHAPES[name]
    rough = plain.environment if isinstance(plain, AtPoints) else plain
    more = {"friction": 0.4, "damping": 20.0}
    if isinstance(rough, Door):
        more["rotational_damping"] = 2.0
    given = {key: getattr(rough, key) for key in rough.__dataclass_fields__}
    rough = type(rough)(**(given | more))
    rough = AtPoints(rough, plain.points) if isinstance(plain, AtPoints) else rough
    T = np.stack([HANDLE @ pose.exp(0.2 * rng.normal(size=6)) for _ in range(200)])
    V = rng.normal(size=(200, 6))
    lost = ((rough.wrench(T, V) - plain.wrench(T, V)) * V).sum(axis=-1)
    assert (lost <= 1e-12).all()
    assert (lost < -1e-6).any()


@pytest.mark.parametrize("name", SHAPES)
def test_batches_are_their_rows(name):
    rng = np.random.default_rng(6)
    T = np.stack([HANDLE @ pose.exp(0.2 * rng.normal(size=6)) for _ in range(6)]).reshape(2, 3, 4, 4)
    V = rng.normal(size=(2, 3, 6))
    together = SHAPES[name].wrench(T, V)
    assert together.shape == (2, 3, 6)
    for at in np.ndindex(2, 3):
        assert np.allclose(together[at], SHAPES[name].wrench(T[at], V[at]), atol=1e-12)
    assert SHAPES[name].wrench(T[:0], V[:0]).shape == (0, 3, 6)


def test_a_large_ball_is_a_wall_and_a_point_at_the_origin_the_tip_itself():
    ball = RoundSurface([0, 0, -1e4], 1e4, 2e3, 30.0, 0.3)
    wall = Wall(np.zeros(3), np.array([0, 0, 1.0]), 2e3, 30.0, 0.3)
    T, V = pose.exp(np.array([0.2, 0.1, 0, 0.01, 0.02, -0.003])), np.array([0.1, 0, 0.2, 0.03, -0.02, -0.01])
    assert np.allclose(ball.wrench(T, V), wall.wrench(T, V), rtol=1e-4)
    assert np.allclose(AtPoints(wall, [[0.0, 0, 0]]).wrench(T, V), wall.wrench(T, V))
    assert not ball.wrench(pose.exp(np.array([0, 0, 0, 0, 0, 0.001])), V).any()


@pytest.mark.capability("10-84", "10-85")
def test_a_virtual_wall_feels_like_the_real_one():
    arm, q = mf.load("planar2r"), np.array([0.4, 1.1])
    tip = arm.forward_kinematics(q)[:3, 3]
    wall = Wall(tip - [0, 0.02, 0], np.array([0, 1.0, 0]), 800.0, 20.0, 0.2)
    start = {"q": q, "qd": [-0.6, -0.2], "trajectory": rest(q, 0.5), "integrator": "semi_implicit_euler"}
    light = Plant(arm, friction=False)
    felt = simulate(Scenario(robot=arm, plant=light, law=virtual_environment(arm, wall), **start))
    real = Plant(arm, friction=False, environment=wall)
    met = simulate(Scenario(robot=arm, plant=real, law=gravity_compensation(arm, 0.0, 0.0), **start))
    assert np.abs(felt.q - met.q).max() < 1e-9
    assert (wall.depth(arm.forward_kinematics(felt.q)) > 1e-4).any()
    assert stiffest_wall(20.0, 1e-3) > 800.0
    batch = virtual_environment(arm, wall)(0.0, felt.q[:7], felt.qd[:7], None)
    assert batch.shape == (7, 2)
    assert isinstance(virtual_environment("planar2r", wall), VirtualEnvironment)
    with pytest.raises(InputError, match="environment"):
        virtual_environment(arm, 3)


def test_guides_leave_free_what_they_guide_along():
    T, V = pose.exp(np.array([0.3, 0.2, 0.1, 0.4, 0.5, 0.6])), np.zeros(6)
    u = np.array([1.0, 2.0, 2.0]) / 3
    for make, free in ((guiding_line, lambda f: f @ u), (guiding_plane, lambda f: np.linalg.norm(f - (f @ u) * u))):
        force = T[:3, :3] @ make([0, 0, 0], u, 100.0).wrench(T, V)[3:]
        assert abs(free(force)) < 1e-12
        assert np.linalg.norm(force) > 1.0
        on = make(T[:3, 3], u, 100.0, 5.0)
        assert np.abs(on.wrench(T, V)).max() < 1e-12


@pytest.mark.capability("10-73", "10-74")
def test_hybrid_control_slides_over_a_ball_with_its_force():
    """A curved constraint: the tip goes round on a ball that gives way, and presses on it with 6 N."""
    robot, q = mf.load("ur5e"), np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])
    T = robot.forward_kinematics(q)
    radius, down = 0.15, T[:3, 2]
    ball = RoundSurface(T[:3, 3] + radius * down, radius, 2e4, 200.0)
    turn = T[:3, 1]

    def touching(pose_now, V):
        n, away = ball.normal(pose_now[:3, 3])[0], np.linalg.norm(pose_now[:3, 3] - ball.centre)
        v = V[3:]
        rate = (v - (v @ n) * n) / away
        return np.r_[0, 0, 0, n][None], np.r_[0, 0, 0, rate][None]

    moving = pose.exp(np.r_[turn, -np.cross(turn, ball.centre)] * 0.5)
    path = TipMotion(screw_path(T, moving @ T), time_law("quintic").unit().scale_time(1.0))
    task = TaskCoordinates()
    law = hybrid_control(
        robot, path, touching, np.r_[0, 0, 0, 6.0 * down], gains=Gains.from_natural_frequency(6, 25.0),
        sensor=TipForceSensor(robot, ball, task), force_ki=15.0,
    )  # fmt: skip

    class Sliding:
        def __call__(self, t, state, rates, reference):
            A, _ = touching(task.pose(robot, state), task.jacobian(robot, state) @ rates)
            press, slow = replace(law, force=-6.0 * A[0]), TipDamping(robot, task, 400.0 * A.T @ A)
            return press(t, state, rates, reference) + slow(t, state, rates, reference)

        def session(self, period):
            return self

    plant = Plant(robot, friction=False, environment=ball)
    run = simulate(Scenario(robot=robot, plant=plant, trajectory=rest(q, 1.0), law=Sliding(), step=1e-3,
                            integrator="semi_implicit_euler", saturate=False))  # fmt: skip
    assert run
    force = np.linalg.norm(run.contact_wrench[300:, 3:], axis=-1)
    assert np.abs(force - 6.0).max() < 0.6
    end = robot.forward_kinematics(run.q[-1])[:3, 3]
    goal = (moving @ T)[:3, 3]
    n = ball.normal(end)[0]
    off = end - goal
    assert np.linalg.norm(off - (off @ n) * n) < 2e-3


def test_what_makes_no_sense_is_named():
    ball = RoundSurface([0, 0, 0], 1.0, 1.0)
    for action, word in (
        (lambda: RoundSurface([0, 0], 1.0, 1.0), "centre"),
        (lambda: RoundSurface([0, 0, 0], -1.0, 1.0), "radius"),
        (lambda: RoundSurface([0, 0, 0], 1.0, np.nan), "stiffness"),
        (lambda: RoundSurface([0, 0, 0], 1.0, 1.0, damping=-1.0), "damping"),
        (lambda: RoundSurface([0, 0, 0], 1.0, 1.0, axis=[0, 0, 0]), "normal"),
        (lambda: Hole([0, 0, 0], [0, 0, 1], clearance=0.0, depth=1.0), "clearance"),
        (lambda: Hole([0, 0, 0], [0, 0, 1], clearance=1.0, depth=1.0, chamfer=-1.0), "chamfer"),
        (lambda: Door([0, 0, 0], [0, 0, 1], np.eye(4), 1.0), "handle"),
        (lambda: Door([1, 0, 0], [0, 0, 1], np.ones((4, 4)), 1.0), "handle"),
        (lambda: Door([1, 0, 0], [0, 0, 1], np.eye(4), 1.0, closer=np.inf), "closer"),
        (lambda: AtPoints(ball, [1.0, 2.0]), "points"),
        (lambda: AtPoints(ball, [[1.0, 2.0, np.inf]]), "points"),
        (lambda: guiding_line([0, 0, 0], [0, 0, 0], 1.0), "normal"),
    ):
        with pytest.raises(InputError, match=word):
            action()
