"""Writes docs/reliability.md from the figures of the harness in docs/figures: no figure is typed by hand.

python docs/make_reliability.py                     writes the page
python docs/make_reliability.py --check             fails if the page is not what would be written
python docs/make_reliability.py --take FOLDER ...   first copies the sums of finished rows (K1.json, ...) from FOLDER
"""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
FIGURES = DOCS / "figures"


@dataclass(frozen=True)
class Row:
    """One promise: what it is, the figure that counts its cases, the goal, the command, what is not covered."""

    id: str
    promise: str
    unit: str
    goal: int
    command: str
    not_covered: str = ""


ROWS = (
    Row(
        "R1",
        "Random trees of 1 to 40 joints of all kinds: kinematics and dynamics equal Pinocchio's and MuJoCo's to "
        "1e-12 in natural scale (weight times reach); four states each.",
        "robots",
        1_000_000,
        "random_trees --robots 1000000 --shard 1/2 --resume",
        "MuJoCo has no helical joints and no chained couplings: those robots have one oracle.",
    ),
    Row(
        "R3",
        "Derivative kernels on library arms and random trees: equal to the complex step through textbook mechanics to "
        "1e-11, forward mode equal to reverse mode to 1e-12, relative to the robot's natural size.",
        "cases",
        1_000_000,
        "derivatives --cases 1000000 --resume DIR",
    ),
    Row(
        "V1",
        "Mutation testing: every sum, product, sine and cosine of every routine exchanged in turn; `mafsil.verify` "
        "finds each that changes a number.",
        "mutants",
        100_000,
        "slips --robots 6",
    ),
    Row(
        "R4",
        "Real robot files load, or are refused with a code, a line and a column.",
        "files",
        134,
        "hostile_tables",
        "The other 65 files of the goal are xacro and SDF; published ones are counted in R4c.",
    ),
    Row(
        "R4c",
        "Published robot files at the commits of `tests/corpus/manifest.jsonl` (makers, peers, collections): "
        "makers' robots in URDF, xacro and SDF and manipulators in MJCF load as shipped, the packages of all "
        "repositories beside one another as in a ROS workspace; what Pinocchio (URDF; xacro as ROS's xacro 2 "
        "expands it), MuJoCo (MJCF) or a second, plain reader of SDF on Pinocchio reads too has the same poses, "
        "mass matrix and forces at 20 states to 1e-9 in natural scale; no crash; and what they take is not refused.",
        "files",
        1_789,
        "tests.corpus run --xacro PYTHON --output DIR",
        "No robots by themselves, hence not counted among the makers' robots: xacro files that only define macros, "
        "that ROS's xacro cannot expand with the arguments of their launch files, or whose expansion holds no links "
        "or hangs joints on links of another file; URDF files of that kind. Files that are no XML or hold another "
        "fault stay in the count. Files of which the peer cannot read a mesh or a texture, without joints, with "
        "more than 120 joints, and SDF files with frames, nested or several models are loaded without being "
        "compared. Free base joints are held, and rotors that Pinocchio does not know are left out. Refused though "
        "MuJoCo takes them: files with inertia across several joints (of tendons, 12; of ball joints, 4), nearly all "
        "tests of MuJoCo itself, and a mesh of a plugin.",
    ),
    Row(
        "R5",
        "Numerical inverse kinematics, pose by pose from a mid-range initial guess: solved within 5 ms of one core, "
        "within 1e-9 m and rad and the limits on recheck; at most one of 100,000 missed.",
        "poses",
        30_000_000,
        "ik_numerical --cases 1000000 --resume DIR",
        "17 arms so far; TRAC-IK's other chains are not among them.",
    ),
    Row(
        "R6",
        "Closed forms, library arms and random arms of every family, round joint values, six arms at their singular "
        "surfaces and 1e-12 to 1e-3 beside: every planted configuration found or member of a named family, nothing "
        "wrong beyond 1e-9, nothing twice, the same configurations as EAIK's (`ik_eaik`, 20,000 poses of each arm).",
        "cases",
        100_000_000,
        "ik_complete --cases 100000000 --resume DIR",
        "Random arms are judged by the table of their structure, and by the public call where that misses one. Beside "
        "a merged elbow or shoulder nobody can tell in working precision where a wrist bent by less than 1e-5 points: "
        "those are counted as hidden bends. Failures are configurations lost, counted twice where the list calls "
        "itself complete: UR and PUMA wrists bent by less than 1e-8 just where the elbow (UR: and the shoulder) "
        "merges; rounding hides the family there. Of prismatic joints that bring the wrist level with joint 2, the "
        "wrist straight as well, not every crossing of continua is named.",
    ),
    Row(
        "R7",
        "Poses out of reach, in the hole, beside the shoulder, beyond limits, tilted: the right reason, distance and "
        "joint, never converged; singular configurations: the right rank, bounded rates, no NaN.",
        "cases",
        10_000_000,
        "ik_unreachable --cases 10000000 --resume DIR",
        "Elbow arms, plane arms and one SCARA arm: where elementary geometry knows the answer.",
    ),
    Row(
        "R9",
        "Random mechanisms of 3 to 8 bodies with up to three loops of all kinds of joints, half of them on special "
        "axes, as drawn and elsewhere: mobility by rank, and of the compiled loops, is that of Pinocchio's constraint "
        "Jacobian; over-constrained ones (planar, spherical, Sarrus, Bennett, Goldberg, Bricard, translating "
        "platforms, parallelograms, bent ones), hung on each other and closed by general chains: finite mobility is "
        "that of the theorem.",
        "mechanisms",
        100_000,
        "mechanisms --mechanisms 100000 --resume DIR",
        "Ranks within four digits of the tolerance are counted as doubtful, not judged. Of finite mobility about a "
        "third is proven, the rest found.",
    ),
    Row(
        "R9c",
        "Random over-constrained linkages, as in R9, with one or two parts that are shaky of order 2, 4 or 8 hung on "
        "any body, a thousandth to a thousand times as large: finite mobility is that of the theorem, or in doubt "
        "between two numbers of which one is right.",
        "linkages",
        10_000,
        "shaky_parts --linkages 10000 --resume DIR",
        "Parts that share no loop are judged apart.",
    ),
    Row(
        "R9b",
        "Random platforms on six legs, each of its own geometry, of which only lengths at a planted pose are told: the "
        "planted pose is among those found, all poses keep the lengths to 1e-9 of the size, there are forty in all; of "
        "every fiftieth a proof is asked that its poses exist, differ and are all.",
        "platforms",
        10_000,
        "platforms --platforms 10000 --resume DIR",
        "Closed chains of other kinds have no row: their residuals and assembly modes are shown by tests alone.",
    ),
    Row(
        "R16",
        "Forward kinematics and back, library arms, example-robot-data and makers' URDF files, up to three frames of "
        "each: no reachable pose is answered no, in batches or alone, every solution reaches its pose to 1e-7 (asked "
        "of Pinocchio for files) and is within the limits where it says so.",
        "poses",
        1_000_000,
        "ik_round_trip --poses 1000 --frames 3 --corpus FOLDER --resume DIR",
        "Frames with more than eight moving joints on the way are left out. Files with mimic joints are judged by our "
        "own forward kinematics.",
    ),
    Row(
        "J1",
        "Random jobs for library arms, hostile gains, weak motors, friction, pushes, wrong masses, low rates: every "
        "sentence, number and cause of the verdict is what plain NumPy finds in the recording; nothing is left out.",
        "jobs",
        1_000,
        "job_verdicts --jobs 1000 --resume DIR",
        "Plans that are refused are counted, not judged; robots from files, vias and lines run in the other tests.",
    ),
    Row(
        "F1",
        "Damaged robot files: no crash, no foreign exception, no hang over 2 s, memory below 256 MB, accepted "
        "models keep the invariants.",
        "files",
        50_000_000,
        "fuzz_reader --files 50000000",
        "SRDF has no reader.",
    ),
    Row(
        "F2",
        "Hostile files: each gets its expected code, line and repair, in both languages.",
        "files",
        300,
        "hostile_tables",
    ),
    Row(
        "F3",
        "Calls with hostile arrays: the right answer bit by bit, or our own error; never a crash.",
        "calls",
        10_000_000,
        "api_fuzz --calls 10000000",
    ),
    Row(
        "K1",
        "The store of compiled code under kill -9: no torn entry, no wrong load, the next start works.",
        "kills",
        100_000,
        "kill_cache --kills 100000",
        "Power loss: the order of fsync and rename is reviewed, not proven.",
    ),
    Row(
        "K2",
        "Damaged entries of kernels and loops are found out before they are used, and compiled again.",
        "cases",
        10_000,
        "corrupt_cache --cases 10000",
    ),
    Row(
        "K3",
        "Many processes and threads start at once on an empty cache: one entry, equal bits, no deadlock.",
        "rounds",
        1_000,
        "stampede --rounds 1000",
    ),
    Row(
        "C1",
        "64 threads share kernels: every answer has the bits of the serial one.",
        "calls",
        640_000,
        "concurrency --calls 640000",
        "Servers, dask and free-threaded builds.",
    ),
    Row(
        "D1",
        "One hash per scenario over threads, batch sizes, order of runs and warm or cold cache.",
        "scenarios",
        1_000,
        "determinism --scenarios 1000",
        "One Python version and one processor.",
    ),
    Row(
        "R12",
        "Force closure by three methods (linear program, exact integers or growing polytope, the proof read back) on "
        "plane and spatial grasps; planted boundaries are marginal.",
        "grasps",
        11_000_000,
        "grasps --grasps 11000000",
    ),
    Row(
        "R11",
        "Jerk-limited motions of 1 to 7 joints between random states (at rest, arbitrary, outside the limits, one-"
        "sided limits): limits and end states to 1e-9, none fails, none longer than Ruckig's by 1e-6 of its duration.",
        "problems",
        10_000_000,
        "jerk_limited --problems 10000000 --resume DIR",
    ),
    Row(
        "R11-via",
        "Jerk-limited motions through via points: limits and points to 1e-9, none fails, none longer than with stops.",
        "problems",
        100_000,
        "jerk_via_points --problems 100000 --resume DIR",
        "Shortest only locally.",
    ),
    Row(
        "R11-paths",
        "Shortest times along random paths of library arms, every twentieth under the arm's efforts with friction: no "
        "limit is exceeded by 1e-6 of it at 4,000 times between and on the places of the grid.",
        "paths",
        10_000,
        "time_optimal_paths --paths 10000 --resume DIR",
        "TOPP-RA is compared in `benchmarks/time_optimal.py` and one test, not in this row; jerk is not limited.",
    ),
    Row(
        "R11-jumps",
        "Random motions of nine kinds on random scales: none without a jump is accused of one; beside every twenty one "
        "with a jump of position, velocity or acceleration planted: joint, time and size are found, and proof denied.",
        "motions",
        10_000,
        "planted_jumps --motions 10000 --resume DIR",
        "Jumps smaller than 1e-4 of the largest value of the derivative are not planted.",
    ),
    Row(
        "R17",
        "Paths of random arms in random scenes of all kinds of obstacles: none in collision at 0.003 rad, ends and "
        "limits kept, every refusal names what it claims.",
        "problems",
        10_000,
        "planning_scenes --problems 10000 --resume DIR",
        "The dense look is by the same checker, which coal confirms in tests; not found is counted, not judged.",
    ),
    Row(
        "R18",
        "Paths of the Panda and the UR5 in the 1,400 problems of MotionBenchMaker, half of them timed too: Pinocchio "
        "and coal find none in collision at 0.001 rad on the same shapes.",
        "problems",
        1_400,
        "coal_paths --problems 1400 --resume DIR",
        "The balls of the spherised models are the shapes; what no joint moves is not checked against the scene.",
    ),
    Row(
        "R19",
        "Two and three arms on one table in random scenes, planned together, in turn and on given paths: no motion in "
        "collision at 0.001 rad, limits kept, every deadlock confirmed, every refusal names what it claims.",
        "problems",
        1_000,
        "several_arms --problems 1000 --resume DIR",
        "The dense look is by the same checker, which coal confirms in tests; not found is counted, not judged.",
    ),
    Row(
        "R20",
        "Random configurations of three arms in random scenes and those of MotionBenchMaker: every verdict is coal's "
        "on the same shapes; distances of primitives and hulls apart lie between two bounds 1e-9 m apart (with a "
        "cylinder or cone 1e-9 of their size).",
        "states",
        1_000_000,
        "coal_verdicts --states 1000000 --resume DIR",
        "Where coal's verdict and its own distance disagree, its distance decides, beyond its tolerance of 1e-6 m.",
    ),
    Row(
        "R21",
        "What is checked of the robots of example-robot-data holds every vertex of their meshes, as Pinocchio's reader "
        "gives and places them, to 1e-7 m; and nothing is thickened.",
        "robots",
        69,
        "mesh_cover --robots 69 --resume DIR",
        "Of meshes with more than 4,000 vertices their extremes along 200 directions and 4,000 others are looked at; "
        "one file has no shapes, one no links.",
    ),
    Row(
        "F4",
        "Hostile frames and requests against the studio: foreign origins, hosts, tokens, what is no HTTP or no JSON, "
        "false lengths, numbers out of range: refused; meanwhile a window is answered within 2 s, no line of its "
        "journal is lost, and another window hears each once and in order.",
        "frames",
        100_000,
        "hostile_frames --frames 100000 --resume DIR",
        "Messages with a piece changed may be good by chance; those are counted.",
    ),
    Row(
        "F5",
        "Files of 26 kinds (robots, loops, meshes, clouds, heights, motions, logs, recordings, results, jobs, grasps, "
        "linkages), damaged, cut, swollen, and pipes, devices, folders, links and bombs in their place: an answer with "
        "finite numbers or our own error in both languages, within 2 s of the processor for each megabyte begun, and "
        "256 MB.",
        "files",
        100_000,
        "hostile_doors --files 100000 --resume DIR",
        "Robots that are let in are judged in F1; jobs, grasps and linkages by their own tests.",
    ),
    Row(
        "R14",
        "The linear program core, random and degenerate: residuals to 1e-10, certificates hold, verdicts as HiGHS.",
        "programs",
        10_000_000,
        "programs --programs 10000000",
        "There is no quadratic program of our own.",
    ),
    Row(
        "R8",
        "Exponentials and logarithms of rotations and motions: round trip to 8 eps away from pi, to 1e-8 at pi, "
        "never NaN.",
        "cases",
        1_000_000_000,
        "lie_groups --cases 1000000000",
    ),
    Row(
        "R10",
        "Free motion of random trees for 100 s at the step chosen by the error estimate: energy to 1e-9 of the largest "
        "kinetic energy, momenta to 1e-12; orders of the integrators within 0.1 of the nominal ones on step halving.",
        "trees",
        1_000,
        "conservation --cases 1000",
        "Trees that need over 100,000 steps are counted as unfinished and judged so far; orders above six are shown on "
        "single problems, for on random trees they are lost in roundoff. The failure, tree 21002, drifts by some 1e-9: "
        "a revolute joint turns a prismatic one that runs 4 km, the mass matrix has condition 4e7, and roundoff of the "
        "state alone changes the energy by up to 1e-11 a step; a finer tolerance does not help.",
    ),
    Row(
        "R22",
        "Routh's array on random polynomials of order 1 to 10 (normal and positive coefficients, roots planted over "
        "six decades, near the axis): stability and the number of roots on the right are those of the companion's "
        "eigenvalues.",
        "polynomials",
        1_000_000,
        "routh_roots --polynomials 1000000 --resume DIR",
        "Polynomials of which a root is nearer to the axis than a hundred times its uncertainty are counted as "
        "unclear.",
    ),
    Row(
        "K6",
        "Ctrl-C at random instants of batches, inverse kinematics and compilations: heard within 0.2 s (compiling: "
        "1 s), and the next call gives what it gave before.",
        "cases",
        10_000,
        "interrupts --cases 10000 --resume DIR",
        "A batch whose result overlaps its arguments is done in one piece.",
    ),
)
ELSEWHERE = (
    ("R2", "Compiled kernels equal the reference path", "`tests/reliability/test_random_trees.py`, `tests/kernels`"),
    ("C2", "Robots and kernels travel by pickle and copy", "`tests/reliability/test_robot_rows.py`"),
    ("N2", "Reports and commands work without a network", "`tests/report`, `tests/cli`"),
    ("K5", "Results of a job under kill -9 and on a full disk: the old ones or the new ones", "`tests/report`"),
    (
        "K4",
        "A live log under kill -9 loses the last milliseconds, a torn one is said to be",
        "`tests/simulation/test_live_log.py`",
    ),
    ("N1", "Exposure of the studio: foreign hosts, origins, tokens and sites are refused", "`tests/studio`"),
    ("Q3", "The worked numbers of the specification, to the printed digits", "`tests/acceptance`"),
    ("Q5", "Every message in both languages", "`tests/house`, `tests/cli`"),
    ("Q6", "Pyright, strict, without an error", "`.ci/run`"),
)
UNSHOWN = (
    ("R13", "planned paths without a collision at ten times the resolution"),
    ("R15", "every control law on 1,000 random robots"),
    ("S1", "24 hours of random operations: memory, files, equal results"),
    ("S2", "24 hours of the studio"),
    ("S3", "10^9 steps of a closed loop"),
    (
        "D2",
        "instruction sets: SSE2, AVX2 with and without fused operations, to 2 ulp (deep kernels differ by more)",
    ),
    ("T1", "time limits of solvers kept"),
    ("T2", "memory limits: batches streamed, refused allocations survived"),
    ("Q1", "coverage of lines and branches measured"),
    ("Q2", "mutation score of the mathematics and the readers"),
    ("Q4", "notebooks executed: there are none; the pages' code is"),
    ("Q7", "alarm at a slower benchmark"),
)
"""Rows of the goal table for which nothing is shown."""


def main() -> int:
    """Write or check the page."""
    if "--take" in sys.argv:
        for folder in sys.argv[sys.argv.index("--take") + 1 :]:
            _take(Path(folder))
    page = "\n".join(_lines()) + "\n"
    path = DOCS / "reliability.md"
    if "--check" in sys.argv:
        return int(not path.exists() or path.read_text("utf-8") != page)
    path.write_text(page, "utf-8")
    return 0


def _take(folder: Path) -> None:
    for row in ROWS:
        if (folder / f"{row.id}.json").exists():
            shutil.copy(folder / f"{row.id}.json", FIGURES)


def _lines() -> list[str]:
    found = {row.id: _figures(row.id) for row in ROWS}
    lines = [
        "# Reliability: what is promised, and what has been shown",
        "",
        "Made by `docs/make_reliability.py` from `docs/figures`, which the harness in `tests/reliability` writes.",
        _headline(found),
        "A row's goal is the size at which its promise counts as shown; most rows have run at a smaller one. What is",
        'missing, and what failures are known, stands under "Not reached". With `--resume FOLDER` a command goes on',
        "where it stopped; a smaller size of each row runs with the tests.",
        "",
        "| row | promise | shown | failures | goal | time |",
        "|---|---|---|---|---|---|",
    ]
    lines += [_table_row(row, found[row.id]) for row in ROWS]
    lines += ["", "## Commands", ""]
    lines += [f"- {row.id}: `python -m {_module(row.command)}`" for row in ROWS]
    lines += ["", "## Shown by tests alone", ""]
    lines += [f"- {name}: {promise}: {place}" for name, promise, place in ELSEWHERE]
    lines += ["", "## Not reached", ""]
    lines += [f"- {text}" for row in ROWS for text in _gaps(row, found[row.id])]
    lines += ["", "## Nothing shown", ""]
    lines += [f"- {name}: {promise}" for name, promise in UNSHOWN]
    return lines


def _headline(found: dict[str, dict[str, Any] | None]) -> str:
    """How many rows ran, which of them at full size, and which of them show failures."""
    ran = {row.id: data for row in ROWS if (data := found[row.id]) is not None}
    full = sum(ran[row.id][row.unit] >= row.goal for row in ROWS if row.id in ran)
    failures = {name: count for name, data in ran.items() if (count := _failures(data))}
    clean = f"{len(ran) - len(failures)} of {len(ROWS)} rows ran without a failure, {full} of {len(ROWS)} at full size."
    failed = ", ".join(f"{name} ({count})" for name, count in failures.items())
    idle = ", ".join(row.id for row in ROWS if row.id not in ran)
    return clean + (f" With failures: {failed}." if failed else "") + (f" Not run: {idle}." if idle else "")


def _module(command: str) -> str:
    return command if command.startswith("tests.") else f"tests.reliability.{command}"


def _figures(name: str) -> dict[str, Any] | None:
    path = FIGURES / f"{name}.json"
    return json.loads(path.read_text("utf-8")) if path.exists() else None


def _table_row(row: Row, found: dict[str, Any] | None) -> str:
    if found is None:
        return f"| {row.id} | {row.promise} | not run | | {row.goal:,} {row.unit} | |"
    shown = f"{found[row.unit]:,} {row.unit}"
    return (
        f"| {row.id} | {row.promise} | {shown}{_details(found, row.unit)} | {_failures(found)} | {row.goal:,} | "
        f"{found['seconds']:.0f} s |"
    )


def _details(found: dict[str, Any], unit: str) -> str:
    """What else was counted: refusals, recompilations, oracles."""
    if "checks" in found:
        worst = max(error for error, _ in found["worst"].values())
        counts = ", ".join(f"{count:,} by {oracle}" for oracle, count in sorted(found["checks"].items()))
        return f" ({counts}; worst {worst:.1e})"
    plain = {"row", "shards", "machine", "python", "passed", "seconds", unit}
    others = {
        name: value
        for name, value in found.items()
        if name not in plain
        and not name.endswith("eps")
        and not name.startswith(("bad_", "at_"))
        and "_below_" not in name
        and value
    }
    text = ", ".join(f"{value:,} {name.replace('_', ' ')}" for name, value in others.items())
    return f" ({text})" if text else ""


def _failures(found: dict[str, Any]) -> int:
    if "beyond" in found:
        return len(found["beyond"])
    return sum(value for name, value in found.items() if name.startswith("bad_"))


def _gaps(row: Row, found: dict[str, Any] | None) -> list[str]:
    count = 0 if found is None else found[row.unit]
    gaps = [f"{row.id}: {count:,} of {row.goal:,} {row.unit}."] if count < row.goal else []
    return gaps + ([f"{row.id}: {row.not_covered}"] if row.not_covered else [])


if __name__ == "__main__":
    raise SystemExit(main())
