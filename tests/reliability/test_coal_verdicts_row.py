"""Row R20, verdicts of coal and distances between two bounds, at the size of a pull request."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil import collision
from tests.collision.arms import scene
from tests.collision.peer import BODIES, random_poses
from tests.reliability import coal_verdicts
from tests.reliability.coal_paths import primitives
from tests.sizes import size


@pytest.mark.row("R20")
@pytest.mark.capability("11-39")
def test_verdicts_are_those_of_coal_and_distances_lie_between_two_bounds():
    arm, peer = primitives()
    rng = np.random.default_rng(20)
    total = coal_verdicts.pairs(0, 1500) | coal_verdicts.awkward_pairs(0, size(300, 5_000))
    for k in range(4):
        q = rng.uniform(arm.robot.limits.lower, arm.robot.limits.upper, (250, arm.robot.n))
        for name, value in coal_verdicts.compared(arm.with_scene(scene(k, 3 + k)), peer, q).items():
            total[name] = total.get(name, 0) + value
    assert not any(value for name, value in total.items() if name.startswith("bad_"))
    assert total["states"] == 1000
    assert 100 < total["colliding"] < 900
    assert total["apart"] > 500


@pytest.mark.capability("11-39")
def test_wrong_verdicts_and_distances_would_be_seen():
    """Another scene gives other verdicts; a turned normal or a moved point leaves a gap between the bounds."""
    arm, peer = primitives()
    q = arm.random_configurations(200)
    right, other = arm.with_scene(scene(1, 8)), arm.with_scene(scene(2, 8))
    theirs, distance = peer.verdicts(other, q, right.in_collision(q))
    assert (theirs != right.in_collision(q)).any()
    assert np.isfinite(distance).any()
    (a, _), (b, _) = BODIES["box"], BODIES["cone"]
    T_a, T_b = random_poses(50, 0.6, 1), random_poses(50, 0.6, 2)
    found = collision.distance(a, b, T_a, T_b)
    apart = found.distance > 0.05
    turned = found.normal + 1e-3 * np.roll(found.normal, 1, axis=1)
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    assert (found.distance - coal_verdicts.slab(a, T_a, b, T_b, turned))[apart].min() > coal_verdicts.RIGHT
    assert coal_verdicts.beyond(a, T_a, found.point_a - 1e-6 * found.normal)[apart].min() > coal_verdicts.RIGHT
