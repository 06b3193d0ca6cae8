"""Planning problems of MotionBenchMaker: how many are solved, how fast, how short; every path looked at densely.

python benchmarks/planning.py [--problems FOLDER] [--count 100] [--shorten 100] [--peer N] [--optimise N]
    [--anytime N] [--roboplan PYTHON N] [--whole N] [--json FILE]

--whole times what a user types, N problems of each set: `mf.plan(robot, obstacles, start, goal)` of a robot that was
never asked before and again, among ten balls and nine thousand; and obstacles of a problem made, laid out and planned
among. Its goals are those of docs/performance.md.

VAMP 0.6.4 names 111 us as its median for the Panda, without proofs; ours is the whole call with every motion proved
free: first each in a scene that was not asked before, then all once more. Each path is checked again at states 0.001
rad apart. Beside a peer each problem is searched five times by both;
the first search of each comes after the other's work, which has taken the caches of the processor.
roboplan (Pinocchio and coal) gets an environment of its own: `python -m venv E; E/bin/pip install roboplan`, then
`--roboplan E/bin/python 10`.
"""

from __future__ import annotations

import argparse
import json
import lzma
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from itertools import combinations, pairwise
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.collision import obstacle  # noqa: E402
from benchmarks.comparison import Comparisons  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.collision import Checker, Obstacle, Scene, Sphere  # noqa: E402
from mafsil.planning import ArmPlan  # noqa: E402
from mafsil.planning.outcome import PlanningStatus  # noqa: E402

REPEATS = 5
"""Searches for each problem beside a peer, each with another seed."""
BLOCKED = (PlanningStatus.START_BLOCKED, PlanningStatus.GOAL_BLOCKED)


def posed(folder: Path, name: str, count: int) -> Iterator[tuple[Checker, Floats, Floats]]:
    """Each problem: the arm in its scene, start and goal."""
    with lzma.open(folder / f"{name}.json.xz") as file:
        data: dict[str, Any] = json.load(file)
    arm = Checker(str(folder / f"{name}_spherized.urdf"), srdf=folder / f"{name}.srdf")
    names = [each.name for each in arm.robot.mechanism.coordinates]
    for problems in data["sets"].values():
        for problem in problems["problems"][:count]:
            fixed = data["other_joints"] or {}
            ends = [dict(zip(problems["joints"], problem[end], strict=True)) | fixed for end in ("start", "goal")]
            a, b = (np.array([values[each] for each in names]) for values in ends)
            yield arm.with_scene(Scene(map(obstacle, problem["obstacles"]))), a, b


def solved(folder: Path, name: str, count: int, shorten: int) -> list[tuple[ArmPlan, float, float, bool]]:
    """Plans, each with its time, that of the same question after all the others, and whether a dense check found it
    free."""
    found: list[tuple[ArmPlan, float, bool]] = []
    cases = []
    for checker, a, b in posed(folder, name, count):
        checker.free(a)
        if not cases:
            mf.plan(checker, None, a, b, shortcut_iterations=shorten)  # A first call ever waits for the compiler.
        begun = perf_counter()
        plan = mf.plan(checker, None, a, b, shortcut_iterations=shorten)
        seconds = perf_counter() - begun
        found.append((plan, seconds, _free(checker, plan)))
        cases.append((checker, a, b))
    again = []
    for checker, a, b in cases:
        begun = perf_counter()
        mf.plan(checker, None, a, b, shortcut_iterations=shorten)
        again.append(perf_counter() - begun)
    return [(plan, first, then, free) for (plan, first, free), then in zip(found, again, strict=True)]


def _free(checker: Checker, plan: ArmPlan) -> bool:
    return not plan or _path_free(checker, plan.path)


def _path_free(checker: Checker, path: Floats) -> bool:
    for a, b in pairwise(path):
        states = a + np.linspace(0.0, 1.0, int(np.abs(b - a).max() / 0.001) + 2)[:, None] * (b - a)
        if not checker.free(states).all():
            return False
    return True


def race_ompl(folder: Path, name: str, count: int) -> None:
    """OMPL's RRT-Connect (pip install ompl) on the same problems: states 0.02 rad apart asked of the same Checker.

    Its search is C++; each state is a call of Python (about half of its time here), ours is one compiled loop.
    """
    from ompl import base, geometric, util  # pyright: ignore

    util.noOutputHandler()
    theirs, ours, unsolved, hit, lengths = [], [], [0, 0], 0, []
    for checker, a, b in posed(folder, name, count):
        if not checker.free(np.stack([a, b])).all():
            continue
        limits, n = checker.robot.limits, checker.robot.n
        space = base.RealVectorStateSpace(n)
        bounds = base.RealVectorBounds(n)
        for k in range(n):
            bounds.setLow(k, float(limits.lower[k]))
            bounds.setHigh(k, float(limits.upper[k]))
        space.setBounds(bounds)
        setup = geometric.SimpleSetup(space)
        setup.setStateValidityChecker(lambda state, c=checker, n=n: bool(c.free([state[k] for k in range(n)])))
        setup.getSpaceInformation().setStateValidityCheckingResolution(0.02 / space.getMaximumExtent())
        ends = []
        for q in (a, b):
            state = space.allocState()
            for k in range(n):
                state[k] = float(q[k])
            ends.append(state)
        setup.setStartAndGoalStates(*ends)
        setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
        begun = perf_counter()
        setup.solve(10.0)
        seconds = [perf_counter() - begun]
        found, path = setup.haveExactSolutionPath(), np.empty((0, n))
        if found:
            path = np.array([[state[k] for k in range(n)] for state in setup.getSolutionPath().getStates()])
        for _ in range(REPEATS - 1):
            setup.clear()
            begun = perf_counter()
            setup.solve(10.0)
            seconds.append(perf_counter() - begun)
        theirs.append(seconds)
        plan, seconds = _repeated(checker, a, b)
        ours.append(seconds)
        unsolved[0] += not found
        unsolved[1] += not plan
        if found and plan:
            hit += not _path_free(checker, path)
            lengths.append([float(np.linalg.norm(np.diff(each, axis=0), axis=1).sum()) for each in (path, plan.path)])
    length = np.mean(np.array(lengths).reshape(-1, 2), axis=0)
    print(
        f"{name}, {len(theirs)} problems: OMPL not found {unsolved[0]}, in collision at 0.001 rad {hit}, mean length "
        f"{length[0]:.2f}; ours not found {unsolved[1]}, mean length {length[1]:.2f}"
    )
    _print_times("OMPL", theirs, ours)


def _repeated(checker: Checker, a: Floats, b: Floats) -> tuple[ArmPlan, list[float]]:
    """The first of as many whole calls as the peer makes, each with another seed, and the seconds of all."""
    plans, seconds = [], []
    for seed in range(REPEATS):
        begun = perf_counter()
        plans.append(mf.plan(checker, None, a, b, shortcut_iterations=0, seed=seed))
        seconds.append(perf_counter() - begun)
    return plans[0], seconds


def _print_times(peer: str, theirs: list[list[float]], ours: list[list[float]]) -> None:
    """Medians over the problems: of the median of each one's searches, and of the first, after the peer's work."""
    first, repeated = (
        [1e3 * np.quantile(measure(np.array(each)), (0.5, 0.95, 1.0)) for each in (theirs, ours)]
        for measure in (lambda s: s[:, 0], lambda s: np.median(s, axis=1))
    )
    for which, (them, us) in ((f"median of {REPEATS} searches", repeated), ("first search", first)):
        print(
            f"  {which}, median / 95 % / worst: {peer} {them[0]:.2f} / {them[1]:.1f} / {them[2]:.0f} ms, ours "
            f"{us[0]:.3f} / {us[1]:.2f} / {us[2]:.1f} ms; ratio of medians {them[0] / us[0]:.0f}"
        )


def race_roboplan(folder: Path, name: str, count: int, python: str) -> None:
    """roboplan's RRT-Connect, C++ throughout, on the same problems, balls and disabled pairs; whole calls, in turns."""
    with lzma.open(folder / f"{name}.json.xz") as file:
        data: dict[str, Any] = json.load(file)
    problems = [row for each in data["sets"].values() for row in each["problems"][:count]]
    cases = list(posed(folder, name, count))
    coordinates = [each.name for each in cases[0][0].robot.mechanism.coordinates]
    joints = next(iter(data["sets"].values()))["joints"]
    rows = [
        {"start": a.tolist(), "goal": b.tolist(), "obstacles": row["obstacles"]}
        for (_, a, b), row in zip(cases, problems, strict=True)
    ]
    first = cases[0][0]
    still = [body.name for body, row in zip(first.bodies, first.arm.bodies, strict=True) if row[3] == row[1]]
    named = [body.name for body in first.bodies]
    looked_at = {frozenset((named[a], named[b])) for a, b in first.arm.pairs}
    files: dict[str, Any] = {
        "urdf": str(folder / f"{name}_spherized.urdf"), "srdf": str(folder / f"{name}.srdf"), "still": still,
        "skipped": [pair for pair in combinations(named, 2) if frozenset(pair) not in looked_at],
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as place:
        asked = Path(place) / "problems.json"
        asked.write_text(json.dumps(files | {"joints": joints, "coordinates": coordinates, "problems": rows}))
        rival = subprocess.Popen(
            [python, str(Path(__file__).with_name("planning_rival_roboplan.py")), str(asked), str(REPEATS)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        assert rival.stdin is not None
        assert rival.stdout is not None
        version = json.loads(rival.stdout.readline())["version"]
        theirs, ours, failed, hit, lengths = [], [], 0, 0, []
        columns = [coordinates.index(each) for each in joints]
        mf.plan(*cases[0][:1], None, *cases[0][1:], shortcut_iterations=0)
        for k, (checker, a, b) in enumerate(cases):
            if not checker.free(np.stack([a, b])).all():
                continue
            rival.stdin.write(f"{k}\n")
            rival.stdin.flush()
            answer = json.loads(rival.stdout.readline())
            plan, seconds = _repeated(checker, a, b)
            ours.append(seconds)
            theirs.append(answer["seconds"])
            if answer["path"] is None or not plan:
                failed += answer["path"] is None
                continue
            path = np.tile(a, (len(answer["path"]), 1))
            path[:, columns] = answer["path"]
            hit += not _path_free(checker, path)
            lengths.append([float(np.linalg.norm(np.diff(each, axis=0), axis=1).sum()) for each in (path, plan.path)])
        rival.stdin.close()
        rival.wait()
    length = np.mean(np.array(lengths).reshape(-1, 2), axis=0)
    print(
        f"{name}, {len(theirs)} problems: roboplan {version} not found {failed}, in collision at 0.001 rad {hit}, mean "
        f"length {length[0]:.2f}; ours mean length {length[1]:.2f}"
    )
    _print_times("roboplan", theirs, ours)


def against_shortcuts(folder: Path, name: str, count: int) -> None:
    """Lengths, costs, clearances and times: a hundred and a thousand shortcuts, and the same path optimised."""
    rows = []
    for checker, a, b in posed(folder, name, count):
        short = mf.plan(checker, None, a, b)
        if not short or len(short.path) < 3:
            continue
        begun = perf_counter()
        more = mf.plan(checker, None, a, b, shortcut_iterations=1000)
        between = perf_counter()
        better = short.optimise()
        ended = perf_counter()
        assert better.descent is not None
        free = _free(checker, better)
        nearest = [float(each.clearance(100).distance.min()) for each in (short, more, better)]
        cost = better.descent.before.total, better.descent.after.total
        lengths = [short.length, more.length, better.length]
        rows.append([*lengths, *nearest, *cost, 1e3 * (between - begun), 1e3 * (ended - between), not free])
    mean = np.mean(rows, axis=0)
    print(
        f"{name}, {len(rows)} problems, means: length {mean[0]:.3f} (100 shortcuts), {mean[1]:.3f} (1000), "
        f"{mean[2]:.3f} (100 and optimised); clearance {1e3 * mean[3]:.1f}, {1e3 * mean[4]:.1f}, "
        f"{1e3 * mean[5]:.1f} mm; cost {mean[6]:.2f} -> {mean[7]:.2f}; 1000 shortcuts {mean[8]:.1f} ms, "
        f"descent {mean[9]:.1f} ms; "
        f"in collision at 0.001 rad: {int(np.sum([row[-1] for row in rows]))}"
    )


def anytime(folder: Path, name: str, count: int) -> None:
    """Mean lengths of the anytime planner after 0.1, 0.5 and 2 seconds beside RRT-Connect and a hundred shortcuts."""
    rows = []
    for checker, a, b in posed(folder, name, count):
        plain = mf.plan(checker, None, a, b)
        if plain:
            longer = [mf.plan(checker, None, a, b, planner="lazy_prm_star", seconds=s) for s in (0.1, 0.5, 2.0)]
            rows.append([plain.length, *(each.length for each in longer), *(not _free(checker, p) for p in longer)])
    mean = np.mean(rows, axis=0)
    print(
        f"{name}, {len(rows)} problems, mean length: {mean[0]:.3f} (RRT-Connect), {mean[1]:.3f} (0.1 s), "
        f"{mean[2]:.3f} (0.5 s), {mean[3]:.3f} (2 s); in collision at 0.001 rad: {int(np.sum(rows, axis=0)[4:].sum())}"
    )


def time_whole_calls(folder: Path, count: int) -> Comparisons:
    """Processor microseconds of calls as they are typed, the least of several; beside goals."""
    found = Comparisons()
    a, b = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.7]), np.array([0.6, 0.2, 0.1, -1.5, 0.2, 1.8, 0.7])
    for balls, goals in ((10, (1e3, 1e2)), (9000, (None, None))):
        around, first, again = balls_beyond_reach(balls), [], []
        for _ in range(4):
            robot = mf.load("panda")
            for seconds, repeats in ((first, 1), (again, 2000 // balls + 5)):
                for _ in range(repeats):
                    begun = process_time()
                    assert mf.plan(robot, around, a, b, radius=0.06)
                    seconds.append(process_time() - begun)
        for case, seconds, goal in (("first", first, goals[0]), ("again", again, goals[1])):
            own = 1e6 * min(seconds)
            found.add("mf.plan(robot, obstacles)", f"{balls:,} balls, {case}", own, "goal", goal or own, goal and 1.0)
    for name in ("panda", "ur5"):
        if not (folder / f"{name}.json.xz").exists():
            print(f"{folder} holds no problems for {name}: its row is left out")
            continue
        with lzma.open(folder / f"{name}.json.xz") as file:
            rows = [row for each in json.load(file)["sets"].values() for row in each["problems"][:count]]
        whole = []
        for (arm, start, goal), row in zip(posed(folder, name, count), rows, strict=True):
            seconds = []
            for _ in range(5):
                begun = process_time()
                mf.plan(arm, [obstacle(each) for each in row["obstacles"]], start, goal)
                seconds.append(process_time() - begun)
            whole.append(min(seconds))
        middle = 1e6 * float(np.median(whole))
        found.add("obstacles made, laid out, planned among", f"{name}, median", middle, "goal", 260.0, 1.0)
    for one in found.rows:
        print(f"{one.call}, {one.case}: {one.ours:.1f} us" + (f", goal {one.theirs:g}" if one.goal else ""), flush=True)
    return found


def balls_beyond_reach(count: int) -> list[Obstacle]:
    """Small balls around an arm, as many as asked for, away from its base."""
    places = np.random.default_rng(0).uniform(-1.2, 1.2, (4 * count, 3))
    far = places[np.linalg.norm(places[:, :2], axis=1) > 0.75][:count]
    return [Obstacle(Sphere(0.01), place) for place in far]


def main() -> None:
    """Print a table for each arm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--problems", type=Path, default=ROOT.parent / "shared" / "data" / "planning")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--shorten", type=int, default=100)
    parser.add_argument("--peer", type=int, default=0, help="problems of each set to race OMPL on")
    parser.add_argument("--optimise", type=int, default=0, help="problems of each set to optimise after shortcuts")
    parser.add_argument("--anytime", type=int, default=0, help="problems of each set for the anytime planner")
    parser.add_argument("--roboplan", nargs=2, metavar=("PYTHON", "N"), help="its interpreter, problems of each set")
    parser.add_argument("--whole", type=int, default=0, help="problems of each set for whole calls")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    kept: dict[str, Any] = {}
    if given.whole:
        kept["comparisons"] = time_whole_calls(given.problems, given.whole).plain()
        if given.json:
            given.json.write_text(json.dumps(kept, indent=1))
        return
    names = sorted(path.name.removesuffix(".json.xz") for path in given.problems.glob("*.json.xz"))
    if not names:
        parser.error(f"{given.problems} holds no problems: name their folder by --problems")
    for name in names:
        if given.optimise:
            against_shortcuts(given.problems, name, given.optimise)
            continue
        if given.anytime:
            anytime(given.problems, name, given.anytime)
            continue
        if given.roboplan:
            race_roboplan(given.problems, name, int(given.roboplan[1]), given.roboplan[0])
            continue
        if given.peer:
            race_ompl(given.problems, name, given.peer)
            continue
        rows = solved(given.problems, name, given.count, given.shorten)
        plans = [plan for plan, _, _, _ in rows]
        seconds, again = (np.array([row[k] for row in rows]) * 1e3 for k in (1, 2))
        row = {
            "problems": len(rows), "solved": sum(map(bool, plans)),
            "ends in collision": sum(plan.status in BLOCKED for plan in plans),
            "in collision at 0.001 rad": sum(not row[3] for row in rows),
            "median ms": float(np.median(seconds)), "95 % ms": float(np.quantile(seconds, 0.95)),
            "worst ms": float(seconds.max()), "median ms in known scenes": float(np.median(again)),
            "95 % ms in known scenes": float(np.quantile(again, 0.95)),
            "mean length": float(np.mean([p.length for p in plans if p])),
        }  # fmt: skip
        kept[name] = row
        print(f"{name}: " + ", ".join(f"{k} {v:.4g}" for k, v in row.items()), flush=True)
    if given.json:
        given.json.write_text(json.dumps(kept, indent=1))


if __name__ == "__main__":
    main()
