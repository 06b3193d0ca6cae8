"""Small mathematics of the page, run by Node.js against what Python computes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import mafsil as mf
from tests.page.node import run_module

ELLIPSOIDS = """
import fs from "node:fs";
import { tipEllipsoids } from "./page/core/ellipsoids.js";
const found = JSON.parse(fs.readFileSync("io.json")).map(({ J, T, n }) => tipEllipsoids(J, n, T));
process.stdout.write(JSON.stringify(found));
"""
HISTORY = """
import { History } from "./page/core/history.js";
const history = new History(2, 4);
for (let k = 0; k < 11; k++) history.push([k, -k]);
const rows = Array.from({ length: history.length }, (_, k) => [history.at(k, 0), history.at(k, 1)]);
history.clear();
process.stdout.write(JSON.stringify([rows, history.length, history.rows.length]));
"""


def test_ellipsoids_are_those_of_the_jacobian(tmp_path: Path) -> None:
    """Half axes as singular values of J_v, directions in {s}; forces are reciprocal, and absent where nothing moves."""
    rng, asked, wanted = np.random.default_rng(3), [], []
    for name in ("panda", "ur5e", "planar3r", "scara_rrrp"):
        robot = mf.load(name)
        for q in rng.uniform(-1.0, 1.0, (5, robot.n)):
            J, T = robot.jacobian_body(q), robot.forward_kinematics(q)
            asked.append({"J": J.ravel().tolist(), "T": T.ravel().tolist(), "n": robot.n})
            wanted.append(T[:3, :3] @ J[3:])
    (tmp_path / "io.json").write_text(json.dumps(asked))
    for A, found in zip(wanted, json.loads(run_module(ELLIPSOIDS, tmp_path)), strict=True):
        U, sigma, _ = np.linalg.svd(A)
        assert np.allclose(found["velocities"], np.append(sigma, np.zeros(3))[:3], atol=1e-7)
        for k, (way, force) in enumerate(zip(found["directions"], found["forces"], strict=True)):
            assert np.isclose(np.linalg.norm(A.T @ way), found["velocities"][k], atol=1e-7)
            assert abs(np.linalg.norm(way) - 1.0) < 1e-12
            if force is None:
                assert sigma[k] < 1e-6 * sigma[0]
            else:
                assert np.isclose(np.linalg.norm(A.T @ np.multiply(force, way)), 1.0, atol=1e-6)
                assert abs(abs(U[:, k] @ way) - 1.0) < 1e-5 or np.min(np.abs(np.diff(sigma))) < 1e-3


def test_history_forgets_the_oldest_and_does_not_grow(tmp_path: Path) -> None:
    rows, left, room = json.loads(run_module(HISTORY, tmp_path))
    assert rows == [[7, -7], [8, -8], [9, -9], [10, -10]]
    assert (left, room) == (0, 8)
