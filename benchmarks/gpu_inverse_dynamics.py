"""Do batches of inverse dynamics on an NVIDIA device reach the speed of its memory?

python benchmarks/gpu_inverse_dynamics.py [--robot panda] [--rows 4000000]

The yardstick is measured in the same run: the driver's own copy within the device's memory, bytes read and written
counted. Inverse dynamics reads q, qd, qdd and writes tau: 32 n bytes a row. The first rows are held against the
processor's kernel, bit for bit. Without a device it says so and stops.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.errors import KernelError  # noqa: E402
from mafsil.kernels.device import device_array, driver  # noqa: E402

TARGET = 0.8
"""Share of the memory's bandwidth that batches shall reach."""
COMPARED = 1000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--rows", type=int, default=4_000_000)
    parser.add_argument("--calls", type=int, default=50, help="launches between two waits")
    options = parser.parse_args()
    try:
        device = driver().device(0)
    except KernelError as reason:
        sys.exit(str(reason))
    details = {**machine("mafsil", "numpy", "llvmlite"), "device": f"{device.name} {device.processor}"}
    print(" | ".join(f"{key} {value}" for key, value in details.items()))
    robot = mf.load(options.robot)
    states = np.random.default_rng(1).uniform(-3, 3, (3, options.rows, robot.n))
    q, qd, qdd = (device_array(x) for x in states)
    tau = device_array(np.zeros((options.rows, robot.n)))
    robot.inverse_dynamics(q, qd, qdd, out=tau)
    expected = robot.inverse_dynamics(*states[:, :COMPARED])
    assert np.array_equal(tau.numpy()[:COMPARED], expected), "the device's numbers are not the processor's"
    places = [ctypes.c_uint64(x.__cuda_array_interface__["data"][0]) for x in (tau, q)]
    size = ctypes.c_size_t(q.nbytes)

    def copy() -> None:
        with device.current():
            device.driver.call("cuMemcpyDtoD_v2", *places, size)

    def launch() -> None:
        robot.inverse_dynamics(q, qd, qdd, out=tau)

    copying = 2 * q.nbytes / seconds(copy, device.synchronize, options.calls)
    computing = 4 * q.nbytes / seconds(launch, device.synchronize, options.calls)
    print(f"copy: {copying / 1e9:.0f} GB/s")
    rate = computing / (32 * robot.n)
    print(f"inverse dynamics of {options.robot}: {computing / 1e9:.0f} GB/s, {rate / 1e9:.2f} rows/ns")
    share = computing / copying
    print(f"{100 * share:.0f} % of the copy's bandwidth (target {100 * TARGET:.0f} %): {share >= TARGET}")


def seconds(task: Callable[[], None], wait: Callable[[], None], calls: int) -> float:
    """Median time of one call, of nine rounds of `calls` calls each."""
    taken: list[float] = []
    for _ in range(10):
        wait()
        start = perf_counter()
        for _ in range(calls):
            task()
        wait()
        taken.append((perf_counter() - start) / calls)
    return median(taken[1:])


if __name__ == "__main__":
    main()
