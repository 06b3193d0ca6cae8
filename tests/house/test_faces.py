"""The faces of packages: one list of public names each, in the stub, found at first use."""

import ast
import subprocess
import sys
import tomllib
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

from mafsil.answer import Status
from mafsil.lazy_module import public_names

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "mafsil"
PACKAGES = sorted(".".join(("mafsil", *path.parent.relative_to(SOURCE).parts)) for path in SOURCE.rglob("__init__.py"))
FACES = [name for name in PACKAGES if (SOURCE.parent / name.replace(".", "/") / "__init__.pyi").exists()]


def _lines(code: str) -> list[str]:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


@pytest.mark.parametrize("name", FACES)
def test_a_face_is_what_type_checkers_see(name: str) -> None:
    """The stub holds nothing but imports of one public name each; all of them are listed, shown and found."""
    package = import_module(name)
    stub = Path(package.__path__[0], "__init__.pyi")
    seen: dict[str, str] = {}
    for node in ast.parse(stub.read_text("utf-8")).body:
        assert isinstance(node, ast.ImportFrom), f"{name}: {ast.unparse(node)}"
        assert node.module
        assert not node.level
        for alias in node.names:
            assert alias.asname == alias.name
            assert alias.name not in seen
            seen[alias.name] = node.module
    assert seen == public_names(package)
    assert package.__all__ == tuple(public for public in seen if not public.startswith("_"))
    assert set(seen) <= set(dir(package))
    for public, home in seen.items():
        module = import_module(f"{name}.{public}" if home == name else home)
        assert getattr(package, public) is (module if home == name else getattr(module, public)), public
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = package.no_such_name


def test_importing_a_package_loads_none_of_its_modules() -> None:
    code = f"""
import sys
from importlib import import_module
for name in {PACKAGES!r}:
    import_module(name)
print(*sorted(m for m in sys.modules if m.split(".")[0] == "mafsil" and m not in {[*PACKAGES, "mafsil.lazy_module"]!r}))
"""
    assert _lines(code) == ["mafsil.argument_gate"]


@pytest.mark.parametrize("name", PACKAGES)
def test_every_package_lists_its_names(name: str) -> None:
    assert name in FACES or import_module(name).__all__ == ()


def test_a_public_name_stays_when_its_module_of_the_same_name_is_loaded() -> None:
    """Python's import sets every module in its package; `control.citation` is the function all the same."""
    shared = [
        (name, public)
        for name in FACES
        for public, home in public_names(import_module(name)).items()
        if home != name and find_spec(f"{name}.{public}")
    ]
    code = f"""
import sys
from importlib import import_module
for package, name in {shared!r}:
    module = import_module(f"{{package}}.{{name}}")
    if getattr(sys.modules[package], name) is module:
        print(package, name)
"""
    assert len(shared) > 40
    assert _lines(code) == []


def test_names_come_from_the_package_or_from_a_lower_layer() -> None:
    """Stubs are no import statements that the contracts of layers see."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    order = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    layer = {name.strip(): -depth for depth, names in enumerate(order) for name in names.split("|")}
    for name in FACES[1:]:
        own = ".".join(name.split(".")[:2])
        for public, home in public_names(import_module(name)).items():
            other = ".".join(home.split(".")[:2])
            assert home == "math" or other == own or layer[other] < layer[own], f"{name}.{public}"


ASKED = [
    "plan", "optimal_base_placement", "control",
    "mobility", "parallel", "trajectory", "simulation", "simulate", "Grasp", "Robot",
    "load", "inverse_kinematics", "solve_ik", "Scene", "identify", "verify", "lint", "performance", "one_joint",
    "geometry", "derivation", "export", "show",
]  # fmt: skip
"""Names at the top whose first use is held to so many modules of the package."""
MOST = 120
MOST_OF_PAGES = {"show": 200, "export": 220}
"""Pages hold most of what a robot can do."""
HEAVY = ("scipy.optimize", "numba", "llvmlite", "matplotlib")


@pytest.mark.parametrize("name", ASKED)
def test_asking_one_name_loads_little(name: str) -> None:
    """A name loads its own module and what this one needs; what computes is loaded when it computes."""
    code = f"""
import sys, mafsil
mafsil.{name}
print(sum(m.split(".")[0] == "mafsil" for m in sys.modules), *(m for m in {HEAVY!r} if m in sys.modules))
"""
    (line,) = _lines(code)
    count, *heavy = line.split()
    assert not heavy
    assert int(count) <= MOST_OF_PAGES.get(name, MOST)


@pytest.mark.parametrize("name", FACES)
def test_a_face_fits_a_screen_and_holds_no_statuses(name: str) -> None:
    package = import_module(name)
    assert len(package.__all__) <= (50 if name == "mafsil" else 60)
    classes = [each for each in (getattr(package, public) for public in package.__all__) if isinstance(each, type)]
    assert not [each for each in classes if issubclass(each, Status) and each.__name__.endswith("Status")]


SHARED = {
    **dict.fromkeys(("load", "read", "write", "diagnose", "file_reader"), "of each format, by its module"),
    **dict.fromkeys(("repair", "export"), "of whatever stands in the module, written or mended"),
    **dict.fromkeys(("jacobian", "simulate", "language"), "a short form of the same"),
    **dict.fromkeys(("solve", "jacobian"), "of expressions: the words of mathematics"),
    **dict.fromkeys(("three_rps", "three_upu"), "the same platform, as legs and as a linkage"),
}
"""Public names of several things, on purpose, and what they have in common."""


def test_a_public_name_means_one_thing() -> None:
    """One noun, one meaning in all faces; a name with several is stated, with its reason, and so is none too many."""
    meanings: dict[str, set[int]] = {}
    for face in FACES:
        package = import_module(face)
        for name, home in public_names(package).items():
            if home != face:
                meanings.setdefault(name, set()).add(id(getattr(package, name)))
    assert {name for name, values in meanings.items() if len(values) > 1} == set(SHARED)


@pytest.mark.parametrize(
    ("package", "old", "new"),
    [
        ("mobility", "redundancy", "redundant_constraints"),
        ("mobility", "trace", "trace_motion"),
        ("planning", "configuration_space", "configuration_space_obstacles"),
    ],
)
def test_a_name_that_meant_two_things_leads_to_its_heir(package: str, old: str, new: str) -> None:
    with pytest.raises(AttributeError, match=f"mf.{package}.{new}"):
        getattr(import_module(f"mafsil.{package}"), old)


def test_a_name_of_a_topic_is_found_from_its_package() -> None:
    """`mf.control.Feedforward` stands in `mf.control.laws`, and the error says so."""
    asked = 0
    for topic in (name for name in FACES if name.count(".") == 2):
        package = import_module(topic.rpartition(".")[0])
        for public in set(import_module(topic).__all__) - set(package.__all__):
            if find_spec(f"{package.__name__}.{public}"):
                continue  # A module of the package has that name.
            with pytest.raises(AttributeError) as error:
                getattr(package, public)
            assert f"mf.{topic.removeprefix('mafsil.')}.{public}" in str(error.value)
            asked += 1
    assert asked > 100
    with pytest.raises(AttributeError, match=r"answer\.status\.name"):
        _ = import_module("mafsil.planning").PlanningStatus
