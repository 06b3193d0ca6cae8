"""The head of each package leads a newcomer: what is called, where it is computed, compiled, tested; all is there."""

from __future__ import annotations

import importlib.util
import pkgutil
import re
from functools import reduce
from pathlib import Path

import pytest

import mafsil as mf
from mafsil.cli.registry import OPERATIONS
from mafsil.robot.robot import Robot

TESTS = Path(__file__).parents[1]
PACKAGES = [each.name for each in pkgutil.iter_modules(mf.__path__) if each.ispkg]


def _guide(package: str) -> dict[str, str]:
    """Lines of the guide by their first word, broken lines joined."""
    doc = importlib.import_module(f"mafsil.{package}").__doc__ or ""
    lines = re.sub(r"\n {10}", " ", doc).split("\n")
    return {word: rest for word, _, rest in (line.partition(" ") for line in lines) if word in GUIDE}


GUIDE = ("call", "computed", "compiled", "tested")


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_begins_with_its_guide(package: str) -> None:
    guide = _guide(package)
    assert set(guide) >= {"call", "computed", "tested"}
    for module in re.findall(r"`([\w.]+)`", " ".join(guide.values())):
        name = module if module.startswith("mafsil.") else f"mafsil.{package}.{module}"
        assert importlib.util.find_spec(name) is not None, module
    for name in re.findall(r"mf\.([\w.]+\w)", guide["call"]):
        assert reduce(getattr, name.split("."), mf) is not None
    for verb in re.findall(r"robot\.(\w+)", guide["call"]):
        assert hasattr(Robot, verb), verb
    for command in re.findall(r"mafsil ([a-z-]+)", guide["call"]):
        assert command in {each.name for each in OPERATIONS}, command
    folder = TESTS
    for part in re.findall(r"[\w/]+(?:\.py)?", guide["tested"]):
        if part.startswith("tests/"):
            folder = (TESTS.parent / part).parent
            assert (TESTS.parent / part).exists(), part
        elif part.endswith(".py"):
            assert (folder / part).exists(), part
