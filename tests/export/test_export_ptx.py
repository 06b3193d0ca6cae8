"""Kernels for NVIDIA devices, looked at without one: what the text says, what NVIDIA's assembler says where it is."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import mafsil as mf
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.ptx.grid import SHARED_BYTES, plan
from mafsil.kernels.ptx.program import KNOWN, GridProgram, device_program, inspect

ROBOT = mf.load("panda")
QUANTITIES = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "jacobian_body", "inverse_dynamics_derivatives"]


def _program(quantity: str) -> GridProgram:
    kernel = ROBOT.kernel(quantity)
    return device_program(kernel.signature, kernel.build)


def text_of(quantity: str, processor: str | None = None) -> str:
    found = ROBOT.export(quantity, to="ptx", target=processor)
    return found.files[f"{found.name}.ptx"].decode("ascii")


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_text_stands_alone(quantity: str) -> None:
    details = inspect(text_of(quantity))
    assert details.entries == (f"panda_{quantity}",)
    assert details.functions == ("mafsil_huge_value",)
    assert not details.undeclared
    assert not details.outside
    assert not details.local, "a stack on a device lies in slow memory"
    assert details.processor == "sm_75"
    assert details.barriers == 2


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_drivers_compiler_may_not_round_otherwise(quantity: str) -> None:
    """Fused where the tape says so; every other operation names its rounding: the bits are those of the processor."""
    details = inspect(text_of(quantity))
    assert details.fused > 50
    assert not details.unrounded


@pytest.mark.parametrize("processor", KNOWN)
def test_generations(processor: str) -> None:
    assert inspect(text_of("gravity_torque", processor)).processor == processor


def test_entry_takes_pointers_and_rows() -> None:
    text = text_of("inverse_dynamics")
    head = text[text.index(".entry") :].partition(")")[0]
    assert len(re.findall(r"\.param \.\w*64", head)) == 3 * 3 + 1 + 1
    assert ".maxntid 128" in text
    assert "ld.shared" in text
    assert "st.shared" in text
    body = text[text.index(".entry") :]
    assert not re.search(r"\bld\.(?:b64|f64)", body), "addresses in shared or global memory are known as such"
    assert "// out inverse_dynamics[7]: tau" in text


@pytest.mark.skipif(shutil.which("ptxas") is None, reason="NVIDIA's assembler is not installed")
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_nvidias_assembler_takes_it(quantity: str, tmp_path: Path) -> None:
    path = tmp_path / "kernel.ptx"
    path.write_text(text_of(quantity))
    words = ["ptxas", "-v", "-arch=sm_90", str(path), "-o", str(tmp_path / "kernel.cubin")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    if quantity == "inverse_dynamics":
        assert re.search(r"0 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads", done.stderr)


def test_checks_see_what_is_wrong() -> None:
    text = text_of("gravity_torque")
    assert inspect(re.sub(r"\.reg \.b64\s+%rd<\d+>;", "", text)).undeclared
    assert inspect(text.replace("mafsil_huge_value, ", "sin, ").replace("mafsil_huge_value,", "sin,")).undeclared == (
        "sin",
    )
    assert inspect(text.replace("mul.rn.f64", "mul.f64", 1)).unrounded == ("mul.f64",)
    assert inspect(".extern .func (.param .b64 r) sin (.param .b64 x);\n" + text).outside == ("sin",)
    assert inspect(".local .align 8 .b8 depot[8];" + text).local


@pytest.mark.parametrize(("sizes", "threads", "staged"), [
    ((7, 7, 7, 7), 128, 4), ((7, 49), 64, 2), ((7, 147), 32, 2), ((7, 343), 64, 1), ((400, 1), 64, 1), ((0, 1), 128, 2),
])  # fmt: skip
def test_blocks_fit_into_shared_memory(sizes: tuple[int, ...], threads: int, staged: int) -> None:
    ports = tuple(Port(f"p{k}", (size,)) for k, size in enumerate(sizes))
    found = plan(Signature("f", ports[:-1], ports[-1:]))
    assert found.threads == threads
    assert sum(tile.first is not None for tile in found.tiles) == staged
    assert 8 * found.size <= SHARED_BYTES
    assert all(tile.stride % 2 for tile in found.tiles)
    assert [found.blocks(rows) for rows in (1, threads, threads + 1)] == [1, 1, 2]


def test_program_is_made_of_the_kernel() -> None:
    program = _program("mass_matrix")
    assert program.name == "mafsil_mass_matrix"
    assert f".entry {program.name}(" in program.text
