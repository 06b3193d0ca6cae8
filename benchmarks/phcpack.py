"""How quick are all forty poses of platforms on six legs, beside PHCpack's blackbox solver, in the same run?

python benchmarks/phcpack.py [--phc phc] [--platforms 3] [--batch 200] [--json FILE]

`phc` is the program of the Debian package phcpack. Its system are the eight equations of Study's quadrics: six legs,
the quadric, and a random plane that fixes the scale. Every platform has its own geometry.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.parallel_robots import planted  # noqa: E402
from benchmarks.stopwatch import machine  # noqa: E402
from mafsil import parallel  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402


def equations(base: Floats, platform: Floats, lengths: Floats, rng: np.random.Generator) -> str:
    """The system in PHCpack's words, in Study parameters x and y: R = x b x*, p = 2 y x*."""
    rows = [leg(*given) for given in zip(base, platform, lengths, strict=True)]
    rows.append("+".join(f"x{i}*y{i}" for i in range(4)) + ";")
    plane = rng.normal(size=5)
    rows.append("".join(f"{c:+.16e}*x{i}" for i, c in enumerate(plane[:4])) + f"{plane[4]:+.16e};")
    return "\n".join(["8", *rows]) + "\n"


def leg(a: Floats, b: Floats, s: float) -> str:
    """4 |y|^2 + |x|^2 (|a|^2 + |b|^2 - s^2) + 4 <y, x b> - 4 <y, a x> - 2 <a x, x b> = 0."""
    A, B = left(a), right(b)
    square = (a @ a + b @ b - s * s) * np.eye(4) - (A.T @ B + B.T @ A)
    mixed = 4 * (B - A)
    terms = [f"+4*y{i}^2" for i in range(4)]
    terms += [f"{square[i, j]:+.16e}*x{i}*x{j}" for i in range(4) for j in range(4)]
    terms += [f"{mixed[i, j]:+.16e}*y{i}*x{j}" for i in range(4) for j in range(4)]
    return "".join(terms) + ";"


def left(v: Floats) -> Floats:
    """(4, 4) of x -> v x for a vector as a quaternion."""
    x, y, z = v
    return np.array([[0, -x, -y, -z], [x, 0, -z, y], [y, z, 0, -x], [z, -y, x, 0]])


def right(v: Floats) -> Floats:
    """(4, 4) of x -> x v."""
    x, y, z = v
    return np.array([[0, -x, -y, -z], [x, 0, z, -y], [y, -z, 0, x], [z, y, -x, 0]])


def by_phcpack(phc: str, system: str) -> tuple[float, int]:
    """Seconds, and the number of solutions."""
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "system"), Path(folder, "found")
        given.write_text(system, "ascii")
        begin = perf_counter()
        subprocess.run([phc, "-b", str(given), str(found)], check=True, stdout=subprocess.DEVNULL)
        seconds = perf_counter() - begin
        return seconds, int(re.findall(r"^(\d+) 8\n=", given.read_text("ascii"), re.MULTILINE)[-1])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--phc", default="phc")
    parser.add_argument("--platforms", type=int, default=3)
    parser.add_argument("--batch", type=int, default=200)
    parser.add_argument("--json")
    given = parser.parse_args()
    if shutil.which(given.phc) is None:
        parser.error(f"there is no program {given.phc}: install the Debian package phcpack, or name it by --phc")
    print(machine("numpy"))
    rng, found = np.random.default_rng(7), Comparisons()
    a, b, _, s = planted(rng, given.batch)
    parallel.stewart_assembly_modes(a[:2], b[:2], s[:2])
    for k in range(given.platforms):
        theirs, count = by_phcpack(given.phc, equations(a[k], b[k], s[k], rng))
        begin = perf_counter()
        ours = parallel.stewart_assembly_modes(a, b, s)
        each = (perf_counter() - begin) / given.batch
        found.add("stewart_assembly_modes", f"platform {k + 1}", 1e6 * each, "PHCpack", 1e6 * theirs)
        print(f"PHCpack {theirs:6.2f} s, {count} poses   ours {1e3 * each:6.3f} ms, {ours.finite[k]} poses", end="   ")
        print(f"({theirs / each:.0f}x; all forty of {(ours.finite == 40).mean():.1%} of {given.batch})")
    if given.json:
        Path(given.json).write_text(json.dumps(found.plain(), indent=1), "utf-8")


if __name__ == "__main__":
    main()
