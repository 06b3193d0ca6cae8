"""Plans for ROS 2: the trajectory read back is the plan, and the MoveIt scene has the obstacles at their places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from mafsil.collision import Box, Capsule, Checker, Cone, ConvexHull, Cylinder, Obstacle, Plane, Scene, Sphere
from mafsil.errors import InputError
from mafsil.geometry.quaternion import from_quaternion
from mafsil.job.language.reading import parse_job
from mafsil.job.planning.ros_program import RATE, program_for
from mafsil.job.solve import prepare

JOB = """
robot = "ur5e"
lengths = "millimetres"
angles = "degrees"
[output]
close = false
[input.there]
start = true
[start]
joints = [0, -90, 90, -90, -90, 0]
[[obstacle]]
name = "floor"
floor = true
position = [0, 0, -60]
[[obstacle]]
name = "post"
capsule = [40, 300]
position = [700, 400, 150]
rpy = [0, 30, 0]
[[obstacle]]
name = "bin"
box = [200, 150, 80]
position = [-500, 300, 40]
rpy = [0, 0, 25]
[[obstacle]]
name = "can"
cylinder = [50, 120]
position = [-450, -300, 60]
[[obstacle]]
name = "hat"
cone = [60, 100]
position = [500, -500, 50]
rpy = [90, 0, 0]
[[obstacle]]
name = "ball"
sphere = 70
position = [0, 800, 70]
[[move]]
joints = [20, -80, 90, -100, -90, 0]
[[move]]
set = { close = true }
[[move]]
wait = { there = true }
[[move]]
joints = [0, -90, 90, -90, -90, 0]
"""


@pytest.fixture(scope="module")
def planned():
    job = parse_job(JOB)
    outcome = prepare(job, JOB, Path())
    assert outcome, outcome
    return job, *outcome


def test_the_trajectory_read_back_is_the_plan(planned):
    job, robot, plan = planned
    program = program_for(job, plan, ".yaml")
    message = yaml.safe_load(program.text)
    assert tuple(message["joint_names"]) == robot.joint_names
    times = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in message["points"]]
    assert max(np.diff(times)) <= 1.0 / RATE + 1e-9
    assert times[-1] == pytest.approx(plan.duration, abs=1e-9)
    for point, leg, t in zip(message["points"], plan.legs_at(np.array(times)), times, strict=True):
        motion = plan.legs[leg].trajectory.at(t - plan.starts[leg])
        for name, value in (("positions", motion.u), ("velocities", motion.v), ("accelerations", motion.a)):
            np.testing.assert_allclose(point[name], value, rtol=0.0, atol=1e-6 if name != "positions" else 1e-9)
    assert "set close = True" in program.text
    assert "job.program_events" in [one.key for one in program.lost]


def pose_of(data):
    T = np.eye(4)
    T[:3, 3] = [data["position"][axis] for axis in "xyz"]
    T[:3, :3] = from_quaternion([data["orientation"][name] for name in "wxyz"])
    return T


def scene_of_message(message):
    """The scene that MoveIt would have, by the definition of the message alone."""
    kinds = {
        1: lambda d: Box(tuple(d)),
        2: lambda d: Sphere(d[0]),
        3: lambda d: Cylinder(d[1], d[0]),
        4: lambda d: Cone(d[1], d[0]),
    }
    bodies = []
    for one in message["world"]["collision_objects"]:
        for k, (solid, place) in enumerate(zip(one.get("primitives", ()), one.get("primitive_poses", ()), strict=True)):
            geometry = kinds[solid["type"]](solid["dimensions"])
            bodies.append(Obstacle(geometry, pose_of(one["pose"]) @ pose_of(place), f"{one['id']} {k}"))
        for k, place in enumerate(one.get("plane_poses", ())):
            assert one["planes"][k]["coef"] == [0.0, 0.0, 1.0, 0.0]
            bodies.append(Obstacle(Plane(), pose_of(one["pose"]) @ pose_of(place), f"{one['id']} {k}"))
        for solid, place in zip(one.get("meshes", ()), one.get("mesh_poses", ()), strict=True):
            points = np.array([[p[axis] for axis in "xyz"] for p in solid["vertices"]])
            used = points[np.unique([face["vertex_indices"] for face in solid["triangles"]])]
            bodies.append(Obstacle(ConvexHull(used), pose_of(one["pose"]) @ pose_of(place), f"{one['id']} hull"))
    return Scene(bodies)


def test_the_scene_is_as_far_from_the_arm_everywhere(planned):
    job, robot, plan = planned
    message = yaml.safe_load(program_for(job, plan, ".yml").scene)
    assert [one["id"] for one in message["world"]["collision_objects"]] == [one.name for one in job.obstacle]
    assert all(
        one["header"]["frame_id"] == robot.mechanism.links[0].name for one in message["world"]["collision_objects"]
    )
    ours = Checker("ur5e", plan.surroundings.obstacles, self_collision=False)
    theirs = Checker("ur5e", scene_of_message(message), self_collision=False)
    q = np.random.default_rng(7).uniform(-2.5, 2.5, (60, 6))
    assert np.asarray(ours.distance(q).distance) == pytest.approx(np.asarray(theirs.distance(q).distance), abs=1e-9)


def test_hulls_become_meshes_with_all_their_corners_and_capsules_three_solids(planned):
    from mafsil.job.planning.ros_program import _collision_object

    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1.0)])
    hull = _collision_object(Obstacle(ConvexHull(corners), name="hull"), "base")
    scene = scene_of_message({"world": {"collision_objects": [hull]}})
    assert {tuple(p) for p in scene.obstacles[0].geometry.points.tolist()} == {tuple(p) for p in corners.tolist()}
    assert len(_collision_object(Obstacle(Capsule(0.1, 0.2), name="post"), "base")["primitives"]) == 3
    assert _collision_object(Obstacle(ConvexHull(corners, rounding=0.01), name="soft"), "base") == {}


def test_an_unknown_ending_names_those_that_are_known(planned):
    job, _, plan = planned
    with pytest.raises(InputError, match=r"\.script.*\.yaml"):
        program_for(job, plan, ".txt")


def test_the_command_writes_trajectory_and_scene(tmp_path, capsys):
    from mafsil.cli.main import main

    job, out = tmp_path / "cell.toml", tmp_path / "cell.yaml"
    job.write_text(JOB)
    assert main(["check-job", str(job), "--program", str(out)]) == 0
    assert "cell.scene.yaml" in capsys.readouterr().out
    assert len(yaml.safe_load((tmp_path / "cell.scene.yaml").read_text())["world"]["collision_objects"]) == 6
    assert yaml.safe_load(out.read_text())["points"]
