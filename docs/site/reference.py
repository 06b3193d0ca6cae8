"""Pages of the reference, written before the site is built: one for each package, from its public names' docstrings.

A package offers the names of its stub; collections of algorithms get a section a module.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping
from enum import Enum
from functools import cache
from pathlib import Path

from formulas import typeset
from sphinx.application import Sphinx

from mafsil import robots
from mafsil.lazy_module import public_names

DOCS = Path(__file__).parents[1]
TESTS = Path(__file__).parents[2] / "tests"
SOURCE = Path(__file__).parents[2] / "src" / "mafsil"
LONGEST = 8
"""Lines of an example."""
ROBOTS = {"arm", "puma", *robots()}
"""Variables that hold robots in the guide, beside `robot`."""
FOLDER = Path(__file__).parents[1] / "reference"
PACKAGES = {
    "robot": ("Robots", "load a robot; its kinematics, statics and dynamics"),
    "model": ("Models and files", "tables, screws, URDF, SDFormat, MJCF; lint and repair"),
    "geometry": ("Rigid motions", "rotations, poses, twists, wrenches"),
    "ik": ("Inverse kinematics", "all solutions, nearest solution, batches, redundancy"),
    "performance": (
        "Singularities, statics, workspaces",
        "ellipsoids, manipulability, singularities, workspace, payload",
    ),
    "mobility": ("Mobility", "degrees of freedom, over-constraint, configuration spaces"),
    "parallel": ("Parallel robots", "Stewart-Gough, Delta, planar and cable-driven platforms, closed chains"),
    "grasp": ("Grasps", "closure, quality, contact forces, grasp planning, fixtures"),
    "collision": ("Collision", "scenes, distances, clearances"),
    "trajectory": ("Trajectories", "profiles, splines, Cartesian paths, time-optimal and jerk-limited timing"),
    "design": ("Design of arms", "parametric arms, accuracy, tasks, drives, search"),
    "planning": ("Planning", "collision-free paths, path constraints, base placement, several arms"),
    "control": ("Control", "joint, task-space, force, impedance, adaptive and robust control"),
    "one_joint": ("One joint", "stability, gain tuning, friction, drives of a single joint"),
    "simulation": ("Simulation", "closed loops, integrators, recordings, Monte Carlo"),
    "identification": ("Identification", "parameters and payloads from logs"),
    "derivation": ("Derivations", "formulas step by step; homework checks"),
    "verification": ("Verification", "every quantity against a second method"),
    "figures": ("Figures", "pictures and animations for Matplotlib"),
    "solvers": ("Solvers", "integration, root finding, optimisation"),
    "kernels": ("Kernels", "compiled functions, code export, GPU arrays"),
}
"""Title and contents of a package's page."""
COLLECTIONS = {
    "mechanics": ("Mechanics as expressions", "kinematics and dynamics of trees and loops"),
    "mechanics.quantities": ("Quantities of a robot as expressions", "one file for each quantity that a robot has"),
    "mechanics.closed_form": ("Inverse kinematics in closed form", "the angles of each kind of arm"),
    "algebra": ("Rigid motion as expressions", "rotations and screws as expressions"),
}


def setup(app: Sphinx) -> None:
    """The pages are written when the builder starts; docstrings get their examples when they are whole."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", add_example, priority=900)


def write_pages(app: Sphinx) -> None:
    """All pages of the reference and their list; a page that stands as it should is not touched."""
    FOLDER.mkdir(exist_ok=True)
    pages = {package: _page(title, _names(package)) for package, (title, _) in PACKAGES.items()}
    pages |= {package: _page(title, _modules(package)) for package, (title, _) in COLLECTIONS.items()}
    pages["index"] = _page("Reference", _contents())
    for name, text in pages.items():
        path = FOLDER / f"{name}.rst"
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")


def _page(title: str, lines: list[str]) -> str:
    return "\n".join([title, "=" * len(title), "", *lines, ""])


def _contents() -> list[str]:
    """The packages by topic, and the arrays that signatures name."""
    packages = PACKAGES | COLLECTIONS
    rows = [f"   * - :doc:`{title} <{name}>`\n     - {purpose}" for name, (title, purpose) in packages.items()]
    arrays = [f".. py:data:: mafsil.arrays.{name}\n\n   {typeset(line)}\n" for name, line in _array_types()]
    return [
        *[".. list-table::", "   :widths: 1 3", "", *rows, ""],
        *["Arrays in signatures", "--------------------", ""],
        "Everything that NumPy makes an array of is taken (``ArrayLike``); results are these:\n",
        *arrays,
        *[".. toctree::", "   :hidden:", "", *(f"   {name}" for name in packages)],
    ]


def _array_types() -> list[tuple[str, str]]:
    """Names of the array vocabulary, and their lines."""
    return re.findall(r'^(\w+): TypeAlias = .*\n"""(.*)"""$', (SOURCE / "arrays.py").read_text("utf-8"), re.M)


def _names(package: str) -> list[str]:
    """Tables of what a package offers, then all of it in the order of its first file."""
    module = importlib.import_module(f"mafsil.{package}")
    things = {name: getattr(module, name) for name in public_names(module)}
    kinds = {"Functions": inspect.isroutine, "Classes": _is_plain_class, "Verdicts and choices": _is_enumeration}
    lines = [f".. automodule:: mafsil.{package}", ""]
    for heading, belongs in kinds.items():
        members = {name: thing for name, thing in things.items() if belongs(thing)}
        if members:
            lines += [f".. rubric:: {heading}", "", *_table(package, members), ""]
    for name, thing in things.items():
        lines += _entry(package, name, thing)
    return lines


def _table(package: str, things: Mapping[str, object]) -> list[str]:
    """Names with the first sentence of their docstrings."""
    rows = []
    for name, thing in sorted(things.items()):
        sentence = (inspect.getdoc(thing) or "").partition("\n\n")[0].replace("\n", " ")
        rows.append(f"   * - :py:obj:`~mafsil.{package}.{name}`\n     - {typeset(sentence)}")
    return [".. list-table::", "   :widths: 1 2", "", *rows]


def _is_enumeration(thing: object) -> bool:
    return inspect.isclass(thing) and issubclass(thing, Enum)


def _is_plain_class(thing: object) -> bool:
    return inspect.isclass(thing) and not _is_enumeration(thing)


def _entry(package: str, name: str, thing: object) -> list[str]:
    if inspect.isclass(thing):
        foreign = not thing.__module__.startswith(f"mafsil.{package}.")
        return [
            f".. autoclass:: mafsil.{package}.{name}",
            "   :members:",
            f"   :inherited-members: {'int' if issubclass(thing, int) else 'object'}",
            *(["   :no-index:"] if foreign else []),
            "",
        ]
    return [f".. autofunction:: mafsil.{package}.{name}", ""] if callable(thing) else []


def add_example(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Below an entry the file of its tests, and the shortest statement of the guide that makes the call."""
    if what not in ("function", "class", "method"):
        return
    *_, owner, last = name.split(".")
    file = tests_of_calls().get(last)
    if file and what != "method":
        lines += ["", f"Tested in ``{file}``.", ""]
    known = examples().get(f"{_variable(owner)}.{last}" if what == "method" else last)
    if known:
        page, code = known
        shown = [".. code-block:: python", "", *(f"   {line}" for line in code.splitlines())]
        lines += ["", ".. rubric:: Example", "", *shown, "", f"From :doc:`/{page}`.", ""]


@cache
def tests_of_calls() -> dict[str, str]:
    """For each name that tests call, or else mention, the file that does so most often."""
    most: dict[str, tuple[int, int, str]] = {}
    for path in sorted(TESTS.rglob("test_*.py")):
        text, file = path.read_text("utf-8"), path.relative_to(TESTS.parent).as_posix()
        calls = Counter(re.findall(r"\b\w+(?=\()", text))
        for name, count in Counter(re.findall(r"\b\w+", text)).items():
            most[name] = max(most.get(name, (0, 0, "")), (calls[name], count, file))
    return {name: file for name, (*_, file) in most.items()}


def _variable(kind: str) -> str:
    """What the guide calls a value of a class: `checker` for `CollisionChecker`."""
    return ("".join(re.findall(r"[A-Z][a-z]*$", kind)) or kind).lower()


@cache
def examples() -> dict[str, tuple[str, str]]:
    """Page and shortest statement of the guide for each name that it calls, and for each `variable.method`."""
    found: dict[str, tuple[str, str]] = {}
    for page in sorted(DOCS.glob("[!.]*.md")):
        blocks = [] if ".ar" in page.name else re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.S)
        lists = re.findall(r"^from mafsil\S* import (?:\w+ as )?([\w, ]+)$", "\n".join(blocks), re.M)
        modules = {"mf", *re.findall(r"\w+", " ".join(lists))}
        for name, code in (pair for block in blocks for pair in _calls(block, modules)):
            if name not in found or len(code) < len(found[name][1]):
                found[name] = page.stem, code
    return found


def _calls(block: str, modules: set[str]) -> Iterator[tuple[str, str]]:
    """Names that a block calls, each with the statement, or the head of the loop, in which it does."""
    lines = block.splitlines()
    for statement in ast.walk(ast.parse(block)):
        if isinstance(statement, ast.stmt) and not isinstance(statement, ast.FunctionDef | ast.ClassDef):
            body = getattr(statement, "body", None)
            end = body[0].lineno - 1 if body else statement.end_lineno or statement.lineno
            parts = _head(statement) if body else [statement]
            code = textwrap.dedent("\n".join(lines[statement.lineno - 1 : end]))
            for call in (node for part in parts for node in ast.walk(part) if isinstance(node, ast.Call)):
                *owners, name = ast.unparse(call.func).split(".")
                if code.count("\n") >= LONGEST:
                    continue
                if not owners or owners[0] in modules:
                    yield name, code
                elif len(owners) == 1:
                    yield f"{'robot' if owners[0] in ROBOTS else owners[0]}.{name}", code


def _head(statement: ast.stmt) -> list[ast.AST]:
    """What a loop or a `with` computes before its body."""
    return [statement.iter] if isinstance(statement, ast.For) else list(getattr(statement, "items", []))


def _modules(package: str) -> list[str]:
    """A section for each module of a collection."""
    folder = SOURCE / package.replace(".", "/")
    paths = [path for path in sorted(folder.glob("*.py")) if path.stem != "__init__"]
    dotted = [".".join(("mafsil", *path.relative_to(SOURCE).with_suffix("").parts)) for path in paths]
    return [
        line for name in dotted for line in [name, "-" * len(name), "", f".. automodule:: {name}", "   :members:", ""]
    ]
