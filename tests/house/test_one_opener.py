"""Files from outside are opened by one function: regular files, at once, within a size."""

import ast
import os
from pathlib import Path

import pytest

import mafsil as mf
from mafsil import collision, trajectory
from mafsil.cli.trajectory import require_success
from mafsil.errors import MafsilError
from mafsil.grasp import read_grasp
from mafsil.mobility import read_linkage
from mafsil.report import compare_results

SOURCES = Path(mf.__file__).parent
READS = {"read_text", "read_bytes", "load", "loadtxt", "genfromtxt", "fromfile", "memmap"}
OURS = {
    "regular_file.py": "the opener itself",
    "toml_source.py": "our own tables",
    "whole_file.py": "writes",
    "code_store/store.py": "the store's own files, in a folder of the user's",
    "code_store/folder.py": "the same, opened without following links",
    "kernels/loops/definition.py": "our own sources",
    "kernels/identity.py": "our own sources, and what the processor is",
    "kernels/result_memory.py": "the size of the processor's cache",
    "mechanics/catalogue.py": "our own sources",
    "scene/modules.py": "our own scripts",
    "report/page.py": "our own template",
    "report/results.py": "writes",
    "messages/catalogue.py": "our own sentences",
    "cli/run.py": "our own example",
    "cli/main.py": "the end of a pipe",
    "simulation/live_log.py": "writes",
    "studio/studio.py": "pages that it has just written",
}


def opens(path: Path) -> list[int]:
    """Lines that open a file by something else than the opener."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        called = node.func
        if isinstance(called, ast.Name) and called.id == "open":
            found.append(node.lineno)
        if isinstance(called, ast.Attribute):
            of = ast.unparse(called.value)
            opened = called.attr == "open" and of not in ("webbrowser", "Image", "page", "self")
            numbers = called.attr in READS and (called.attr.startswith("read_") or of == "np")
            handed = of == "np" and bool(node.args) and isinstance(node.args[0], ast.Name) and node.args[0].id == "file"
            found += [node.lineno] * ((opened or numbers) and not handed)
    return found


def test_only_the_opener_opens() -> None:
    """`np.load(file)` reads what the opener has opened."""
    elsewhere = {str(path.relative_to(SOURCES)): opens(path) for path in SOURCES.rglob("*.py")}
    assert {name: lines for name, lines in elsewhere.items() if lines and name not in OURS} == {}
    assert {name for name in OURS if name != "regular_file.py" and not elsewhere[name]} == set()


READERS = {
    "robot.urdf": mf.load,
    "robot.xml": mf.load,
    "robot.sdf": mf.load,
    "robot.toml": mf.load,
    "motion.csv": trajectory.read_trajectory,
    "run.npz": mf.Recording.load,
    "run.mcap": mf.Recording.load,
    "grasp.toml": read_grasp,
    "linkage.toml": read_linkage,
    "names.srdf": lambda path: collision.Checker("ur5e", srdf=path),
    "results.json": lambda path: compare_results(path, path),
}


@pytest.mark.timeout(60)
@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize("name", READERS)
def test_pipes_and_devices_are_refused_at_once(tmp_path: Path, name: str, kind: str) -> None:
    path = tmp_path / name
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    with pytest.raises(MafsilError):
        READERS[name](path)


def test_a_pipe_is_no_status_of_a_run(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.json")
    require_success(tmp_path / "run.csv")
