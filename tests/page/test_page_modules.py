"""Small mathematics of the page, run by Node.js against what Python computes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.page.arm import Arm
from mafsil.page.content import dh_table
from mafsil.page.session import action_arguments
from tests.page.node import run_module

ELLIPSOIDS = """
import fs from "node:fs";
import { tipEllipsoids } from "./page/core/linear.js";
const found = JSON.parse(fs.readFileSync("io.json")).map(({ J, T, n }) => tipEllipsoids(J, n, T));
process.stdout.write(JSON.stringify(found));
"""
SCRIPTS = """
import fs from "node:fs";
import { scriptActions } from "./page/core/script.js";
const { texts, args } = JSON.parse(fs.readFileSync("io.json"));
const read = (text) => {
  try {
    return scriptActions(text, args, "'panda'").map(({ action }) => action);
  } catch (error) {
    return error.reason ?? `${error}`;
  }
};
process.stdout.write(JSON.stringify(texts.map(read)));
"""
TABLES = """
import fs from "node:fs";
import { dhChain, dhPython } from "./page/core/dh.js";
const found = JSON.parse(fs.readFileSync("io.json")).map(({ table, q }) => [dhChain(table, q).at(-1), dhPython(table)]);
process.stdout.write(JSON.stringify(found));
"""
GRASPS = """
import fs from "node:fs";
import { coneWrenches, fingerAt, graspPython, lengthNear, planarClosure } from "./page/core/planar_grasp.js";
const found = JSON.parse(fs.readFileSync("io.json")).map(({ corners, lengths, mu }) => {
  const fingers = lengths.map((length) => fingerAt(corners, length));
  const back = fingers.map(({ point }) => fingerAt(corners, lengthNear(corners, point)).point);
  return { fingers, back, text: graspPython(fingers, mu), ...planarClosure(coneWrenches(fingers, mu)) };
});
process.stdout.write(JSON.stringify(found));
"""
HEAD = "from mafsil.page import Session\n\narm = Session('panda')\n"
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
    rng = np.random.default_rng(3)
    asked: list[dict[str, Any]] = []
    wanted: list[Any] = []
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


def scripts_read(texts: list[str], folder: Path) -> list[Any]:
    (folder / "io.json").write_text(json.dumps({"texts": texts, "args": action_arguments()}))
    return json.loads(run_module(SCRIPTS, folder))


def test_a_script_is_read_as_python_reads_it(tmp_path: Path) -> None:
    """Keywords, places, tuples, signs, remarks: the lines of docs/page.md."""
    text = HEAD + (
        "arm.set_joint(joint=3, value=-1.2e-1)\narm.set_joint(0, .5)   # by place\n# a remark\n"
        "arm.push(wrench=(0, 0, 0, -0.0, 20., 1e+1))\narm.loop(closed=True)\nprint(arm.status, arm.q.tolist())\n"
    )
    (found,) = scripts_read([text.replace("'panda'", '"panda"')], tmp_path)
    assert found == [
        {"do": "set_joint", "with": {"joint": 3, "value": -0.12}},
        {"do": "set_joint", "with": {"joint": 0, "value": 0.5}},
        {"do": "push", "with": {"wrench": [0, 0, 0, 0, 20, 10]}},
        {"do": "loop", "with": {"closed": True}},
    ]


@pytest.mark.parametrize(
    "line",
    [
        "import os", "arm.fly()", "arm.loop(closed=alert(1))", "arm.set_joint(joint=1)", "other.loop(closed=True)",
        "arm.set_joint(joint=1, value=1, value=2)", "arm.set_joint(1, 2, 3)", "arm.push(wrench=[1, [2]])",
        "for k in range(3): arm.loop(closed=True)", "arm.constructor()", "arm.set_joint(joint=1, value=1e999)",
    ],
)  # fmt: skip
def test_a_script_that_is_not_understood_is_refused_by_its_line(line: str, tmp_path: Path) -> None:
    found = scripts_read([HEAD + line, HEAD.replace("panda", "ur5e") + line, "x = 1", "# nothing"], tmp_path)
    assert found[0] == {"key": "script_line", "values": {"line": 4}}
    assert found[1] == {"key": "script_robot", "values": {"robot": "'ur5e'"}}
    assert found[2] == {"key": "script_line", "values": {"line": 1}}
    assert found[3]["key"] == "script_empty"


def test_edited_tables_are_the_arms_that_their_python_makes(tmp_path: Path) -> None:
    """What is drawn of an edited table ends where the robot of the written lines has its tip."""
    rng = np.random.default_rng(8)
    asked: list[dict[str, Any]] = []
    for name in ("panda", "ur5e", "puma560", "scara_rrrp", "planar3r"):
        arm = Arm(mf.load(name))
        table = dh_table(arm)
        assert table is not None
        asked.append({"table": table, "q": rng.uniform(-1.0, 1.0, arm.robot.n).tolist()})
        changed = [{**row, "a": row["a"] + 0.1, "alpha": row["alpha"] + rng.normal()} for row in table["rows"]]
        asked.append({"table": {**table, "rows": changed}, "q": asked[-1]["q"]})
        assert np.abs(_drawn([asked[-2]], tmp_path)[0][0] - arm.robot.forward_kinematics(asked[-2]["q"])).max() < 1e-9
    for one, (T, text) in zip(asked, _drawn(asked, tmp_path), strict=True):
        scope: dict[str, Any] = {}
        exec(text, scope)
        assert np.abs(scope["robot"].forward_kinematics(one["q"]) - T).max() < 1e-12


def _drawn(asked: list[dict[str, Any]], folder: Path) -> list[tuple[Any, str]]:
    (folder / "io.json").write_text(json.dumps(asked))
    return [(np.reshape(T, (4, 4)), text) for T, text in json.loads(run_module(TABLES, folder))]


def test_grasps_are_judged_as_by_mafsil(tmp_path: Path) -> None:
    """Verdict and epsilon quality of random fingers, and of symmetric ones on the boundary; a no is proved."""
    rng = np.random.default_rng(11)
    bodies = [[[-1, -0.6], [1, -0.6], [1, 0.6], [-1, 0.6]], [[-1, -0.6], [1, -0.6], [0, 1]]]
    asked: list[dict[str, Any]] = [
        {"corners": bodies[k % 2], "lengths": rng.uniform(0, 6, 1 + k % 6).tolist(), "mu": [0.0, 0.2, 0.6, 1.0][k % 4]}
        for k in range(120)
    ]
    asked += [{"corners": bodies[0], "lengths": [1, 2.6, 4.2, 5.8], "mu": mu} for mu in (0.0, 1e-6, 0.3)]
    asked += [{"corners": bodies[0], "lengths": [1, 4.2], "mu": mu} for mu in (0.0, 0.3)]
    (tmp_path / "io.json").write_text(json.dumps(asked))
    verdicts: set[bool] = set()
    for found in json.loads(run_module(GRASPS, tmp_path)):
        scope: dict[str, Any] = {}
        exec(found["text"].replace("print(", "found = ("), scope)
        grasp = scope["grasp"]
        closure = grasp.closure()
        verdicts.add(found["closed"])
        assert found["closed"] == bool(closure), found["text"]
        assert np.allclose(found["back"], [finger["point"] for finger in found["fingers"]], atol=2e-6)
        if closure:
            assert np.isclose(found["margin"], closure.margin, rtol=1e-6, atol=1e-9)
            continue
        y = np.array(found["unresisted"])
        assert abs(np.linalg.norm(y) - 1.0) < 1e-9
        assert (y @ closure.columns >= -1e-8).all()
        assert not grasp.resist(y).holds
    assert verdicts == {True, False}
