"""The catalogue: what a row must say, how it is found, and what follows from it without another line."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.catalogue import CATALOGUE, PACKAGE, found_rows
from mafsil.mechanics.quantity import Deferred, Quantity, SecondMethod
from mafsil.messages import say
from mafsil.robot import Robot

ROW = """
from mafsil.mechanics.quantity import Quantity, SecondMethod


def half(tree, q):
    return q / 2


HALF = Quantity(
    name="half", symbol="q/2", title="Half of it.", builder=half, inputs=("q",), shape=("n",), unit="rad | m",
    reference="none", {rest}
)
"""
WHOLE = 'size=lambda arm: arm.unit, second=SecondMethod("verification.solved", lambda book, s: s.q / 2)'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of quantities of its own, importable as `own_quantities`."""
    package = tmp_path / "own_quantities"
    package.mkdir()
    (package / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "kept"))
    for name in [name for name in sys.modules if name.startswith("own_quantities")]:
        monkeypatch.delitem(sys.modules, name)
    return package


def test_a_file_in_the_folder_is_found_and_read_again_without_import(folder: Path) -> None:
    (folder / "half.py").write_text(ROW.format(rest=WHOLE))
    (row,) = found_rows(folder, "own_quantities")
    assert not isinstance(row.builder, Deferred)
    for name in [name for name in sys.modules if name.startswith("own_quantities")]:
        del sys.modules[name]
    (kept,) = found_rows(folder, "own_quantities")
    assert "own_quantities.half" not in sys.modules
    assert kept.record() == row.record()
    assert kept.home == "own_quantities.half"
    assert kept.builder(None, 3.0) == 1.5
    assert kept.size(ArmSize.of(mf.load("panda").mechanism)).shape == (7,)
    assert "own_quantities.half" in sys.modules


@pytest.mark.parametrize(
    ("rest", "said"),
    [
        ("", "'size' and 'second'"),
        ('second=SecondMethod("verification.solved", lambda book, s: s.q)', "'size'"),
        ("size=lambda arm: arm.unit", "'second'"),
    ],
)
def test_a_row_without_natural_size_or_second_method_is_refused(folder: Path, rest: str, said: str) -> None:
    (folder / "half.py").write_text(ROW.format(rest=rest))
    with pytest.raises(TypeError, match=said):
        found_rows(folder, "own_quantities")


def test_an_input_that_nothing_knows_is_refused(folder: Path) -> None:
    (folder / "half.py").write_text(ROW.format(rest=WHOLE).replace('("q",)', '("p",)'))
    with pytest.raises(InputError, match="'p'"):
        found_rows(folder, "own_quantities")


def test_two_rows_of_one_name_are_refused(folder: Path) -> None:
    for name in ("half", "other"):
        (folder / f"{name}.py").write_text(ROW.format(rest=WHOLE))
    with pytest.raises(ValueError, match="half"):
        found_rows(folder, "own_quantities")


def test_rows_are_read_without_expressions() -> None:
    """After they were once: by a process that has the same folder of code."""
    code = "import mafsil.robot, sys; print('mafsil.expression' in sys.modules)"
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("row", CATALOGUE.values(), ids=CATALOGUE)
def test_a_row_is_sound(row: Quantity) -> None:
    size = ArmSize.of(mf.load("panda").mechanism)
    core = tuple({"n": 7, "L": len(mf.load("panda").mechanism.links)}.get(x, x) for x in row.shape)
    found = np.asarray(row.size(size))
    assert np.broadcast_shapes(np.shape(found), core) == core, (
        "size has the shape of the quantity, or one for all of it"
    )
    assert (found > 0).all()
    assert say(row.second.key, language="ar") != say(row.second.key, language="en")
    assert row.home.startswith(f"{PACKAGE}.")
    assert row.reference
    assert row.title.endswith(".")


@pytest.mark.parametrize("row", CATALOGUE.values(), ids=CATALOGUE)
def test_signatures_say_what_a_routine_takes(row: Quantity) -> None:
    robot = mf.load("panda")
    expected = [*row.inputs, *row.optional, *(["frame"] if row.framed else []), "out", "threads", "degrees"]
    assert list(inspect.signature(getattr(robot, row.name)).parameters) == expected
    assert list(inspect.signature(getattr(Robot, row.name)).parameters) == ["self", *expected]
    assert str(inspect.signature(getattr(robot, row.name))) == row.parameters
    assert getattr(robot, row.name).__doc__ == getattr(Robot, row.name).__doc__ == row.doc()


def test_robots_that_may_be_singular_or_cannot_move_show_the_same_signatures() -> None:
    axes = np.eye(3)[1:]
    joints = [
        mf.model.Joint(f"j{k}", mf.model.JointKind.REVOLUTE, f"l{k}", f"l{k + 1}", axis=axes[k]) for k in range(2)
    ]
    body = mf.model.Inertial(1.0, np.array([0.1, 0, 0.2]), np.eye(3) * 0.01)
    links = [mf.model.Link("l0"), mf.model.Link("l1"), mf.model.Link("l2", body)]
    robot = Robot(mf.Mechanism.assemble("massless middle", links, joints))
    still = Robot(mf.Mechanism.assemble("still", [mf.model.Link("a")], []))
    for routine, name in ((robot.forward_dynamics, "forward_dynamics"), (still.link_poses, "link_poses")):
        assert str(inspect.signature(routine)) == CATALOGUE[name].parameters


def test_the_class_can_be_called_with_a_robot() -> None:
    robot = mf.load("planar2r")
    np.testing.assert_array_equal(Robot.mass_matrix(robot, [0.1, 0.2]), robot.mass_matrix([0.1, 0.2]))


def test_second_methods_are_called_by_rows() -> None:
    second = SecondMethod("verification.solved", lambda book, s: s.q)
    assert second.key == "verification.solved"
