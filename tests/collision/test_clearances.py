"""What is known before a question: where bodies can be, how near pairs come, what is out of reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Obstacle, Scene, Sphere
from mafsil.collision import clearance_loops as known_loops
from mafsil.collision.arm_loops import gap_between, place_bodies, scratch_for
from mafsil.collision.clearance_tables import Regions
from mafsil.collision.joints import joints_of
from mafsil.kernels.loops.lanes import WIDTH
from mafsil.kernels.loops.loop import compiled
from mafsil.model.placement import rotation_z
from tests.collision.arms import arm, scene
from tests.collision.clearance_probe_loops import bounds

WRIST = """<robot name="wrist">
<link name="forearm"><collision><origin xyz="0.1 0 0"/><geometry><box size="0.3 0.05 0.05"/></geometry></collision>
</link><link name="turner"/>
<link name="hand"><collision><origin xyz="0.06 0.02 0"/><geometry><sphere radius="0.04"/></geometry></collision>
<collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.02" length="0.1"/></geometry></collision></link>
<link name="finger"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
<joint name="bend" type="revolute"><parent link="forearm"/><child link="turner"/><origin xyz="0.3 0 0"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="1.5" effort="1" velocity="1"/></joint>
<joint name="roll" type="{roll}"><parent link="turner"/><child link="hand"/><axis xyz="1 0 0"/>{limit}</joint>
<joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/><origin xyz="0 0 0.16"/>
<axis xyz="0 1 0"/><limit lower="0" upper="0.02" effort="1" velocity="1"/></joint></robot>"""
SPINNING = """<robot name="spinning">
<link name="forearm"><collision><origin xyz="0 0 0"/><geometry><box size="0.5 0.05 0.05"/></geometry></collision>
</link><link name="first"/><link name="second"/>
<link name="hand"><collision><origin xyz="0.12 0.02 0"/><geometry><sphere radius="0.04"/></geometry></collision></link>
<joint name="bend" type="revolute"><parent link="forearm"/><child link="first"/><origin xyz="0.3 0 0"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="sway" type="revolute"><parent link="first"/><child link="second"/><origin xyz="0.05 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="spin" type="{spin}"><parent link="second"/><child link="hand"/><axis xyz="1 0 0"/>{limit}</joint>
</robot>"""
LIMITED = '<limit lower="-2" upper="2.5" effort="1" velocity="1"/>'


@compiled
def _gaps(arm, poses, out):
    s = scratch_for(arm)
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(len(arm.pairs)):
            out[r, k] = gap_between(arm, arm.pairs[k, 0], arm.pairs[k, 1], poses[r], 10.0, 0.0, s)


def wrist(tmp_path, roll="revolute", limit=LIMITED) -> Checker:
    path = tmp_path / "wrist.urdf"
    path.write_text(WRIST.format(roll=roll, limit=limit))
    return Checker(str(path))


def looked_up(checker, q):
    """(m, pairs) bounds of configurations (m, n), m a multiple of eight."""
    known = checker.world().known
    out = np.full((len(q) // WIDTH, len(known.table), WIDTH), -np.inf)
    for some, rows in zip(out, q.reshape(-1, WIDTH, q.shape[1]), strict=True):
        bounds(known, np.ascontiguousarray(rows), some)
    return out.transpose(0, 2, 1).reshape(len(q), -1)


def gaps(checker, q):
    """(m, pairs) distances, zero or less where bodies meet."""
    out = np.empty((len(q), len(checker.arm.pairs)))
    _gaps(checker.arm, checker.robot.link_poses(q), out)
    return out


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("roll", [("revolute", LIMITED), ("continuous", "")])
def test_tables_are_below_the_distances_and_near_them(tmp_path, roll):
    checker = wrist(tmp_path, *roll)
    known = checker.world().known
    assert (known.table >= 0).all()
    assert len(known.table) == 2
    q = checker.random_configurations(8000)
    q[:, 1] += np.where(roll[0] == "continuous", 2 * np.pi * np.arange(8000) % 40 - 20, 0.0)
    found, true = looked_up(checker, q), np.minimum(gaps(checker, q), 0.3)
    assert (found <= true + 1e-12).all()
    assert np.isfinite(found).all()
    assert (true - found).mean() < 0.03
    assert ((true <= 0.0).any(axis=0)).all()


@pytest.mark.capability("11-39")
def test_tables_know_nothing_of_angles_that_are_no_angles_any_more(tmp_path):
    checker = wrist(tmp_path, "continuous", "")
    found = looked_up(
        checker, np.array([[0.2, roll, 0.01] for roll in (0.0, 1e7, -1e7, 1e12, -1e12, 1e300, np.inf, np.nan)])
    )
    assert np.isfinite(found[:3]).all()
    assert (found[3:] == known_loops.UNKNOWN).all()


@pytest.mark.capability("11-39")
def test_tables_know_nothing_beyond_the_limits(tmp_path):
    checker = wrist(tmp_path)
    inside = np.array([[0.2, 0.3, 0.01]])
    outside = np.array([[1.6, 0.3, 0.01], [-3.1, 0.3, 0.01], [0.2, 2.6, 0.01], [0.2, 0.3, 0.03], [0.2, 0.3, -0.01]])
    found = looked_up(checker, np.concatenate([inside, outside, inside, inside]))
    hand, finger = (k for k, (_, b) in enumerate(checker.arm.pairs) if checker.bodies[b].name in ("hand", "finger"))
    assert np.isfinite(found[[0, 6, 7]]).all()
    assert (found[1:4] == known_loops.UNKNOWN).all()
    assert (found[4:6, finger] == known_loops.UNKNOWN).all()
    assert np.isfinite(found[4:6, hand]).all()
    beyond = np.concatenate([outside, checker.random_configurations(4000) * 1.5])
    assert (checker.in_collision(beyond) == (gaps(checker, beyond) <= 0.0).any(axis=1)).all()


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("spin", [("revolute", LIMITED), ("continuous", "")])
def test_tables_over_two_coordinates_hold_for_all_values_of_a_third(tmp_path, spin):
    path = tmp_path / "spinning.urdf"
    path.write_text(SPINNING.format(spin=spin[0], limit=spin[1]))
    checker = Checker(str(path))
    assert (checker.world().known.table >= 0).all()
    q = checker.random_configurations(8000)
    found, true = looked_up(checker, q), np.minimum(gaps(checker, q), 0.3)
    assert (found <= true + 1e-12).all()
    assert (found > 0.0).mean() > 0.5
    assert ((true <= 0.0).any(axis=0)).all()
    q[:, 2] += 2 * np.pi
    assert np.isfinite(looked_up(checker, q)).all() == (spin[0] == "continuous")
    assert (checker.in_collision(q) == (gaps(checker, q) <= 0.0).any(axis=1)).all()


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("name", ["puma560", "panda", "offset_stanford"])
def test_bodies_stay_in_their_regions(name):
    mechanism = mf.load(name).mechanism
    T = rotation_z(0.7)
    T[:3, 3] = (0.3, -0.2, 0.5)
    checker = Checker(replace(mechanism, T_sb=T), radius=0.05)
    regions, bodies = checker.laid.regions, checker.arm.bodies
    poses = checker.robot.link_poses(checker.random_configurations(2000) * 3.0)
    for region, body in zip(regions, bodies, strict=True):
        at = poses[:, int(body[0]), :3]
        centres = at[:, :, :3] @ body[4:7] + at[:, :, 3]
        assert np.linalg.norm(centres - region[:3], axis=1).max() + body[7] <= region[3] + 1e-9
    assert np.isfinite(regions[0]).all()


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("name", ["puma560", "panda", "offset_stanford"])
def test_bodies_stay_as_near_to_axes_as_levers_say(name):
    """Whether the hinge moves the body or the body stands where the hinge is moved."""
    checker = Checker(name, radius=0.05)
    arm, joints, limits = checker.arm, checker.laid.motion.joints, checker.robot.limits
    regions = Regions(checker.robot.mechanism, joints_of(checker.robot.mechanism), arm, limits.lower, limits.upper)
    poses = checker.robot.link_poses(checker.random_configurations(2000))
    for j in np.flatnonzero(joints[:, 3] != 0.0):
        axes = poses[:, int(joints[j, 0]), :3]
        along = axes[:, :, :3] @ joints[j, 5:8]
        for b, body in enumerate(arm.bodies):
            at = poses[:, int(body[0]), :3]
            away = np.cross(at[:, :, :3] @ body[4:7] + at[:, :, 3] - axes[:, :, 3], along)
            assert np.linalg.norm(away, axis=1).max() + body[7] <= regions.lever(j, b) + 1e-9


@pytest.mark.capability("11-39")
def test_what_a_body_never_meets_is_further_than_said(tmp_path):
    around = Scene([*scene(3), Obstacle(Box((0.2, 0.3, 0.4)), (0.9, 0.0, 0.2), "shelf")])
    checker = Checker(arm(tmp_path), around)
    apart, rows = checker.world().few.apart, checker.world().around.pieces.rows
    assert apart.shape == (len(checker.bodies), len(around))
    assert (apart > 0.0).any()
    for b, body in enumerate(checker.bodies):
        for j in np.flatnonzero(apart[b] > 0.0):
            alone = checker.with_scene([around.obstacles[int(rows[j, 7])]])
            found = alone.distance(checker.random_configurations(200))
            nearest = found.distance[(found.first == body.name) & (found.second == alone.scene.names[0])]
            assert (nearest >= apart[b, j] - 1e-9).all()


@pytest.mark.capability("11-39")
def test_few_and_many_pieces_give_the_same_verdicts(tmp_path):
    """Few pieces are asked one after another, many through a tree: obstacles far away make few many."""
    few = Checker(arm(tmp_path), scene(5))
    far = [Obstacle(Sphere(0.1), (50.0 + k, 0.0, 0.0), f"far {k}") for k in range(30)]
    many = few.with_scene([*scene(5).obstacles, *far])
    q = few.random_configurations(4000)
    assert few.world().few.apart.shape[1] == len(scene(5))
    assert many.world().few.apart.shape[1] == 0
    verdicts = few.in_collision(q)
    assert 0.1 < verdicts.mean() < 0.9
    assert (verdicts == many.in_collision(q)).all()
