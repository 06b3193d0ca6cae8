"""Many kernels in one WebAssembly module: Node.js computes with them what Python computes without fused products."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import kernels
from mafsil.cli.main import main
from mafsil.errors import InputError
from mafsil.ik import closed_form
from mafsil.kernels import Kernel, Port, Signature
from mafsil.kernels.export import wasm
from mafsil.kernels.export.exported import compiler, trial
from mafsil.kernels.export.object_file import STACK, Bundle, bundle
from mafsil.kernels.target import host
from mafsil.page.exporting import BEYOND
from tests.page.node import run_module

NAMES = ("forward_kinematics", "jacobian_body", "inverse_dynamics", "mass_matrix", "gravity_torque")
ROBOTS = ("panda", "ur5e", "puma560")
ROWS = 40
rng = np.random.default_rng(23)

SCRIPT = """
import fs from "node:fs";
import { loadKernels } from "./page/core/kernels.js";
const io = JSON.parse(fs.readFileSync("io.json"));
const numbers = new Float64Array(new Uint8Array(fs.readFileSync("in.bin")).buffer);
const kernels = await loadKernels(fs.readFileSync("bundle.wasm"), io.layout);
const found = [];
let at = 0;
const take = (shape) => numbers.slice(at, at += shape.reduce((a, b) => a * b, 1));
for (let row = 0; row < io.rows; row++) for (const [name, ports] of Object.entries(io.layout.kernels))
  for (const output of kernels[name](...ports.inputs.map((port) => take(port.shape)))) found.push(...output);
fs.writeFileSync("out.bin", new Uint8Array(Float64Array.from(found).buffer));
"""


def in_node(found: Bundle, rows: list[list[np.ndarray]], folder: Path) -> np.ndarray:
    """All outputs of all kernels, row after row."""
    (folder / "bundle.wasm").write_bytes(found.code)
    (folder / "io.json").write_text(json.dumps({"layout": found.layout, "rows": len(rows)}))
    (folder / "in.bin").write_bytes(np.concatenate([x.ravel() for row in rows for x in row]).tobytes())
    run_module(SCRIPT, folder)
    return np.frombuffer((folder / "out.bin").read_bytes())


def unfused(kernel: Kernel) -> Kernel:
    """The same kernel for this processor without fused products and sums."""
    return replace(kernel, recipe=None, fallback=None, target=host("-fma"))


def numbers(kernels: Mapping[str, Kernel]) -> list[list[np.ndarray]]:
    """Rows of inputs, huge and odd numbers among them."""
    rows = [
        [rng.uniform(-3, 3, port.shape) for k in kernels.values() for port in k.signature.inputs] for _ in range(ROWS)
    ]
    rows[1] = [x * 1e8 for x in rows[1]]
    rows[2] = [x * 1e200 for x in rows[2]]
    rows[3] = [np.where(rng.random(x.shape) < 0.3, np.nan, x) for x in rows[3]]
    rows[4] = [np.where(rng.random(x.shape) < 0.3, -0.0, x) for x in rows[4]]
    return rows


def in_python(kernels: Mapping[str, Kernel], rows: list[list[np.ndarray]]) -> np.ndarray:
    plain = [(unfused(kernel), len(kernel.signature.inputs)) for kernel in kernels.values()]
    found: list[np.ndarray] = []
    for row in rows:
        at = 0
        for kernel, count in plain:
            answer = kernel.ufunc(*row[at : at + count])
            found += [np.ravel(y) for y in (answer if isinstance(answer, tuple) else (answer,))]
            at += count
    return np.concatenate(found)


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    """Bit for bit; a NaN is a NaN, its payload is nobody's."""
    both = np.isnan(a) & np.isnan(b)
    return a.shape == b.shape and bool(np.all(both | (a.view(np.uint64) == b.view(np.uint64))))


@pytest.mark.parametrize("name", ROBOTS)
def test_bits_of_quantities(name: str, tmp_path: Path) -> None:
    robot = mf.load(name)
    chosen = {quantity: robot.kernel(quantity) for quantity in NAMES}
    rows = numbers(chosen)
    with np.errstate(all="ignore"):
        expected = in_python(chosen, rows)
    assert same_bits(in_node(bundle(chosen), rows, tmp_path), expected)


@pytest.mark.parametrize("name", ROBOTS)
def test_bits_of_all_branches(name: str, tmp_path: Path) -> None:
    """The closed form with names and limits, at poses that the arm reaches and at some that it does not."""
    robot = mf.load(name)
    form = closed_form(robot)
    assert form is not None
    chosen = {"branches": form.labelled}
    rows: list[list[np.ndarray]] = []
    for k in range(ROWS):
        q = rng.uniform(-2, 2, robot.n)
        T = robot.forward_kinematics(q)
        T[:3, 3] *= 4 if k % 8 == 7 else 1
        rows.append([T, q, np.stack([np.cos(q), np.sin(q)], axis=1), robot.limits.lower, robot.limits.upper])
    with np.errstate(all="ignore"):
        expected = in_python(chosen, rows)
    assert same_bits(in_node(bundle(chosen), rows, tmp_path), expected)


def test_constants_lie_above_the_stack(tmp_path: Path) -> None:
    """Every address that the code reads is moved with them: a huge angle is reduced by the table of 2/pi."""
    chosen = {"fk": mf.load("planar2r").kernel("forward_kinematics")}
    found = bundle(chosen)
    size = wasm.constants_size(found.code)
    assert size > 160
    assert found.layout["memory"]["stack"] == STACK
    assert STACK + 160 <= found.layout["memory"]["first"] <= STACK + size + 16
    rows = [[rng.uniform(1e17, 1e300, 2)] for _ in range(9)]
    assert same_bits(in_node(found, rows, tmp_path), in_python(chosen, rows))


def test_kept_by_content(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from mafsil.kernels.export import object_file as module

    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path))
    module._store.cache_clear()
    kernel = mf.load("planar2r").kernel("forward_kinematics")
    first = bundle({"fk": kernel})
    monkeypatch.setattr(module, "_compile", lambda _: pytest.fail("compiled twice"))
    assert bundle({"fk": kernel}) == first
    monkeypatch.setattr(module, "_compile", lambda _: first.code + b"\0\0")
    assert bundle({"other": kernel}).code != first.code
    module._store.cache_clear()


def test_a_port_without_numbers_is_refused() -> None:
    kernel = kernels.compile(Signature("odd", (Port("x", (0, 3)),), (Port("y"),)), lambda: None, key="odd")
    with pytest.raises(InputError, match="port x holds no numbers"):
        bundle({"odd": kernel})


def test_wasm_is_a_form_of_export(tmp_path: Path) -> None:
    robot = mf.load("planar2r")
    found = robot.export("inverse_dynamics", to="wasm")
    assert set(found.files) == {f"{found.name}.{end}" for end in ("wasm", "json", "txt")}
    layout = json.loads(found.files[f"{found.name}.json"])
    assert [port["name"] for port in layout["kernels"][found.name]["inputs"]] == ["q", "qd", "qdd"]
    x = [rng.uniform(-3, 3, 2) for _ in range(3)]
    (answer,) = [in_node(Bundle(found.files[f"{found.name}.wasm"], layout), [x], tmp_path)]
    assert np.allclose(answer, robot.inverse_dynamics(*x), rtol=1e-13)
    with pytest.raises(InputError, match="leaves no choice"):
        robot.export("inverse_dynamics", to="wasm", target="aarch64")


def test_closed_form_of_an_arm_with_a_locked_joint() -> None:
    """Without `q0` the locked joint is at zero, as the docstring says."""
    robot = mf.load("panda")
    form = closed_form(robot)
    assert form is not None
    assert form.pattern.locked
    q = np.array([0.3, -0.4, 0.2, -2.0, 0.1, 1.5, 0.5])
    q[form.pattern.locked[0].joint] = 0.0
    T = robot.forward_kinematics(q)
    found = form.solve(T)
    assert found.solves_pose().any()
    assert np.array_equal(found.q[..., form.pattern.locked[0].joint], np.zeros(found.q.shape[:-1]))
    for row in found.q[found.solves_pose()]:
        assert np.allclose(robot.forward_kinematics(row), T, atol=1e-9)
    zero = form.solve(T, np.zeros(7))
    assert np.array_equal(zero.solves_pose(), found.solves_pose())
    assert np.abs(zero.q - found.q)[found.solves_pose()].max() < 1e-9
    assert form.kernel(T).shape == (form.pattern.branches, 10)


@pytest.mark.parametrize("to", ["c", "wasm", "object"])
@pytest.mark.parametrize("name", sorted(BEYOND))
def test_inverse_kinematics_and_the_loop_are_exported_by_name(name: str, to: str) -> None:
    found = mf.export("ur5e", name, to)
    assert found.name == f"ur5e_{name}"
    if to == "c":
        header = found.files[f"{found.name}.h"].decode()
        assert BEYOND[name].title in header
        assert not re.search(r"^.*(?:in|out) +\w+(?:\[\d+\])*: *$", header, re.M), "a port without a word"


def test_what_an_arm_does_not_have_is_said() -> None:
    with pytest.raises(InputError, match="no exact closed form"):
        mf.export("spatial3r", "closed_form", "wasm")
    with pytest.raises(InputError, match="no frames"):
        mf.export("ur5e", "pose_step", frame="link3")
    with pytest.raises(InputError, match="nonsense"):
        mf.export("ur5e", "nonsense")


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["pose_step", "closed_loop"])
def test_exported_c_proves_itself(name: str) -> None:
    path = compiler()
    assert path
    found = trial(mf.export("puma560", name, "c"), path)
    assert found.ok, found.said


def test_all_kernels_and_the_page_by_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for to in ("wasm", "page"):
        assert main(["--json", "export", "planar2r", "--to", to, "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "planar2r_page.wasm", "planar2r_page.json", "planar2r_page.html",
    }  # fmt: skip
    layout = json.loads((tmp_path / "planar2r_page.json").read_text())
    assert {"forward_kinematics", "pose_step", "closed_loop"} <= set(layout["kernels"])
    capsys.readouterr()
    assert main(["export", "planar2r"]) == 2
    assert "without a quantity" in capsys.readouterr().err
