"""The rules of the house: sizes, names, documentation, languages, and what the README promises."""

import ast
import re
import string
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "mafsil"
FILES = sorted(SOURCE.rglob("*.py"))
DRAWERS = {"utils", "util", "helpers", "helper", "common", "misc", "tools", "base", "stuff"}
OPENING = re.compile(r'(#.*\n|\s)*r?"""\s*[^\s"]')
"""A docstring before everything but comments."""
INDENTED_IMPORT = re.compile(r"^[ \t].*\bimport\b.*", re.M)


def _parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def test_files_have_names_and_say_what_they_hold() -> None:
    drawers = [path for path in FILES if path.stem in DRAWERS]
    assert not drawers, "a homeless function means a missing concept: find its noun"
    silent = [path for path in FILES if path.name != "__init__.py" and not OPENING.match(path.read_text("utf-8"))]
    assert not silent, "the docstring of the module is missing"
    assert not [path for path in FILES if "import *" in path.read_text("utf-8")]


def _is_overload(function: ast.FunctionDef) -> bool:
    return any(isinstance(d, ast.Name) and d.id == "overload" for d in function.decorator_list)


@pytest.mark.parametrize("package", ["algebra", "mechanics", "robot", "geometry", "trajectory", "ik"])
def test_public_functions_document_their_arguments(package: str) -> None:
    """Every argument of a public function is explained, there or where its docstring points to."""
    for path in sorted((SOURCE / package).rglob("*.py")):
        for node in _parsed(path).body:
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_") or _is_overload(node):
                continue
            doc = ast.get_docstring(node) or ""
            assert doc, f"{path.name}: {node.name} has no docstring"
            names = [a.arg for a in (*node.args.args, *node.args.kwonlyargs) if a.arg not in {"self", "cls"}]
            if len(names) >= 3 and "rguments as " not in doc:
                missing = [name for name in names if not re.search(rf"(?<!\w){re.escape(name)}(?!\w)", doc)]
                assert not missing, f"{path.name}: {node.name} does not explain {missing}"


def test_every_sentence_exists_in_both_languages_with_the_same_details() -> None:
    def fields(text: str) -> set[str]:
        return {name for _, name, _, _ in string.Formatter().parse(text) if name}

    english = {path.name: tomllib.loads(path.read_text("utf-8")) for path in (SOURCE / "messages/en").glob("*.toml")}
    arabic = {path.name: tomllib.loads(path.read_text("utf-8")) for path in (SOURCE / "messages/ar").glob("*.toml")}
    assert english.keys() == arabic.keys()
    for area in english:
        assert english[area].keys() == arabic[area].keys(), area
        for key, text in english[area].items():
            assert fields(text) == fields(arabic[area][key]), f"{area}: {key}"
            words = re.sub(r"\{[^}]*\}", "", arabic[area][key])
            assert re.search(r"[\u0600-\u06ff]", words) or not re.search(r"[A-Za-z]{4}", re.sub(r"\{[^}]*\}", "", text))


def test_every_sentence_that_the_code_says_exists() -> None:
    english = {p.stem: tomllib.loads(p.read_text("utf-8")) for p in (SOURCE / "messages/en").glob("*.toml")}
    said = re.compile(r"""(?:Error|say|template)\(\s*["']([a-z_]+)\.([a-z0-9_]+)["']""")
    for path in FILES:
        for area, key in said.findall(path.read_text("utf-8")):
            assert key in english.get(area, {}), f"{path.relative_to(SOURCE)} says {area}.{key}"


def test_import_is_light() -> None:
    heavy = ("mafsil.expression", "casadi", "llvmlite", "scipy", "matplotlib", "numba", "msgspec")
    code = f"import mafsil, sys; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_found() -> None:
    import mafsil

    for name in mafsil.__all__:
        assert getattr(mafsil, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = mafsil.no_such_name


def test_commands_of_the_readme_exist() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    scripts = re.findall(r"^python3 (\S+\.py) (\w+)", text, flags=re.M)
    assert {verb for _, verb in scripts} >= {"run", "test"}
    assert all((ROOT / script).exists() for script, _ in scripts)
    used = set(re.findall(r"^mafsil (\w+)", text, flags=re.M))
    shown = subprocess.run(
        [sys.executable, "-m", "mafsil.cli.main", "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert used
    assert not [command for command in used if command not in shown]


def test_pictures_of_the_readme_exist() -> None:
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", (ROOT / "README.md").read_text("utf-8")):
        assert (ROOT / picture).exists(), picture


def test_nothing_names_the_workshop() -> None:
    """No path of the machine on which it was written, no word about how."""
    forbidden = re.compile(r"/work/(main|shared)|/tmp/[a-z]\d?\.md|\bhelper-\d")
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    for name in listed:
        path = ROOT / name
        if (
            path.suffix in {".py", ".md", ".toml", ".html", ".js", ".css", ""}
            and path.is_file()
            and path != Path(__file__)
        ):
            assert not forbidden.search(path.read_text("utf-8", errors="ignore")), name


def test_lines_of_javascript_are_at_most_160_columns_wide() -> None:
    wide = [
        f"{path.relative_to(SOURCE)}:{number}"
        for path in SOURCE.rglob("*.js")
        for number, line in enumerate(path.read_text("utf-8").split("\n"), start=1)
        if len(line) > 160
    ]
    assert not wide


def test_no_function_imports_a_module_of_the_package() -> None:
    """What is loaded late stands at the top, in `lazily`; the door and the commands alone find names at their use."""
    late: list[str] = []
    for path in FILES:
        place = path.relative_to(SOURCE)
        if str(place) == "__init__.py" or place.parts[0] == "cli":
            continue
        if not any("mafsil" in line for line in INDENTED_IMPORT.findall(path.read_text("utf-8"))):
            continue
        for function in ast.walk(_parsed(path)):
            if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
                for node in ast.walk(function):
                    names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
                    names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                    if any(name.split(".")[0] == "mafsil" for name in names):
                        late.append(f"{place}:{node.lineno}")
    assert not late, late


def test_every_lazy_module_is_the_one_that_checkers_see() -> None:
    """`name = lazily("a.b")` stands beside `import a.b as name`, and there is such a module."""
    said = re.compile(r'^    (\w+) = lazily\("([\w.]+)"\)$', re.M)
    for path in FILES:
        text = path.read_text("utf-8")
        if path.name == "lazy_module.py" or not said.search(text):
            continue
        seen = {
            (alias.asname, alias.name)
            for node in ast.walk(_parsed(path))
            if isinstance(node, ast.Import)
            for alias in node.names
        }
        for name, module in said.findall(text):
            assert (name, module) in seen, f"{path.relative_to(SOURCE)}: {name}"
            place = SOURCE.parent / module.replace(".", "/")
            assert place.is_dir() or place.with_suffix(".py").exists(), module


def test_a_lazy_module_is_loaded_at_its_first_name() -> None:
    code = """
import sys
from mafsil.lazy_module import lazily
page = lazily("mafsil.model.urdf")
before = "mafsil.model.urdf" in sys.modules
import pickle
print(before, callable(page.file_reader), "mafsil.model.urdf" in sys.modules, pickle.loads(pickle.dumps(page)).__name__)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True", "True", "mafsil.model.urdf"]
