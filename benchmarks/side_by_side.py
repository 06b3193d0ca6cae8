"""The same seven tasks as told by mafsil and by a peer: lines of code that tell them, and how far the numbers agree.

python benchmarks/side_by_side.py [--json FILE]

Lines of code are those that hold a token: no blank lines, comments, docstrings. What a peer's task takes is listed
with it; a file of C++ counts without comments. Peers that are not installed are left out. The page
docs/side_by_side.md holds the last figures.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import io
import json
import re
import sys
import textwrap
import tokenize
from collections.abc import Callable, Iterable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.model import screws  # noqa: E402

SILENT = {tokenize.NL, tokenize.NEWLINE, tokenize.COMMENT, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
OURS: dict[str, tuple[str, ...]] = {
    "forward kinematics": ("mechanics/quantities/forward_kinematics.py", "mechanics/placement.py"),
    "inverse dynamics": (
        "mechanics/quantities/inverse_dynamics.py",
        "mechanics/quantities/link_motion.py",
        "mechanics/placement.py",
    ),
    "subproblems": ("algebra/subproblems.py", "algebra/subproblem_angles.py", "algebra/subproblem_quartics.py"),
    "damped least squares": ("mechanics/damped_least_squares.py",),
    "URDF": ("model/urdf",),
    "integrator": ("solvers/embedded.py", "solvers/adaptive.py", "solvers/tableaus.py"),
    "force closure": ("grasp/closure_methods.py",),
}
"""Files that tell a task, in the package."""
PEERS: dict[str, tuple[tuple[str, str], ...]] = {
    "forward kinematics": (
        ("modern_robotics", "FKinSpace"),
        ("pinocchio", "kinematics.hxx"),
    ),
    "inverse dynamics": (("modern_robotics", "InverseDynamics"), ("pinocchio", "rnea.hxx")),
    "subproblems": (("ssik", "subproblems"),),
    "damped least squares": (("modern_robotics", "IKinSpace"),),
    "URDF": (("urchin", "."),),
    "integrator": (("scipy", "integrate/_ivp/rk.py"),),
}
"""Package, and the function, file or folder in it that tells the task."""


def main() -> None:
    """Print the table, then the agreement of the numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="file for the figures")
    options = parser.parse_args()
    print(" | ".join(f"{key} {value}" for key, value in machine("mafsil", "numpy").items()))
    rows = [
        {
            "task": task,
            "mafsil": sum(map(lines_of_path, (ROOT / "src/mafsil" / name for name in files))),
            "peers": {f"{package}: {place}": lines_of_peer(package, place) for package, place in PEERS.get(task, ())},
        }
        for task, files in OURS.items()
    ]
    for row in rows:
        peers = ", ".join(f"{name} {count}" for name, count in row["peers"].items())
        print(f"{row['task']:22}{row['mafsil']:6}   {peers}")
    agreement = differences()
    for name, value in agreement.items():
        print(f"{name:50}{value:9.1e}")
    if options.json:
        options.json.write_text(json.dumps({"lines": rows, "differences": agreement}, indent=1))


def lines_of_code(text: str) -> int:
    """Lines of Python that hold a token outside docstrings."""
    text = textwrap.dedent(text)
    documented: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module) and ast.get_docstring(node) is not None:
            documented |= set(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    held = {line for t in tokens if t.type not in SILENT for line in range(t.start[0], t.end[0] + 1)}
    return len(held - documented)


def lines_of_path(path: Path) -> int:
    """Of a file of Python or C++, or of the files of Python in a folder."""
    if path.is_dir():
        return sum(map(lines_of_path, _files(path)))
    text = path.read_text("utf-8", errors="replace")
    if path.suffix == ".py":
        return lines_of_code(text)
    bare = re.sub(r"//[^\n]*", "", re.sub(r"/\*.*?\*/", "", text, flags=re.S))
    return sum(bool(line.strip()) for line in bare.splitlines())


def _files(folder: Path) -> Iterable[Path]:
    return sorted(folder.rglob("*.py"))


def lines_of_peer(package: str, place: str) -> int | None:
    """Of a function, file or folder of a peer; None where it is not installed."""
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        return None
    if place.isidentifier() and not (Path(spec.origin).parent / place).exists():
        return lines_of_code(inspect.getsource(getattr(import_module(package), place)))
    if place.endswith(".hxx"):
        root = next(parent for parent in Path(spec.origin).parents if (parent / "include").exists())
        found = sorted((root / "include").rglob(f"algorithm/{place}"), key=lambda path: len(path.parts))
        return lines_of_path(found[0]) if found else None
    return lines_of_path(Path(spec.origin).parent / place)


def differences() -> dict[str, float]:
    """Largest difference of our numbers from a peer's for the same arm, by task; of peers that are installed."""
    robot = mf.load("ur5e")
    q, qd, qdd = np.random.default_rng(0).uniform(-1, 1, (3, robot.n))
    T = np.asarray(robot.forward_kinematics(q))
    found: dict[str, float] = {}
    if find_spec("modern_robotics"):
        peer: Any = import_module("modern_robotics")
        arm = screws(robot.mechanism)
        found["forward kinematics, modern_robotics"] = _off(peer.FKinSpace(arm.home, arm.S_s.T, q), T)
    if find_spec("pinocchio"):
        model_of: Callable[..., Any] = import_module("tests.oracles.pinocchio_model").model_of
        pin: Any = import_module("pinocchio")
        model, _ = model_of(robot.mechanism)
        tau = pin.rnea(model, model.createData(), q, qd, qdd)
        found["inverse dynamics, pinocchio"] = _off(tau, robot.inverse_dynamics(q, qd, qdd))
    if find_spec("scipy"):
        integrate: Any = import_module("scipy.integrate")
        load = robot.gravity_torque(q)
        ours = mf.simulation.forward_dynamics_trajectory(robot, q, qd, tau=load, duration=0.2, friction=False)

        def rate(_t: float, x: Any) -> Any:
            return np.concatenate([x[6:], robot.forward_dynamics(x[:6], x[6:], load)])

        theirs = integrate.solve_ivp(rate, (0.0, 0.2), np.concatenate([q, qd]), "DOP853", rtol=1e-11, atol=1e-12)
        found["motion of 0.2 s, scipy"] = _off(theirs.y[:6, -1], np.asarray(ours.q)[-1])
    return found


def _off(theirs: Any, ours: Any) -> float:
    return float(np.abs(np.asarray(theirs) - np.asarray(ours)).max())


if __name__ == "__main__":
    main()
