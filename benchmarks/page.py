"""All benchmarks in one run: a page of ratios, docs/performance.md, and every figure in docs/performance.csv.

python benchmarks/page.py [--only NAME ...] [--quick] [--peers FOLDER] [--out FILE]

Each benchmark runs by itself, one after the other, on one thread unless it says otherwise, and writes its figures as
JSON; what it compares with a rival (`Comparison`) becomes the page. Rivals whose dependencies do not fit ours live in
environments of their own under --peers: `rtb` (roboticstoolbox-python) and `klampt` (Klampt), each made on first use.
A benchmark that fails is named on the page with its last line; the others are not lost.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import date
from io import StringIO
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.comparison import Comparison, read  # noqa: E402
from benchmarks.stopwatch import machine  # noqa: E402

PAGE = ROOT / "docs" / "performance.md"
BY_HAND = "## Off the regular case, and at size"
"""Heading from which on the page is not written anew."""
SHOWN = 4
"""Rows of a benchmark on the page."""
VERSIONS = ("mafsil", "numpy", "scipy", "llvmlite", "pin", "eaik", "ssik", "mujoco-core")
ENVIRONMENTS = {
    "rtb": ("--only-binary=:all:", "roboticstoolbox-python", "scipy"),
    "klampt": ("klampt", "numpy<2"),
}
"""Packages of the rivals that need an interpreter of their own."""


@dataclass(frozen=True)
class Benchmark:
    """One script.

    Attributes:
        script: its file in this folder.
        question: what it answers, the heading on the page.
        peer: key of `ENVIRONMENTS`; passed as `--<peer> PYTHON`.
        quick: arguments of a shorter run.
        always: arguments of every run.
    """

    script: str
    question: str
    peer: str = ""
    quick: tuple[str, ...] = field(default=("--quick",))
    always: tuple[str, ...] = ()


BENCHMARKS = (
    Benchmark("batch_sizes.py", "Kinematics and dynamics, from one state to a million"),
    Benchmark("call_forms.py", "Every form of a call"),
    Benchmark("ik_closed_form.py", "Inverse kinematics with all solutions, closed forms", quick=("--poses", "4000")),
    Benchmark("ik_general.py", "Inverse kinematics of any six joints", quick=("--six", "jaco2", "xarm6")),
    Benchmark("ik_redundant.py", "Inverse kinematics of seven joints", quick=("--poses", "300")),
    Benchmark(
        "ik_numerical.py",
        "Numerical inverse kinematics",
        peer="rtb",
        quick=("--robots", *["panda", "iiwa7", "ur5e", "puma560"], "--rival-poses", "500"),
    ),
    Benchmark("grasp_closure.py", "Grasps: force closure and its margin", peer="klampt", quick=("--grasps", "1000")),
    Benchmark("first_use.py", "First answers with an empty cache, and commands with a full one", quick=()),
    Benchmark(
        "planning.py",
        "Plans as they are typed: robot, obstacles, start, goal",
        quick=("--whole", "3"),
        always=("--whole", "20"),
    ),
)


@dataclass(frozen=True)
class Outcome:
    """What a benchmark gave.

    Attributes:
        comparisons: its rows.
        failure: the last line of a run that failed.
    """

    comparisons: list[Comparison]
    failure: str = ""


def main() -> None:
    """Run, and write the page."""
    options = _parsed()
    details = machine(*VERSIONS)
    _, by_hand, rest = PAGE.read_text(encoding="utf-8").partition(BY_HAND)
    kept = f"\n{by_hand}{rest}"
    chosen = [one for one in BENCHMARKS if not options.only or Path(one.script).stem in options.only]
    outcomes: dict[Benchmark, Outcome] = {}
    for number, benchmark in enumerate(chosen, 1):
        print(f"[{number}/{len(chosen)}] {benchmark.question} ...", file=sys.stderr, flush=True)
        outcomes[benchmark] = measured(benchmark, options.quick, options.peers)
        options.out.write_text("\n".join(page(details, outcomes)) + "\n" + kept, encoding="utf-8")
        options.out.with_suffix(".csv").write_text(table(outcomes), encoding="utf-8")
    print("\n".join(summary(outcomes)))


def measured(benchmark: Benchmark, quick: bool, peers: Path) -> Outcome:
    """One script in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        figures = Path(folder) / "figures.json"
        command = [sys.executable, str(ROOT / "benchmarks" / benchmark.script), "--json", str(figures)]
        command += (*benchmark.always, *(benchmark.quick if quick else ()))
        if benchmark.peer:
            command += [f"--{benchmark.peer}", str(interpreter(benchmark.peer, peers))]
        done = subprocess.run(
            command, check=False, cwd=ROOT, env=os.environ | {"MAFSIL_THREADS": "1"}, capture_output=True, text=True
        )
        if done.returncode or not figures.exists():
            lines = (done.stderr or done.stdout).strip().splitlines()
            return Outcome([], lines[-1] if lines else f"exit status {done.returncode}")
        return Outcome(read(json.loads(figures.read_text()).get("comparisons", ())))


def interpreter(peer: str, peers: Path) -> Path:
    """The Python of a rival's environment, made if it is not there."""
    home = peers / peer
    python = home / "bin" / "python"
    if not python.exists():
        venv.EnvBuilder(with_pip=True).create(home)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *ENVIRONMENTS[peer]], check=True)
    return python


def page(details: dict[str, str], outcomes: dict[Benchmark, Outcome]) -> Iterator[str]:
    """The lines of the page."""
    yield "# Speed beside the peers"
    yield ""
    yield f"Written by `python benchmarks/page.py` on {date.today().isoformat()}: public names, one thread, every rival"
    yield "in the same run, the least of many turns taken in turn. Judge the ratios, not the microseconds. All figures:"
    yield "[performance.csv](performance.csv)."
    yield ""
    yield ", ".join(f"{name} {value}" for name, value in details.items()) + "."
    yield ""
    yield from summary(outcomes)
    yield ""
    yield f"Of each question {SHOWN} rows, evenly from the farthest from its goal to the farthest beyond it:"
    yield ""
    yield "| call | case | us | peer | its us | times | goal |"
    yield "|---|---|---|---|---|---|---|"
    for outcome in outcomes.values():
        for one in spread(outcome.comparisons):
            goal = "" if one.goal is None else f"{one.goal:g}" + ("" if one.met else " (missed)")
            figures = f"{one.ours:.3g} | {one.peer} | {one.theirs:.3g} | {one.ratio:.3g}"
            yield f"| {one.call} | {one.case} | {figures} | {goal} |"


def spread(comparisons: list[Comparison]) -> list[Comparison]:
    """Rows at equal steps of rank in how far they are beyond their goals."""
    ranked = sorted(comparisons, key=lambda one: one.ratio / (one.goal or 1.0))
    count = min(SHOWN, len(ranked))
    return [ranked[round(k * (len(ranked) - 1) / max(count - 1, 1))] for k in range(count)]


def table(outcomes: dict[Benchmark, Outcome]) -> str:
    """All comparisons as CSV, one line each."""
    text = StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["script", "call", "case", "us", "peer", "its_us", "times", "goal", "met", "bound"])
    for benchmark, outcome in outcomes.items():
        for one in outcome.comparisons:
            times = [f"{one.ours:.3g}", one.peer, f"{one.theirs:.3g}", f"{one.ratio:.3g}"]
            rows.writerow([benchmark.script, one.call, one.case, *times, one.goal, one.met, one.bound])
    return text.getvalue()


def summary(outcomes: dict[Benchmark, Outcome]) -> Iterator[str]:
    """How many goals each benchmark reaches, and its worst one."""
    yield "| question, script | goals reached | farthest from its goal |"
    yield "|---|---|---|"
    for benchmark, outcome in outcomes.items():
        judged = [one for one in outcome.comparisons if one.goal is not None]
        if outcome.failure or not judged:
            yield f"| {benchmark.question}, `{benchmark.script}` | {outcome.failure or 'none set'} | |"
            continue
        worst = min(judged, key=lambda one: one.ratio / (one.goal or 1.0))
        told = f"{worst.call}, {worst.case}: {worst.ratio:.3g} of {worst.goal:g} times"
        reached = f"{sum(one.met is True for one in judged)} of {len(judged)}"
        yield f"| {benchmark.question}, `{benchmark.script}` | {reached} | {told} |"


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=[Path(one.script).stem for one in BENCHMARKS])
    parser.add_argument("--quick", action="store_true", help="shorter runs")
    parser.add_argument(
        "--peers", type=Path, default=Path.home() / ".cache" / "mafsil-peers", help="environments of rivals"
    )
    parser.add_argument("--out", type=Path, default=PAGE)
    return parser.parse_args()


if __name__ == "__main__":
    main()
