"""Arms whose quarter turns are printed with few digits: recognised, refined to the arm as it is, in batches."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics
from mafsil.ik.answers.eliminated import beside_folds, refined_rows
from mafsil.ik.answers.setting import setting
from mafsil.mechanics.arm_pattern import Family

DOOSAN = [
    ("0 0 0.135", "0 0 0"),
    ("0 0 0", "0 -{q} -{q}"),
    ("0.411 0 0", "0 0 {q}"),
    ("0 -0.368 0", "{q} 0 0"),
    ("0 0 0", "-{q} 0 0"),
    ("0 -0.121 0", "{q} 0 0"),
]
"""Origins of a Doosan M0609's joints, from its maker's URDF."""

UR = [
    ("0 0 0.1625", "0 0 0"),
    ("0 0 0", "{q} 0 0"),
    ("-0.425 0 0", "0 0 0"),
    ("-0.3922 0 0.1333", "0 0 0"),
    ("0 -0.0997 0", "{q} 0 0"),
    ("0 0.0996 0", "{q} 3.14159 3.14159"),
]
"""Origins of a UR5e's joints."""


def arm(folder, origins, quarter):
    links = "".join(f'<link name="l{i}"/>' for i in range(7))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy.format(q=quarter)}"/><axis xyz="0 0 1"/>'
        '<limit lower="-6.28" upper="6.28" velocity="1" effort="1"/></joint>'
        for i, (xyz, rpy) in enumerate(origins)
    )
    file = folder / "arm.urdf"
    file.write_text(f'<robot name="arm">{links}{joints}</robot>')
    return mf.load(file)


@pytest.mark.parametrize("quarter", ["1.5708", "1.571"])
@pytest.mark.parametrize(("origins", "family"), [(DOOSAN, Family.SPHERICAL_WRIST), (UR, Family.THREE_PARALLEL)])
def test_planted_postures_are_found_on_the_arm_as_it_is(tmp_path, origins, family, quarter):
    robot = arm(tmp_path, origins, quarter)
    asked = setting(robot, None, "pose")
    assert asked.arm.form.pattern.family is family
    rng = np.random.default_rng(0)
    q = rng.uniform(-3.1, 3.1, (400, 6))
    T = robot.forward_kinematics(q)
    batch = inverse_kinematics(robot, T)
    assert batch
    d = np.abs((batch.q - q[:, None] + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
    assert np.where(batch.valid, d, np.inf).min(axis=1).max() < 1e-5
    reached = robot.forward_kinematics(batch.q[batch.valid])
    wanted = np.broadcast_to(T[:, None], (*batch.valid.shape, 4, 4))[batch.valid]
    assert np.abs(reached - wanted).max() < 1e-9
    assert (batch.residual[batch.valid] < 1e-9).all()


def test_lists_called_complete_are_those_of_elimination(tmp_path):
    robot = arm(tmp_path, UR, "1.5708")
    asked = setting(robot, None, "pose")
    T = robot.forward_kinematics(np.random.default_rng(1).uniform(-3.1, 3.1, (150, 6)))
    found = refined_rows(asked, T, asked.middle)
    proof = asked.arm.general.solve_all(T)
    both = found.clear & proof.complete
    assert both.sum() > 100
    np.testing.assert_array_equal(np.isfinite(found.residual).sum(axis=1)[both], proof.count[both])
    one = inverse_kinematics(robot, T[int(np.flatnonzero(both)[0])])
    assert one.complete
    assert one.method == "refined closed form"
    assert all(str(branch) != "-" for branch in one.branches)
    far = T[0].copy()
    far[:3, 3] *= 0.99 / np.linalg.norm(far[:3, 3])
    assert inverse_kinematics(robot, far).status is inverse_kinematics(robot, far[None]).status[0]


def test_rows_away_from_folds_are_refined_to_the_last_digit(tmp_path):
    robot = arm(tmp_path, UR, "1.5708")
    asked = setting(robot, None, "pose")
    T = robot.forward_kinematics(np.random.default_rng(1).uniform(-3.1, 3.1, (1000, 6)))
    # Of a step less, a tenth of the poses is left with rows that miss by more than 1e-11.
    assert refined_rows(asked, T, asked.middle).clear.mean() > 0.94


@pytest.mark.parametrize("origins", [DOOSAN, UR])
@pytest.mark.parametrize("bent", [2, 4])
def test_pairs_beside_a_fold_are_found_from_both_sides(tmp_path, origins, bent):
    robot = arm(tmp_path, origins, "1.571")
    asked = setting(robot, None, "pose")
    rng = np.random.default_rng(2)
    q = rng.uniform(-3.1, 3.1, (100, 6))
    q[:, bent] = rng.normal(size=100) * 1e-3
    T = robot.forward_kinematics(q)
    found, error = beside_folds(asked, T, asked.middle)
    d = np.abs((found - q[:, None] + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
    assert (np.where(np.isfinite(error), d, np.inf).min(axis=1) > 5e-4).sum() <= 1


def test_rounded_wrists_are_offset_wrists_whose_lists_are_proven(tmp_path):
    """A wrist whose axes nearly meet defeats every elimination; the polynomial of its last joint proves its lists."""
    assert setting(arm(tmp_path, UR, "1.5708"), None, "pose").arm.general.proves
    robot = arm(tmp_path, DOOSAN, "1.5708")
    general = setting(robot, None, "pose").arm.general
    assert general.proves
    q = np.random.default_rng(0).uniform(-3.1, 3.1, (500, 6))
    found = general.solve_all(robot.forward_kinematics(q))
    assert found.complete.mean() > 0.98
    away = np.abs((found.q - q[:, None] + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
    assert (np.nanmin(away, axis=1) < 1e-6).all()
