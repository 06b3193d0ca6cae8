"""How long does the first answer take? Processor seconds of a fresh process, imports included, per question.

Three caches: empty; as set-up leaves it (`mafsil doctor --build`: the loops that know no robot, nothing of the arm);
and full. Goals with the loops of set-up: pose 0.3 s, closed form 1 s, numerical 1 s, grasp 1 s.

python benchmarks/first_use.py [--repeats 3] [--empty] [--json FILE]

`--empty` times the empty cache too, which takes minutes.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.comparison import Comparisons  # noqa: E402

ARM = """
import dataclasses, numpy as np, mafsil as mf
rows = [mf.DHRow(a=a, alpha=b, d=d) for a, b, d in {rows}]
robot = mf.Robot.from_dh(rows, "classic")
T = robot.forward_kinematics(np.full(len(rows), 0.3))
"""
WRIST = "[(0, 1.5707963267948966, 0.31), (0.43, 0, 0), (0.02, -1.5707963267948966, 0.15), " \
    "(0, 1.5707963267948966, 0.43), (0, -1.5707963267948966, 0), (0, 0, 0.07)]"  # fmt: skip
POINTS = "((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))"
QUESTIONS = {
    "nothing but NumPy": ("import numpy", None),
    "pose of a new arm": (ARM.format(rows=WRIST), 0.3),
    "closed form": (ARM.format(rows=WRIST) + "assert mf.inverse_kinematics(robot, T)", 1.0),
    "numerical": (ARM.format(rows=WRIST) + "assert mf.solve_ik(robot, T)", 1.0),
    "grasp": (
        "import mafsil as mf\n"
        f"assert mf.Grasp([mf.Contact(p, tuple(-x for x in p), 0.5) for p in {POINTS}]).closure()",
        1.0,
    ),
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> None:
    """Time every question with every cache and print the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--repeats", type=int, default=3)
    options.add_argument("--empty", action="store_true")
    options.add_argument("--json", type=Path)
    chosen, found = options.parse_args(arguments), Comparisons()
    with tempfile.TemporaryDirectory() as folder:
        ready = Path(folder, "ready")
        seconds("from mafsil.cli.build import build; build(lambda name: None)", ready)
        for path in ready.iterdir():
            if path.suffix != ".loop":
                path.unlink()
        print(f"{'processor seconds':20} {'empty':>8} {'set up':>8} {'full':>8}   goal")
        for name, (question, goal) in QUESTIONS.items():
            empty = least(question, None, folder, 1) if chosen.empty else None
            columns = [empty, least(question, ready, folder, chosen.repeats), full(question, ready, folder, chosen)]
            print(f"{name:20} " + " ".join(f"{x:8.2f}" if x is not None else f"{'-':>8}" for x in columns), end="")
            print(f"   {goal}" if goal else "", flush=True)
            if goal:
                found.add(
                    f"first answer: {name}", "loops of set-up", 1e6 * (columns[1] or 0.0), "goal", 1e6 * goal, 1.0
                )
    if chosen.json:
        chosen.json.write_text(json.dumps({"comparisons": found.plain()}, indent=1))


def least(question: str, start: Path | None, folder: str, repeats: int) -> float:
    """The least of several fresh processes, each with its own copy of a cache."""
    found: list[float] = []
    for _ in range(repeats):
        place = Path(tempfile.mkdtemp(dir=folder))
        if start is not None:
            shutil.copytree(start, place, dirs_exist_ok=True)
        found.append(seconds(question, place))
    return min(found)


def full(question: str, start: Path, folder: str, chosen: argparse.Namespace) -> float:
    """The least of several processes after a first one has filled the cache."""
    place = Path(tempfile.mkdtemp(dir=folder))
    shutil.copytree(start, place, dirs_exist_ok=True)
    return min([seconds(question, place) for _ in range(chosen.repeats + 1)][1:])


def seconds(code: str, cache: Path) -> float:
    """Processor seconds of a fresh process, start and imports included."""
    clock = "\nimport time; print(time.process_time())"
    settings = {**os.environ, "MAFSIL_CACHE": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", code + clock], env=settings, capture_output=True, text=True, check=True
    )
    return float(done.stdout.split()[-1])


if __name__ == "__main__":
    main()
