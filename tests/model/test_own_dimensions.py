"""Arms of the library with lengths of one's own; mass properties that no body has are said when they are typed."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, ModelWarning
from mafsil.model import library

IMPOSSIBLE = mf.model.Inertial(1.0, np.zeros(3), np.diag([1.0, 1.0, 5.0]))
TABLE = """name = "mine"
convention = "classic"
[[joint]]
a = 0.3
inertial = { mass = 1.0, com = [0.0, 0.0, 0.0], inertia = [1.0, 1.0, 5.0] }
"""


def test_own_lengths_move_the_tip() -> None:
    stretched = mf.load("planar3r", lengths=[0.4, 0.3, 0.2]).forward_kinematics([0, 0, 0])
    np.testing.assert_allclose(stretched[:3, 3], [0.9, 0, 0], atol=1e-15)
    raised = mf.load("puma560", base_height=0.67).forward_kinematics([0.0] * 6)
    np.testing.assert_allclose(raised[2, 3] - mf.load("puma560").forward_kinematics([0.0] * 6)[2, 3], 0.67, atol=1e-12)
    for name in library.robots():
        assert library.load(name).n == mf.load(name).n


@pytest.mark.parametrize(
    ("name", "dimensions", "said"),
    [
        ("planar3r", {"lengths": [1, 2]}, "lengths"),
        ("planar3r", {"length": [1, 2, 3]}, "it takes: lengths, masses"),
        ("planar3r", {"lengths": [1, np.nan, 3]}, "not a finite number"),
        ("panda", {"lengths": [1]}, "from_dh"),
        ("elbow6r", {"L1": "long"}, "real numbers"),
        ("planar2r", {"tipp": "link2"}, "'tipp'"),
    ],
)
def test_dimensions_that_an_arm_does_not_have_are_refused(name: str, dimensions: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        mf.load(name, **dimensions)


def test_files_have_no_dimensions(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text(TABLE)
    with pytest.raises(InputError, match="lengths is not an argument for a file"):
        mf.load(tmp_path / "arm.toml", lengths=[1.0])


@pytest.mark.capability("09-1")
def test_moments_that_no_body_has_are_said_with_their_link(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text(TABLE)
    makers = (
        lambda: mf.Robot.from_dh([[0.3, 0, 0, 0]], "classic", inertials=[IMPOSSIBLE], name="mine"),
        lambda: mf.Robot.from_screws([[0, 0, 1, 0, 0, 0]], np.eye(4), inertials=[IMPOSSIBLE], name="mine"),
        lambda: mf.load(tmp_path / "arm.toml"),
    )
    for make in makers:
        with pytest.warns(ModelWarning, match=r"mine: link 'link1' has the principal moments \(1.0, 1.0, 5.0\)"):
            make()


def test_rods_points_and_the_library_give_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rod = mf.model.Inertial(1.0, [0.1, 0, 0], np.diag([0.0, 0.02, 0.02]))
        mf.Robot.from_dh([[0.3, 0, 0, 0]] * 3, "classic", inertials=[rod, mf.model.Inertial(1.0), None])
        for name in library.robots():
            mf.load(name)
