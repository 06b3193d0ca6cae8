"""How long does the first answer take? Processor seconds of a fresh process per question, beside the goals.

Each question is the smallest of its kind (those of `mafsil info --build`) and is asked twice, each time by a new
process: of an empty store, and of the store that the first one left. The first column of each is the question alone,
the second the whole process, start and imports included; the last the memory of the process that compiles. Python's own
bytecode is there before, as an installation leaves it.

Then commands as they are typed, of a store that holds what they need: the least of the repeats, whole processes.

python benchmarks/first_use.py [--questions plan closure ...] [--repeats 3] [--json FILE]
"""

from __future__ import annotations

import argparse
import compileall
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

GOALS = {
    "pose": 0.3, "demo": 6.0, "collision": 2.0, "plan": 5.0, "closure": 2.0, "inverse_kinematics_6r": 2.0,
    "solve_ik": 1.0, "time_optimal": 2.0, "jerk_limited": 2.0, "monte_carlo": None, "closed_chain": None,
    "build": 30.0,
}  # fmt: skip
"""Seconds of the question alone, of an empty store."""
WARM = {"plan": 0.5}
"""The same of the store that is full."""
ASKED = """
import os, time
from mafsil.cli.build import build, families
import mafsil as mf, numpy as np
{before}
begun = os.times()
{question}
ended = os.times()
def spent(a): return a.user + a.system + a.children_user + a.children_system
def peak():
    try:
        import resource
    except ImportError:
        return 0.0
    return max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1024
print("", spent(ended) - spent(begun), spent(ended), peak())
"""
OTHERS = {
    "pose": ("robot = mf.load('ur5e')", "robot.forward_kinematics(np.full(6, 0.3))"),
    "demo": ("from mafsil.cli.main import main; os.chdir(os.environ['MAFSIL_CACHE'])", "main(['demo'])"),
    "build": ("", "build(lambda one, share: None)"),
}
"""What is no single question of the build: what stands before the clock starts, and what is timed."""
COMMANDS = {
    "fk panda 0 -0.5 0 -2 0 1.5 0.7": 0.2,
    "ik panda --pose 0.4 0 0.5 pi 0 0": 0.3,
    "plan panda --start 0 -0.5 0 -2 0 1.5 0.7 --goal 0.6 0.2 0.1 -1.5 0.2 1.8 0.7": 0.4,
    "demo": 1.2,
}
"""Processor seconds of each as a process, once the store holds what it needs."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Time every question and print the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--questions", nargs="*", choices=list(GOALS), default=list(GOALS))
    options.add_argument("--repeats", type=int, default=3)
    options.add_argument("--json", type=Path)
    chosen, found = options.parse_args(arguments), Comparisons()
    compileall.compile_dir(ROOT / "src", quiet=1)
    print(f"{'processor seconds':24} {'empty':>7} {'whole':>7} {'full':>7} {'whole':>7} {'MB':>6}   goals")
    for name in chosen.questions:
        empty, full, memory = asked(name, chosen.repeats)
        goals = " ".join(str(goal) for goal in (GOALS[name], WARM.get(name)) if goal)
        print(f"{name:24} {empty[0]:7.2f} {empty[1]:7.2f} {full[0]:7.2f} {full[1]:7.2f} {memory:6.0f}   {goals}")
        for which, seconds, goal in (("empty", empty, GOALS[name]), ("full", full, WARM.get(name))):
            if goal:
                found.add(f"first answer: {name}", f"{which} store", 1e6 * seconds[0], "goal", 1e6 * goal, 1.0)
    with tempfile.TemporaryDirectory() as folder:
        for command, goal in COMMANDS.items():
            own = command_seconds(command.split(), Path(folder), chosen.repeats)
            print(f"mafsil {command:70} {own:.2f}   {goal}")
            found.add(f"mafsil {command.split()[0]}", "full store, whole process", 1e6 * own, "goal", 1e6 * goal, 1.0)
    if chosen.json:
        chosen.json.write_text(json.dumps({"comparisons": found.plain()}, indent=1))


def asked(name: str, repeats: int) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Seconds alone and whole, of an empty and of a full store, the least of the repeats; and MB of the first."""
    before, question = OTHERS.get(name) or (
        f"ask = next(questions[{name!r}] for questions in families().values() if {name!r} in questions)",
        "ask()",
    )
    code, runs = ASKED.format(before=before, question=question), []
    for _ in range(repeats):
        store = tempfile.mkdtemp()
        runs.append((seconds(code, store), seconds(code, store)))
        shutil.rmtree(store)
    (alone, whole, memory), (again, whole_again, _) = (
        [min(each) for each in zip(*of, strict=True)] for of in zip(*runs, strict=True)
    )
    return (alone, whole), (again, whole_again), memory


def command_seconds(words: list[str], folder: Path, repeats: int) -> float:
    """Processor seconds of a command, the least of the repeats after one that fills the store."""
    settings, spent = {**os.environ, "MAFSIL_CACHE": str(folder / "store"), "PYTHONDONTWRITEBYTECODE": ""}, []
    for _ in range(repeats + 1):
        begun = os.times()
        subprocess.run(
            [sys.executable, "-m", "mafsil", *words], env=settings, cwd=folder, capture_output=True, check=True
        )
        ended = os.times()
        spent.append(ended.children_user + ended.children_system - begun.children_user - begun.children_system)
    return min(spent[1:])


def seconds(code: str, store: str) -> tuple[float, float, float]:
    """What one process printed of itself."""
    settings = {**os.environ, "MAFSIL_CACHE": store, "PYTHONDONTWRITEBYTECODE": ""}
    done = subprocess.run([sys.executable, "-c", code], env=settings, capture_output=True, text=True, check=True)
    alone, whole, memory = map(float, done.stdout.split()[-3:])
    return alone, whole, memory


if __name__ == "__main__":
    main()
