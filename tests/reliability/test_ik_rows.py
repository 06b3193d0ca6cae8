"""Rows R5, R6 and R7 at the size of a pull request; the modules they call go on to any size."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.ik import inverse_kinematics
from mafsil.ik.chain import chain_of
from tests.reliability import (
    ik_complete,
    ik_eaik,
    ik_numerical,
    ik_offset_wrists,
    ik_round_trip,
    ik_singular,
    ik_unreachable,
)
from tests.reliability.arm_families import forward
from tests.reliability.ik_arms import ARMS, arm


@pytest.mark.row("R5")
@pytest.mark.parametrize("name", ["panda", "ur5e", "puma560", "kinova", "baxter"])
def test_reachable_poses_are_reached_one_by_one(name: str) -> None:
    found = ik_numerical.shard(name, 150, seed=5)
    if not found["poses"]:
        pytest.skip("example-robot-data is not installed")
    assert not any(value for key, value in found.items() if key.startswith("bad_pose") or key.startswith("bad_limit"))
    assert found["missed"] == 0


def test_there_are_ten_arms_and_more() -> None:
    assert len(ARMS) >= 16
    assert sum((robot := arm(name)) is not None and robot.n >= 7 for name in ("panda", "fr3", "iiwa7")) == 3


@pytest.mark.row("R6")
@pytest.mark.parametrize("name", ["puma", "generalised_puma", "ur", "elbow6r", "ur5e"])
def test_planted_postures_are_found(name: str) -> None:
    found = ik_complete.work([name], seed=1, cases=120)
    assert found["cases"] >= 90
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R6")
def test_arms_that_are_by_chance_almost_of_a_simpler_family_are_judged_by_the_public_call() -> None:
    place = list(ik_complete.FAMILIES).index("parallel_at_4")
    found = ik_complete.of_family("parallel_at_4", np.random.default_rng([1, place]), 10)
    assert found["snapped"] == 1
    assert found["cases"] == 10
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R6")
@pytest.mark.parametrize("name", ik_singular.ARMS)
def test_postures_at_singular_surfaces_are_found_or_members_of_families(name: str) -> None:
    found = ik_singular.work(np.random.default_rng(4), name, 20)
    assert found["cases"] >= 16
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R6")
@pytest.mark.capability("07-44")
@pytest.mark.parametrize("name", ik_offset_wrists.SHAPES)
def test_arms_with_offset_wrists_lose_no_regular_posture_at_round_joint_values(name: str) -> None:
    found = ik_offset_wrists.work(np.random.default_rng(8), name, 150)
    assert found["regular_postures"] >= 55
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R6")
def test_a_straight_wrist_at_a_folded_elbow_is_a_family_of_joint_4() -> None:
    arm = ik_singular.specimens()["puma560"]
    q = np.array([0.0, 2.5862768187304592, 1.6177742431347037, -2.3140338461064927, np.pi, 0.5465957355779478])
    answer = inverse_kinematics(arm.robot, forward(arm.chain, q[None])[0])
    members = [family.at(q[3]) for family in answer.families if family.joint == "joint4"]
    assert members
    assert min(np.abs((member - q + np.pi) % (2 * np.pi) - np.pi).max() for member in members) < 1e-6


@pytest.mark.row("R6")
def test_shoulder_elbow_and_wrist_at_once_are_not_out_of_reach() -> None:
    arm = ik_singular.specimens()["ur5e"]
    q = np.array([0.463643003, -1.468710203, -1.897264370e-12, -2.661570577, 3.141592656, -2.206380763])
    for shift in np.linspace(-3e-9, 3e-9, 7):
        T = forward(arm.chain, (q + shift * np.eye(6)[4])[None])[0]
        assert len(inverse_kinematics(arm.robot, T))
        assert inverse_kinematics(arm.robot, T[None]).solved.all()


@pytest.mark.row("R6")
@pytest.mark.parametrize("name", ["puma560", "ur5e", "arm6r"])
def test_postures_are_those_of_eaik(name: str) -> None:
    pytest.importorskip("eaik.IK_HP")
    robot = ik_complete.library()[name]
    chain = chain_of(robot.mechanism)
    assert chain is not None
    found = ik_eaik.compared(robot, ik_eaik.rival(chain), np.random.default_rng(6), 200)
    assert found["equal"] == 200


@pytest.mark.row("R7")
def test_what_cannot_be_reached_is_said_so() -> None:
    found = ik_unreachable.work(seed=3, cases=500)
    assert found["cases"] >= 470
    assert found["rank_4"] > 0
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R16")
@pytest.mark.parametrize("name", ["puma560", "iiwa7", "planar3r", "erd/panda", "erd/so101", "erd/talos_left_arm"])
def test_reachable_poses_are_never_answered_no(name: str) -> None:
    known = ik_round_trip.sources()
    if name not in known:
        pytest.skip("example-robot-data is not installed")
    found = ik_round_trip.work({name: known[name]}, seed=3, poses=21, most=1)
    assert found["poses"] == 21
    assert found["solutions"] >= 21
    assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}


@pytest.mark.row("R6")
def test_ur_wrists_bent_a_little_where_shoulder_and_elbow_are_merged_lose_nothing() -> None:
    arm = ik_singular.specimens()["ur5e"]
    planted = ik_singular.plant(arm, np.random.default_rng(5), 20, ("elbow", "shoulder", "wrist"))
    for q in planted:
        q[4] = np.round(q[4] / np.pi) * np.pi + 2e-8
        found = ik_singular.judged(arm, arm.chain, q, forward(arm.chain, q[None])[0])
        assert not {key: value for key, value in found.items() if key.startswith("bad_") and value}
