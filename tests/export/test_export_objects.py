"""Object files for other processors: what stands in them; those that can run here give the kernel's numbers."""

from __future__ import annotations

import ctypes
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.kernels import target
from mafsil.kernels.export.exported import compiler, tapes, trial
from mafsil.kernels.export.object_file import object_file, symbols
from mafsil.kernels.export.wasm import MACHINES, machine
from tests.page.node import needed

ROBOT = mf.load("panda")
X86 = target.host().triple.startswith("x86_64")
KINDS = {
    "x86-64": ("x86-64", 64), "x86-64-avx2": ("x86-64", 64), "aarch64": ("AArch64", 64), "cortex-m4f": ("ARM", 32),
    "cortex-m7": ("ARM", 32), "riscv64": ("RISC-V", 64), "wasm32": ("WebAssembly", 32),
}  # fmt: skip
rng = np.random.default_rng(11)


@pytest.mark.parametrize("quantity", ["inverse_dynamics", "forward_dynamics"])
@pytest.mark.parametrize("name", MACHINES)
def test_symbols_of_every_processor(name: str, quantity: str) -> None:
    found = ROBOT.export(quantity, to="object", target=name)
    details = symbols(found.files[f"{found.name}.o"])
    assert (details.machine, details.bits) == KINDS[name]
    assert set(details.defined) == {found.name, f"{found.name}_rows"}
    assert all(need.startswith(machine(name).outside) for need in details.needed), details.needed
    header = found.files[f"{found.name}.h"].decode()
    assert f"void {found.name}_rows(" in header
    assert all(need in header for need in details.needed)


def test_only_processors_without_doubles_need_anything() -> None:
    needing = {name for name in MACHINES if ROBOT.export("mass_matrix", "object", target=name).details["needed"]}
    assert needing == {"cortex-m4f", "cortex-m7"}


@pytest.mark.parametrize("name", ["host", *(["x86-64"] if X86 else [])])
def test_in_this_process(name: str) -> None:
    """The host's has the kernel's bits; that without fused products rounds differently, in the last places."""
    kernel = ROBOT.kernel("inverse_dynamics")
    code = object_file(tapes(kernel)[1], kernel.signature, machine(name), "arm")
    loaded = target.load(code, ("arm", "arm_rows"))
    rows = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4, ctypes.c_size_t)(loaded.addresses["arm_rows"])
    one = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(loaded.addresses["arm"])
    for count in (0, 1, 2, 3, 7, 8, 9, 33):
        x, out = rng.uniform(-3, 3, (3, count, 7)), np.full((count + 1, 7), np.nan)
        rows(*(a.ctypes.data for a in (*x, out)), count)
        expected = ROBOT.inverse_dynamics(*x)
        assert np.isnan(out[count]).all()
        if name == "host":
            assert np.array_equal(out[:count], expected)
        else:
            assert np.allclose(out[:count], expected, rtol=1e-12, atol=1e-12)
    single = np.full(7, np.nan)
    one(*(np.ascontiguousarray(a[3]).ctypes.data for a in x), single.ctypes.data)
    assert np.array_equal(single, out[3])


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_linked_by_the_c_compiler() -> None:
    path = compiler()
    assert path
    for robot, quantity in (("puma560", "mass_matrix"), ("panda", "inverse_dynamics_derivatives")):
        found = trial(mf.export(mf.load(robot), quantity, "object"), path)
        assert found.ok, found.said
        assert "worst 0 units" in found.said


SCRIPT = """
const fs = require("fs");
const io = JSON.parse(fs.readFileSync(process.argv[3]));
const memory = new WebAssembly.Memory({initial: 4});
const stack = new WebAssembly.Global({value: "i32", mutable: true}, 65536);
const env = {__linear_memory: memory, __stack_pointer: stack};
const instance = new WebAssembly.Instance(new WebAssembly.Module(fs.readFileSync(process.argv[2])), {env});
const numbers = new Float64Array(memory.buffer);
io.inputs.forEach((x, k) => numbers.set(x, io.places[k] / 8));
instance.exports[io.name](...io.places, io.rows);
const start = io.places[io.places.length - 1] / 8;
process.stdout.write(JSON.stringify(Array.from(numbers.slice(start, start + io.count))));
"""


def test_webassembly_runs(tmp_path: Path) -> None:
    found = ROBOT.export("inverse_dynamics", to="object", target="wasm32")
    found.write(tmp_path)
    (tmp_path / "run.js").write_text(SCRIPT)
    x = rng.uniform(-3, 3, (3, 13, 7))
    x[0, 3, 2], x[0, 4, 1] = 1e200, 123456789.125
    places = [65536 + 8192 * k for k in range(4)]
    io = {
        "name": f"{found.name}_rows",
        "rows": 13,
        "places": places,
        "count": 91,
        "inputs": [a.ravel().tolist() for a in x],
    }
    (tmp_path / "io.json").write_text(json.dumps(io))
    words = [needed("node", "nodejs"), "run.js", f"{found.name}.wasm", "io.json"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    expected = ROBOT.inverse_dynamics(*x)
    assert np.allclose(np.reshape(json.loads(done.stdout), (13, 7)), expected, rtol=1e-13, atol=1e-13)
