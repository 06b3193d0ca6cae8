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


@pytest.mark.parametrize("name", library.names())
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
    with pytest.raises(ModelError, match=r'no body has.*b.*without=\["inertia"\]'):
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
