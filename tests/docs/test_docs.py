"""Every Python block of the documentation runs; the map of the house is current."""

import re
import subprocess
import sys
import tomllib
from importlib import import_module
from inspect import isfunction, unwrap
from pathlib import Path
from types import ModuleType

import pytest

from mafsil import messages
from mafsil.lazy_module import public_names

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
WITH_CODE = [page for page in PAGES if "```python" in page.read_text("utf-8")]


BLOCKS = re.compile(r"```python\n(.*?)```(?:\s*```text\n(.*?)```)?", re.S)
"""Code, and what it prints where that is shown right below."""
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?")


@pytest.mark.parametrize("page", WITH_CODE, ids=lambda page: page.name)
def test_blocks_of_the_page_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(messages.catalogue, "_chosen", None)  # pages in Arabic choose their language
    names: dict[str, object] = {}
    for block, shown in BLOCKS.findall(page.read_text("utf-8")):
        capsys.readouterr()
        exec(compile(block, str(page), "exec"), names)
        if shown:
            printed = capsys.readouterr().out
            assert words(printed) == words(shown), printed
            assert numbers(printed) == pytest.approx(numbers(shown), rel=2e-3, abs=2e-3), printed


def words(text: str) -> str:
    return re.sub(r"\s+", "", NUMBER.sub("#", text))


def numbers(text: str) -> list[float]:
    return [float(number) for number in NUMBER.findall(text)]


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text("utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name}: {target}"


WITHOUT_EXAMPLE = {
    *("joint_group", "plan_around_moving", "take_shortcuts", "with_loops", "read_grasp", "read_log", "derive_ik"),
    *("of_robot", "as_open_tree", "legs_from_screws", "structure", "compile", "plot_block_diagram", "plot_response"),
    *("plot_surface", "plot_frame_graph", "plot_eclipse", "plot_five_bar", "plot_planar_platform", "plot_synthesis"),
    *("plot_placement", "plot_crank_turn", "measure_designs", "calibrate_arm"),
}
"""Functions whose example would be longer than an entry: a file, a cell of arms, a problem of one's own, a drawing."""


@pytest.fixture(scope="module")
def reference() -> ModuleType:
    pytest.importorskip("sphinx")
    sys.path.append(str(ROOT / "docs" / "site"))
    return import_module("reference")


def test_functions_have_an_example_in_the_reference(reference: ModuleType) -> None:
    """A statement of the guide, all of which runs here, below the entry of each function."""
    examples = reference.examples()
    functions: set[str] = set()
    for package in map(import_module, ["mafsil", *(f"mafsil.{name}" for name in reference.PACKAGES)]):
        functions |= {public for public in public_names(package) if isfunction(unwrap(getattr(package, public)))}
    assert functions - set(examples) <= WITHOUT_EXAMPLE
    for public in functions & set(examples):
        page, code = examples[public]
        assert code.splitlines()[0].strip() in (ROOT / "docs" / f"{page}.md").read_text("utf-8")


def test_entries_of_the_reference_name_a_file_of_tests_that_calls_them(reference: ModuleType) -> None:
    functions: set[str] = set()
    for package in map(import_module, (f"mafsil.{name}" for name in reference.PACKAGES)):
        functions |= {public for public in public_names(package) if isfunction(unwrap(getattr(package, public)))}
    files = reference.tests_of_calls()
    without = functions - set(files)
    assert len(without) <= len(functions) // 50, sorted(without)
    assert all(name in (ROOT / files[name]).read_text("utf-8") for name in functions & set(files))


def test_methods_of_a_robot_have_an_example_in_the_reference(reference: ModuleType) -> None:
    """Below the docstring, where the guide calls the method of a variable that holds a robot."""
    verbs = ("fk", "ik", "ik_all", "jacobian", "plan", "simulate", "singularity", "derive", "save", "mass_matrix")
    for verb in verbs:
        lines = ["What it does."]
        reference.add_example(None, "method", f"mafsil.robot.Robot.{verb}", None, None, lines)
        assert any(f".{verb}(" in line for line in lines), verb


def test_map_is_current() -> None:
    done = subprocess.run([sys.executable, str(ROOT / "docs" / "make_map.py"), "--check"], check=False)
    assert done.returncode == 0, "run python docs/make_map.py"


def test_reliability_page_is_current() -> None:
    done = subprocess.run([sys.executable, str(ROOT / "docs" / "make_reliability.py"), "--check"], check=False)
    assert done.returncode == 0, "run python docs/make_reliability.py"


def test_mjcf_page_is_current() -> None:
    done = subprocess.run([sys.executable, str(ROOT / "docs" / "make_mjcf.py"), "--check"], check=False)
    assert done.returncode == 0, "run python docs/make_mjcf.py"


def test_stub_of_the_robot_is_current() -> None:
    done = subprocess.run([sys.executable, str(ROOT / "docs" / "make_robot_stub.py"), "--check"], check=False)
    assert done.returncode == 0, "run python docs/make_robot_stub.py"


def test_the_manual_page_and_completions_of_the_wheel_are_those_of_the_commands():
    done = subprocess.run([sys.executable, str(ROOT / "docs" / "make_shell_files.py"), "--check"], check=False)
    assert done.returncode == 0, "run python docs/make_shell_files.py"
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    shared = settings["tool"]["hatch"]["build"]["targets"]["wheel"]["shared-data"]
    assert {ROOT / file for file in shared} == set((ROOT / "docs" / "shell").iterdir())
    assert shared["docs/shell/mafsil.1"] == "share/man/man1/mafsil.1"
