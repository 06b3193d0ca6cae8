"""The compiled search: bit for bit that of its source as Python, and its starts in the order of their distance."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik.numerical.fast_search import search_of
from mafsil.ik.numerical.records import LAST, NEAREST, SECOND, features_of, next_sample

SEARCH = """
import sys
import numpy as np, mafsil as mf
robot = mf.load(sys.argv[1])
q = np.random.default_rng(3).uniform(-1, 1, (5, robot.n))
T = robot.forward_kinematics(np.clip(q, robot.limits.lower, robot.limits.upper))
T[3, :3, 3] += 9.0
for given in (dict(), dict(q0=q + 0.2), dict(task="position"), dict(q_preferred=q * 0)):
    found = mf.solve_ik(robot, T, restarts=4, **given)
    print(found.nearest.tobytes().hex(), found.iterations.tolist(), found.attempts.tolist(), found.codes.tolist())
print(mf.solve_ik(robot, T[0], q0=q[1]).nearest.tobytes().hex())
"""


@pytest.mark.parametrize("name", ["panda", "planar3r", "scara_rrrp"])
def test_the_search_is_the_same_as_python(name):
    """Whole searches, their loops compiled, and run by Python around the same kernels."""
    found: list[str] = []
    for mode in ("", "python"):
        environment = dict(os.environ) | {"MAFSIL_LOOPS": mode}
        found.append(subprocess.check_output([sys.executable, "-c", SEARCH, name], env=environment, text=True))
    assert found[0] == found[1]
    assert len(found[0]) > 1000


def test_samples_come_in_the_order_of_their_distance():
    robot = mf.load("puma560")
    plan = search_of(robot, None, True, 0, "pose", (0.0, 0.0, 1.0), None, 1e-10, None).plan
    T = robot.forward_kinematics(np.full(6, 0.3)).reshape(16)
    exact, lane = np.zeros(12), np.full(5, -1)
    features_of(plan.record, T, exact)
    rows, pool = plan.problem.poses(plan.pool.samples), plan.pool
    features = np.hstack([pool.rotation_factor * rows[:, :3, :3].reshape(-1, 9), pool.position_factor * rows[:, :3, 3]])
    distances = ((features - exact) ** 2).sum(axis=1)
    chosen: list[int] = []
    while (k := next_sample(plan.record, T, lane)) >= 0:
        assert lane[LAST] == k
        chosen.append(k)
    begins = pool.first_sample
    cells = [np.arange(begins[c], begins[c + 1]) for c in lane[[NEAREST, SECOND]]]
    assert sorted(chosen) == sorted(np.concatenate(cells).tolist())
    np.testing.assert_array_less(-1e-5, np.diff(distances[chosen]))
    assert distances[chosen[0]] <= np.sort(distances)[20]
