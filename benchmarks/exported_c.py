"""How fast is exported C beside the kernel it comes from, both called once from compiled code, in the same run?

python benchmarks/exported_c.py [--quantities inverse_dynamics ...]

Three contestants evaluate the same 2048 states one after another through the same loop in C: the exported C by the C
compiler at -O3 (without and with -march=native, where libm serves the sines), the kernel's single entry, and for
orientation the kernel's batch entry on one thread.
"""

from __future__ import annotations

import argparse
import ctypes
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.stopwatch import BRIEF, machine, race  # noqa: E402
from mafsil.kernels.export.exported import compiler  # noqa: E402

ROWS = 2048
FLAGS = {"C -O3": ["-O3"], "C -O3 -march=native": ["-O3", "-march=native"]}


def loop(path: str, folder: Path, inputs: int) -> Any:
    """Compiled code that calls a function once for each row: void rows(void *f, double *in..., double *out, ...)."""
    names = [*(f"x{k}" for k in range(inputs)), "y"]
    takes = ", ".join(f"double *{name}" for name in names)
    sizes = ", ".join(f"long n{name}" for name in names)
    given = ", ".join(f"{name} + row * n{name}" for name in names)
    kinds = ", ".join(["double *"] * len(names))
    text = f"void rows(void (*f)({kinds}), {takes}, {sizes}, long count)\n"
    text += f"{{ for (long row = 0; row < count; ++row) f({given}); }}\n"
    (folder / "loop.c").write_text(text)
    subprocess.run([path, "-O2", "-shared", "-fPIC", "loop.c", "-o", "loop.so"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "loop.so")).rows


def tasks(robot: mf.Robot, quantity: str, path: str, folder: Path) -> dict[str, Callable[[], object]]:
    """The contestants, after their numbers were compared."""
    kernel = robot.kernel(quantity)
    ports = kernel.signature.ports
    rng = np.random.default_rng(1)
    inputs = [rng.uniform(-3, 3, (ROWS, *port.shape)) for port in kernel.signature.inputs]
    expected = kernel(*inputs, threads=1)
    found = robot.export(quantity)
    found.write(folder)
    rows = loop(path, folder, len(inputs))
    functions = {"kernel, single": ctypes.c_void_p(kernel.addresses.single)}
    for label, flags in FLAGS.items():
        library = folder / f"{quantity}{len(functions)}.so"
        words = [path, "-std=c99", *flags, "-shared", "-fPIC", f"{found.name}.c", "-o", str(library), "-lm"]
        subprocess.run(words, cwd=folder, check=True)
        functions[label] = ctypes.cast(getattr(ctypes.CDLL(str(library)), found.name), ctypes.c_void_p)
    out = np.empty_like(expected)
    given = [*(ctypes.c_void_p(x.ctypes.data) for x in (*inputs, out)), *(ctypes.c_long(p.size) for p in ports)]
    contestants: dict[str, Callable[[], object]] = {}
    for label, function in functions.items():
        out[...] = np.nan
        rows(function, *given, ctypes.c_long(ROWS))
        assert np.allclose(out, expected, rtol=1e-11, atol=1e-11), label
        contestants[label] = lambda function=function: rows(function, *given, ctypes.c_long(ROWS))
    contestants["kernel, batch"] = lambda: kernel(*inputs, out=out, threads=1)
    return contestants


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=["puma560", "panda"])
    parser.add_argument("--quantities", nargs="+", default=["inverse_dynamics", "mass_matrix", "forward_kinematics"])
    options = parser.parse_args()
    path = compiler()
    if path is None:
        sys.exit("no C compiler found")
    version = subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    details = {**machine("mafsil", "numpy", "llvmlite"), "compiler": version}
    print(" | ".join(f"{key} {value}" for key, value in details.items()))
    for name in options.robots:
        for quantity in options.quantities:
            with tempfile.TemporaryDirectory() as folder:
                timings = race(tasks(mf.load(name), quantity, path, Path(folder)), **BRIEF)
            base = timings["kernel, single"].least
            parts = [f"{k} {1e9 * t.least / ROWS:.0f} ns ({t.least / base:.2f})" for k, t in timings.items()]
            print(f"{name} {quantity}: " + ", ".join(parts), flush=True)


if __name__ == "__main__":
    main()
