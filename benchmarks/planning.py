"""Planning problems of MotionBenchMaker: how many are solved, how fast, how short; every path looked at densely.

python benchmarks/planning.py [--problems FOLDER] [--count 100] [--shorten 100] [--json FILE]

VAMP 0.6.4 names 111 us as its median for the Panda, without
proofs; ours is the whole call with every motion proved free. Each path is checked again at states 0.001 rad apart.
"""

from __future__ import annotations

import argparse
import json
import lzma
import sys
import warnings
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.collision import obstacle  # noqa: E402
from mafsil.collision import Checker, Scene  # noqa: E402
from mafsil.planning import ArmPlan, PlanningStatus  # noqa: E402

BLOCKED = (PlanningStatus.START_BLOCKED, PlanningStatus.GOAL_BLOCKED)


def solved(folder: Path, name: str, count: int, shorten: int) -> dict[str, list[tuple[ArmPlan, float, bool]]]:
    """Plans by set, each with its time and whether a dense check found it free."""
    with lzma.open(folder / f"{name}.json.xz") as file:
        data: dict[str, Any] = json.load(file)
    arm = Checker(str(folder / f"{name}_spherized.urdf"), srdf=folder / f"{name}.srdf")
    names = [each.name for each in arm.robot.mechanism.coordinates]
    found: dict[str, list[tuple[ArmPlan, float, bool]]] = {}
    for key, problems in data["sets"].items():
        for problem in problems["problems"][:count]:
            fixed = data["other_joints"] or {}
            ends = [
                np.array([(dict(zip(problems["joints"], problem[end], strict=True)) | fixed)[each] for each in names])
                for end in ("start", "goal")
            ]
            checker = arm.with_scene(Scene(map(obstacle, problem["obstacles"])))
            checker.free(ends[0])
            begun = perf_counter()
            plan = mf.plan(checker, None, *ends, shorten=shorten)
            seconds = perf_counter() - begun
            found.setdefault(key, []).append((plan, seconds, _free(checker, plan)))
    return found


def _free(checker: Checker, plan: ArmPlan) -> bool:
    if not plan:
        return True
    for a, b in zip(plan.path[:-1], plan.path[1:], strict=True):
        states = a + np.linspace(0.0, 1.0, int(np.abs(b - a).max() / 0.001) + 2)[:, None] * (b - a)
        if not checker.free(states).all():
            return False
    return True


def main() -> None:
    """Print a table for each arm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--problems", type=Path, default=ROOT.parent / "shared" / "data" / "planning")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--shorten", type=int, default=100)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    kept: dict[str, Any] = {}
    for name in ("panda", "ur5"):
        for key, rows in solved(given.problems, name, given.count, given.shorten).items():
            plans = [plan for plan, _, _ in rows]
            seconds = np.array([s for _, s, _ in rows]) * 1e3
            row = {
                "problems": len(rows), "solved": sum(map(bool, plans)),
                "ends in collision": sum(plan.status in BLOCKED for plan in plans),
                "in collision at 0.001 rad": sum(not free for _, _, free in rows),
                "median ms": float(np.median(seconds)), "95 % ms": float(np.quantile(seconds, 0.95)),
                "worst ms": float(seconds.max()), "mean length": float(np.mean([p.length for p in plans if p])),
            }  # fmt: skip
            kept[f"{name} {key}"] = row
            print(f"{name} {key}: " + ", ".join(f"{k} {v:.3g}" for k, v in row.items()), flush=True)
    if given.json:
        given.json.write_text(json.dumps(kept, indent=1))


if __name__ == "__main__":
    main()
