"""The hash of the code behind an expression: comments, docstrings and strangers do not count, everything else does."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from mafsil.code_store import CacheWarning
from mafsil.code_store import store as stores
from mafsil.kernels import fingerprint, identity

PACKAGE = {
    "__init__.py": '"""A package."""\n',
    "builder.py": """
from arms.parts import half


def build(x):
    '''Half of x.'''
    return half(x)
""",
    "parts.py": """
def half(x):
    from arms import units

    return x * 0.5 * units.METRE
""",
    "units.py": """
METRE = 1.0


def known(x):
    return x in {"m", "mm", "um", "nm"}
""",
    "stranger.py": """
def elsewhere():
    return 1
""",
    "searching.py": """
from importlib import import_module


def build(x):
    return import_module("arms.parts").half(x)
""",
}


@pytest.fixture
def arms(tmp_path, monkeypatch):
    """A package `arms` of its own in every test, and an empty cache."""
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(stores, "_warned", set())
    folder = tmp_path / "arms"
    folder.mkdir()
    for name, text in PACKAGE.items():
        (folder / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield folder
    _forget()


def _forget() -> None:
    sys.modules.pop("arms", None)
    for known in (identity.meaning, identity._modules, fingerprint):
        known.cache_clear()


def _meaning(root: str = "arms.builder", without: tuple[str, ...] = ()) -> str:
    _forget()
    return identity.meaning((root,), ("arms",), without)


@pytest.mark.parametrize(
    ("file", "before", "after", "changes"),
    [
        ("builder.py", "'''Half of x.'''", "'''The half of x.\n\n    In metres.\n    '''", False),
        ("builder.py", "    return half", "    # why\n\n    return half", False),
        ("__init__.py", "A package", "Another package", False),
        ("stranger.py", "return 1", "return 2", False),
        ("builder.py", "half(x)\n", "half(x) + 0.0\n", True),
        ("parts.py", "0.5", "0.25", True),
        ("parts.py", "x * 0.5", "0.5 * x", True),
        ("units.py", "1.0", "1", True),
        ("units.py", "METRE = 1.0", "METRE = -1.0", True),
    ],
)
def test_what_counts(arms: Path, file: str, before: str, after: str, changes: bool) -> None:
    first = _meaning()
    text = (arms / file).read_text()
    assert before in text
    (arms / file).write_text(text.replace(before, after))
    assert (_meaning() != first) == changes
    (arms / file).write_text(text)
    assert _meaning() == first


def test_a_package_imports_what_its_stub_does(arms: Path) -> None:
    """Public names of a package are found at their first use: no statement of its own says where they come from."""
    (arms / "builder.py").write_text("from arms import half\n\n\ndef build(x):\n    return half(x)\n")
    (arms / "__init__.pyi").write_text("from arms.parts import half as half\n")
    first = _meaning()
    (arms / "stranger.py").write_text("def elsewhere():\n    return 3\n")
    assert _meaning() == first
    (arms / "units.py").write_text("METRE = 7.0\n")
    assert _meaning() != first


def test_a_module_left_out_does_not_count(arms: Path) -> None:
    first = _meaning(without=("arms.units",))
    (arms / "units.py").write_text("METRE = 7.0\n")
    assert _meaning(without=("arms.units",)) == first


@pytest.mark.parametrize("text", [PACKAGE["searching.py"], "def broken(:\n"])
def test_what_cannot_be_followed_counts_byte_by_byte(arms: Path, text: str) -> None:
    (arms / "searching.py").write_text(text)
    first = _meaning("arms.searching")
    (arms / "stranger.py").write_text(PACKAGE["stranger.py"] + "# a comment\n")
    assert _meaning("arms.searching") != first


def test_every_process_finds_the_same(arms: Path) -> None:
    """Whatever the order in which sets are printed, and whether the hash is computed or read."""
    code = "from mafsil.kernels import identity; print(identity.meaning(('arms.builder',), ('arms',)))"
    seen = set()
    for seed in range(4):
        for cache in ("off", str(arms.parent / "shared")):
            paths = os.pathsep.join([str(arms.parent), *sys.path])
            settings = {**os.environ, "PYTHONHASHSEED": str(seed), "MAFSIL_CACHE": cache, "PYTHONPATH": paths}
            done = subprocess.run(
                [sys.executable, "-c", code], env=settings, capture_output=True, text=True, check=True, timeout=60
            )
            seen.add(done.stdout)
    assert len(seen) == 1


def test_a_damaged_note_is_made_again(arms: Path) -> None:
    first = _meaning()
    path = next((arms.parent / "cache").glob("*.sources"))
    for damage in (b"", path.read_bytes()[:-1], path.read_bytes()[:-1] + b"x", path.read_bytes() + b"0"):
        stores._warned.clear()
        path.write_bytes(damage)
        with pytest.warns(CacheWarning):
            assert _meaning() == first


def test_a_quantity_depends_on_its_own_builder_alone() -> None:
    from mafsil.mechanics.catalogue import quantity
    from mafsil.robot import compiling

    energy, coriolis = (compiling._sources(quantity(name)) for name in ("kinetic_energy", "coriolis_matrix"))
    assert energy != coriolis
    assert all(len(found) == 2 for found in (energy, coriolis))
    roots = ("mafsil.robot.trace", "mafsil.mechanics.quantities.coriolis")
    texts = {root: identity._file(root).read_bytes() for root in roots}  # type: ignore[union-attr]
    changed = {**texts, roots[1]: texts[roots[1]] + b"\nEXTRA = 1\n"}
    found = [identity._closure(each, compiling.SOURCES, compiling.BESIDE) for each in (texts, changed)]
    assert found[0] is not None
    assert found[0] != found[1]
