"""How small errors grow where rigid surfaces hold the arm, against runs that begin side by side on them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.job import Run, parse_job, solve
from mafsil.job.judging.law_stability import HeldArm, growth_along, quiet_law
from mafsil.trajectory import Motion, quintic
from mafsil.trajectory.profiles import rest

PLANAR = ("planar2r_point_masses", [0.4, 0.9], [0, 1.0, 0], [0])
SPATIAL = ("puma560", [0.4, -0.3, 0.5, 0.3, -0.4, 0.5], [0.0, 0.6, 0.8], [0, 1, 3, 4, 5])


def pressed(robot, q, normal, controller, friction=0.0):
    """A stretch in which the arm rests on a surface, and its law wants to be a millimetre in it; with its job."""
    arm = mf.load(robot)
    T = arm.forward_kinematics(q)
    text = f"""
robot = "{robot}"
[start]
joints = {q}
[simulation]
friction = false
method = "rk4"
[controller]
{controller}
[[surface]]
point = {T[:3, 3].tolist()}
normal = {normal}
rigid = true
friction = {friction}
[[move]]
pause = 0.1
"""
    job = parse_job(text)
    found = solve(job, text, Path())
    assert isinstance(found, Run)
    A = normal @ T[:3, :3] @ arm.jacobian_body(q)[3:]
    inside = rest(q - 1e-3 * A / (A @ A), 0.1)
    driven = found.driven[0]
    scenario = replace(driven.scenario, trajectory=inside, q=q, saturate=False)
    return job, replace(driven, scenario=scenario, stretch=replace(driven.stretch, trajectory=inside))


def put_on(arm, surface, q, qd):
    """A state on a surface, near another one."""
    n = surface.outward(np.zeros(3))
    for _ in range(6):
        T = arm.forward_kinematics(q)
        A = n @ T[:3, :3] @ arm.jacobian_body(q)[3:]
        q = q - A * surface.distance(T[:3, 3]) / (A @ A)
    T = arm.forward_kinematics(q)
    A = n @ T[:3, :3] @ arm.jacobian_body(q)[3:]
    return q, qd - A * (A @ qd) / (A @ A)


@pytest.mark.capability("10-23", "10-66")
@pytest.mark.parametrize("late", [0, 2])
@pytest.mark.parametrize(
    ("case", "controller"),
    [
        (PLANAR, 'kind = "computed_torque"\nfrequency = 60'),
        (PLANAR, 'kind = "pd_gravity"\nkp = 4e4\nkd = 20'),
        (SPATIAL, 'kind = "pd_gravity"\nkp = 1500\nkd = 60'),
    ],
)
def test_the_growth_on_a_rigid_surface_is_that_of_runs_that_begin_side_by_side_on_it(case, controller, late):
    robot, q, normal, chart = case
    arm = mf.load(robot)
    job, driven = pressed(robot, q, normal, f"{controller}\ndelay = {0.001 * late}")
    scenario, factor = driven.scenario, growth_along(job, driven).factor
    (surface,) = scenario.true_plant.surfaces
    rng, pairs, r = np.random.default_rng(2), [], len(chart)
    base = np.array(q)
    for _ in range(2 * r + late * r + 2):
        x, v = 1e-5 * rng.normal(size=(2, arm.n)) * [[1.0], [30.0]]
        runs = []
        for side in (1, -1):
            start, rate = put_on(arm, surface, base + side * x, side * v)
            tape = mf.simulate(replace(scenario, q=start, qd=rate, duration=0.012 + 0.001 * late))
            assert tape.metadata["rigid_contact"]["releases"] == 0
            runs.append(np.concatenate([tape.q[:, chart], tape.qd[:, chart] / 30.0], axis=1))
            waits = [tape.tau_commanded[k : len(tape.t) - max(late - 1, 0) + k] / 1e3 for k in range(late)]
            runs[-1] = np.concatenate([runs[-1][: len(tape.t) - max(late - 1, 0)], *waits], axis=1)
        pairs.append((runs[0] - runs[1])[late + 1 :])
    before, after = (np.concatenate([pair[part] for pair in pairs]) for part in (slice(None, -1), slice(1, None)))
    step = np.linalg.lstsq(before, after, rcond=1e-9)[0]
    assert np.abs(np.linalg.eigvals(step)).max() == pytest.approx(factor, abs=2e-3)


RAILS = """<robot name="rails"><link name="base"/>{links}</robot>"""
RAIL = """
<link name="{name}"><inertial><mass value="{mass}"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{name}_rail" type="prismatic"><parent link="{parent}"/><child link="{name}"/><axis xyz="{axis}"/>
<limit lower="-2" upper="2" effort="1000" velocity="5"/></joint>"""
TICK, SIDE = 1e-5, np.array([1e-6, 3e-5])


def step_of_runs(scenario, bases, free):
    """The step of small errors over a tick, from pairs of runs of one tick that begin beside each other.

    Each base (n, k) has a column for every direction that the surface leaves free; `free` picks as many joints.
    """
    q, qd = (np.asarray(x) for x in (scenario.q, scenario.qd))
    columns = []
    for k in range(2 * len(free)):
        ends = []
        for side in (1.0, -1.0):
            moved = side * SIDE[k // len(free)] * bases[:, k % len(free)]
            start, rate = (q + moved, qd) if k < len(free) else (q, qd + moved)
            run = mf.simulate(replace(scenario, q=start, qd=rate, duration=TICK))
            assert run.metadata["rigid_contact"]["slips"] == 0
            ends.append(np.concatenate([run.q[-1, free], run.qd[-1, free]]))
        columns.append((ends[0] - ends[1]) / (2.0 * SIDE[k // len(free)]))
    return np.stack(columns, axis=1)


@pytest.mark.capability("10-23", "10-94")
def test_the_growth_while_sliding_on_rough_ground_is_that_of_runs_side_by_side(tmp_path):
    """Three rails: the coordinates are flat, so that the frozen step is the true one. Friction follows the velocity."""
    speed = 1.0
    names, axes, masses = ("base", "a", "b", "c"), ("1 0 0", "0 1 0", "0 0 1"), (3.0, 2.0, 1.5)
    links = [RAIL.format(name=names[k + 1], parent=names[k], axis=axes[k], mass=masses[k]) for k in range(3)]
    file = tmp_path / "rails.urdf"
    file.write_text(RAILS.format(links="".join(links)))
    q, v = [0.1, 0.2, 0.3], speed * np.array([0.3, -0.4, 0.0])
    job, driven = pressed(str(file), q, [0, 0, 1], 'kind = "pd_gravity"\nkp = 1500\nkd = 60', 0.4)
    inside = np.array(q) - [0.0, 0.0, 5e-3]
    motion = quintic(inside, inside + 2 * TICK * v, 2 * TICK, start_velocity=v, goal_velocity=v)
    scenario = replace(driven.scenario, trajectory=motion, q=q, qd=v, step=TICK, period=TICK)
    factor = growth_along(job, replace(driven, scenario=scenario, stretch=replace(driven.stretch, trajectory=motion)))
    step = step_of_runs(scenario, np.eye(3)[:, :2], [0, 1])
    rates = np.log([factor.factor, np.abs(np.linalg.eigvals(step)).max()]) / TICK
    assert rates[0] == pytest.approx(rates[1], rel=5e-4)
    assert -10.0 < rates[0] < -4.0


@pytest.mark.capability("10-23", "10-94")
@pytest.mark.parametrize(("case", "friction"), [(PLANAR, 0.3), (SPATIAL, 0.3), (SPATIAL, 0.0)])
def test_the_growth_of_arms_that_slide_fast_is_that_of_runs_in_the_same_coordinates(case, friction):
    """At 1 m/s what is tangent to the surface changes from tick to tick: errors are compared by Z+ of one place."""
    robot, q, normal, _ = case
    job, driven = pressed(robot, q, normal, 'kind = "pd_gravity"\nkp = 1500\nkd = 60', friction)
    arm, base, n = mf.load(robot), np.array(q), np.array(normal)
    J = arm.forward_kinematics(base)[:3, :3] @ arm.jacobian_body(base)[3:]
    v, inside = (
        np.linalg.pinv(J) @ np.cross(n, [0, 0, 1.0] if arm.n == 2 else [1.0, 0, 0]),
        base - 2e-3 * np.linalg.pinv(J) @ n,
    )
    motion = quintic(inside, inside + 2 * TICK * v, 2 * TICK, start_velocity=v, goal_velocity=v)
    scenario = replace(driven.scenario, trajectory=motion, step=TICK, period=TICK)
    driven = replace(driven, scenario=scenario, stretch=replace(driven.stretch, trajectory=motion))
    held = HeldArm(driven, quiet_law(job, driven), 0.0, Motion(*motion.at(0.0)), (0,))
    (surface,), (q0, v0) = scenario.true_plant.surfaces, held.base
    before, after = [], []
    for e, x in [(SIDE[k], z) for k in range(2) for z in held.Z.T]:
        pair = []
        for side in (e, -e):
            moved = (q0 + side * x, v0) if e == SIDE[0] else (q0, v0 + side * x)
            start, rate = put_on(arm, surface, *moved)
            run = mf.simulate(replace(scenario, q=start, qd=rate, duration=TICK))
            pair.append([held.inverse @ np.stack([run.q[k], run.qd[k]], axis=1) for k in (0, -1)])
        first, last = (np.array(pair[0]) - pair[1]) / (2.0 * e)
        before.append(first.T.ravel())
        after.append(last.T.ravel())
    step = np.linalg.solve(before, after)
    rates = np.log([growth_along(job, driven).factor, np.abs(np.linalg.eigvals(step)).max()]) / TICK
    assert rates[0] == pytest.approx(rates[1], rel=2e-5)


@pytest.mark.capability("10-23", "10-94")
def test_the_growth_where_friction_holds_the_tip_is_that_of_the_wrist_behind_it():
    robot, q, normal, _ = SPATIAL
    job, driven = pressed(robot, q, normal, 'kind = "pd_gravity"\nkp = 1500\nkd = 60', 0.9)
    arm, base = mf.load(robot), np.array(q)
    T = arm.forward_kinematics(base)
    J = T[:3, :3] @ arm.jacobian_body(base)[3:]
    # Rotations about the resting tip: the null space of J, by what the wrist does.
    Z = np.linalg.svd(J)[2][3:].T
    Z = Z @ np.linalg.inv(Z[3:])
    scenario = replace(driven.scenario, q=base, qd=np.zeros(6), step=TICK, period=TICK)
    factor = growth_along(job, replace(driven, scenario=scenario)).factor
    step = step_of_runs(scenario, Z, [3, 4, 5])
    rates = np.log([factor, np.abs(np.linalg.eigvals(step)).max()]) / TICK
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)
