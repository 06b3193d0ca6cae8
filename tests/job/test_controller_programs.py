"""Plans as programs of controllers and of ROS 2, read back."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

import mafsil as mf
from mafsil.cli.main import main
from mafsil.collision import Box, Capsule, Checker, Cone, ConvexHull, Cylinder, Obstacle, Plane, Scene, Sphere
from mafsil.errors import FileError, InputError
from mafsil.geometry.quaternion import from_quaternion, to_quaternion
from mafsil.job.language.reading import parse_job
from mafsil.job.planning.controller_program import LANGUAGES, instructions, language_of, read_program, write_program
from mafsil.job.planning.ros_program import RATE, program_for
from mafsil.job.solve import prepare
from mafsil.model import library
from tests.sizes import few

ARMS = tuple(name for name in library.robots() if not library.load(name).loops)
HEAD = """
robot = "ROBOT"
[tool]
offset = { position = [0.01, -0.02, 0.13], rpy = [0.3, -0.2, 0.5] }
mass = 0.4
com = [0.0, 0.01, 0.05]
[output]
close = false
[input.there]
start = true
[collision]
self_collision = false
[start]
joints = START
"""
MOVES = """
[[move]]
joints = GOAL
[[move]]
pick = { mass = 0.02, offset = [0.0, 0.0, 0.03] }
[[move]]
set = { close = true }
[[move]]
wait = { there = true }
[[move]]
pause = 0.125
[[move]]
pose = { relative = "space", position = [0.003, -0.004, 0.002] }
path = "line"
[[move]]
joints = START
"""


@cache
def planned(robot, moves=MOVES):
    arm = mf.load(robot)
    low, high = np.maximum(arm.limits.lower, -1.5), np.minimum(arm.limits.upper, 1.5)
    text = HEAD.replace("ROBOT", robot) + (moves if arm.n > 5 else moves.replace('path = "line"\n', 'path = "joint"\n'))
    if arm.n < 6:
        text = text.replace('pose = { relative = "space", position = [0.003, -0.004, 0.002] }', "joints = GOAL")
    for seed in range(20):  # until the line does not start at a singularity
        start = low + (high - low) * np.random.default_rng(seed).uniform(0.2, 0.8, arm.n)
        goal = start + 0.05 * (high - low) * np.cos(np.arange(arm.n))
        made = text.replace("START", str(start.tolist())).replace("GOAL", str(goal.tolist()))
        if found := prepare(parse_job(made), made, Path()):
            return made, parse_job(made), *found
    raise AssertionError(found)


def again(text, steps, robot):
    """The path of a program, planned by what it says alone."""
    first, lines, head = None, [], text[: text.index("[start]")]
    for step in steps:
        if step.kind == "joints" and first is None:
            first = step.values.tolist()
        elif step.kind == "joints":
            lines.append(f"[[move]]\njoints = {step.values.tolist()}")
        elif step.kind == "line":
            p, w = step.values[:3, 3].tolist(), to_quaternion(step.values[:3, :3]).tolist()
            pose = f"position = {p}, quaternion = {w}"
            lines.append(f'[[move]]\npose = {{ {pose} }}\npath = "line"')
    made = "\n".join([head, f"[start]\njoints = {first}", *lines])
    return [leg for leg in prepare(parse_job(made), made, Path())[1].legs if leg.kind in ("joint", "line")]


@pytest.mark.parametrize("name", LANGUAGES)
@pytest.mark.parametrize("robot", few(ARMS, 10))
def test_a_program_read_back_is_the_plan_and_moves_along_the_same_path(robot, name):
    language = LANGUAGES[name]
    text, job, arm, plan = planned(robot)
    if name == "urscript" and arm.n != 6:
        with pytest.raises(InputError, match="6 to 6"):
            write_program(job, plan, language)
        return
    program = write_program(job, plan, language)
    steps, back = instructions(job, plan)[0], read_program(program.text, language, arm.mechanism.angular)
    assert [one.kind for one in back] == [one.kind for one in steps]
    assert {"joints", "tool", "load", "set", "wait", "pause"} <= {one.kind for one in back}
    for one, other in zip(steps, back, strict=True):
        np.testing.assert_allclose(other.values, one.values, rtol=0.0, atol=1e-11)
        assert one.number == other.number
        if language.keeps_time:
            assert other.time == pytest.approx(one.time, abs=1e-12)
    legs = [leg for leg in plan.legs if leg.kind in ("joint", "line")]
    for leg, other in zip(legs, again(text, back, robot), strict=True):
        share = np.linspace(0.0, 1.0, 101)
        ours, theirs = (one.trajectory.at(share * one.trajectory.duration).u for one in (leg, other))
        np.testing.assert_allclose(theirs, ours, rtol=0.0, atol=1e-9)
    loads = [one.values for one in back if one.kind == "load"]
    assert [round(float(load[0]), 9) for load in loads] == [0.4, 0.42]
    T = next(one.values for one in steps if one.kind == "tool")
    centre = (0.4 * np.array([0.0, 0.01, 0.05]) + 0.02 * (T[:3, :3] @ [0.0, 0.0, 0.03] + T[:3, 3])) / 0.42
    np.testing.assert_allclose(loads[1][1:], centre, atol=1e-12)


SEAM = """
robot = "ur5e"
[tool]
offset = { position = [0.0, 0.06, 0.32], rpy = [0, 0, 0] }
[output]
arc = false
[start]
START
"""
SEAM_START = "pose = { position = [0.4, -0.15, 0.18], quaternion = [0, 1, 0, 0] }"
SEAM_MOVES = """
[[move]]
path = "line"
pose = { position = [0.4, 0.0, 0.18] }
tip_speed = 0.05
blend = 0.003
[[move]]
path = "arc"
via = [{ position = [0.4293, 0.0707, 0.18] }]
pose = { position = [0.5, 0.1, 0.18], quaternion = [0.0, 0.99, 0.14, 0.0] }
blend = 0.004
[[move]]
path = "line"
pose = { relative = "space", position = [0.06, 0.0, 0.0] }
outputs = [{ share = 0.5, set = { arc = true } }]
[[move]]
path = "arc"
via = [{ position = [0.6, 0.15, 0.2] }]
pose = { position = [0.55, 0.2, 0.22] }
"""


@pytest.mark.parametrize("name", LANGUAGES)
def test_lines_and_arcs_with_rounded_corners_are_read_back_and_planned_again_to_the_same_path(name):
    language, text = LANGUAGES[name], SEAM.replace("START", SEAM_START) + SEAM_MOVES
    job = parse_job(text)
    arm, plan = prepare(job, text, Path())
    program = write_program(job, plan, language)
    keys = {one.key for one in program.lost}
    assert {"job.program_key", "job.program_corners"} <= keys
    assert ("job.program_arcs" in keys) == (name == "urscript")
    moves = [
        step for step in read_program(program.text, language, arm.mechanism.angular) if step.kind in ("line", "arc")
    ]
    assert [step.kind for step in moves] == ["line", "arc", "line", "arc"]
    np.testing.assert_allclose([step.zone for step in moves], [0.003, 0.004, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose([step.speed for step in moves], [0.05, 0.25, 0.25, 0.25], atol=1e-12)
    made = SEAM.replace("START", f"joints = {plan.start.tolist()}")
    for step in moves:
        via, goal = step.values if step.kind == "arc" else (None, step.values)
        points = "" if via is None else f"via = [{{ position = {via[:3, 3].tolist()} }}]\n"
        place = f"position = {goal[:3, 3].tolist()}, quaternion = {to_quaternion(goal[:3, :3]).tolist()}"
        made += f'[[move]]\npath = "{step.kind}"\n{points}pose = {{ {place} }}\n'
        made += f"blend = {step.zone}\ntip_speed = {step.speed}\n"
    other = prepare(parse_job(made), made, Path())[1]
    for one, two in zip(plan.legs[:2], other.legs[:2], strict=True):
        share = np.linspace(0.0, 1.0, 201)
        ours, theirs = (leg.trajectory.at(share * leg.trajectory.duration).u for leg in (one, two))
        np.testing.assert_allclose(theirs, ours, rtol=0.0, atol=1e-9)


def test_a_robot_on_a_track_has_no_program():
    text = 'robot = "ur5e"\n[[track]]\ndirection = [0, 1, 0]\nrange = [0, 1]\n'
    text += "[[move]]\njoints = [0.1, 0, -1, 1, -1, -1, 0]\n"
    job = parse_job(text)
    with pytest.raises(InputError, match="track"):
        write_program(job, prepare(job, text, Path())[1], LANGUAGES["krl"])


def test_what_a_language_cannot_carry_is_listed():
    choice = "[[move]]\nif = { there = true }\nthen = [{ pause = 0.1 }]\n"
    _, job, _, plan = planned("ur5e", MOVES + choice)
    keys = {one.key for one in write_program(job, plan, LANGUAGES["krl"]).lost}
    assert keys == {"job.program_gripper", "job.program_choice", "job.program_times"}
    assert all("\u0600" <= max(one.sentence("ar")) for one in write_program(job, plan, LANGUAGES["krl"]).lost)


def test_a_line_of_another_program_is_refused_with_its_number():
    _, job, arm, plan = planned("ur5e")
    text = write_program(job, plan, LANGUAGES["krl"]).text.replace("WAIT SEC", "HALT")
    with pytest.raises(FileError, match="HALT"):
        read_program(text, LANGUAGES["krl"], arm.mechanism.angular)


def test_the_command_writes_a_program_and_says_what_is_missing(tmp_path, capsys):
    job, out = Path("examples/jobs/pick_and_place_ur5_urdf.toml").resolve(), tmp_path / "pick.src"
    assert main(["check-job", str(job), "--program", str(out)]) == 0
    said = capsys.readouterr().out
    assert "gripper" in said
    assert out.read_text().startswith("DEF mafsil_job()")
    assert main(["check-job", str(job), "--program", str(tmp_path / "pick.txt")]) == 2
    assert language_of(out.suffix) is LANGUAGES["krl"]


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
def ros_plan():
    job = parse_job(JOB)
    outcome = prepare(job, JOB, Path())
    assert outcome, outcome
    return job, *outcome


def test_the_trajectory_read_back_is_the_plan(ros_plan):
    job, robot, plan = ros_plan
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


def test_the_scene_is_as_far_from_the_arm_everywhere(ros_plan):
    job, robot, plan = ros_plan
    message = yaml.safe_load(program_for(job, plan, ".yml").scene)
    assert [one["id"] for one in message["world"]["collision_objects"]] == [one.name for one in job.obstacle]
    assert all(
        one["header"]["frame_id"] == robot.mechanism.links[0].name for one in message["world"]["collision_objects"]
    )
    ours = Checker("ur5e", plan.surroundings.obstacles, self_collision=False)
    theirs = Checker("ur5e", scene_of_message(message), self_collision=False)
    q = np.random.default_rng(7).uniform(-2.5, 2.5, (60, 6))
    assert np.asarray(ours.distance(q).distance) == pytest.approx(np.asarray(theirs.distance(q).distance), abs=1e-9)


def test_hulls_become_meshes_with_all_their_corners_and_capsules_three_solids(ros_plan):
    from mafsil.job.planning.ros_program import _collision_object

    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1.0)])
    hull = _collision_object(Obstacle(ConvexHull(corners), name="hull"), "base")
    scene = scene_of_message({"world": {"collision_objects": [hull]}})
    assert {tuple(p) for p in scene.obstacles[0].geometry.points.tolist()} == {tuple(p) for p in corners.tolist()}
    assert len(_collision_object(Obstacle(Capsule(0.1, 0.2), name="post"), "base")["primitives"]) == 3
    assert _collision_object(Obstacle(ConvexHull(corners, rounding=0.01), name="soft"), "base") == {}


def test_an_unknown_ending_names_those_that_are_known(ros_plan):
    job, _, plan = ros_plan
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


@pytest.mark.parametrize("ending", [".src", ".script", ".mod", ".yaml"])
def test_process_forces_and_searches_are_listed_as_lost_in_every_language(ending):
    text = """
robot = "ur5e"
[input.probe]
changes = [[0.9, true]]
[start]
joints = [0.0, -1.5, 1.5, -1.5, -1.5, 0.0]
[[move]]
pose = { relative = "space", position = [0.0, 0.0, -0.05] }
path = "line"
process_wrench = [0, 0, 0, 0, 0, -5]
[[move]]
pose = { relative = "space", position = [0.0, 0.0, -0.1] }
path = "line"
until = { probe = true }
"""
    job = parse_job(text)
    lost = program_for(job, prepare(job, text, Path())[1], ending).lost
    assert {"process_wrench", "until"} <= {one.details.get("key") for one in lost}
