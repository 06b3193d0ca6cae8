"""What we write as SDFormat is read by libsdformat, in Drake, without a warning, and computes the same there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import ModelError
from mafsil.model import Actuator, Inertial, Limits, Link, Mechanism, library, sdf, urdf
from tests.model.drake_reader import by_drake, plant_of, warnings_of
from tests.model.peer_readers import differences, text_of
from tests.model.random_robots import random_robot
from tests.model.sdf.test_sdf_loops import ENDS, bars
from tests.model.test_saving import arm
from tests.model.urdf.real_files import robots
from tests.oracles.random_tree import random_tree
from tests.sizes import few

NEAR = 1e-10
"""Links that move without mass have 1e-12 kg."""
IMPOSSIBLE = {"allegro_left_hand", "allegro_right_hand", "icub_reduced", "pr2", "romeo_small", "romeo_laas_small"}
"""Published robots with inertias that no body has, where no shift along joint axes mends them."""


def same(mechanism: Mechanism, seed: int = 0) -> None:
    """Equal numbers, and nothing for libsdformat to complain of."""
    text = text_of(mechanism, sdf)
    worst = differences(mechanism, text, by_drake, seed)
    assert max(worst.values()) < NEAR, worst
    assert warnings_of(text) == []


@pytest.mark.parametrize("name", library.robots())
def test_library_arms(name: str) -> None:
    mechanism = library.load(name)
    if name == "puma560":
        with pytest.raises(ModelError, match=r'without=\["friction"\]'):
            sdf.write(mechanism)
    else:
        sdf.write(mechanism)
    same(mechanism)


@pytest.mark.parametrize("seed", few(range(200), 20))
def test_random_robots(seed: int) -> None:
    same(random_robot(seed), seed)


@pytest.mark.parametrize("seed", few(range(40), 4))
def test_random_robots_with_screws(seed: int) -> None:
    same(random_tree(np.random.default_rng(seed), most_joints=9), seed)


def typed() -> dict[str, mf.Robot]:
    """Arms as people type them."""
    home = np.eye(4)
    home[:3, 3] = 0.7, 0.0, 0.2
    screws = [[0, 0, 1, 0, 0, 0], [0, 1, 0, -0.2, 0, 0], [0, 0, 0, 1, 0, 0]]
    rows = [[0.1, 90, 0.4, 0], [0.5, 0, 0, 10], [0.3, -90, 0.1, 0]]
    return {
        "classic": mf.Robot.from_dh(rows, "classic", degrees=True),
        "modified": mf.Robot.from_dh(rows, "modified", degrees=True),
        "screws": mf.Robot.from_screws(np.array(screws, float), home),
    }


@pytest.mark.parametrize("name", ["classic", "modified", "screws", "table"])
def test_typed_arms(name: str, tmp_path: Path) -> None:
    if name == "table":
        mf.save(typed()["modified"], tmp_path / "arm.toml")
        robot = mf.load(tmp_path / "arm.toml")
    else:
        robot = typed()[name]
    same(robot.mechanism)
    loaded = robot.mechanism.with_payload(2.0, com=(0.0, 0.1, 0.05), inertia=np.diag([0.02, 0.03, 0.04]))
    same(loaded)


@pytest.mark.parametrize(
    "path", few([path for path in robots() if path.stem not in IMPOSSIBLE], 8), ids=lambda path: path.stem
)
def test_published_robots(path: Path) -> None:
    """Without their shapes, whose files are somewhere else."""
    mechanism = urdf.read(path)
    if not 0 < mechanism.n <= 30:
        pytest.skip("too large for this test, or nothing moves")
    same(replace(mechanism, links=tuple(replace(link, visuals=(), collisions=()) for link in mechanism.links)))


def test_an_inertia_that_no_body_has() -> None:
    """As it is, libsdformat complains; what we write instead it takes."""
    body = Inertial(1.0, inertia=np.diag([0.5, 0.1, 0.1]))
    robot = replace(arm(axis=np.array([0.0, 1.0, 0.0])), links=(Link("a"), Link("b", body)))
    with pytest.raises(ModelError, match=r'not physically consistent.*b.*without=\["inertia"\]'):
        sdf.write(robot)
    text = sdf.write(robot, without=["inertia"])
    assert warnings_of(text) == []
    moments = [f"<i{axis}{axis}>{value}</i{axis}{axis}>" for axis, value in zip("xyz", (0.5, 0.1, 0.1), strict=True)]
    start, end = text.rindex("<ixx>"), text.rindex("<ixy>")
    assert warnings_of(text[:start] + "".join(moments) + text[end:])


def test_limits_motors_and_gravity_reach_drake() -> None:
    limits = Limits(-1.0, 2.0, 3.0, 4.0, effort=5.0)
    text = sdf.write(arm(limits=limits, actuator=Actuator(1e-4, 100.0)), without=["actuator"])
    plant = plant_of(text)
    joint, motor = plant.GetJointByName("hinge"), plant.GetJointActuatorByName("hinge")
    assert (joint.position_lower_limits()[0], joint.position_upper_limits()[0]) == (-1.0, 2.0)
    assert (joint.velocity_upper_limits()[0], joint.acceleration_upper_limits()[0]) == (3.0, 4.0)
    assert (motor.effort_limit(), motor.default_gear_ratio(), motor.default_rotor_inertia()) == (5.0, 100.0, 1e-4)
    assert plant_of(sdf.write(arm(actuated=False))).num_actuators() == 0


def test_libsdformat_takes_loops() -> None:
    """Drake has no loops; its parser reads them, and says so afterwards, of the graph."""
    with pytest.raises(RuntimeError, match="loops in the system graph"):
        plant_of(sdf.write(sdf.read(bars(ENDS, "ABDC"))))


def framed_model(rng: np.random.Generator) -> tuple[str, list[str], list[str]]:
    """A tree whose joints begin and end at links, frames on them, or the model; poses relative to anything before.

    Frames stand in the order in which they hang on each other, and none on a joint: there Drake 1.51 takes their poses
    relative to the link, not to what they are attached to (sdformat.org: `relative_to` defaults to `attached_to`).
    """

    def pose(relative: list[str]) -> str:
        numbers = " ".join(map(str, rng.uniform(-1, 1, 6).round(3)))
        where = f' relative_to="{rng.choice(relative)}"' if rng.random() < 0.6 else ""
        return f"<pose{where}>{numbers}</pose>" if rng.random() < 0.8 else ""

    count = int(rng.integers(2, 6))
    links, ends, parts = [f"l{k}" for k in range(count)], dict[str, list[str]](), []
    for k, name in enumerate(links):
        moments = "<inertia><ixx>1</ixx><iyy>1.2</iyy><izz>1.5</izz></inertia>"
        parts.append(f'<link name="{name}">{pose(links[:k] or ["__model__"])}<inertial>{moments}</inertial></link>')
        ends[name] = [name]
        for j in range(int(rng.integers(0, 3))):
            parts.append(f'<frame name="f{k}{j}" attached_to="{rng.choice(ends[name])}">{pose(ends[name])}</frame>')
            ends[name].append(f"f{k}{j}")
    ends["l0"].append("__model__")
    parts.append('<joint name="w" type="fixed"><parent>world</parent><child>l0</child></joint>')
    for k in range(1, count):
        parent, child = rng.choice(ends[f"l{rng.integers(k)}"]), rng.choice(ends[f"l{k}"])
        kind, named = rng.choice(["revolute", "prismatic"]), [*links, *ends[f"l{k}"]]
        where = f' expressed_in="{rng.choice(named)}"' if rng.random() < 0.5 else ""
        axis = f"<axis><xyz{where}>{' '.join(map(str, rng.normal(size=3).round(3)))}</xyz></axis>"
        relative = pose([*named, "__model__"])
        parts.append(
            f'<joint name="j{k}" type="{kind}">{relative}<parent>{parent}</parent><child>{child}</child>{axis}</joint>'
        )
    order = sorted(rng.permutation(len(parts)), key=lambda k: k * parts[k].startswith("<frame"))
    text = f'<sdf version="1.9"><model name="m" canonical_link="l0">{"".join(parts[k] for k in order)}</model></sdf>'
    return text, [f"j{k}" for k in range(1, count)], [name for found in ends.values() for name in found]


@pytest.mark.parametrize("seed", few(range(300), 25))
def test_frames_of_others_are_read_as_libsdformat_reads_them(seed: int) -> None:
    """Poses of all links and frames at random coordinates, whatever the order of the file."""
    text, joints, names = framed_model(np.random.default_rng(seed))
    plant, robot = plant_of(text), mf.Robot(sdf.read(text))
    context, rng = plant.CreateDefaultContext(), np.random.default_rng(seed)
    values = dict(zip(joints, rng.uniform(-2, 2, len(joints)), strict=True))
    x = np.zeros(plant.num_positions())
    for name, value in values.items():
        x[plant.GetJointByName(name).position_start()] = value
    plant.SetPositions(context, x)
    q = np.array([values[name] for name in robot.joint_names])
    for name in names:
        if name != "__model__":
            theirs = plant.GetFrameByName(name).CalcPoseInWorld(context).GetAsMatrix4()
            np.testing.assert_allclose(robot.forward_kinematics(q, frame=name), theirs, atol=1e-12, err_msg=name)
