"""How small errors grow where rigid surfaces hold the arm, against runs that begin side by side on them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.job import Run, parse, solve
from mafsil.job.law_stability import growth_along
from mafsil.trajectory import rest

PLANAR = ("planar2r_point_masses", [0.4, 0.9], [0, 1.0, 0], [0])
SPATIAL = ("puma560", [0.4, -0.3, 0.5, 0.3, -0.4, 0.5], [0.0, 0.6, 0.8], [0, 1, 3, 4, 5])


def pressed(robot, q, normal, controller):
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
[[move]]
pause = 0.1
"""
    job = parse(text)
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
        (PLANAR, 'kind = "pd_gravity"\nstiffness = 4e4\nrate_gain = 20'),
        (SPATIAL, 'kind = "pd_gravity"\nstiffness = 1500\nrate_gain = 60'),
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
