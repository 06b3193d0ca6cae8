"""Mutants differ from what they replace, everybody meets them, and every capability has a target that exists."""

import subprocess
import sys
import tomllib
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from tests.mutation.mutants import break_target, perturbed

TARGETS = tomllib.loads(Path(__file__).with_name("targets.toml").read_text("utf-8"))
ROOT = Path(__file__).parents[2]


class Colour(Enum):
    RED = 1
    BLUE = 2


@pytest.mark.parametrize(
    "value",
    [True, 3, 0.0, 2.5, "text", None, [1.0], (), {"a": 1}, Colour.BLUE, np.zeros(3), np.array([True]), np.array([4])],
    ids=repr,
)
def test_perturbed_differs(value: object) -> None:
    other = perturbed(value)
    different = other != value
    assert np.all(different)


def test_infinite_and_missing_numbers_do_not_stop_a_mutant() -> None:
    assert np.isnan(perturbed(np.array([np.nan, 1.0]))[0])
    assert perturbed(np.array([np.inf]))[0] == np.inf


@pytest.mark.parametrize(
    ("target", "expression", "true"),
    [
        (
            "mafsil.geometry.rotation:from_axis_angle",
            "mf.geometry.rotation.from_axis_angle([0, 0, 1], 0.0)[0, 0]",
            "1.0",
        ),
        ("mafsil.robot.description:Description.n", "mf.load('planar2r').n", "2"),
        (
            "mafsil.trajectory.profiles.polynomial:quintic",
            "mf.trajectory.quintic([0.0], [1.0], 2.0).duration",
            "2.0",
        ),
        ("quantity:forward_kinematics", "mf.load('planar2r').forward_kinematics([0.0, 0.0])[2, 2]", "1.0"),
        (
            "mafsil.geometry.values.pose:Rotation.from_euler",
            "mf.Rotation.from_euler([0, 0, 0], 'ZYX').array[0, 0]",
            "1.0",
        ),
    ],
)
def test_whoever_holds_a_broken_thing_meets_the_mutant(target: str, expression: str, true: str) -> None:
    """In a process of its own: the name had been imported before it was broken."""
    script = (
        "import mafsil as mf\n"
        f"assert {expression} == {true}\n"
        f"from tests.mutation.mutants import break_target\nbreak_target({target!r})\n"
        f"assert {expression} != {true}\n"
    )
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True)


def test_an_unknown_target_is_refused() -> None:
    with pytest.raises(AttributeError):
        break_target("mafsil.geometry.rotation:no_such_function")


def test_a_refusal_is_swallowed() -> None:
    script = (
        "import mafsil as mf\nfrom tests.mutation.mutants import break_target\n"
        "break_target('mafsil.trajectory.profiles.polynomial:quintic')\n"
        "assert mf.trajectory.quintic([0.0], [1.0], -1.0) == 0.5\n"
    )
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True)


@pytest.mark.parametrize("target", sorted(set(TARGETS.values())))
def test_target_exists(target: str) -> None:
    """The table follows renamed things."""
    import importlib
    import inspect

    place, _, name = target.partition(":")
    if place == "page":
        assert (ROOT / name).exists()
        return
    if place == "quantity":
        place, name = "mafsil.robot.robot", f"Robot.{name}"
    thing: object = importlib.import_module(place)
    for each in name.split("."):
        thing = inspect.getattr_static(thing, each) if inspect.isclass(thing) else getattr(thing, each)
    assert thing is not None
