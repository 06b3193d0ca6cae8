"""F5 at a small size, and that the row finds what it is there to find."""

from __future__ import annotations

from pathlib import Path

import pytest

import mafsil as mf
from mafsil.errors import MafsilError
from mafsil.grasp import read_grasp
from tests.reliability import hostile_doors
from tests.sizes import size


@pytest.mark.row("F5")
@pytest.mark.timeout(600)
def test_no_door_lets_in_what_is_foreign_slow_or_unsound():
    counts = hostile_doors.work(10_001, size(400, 5000))
    assert counts["files"] == size(400, 5000)
    assert counts["accepted"] > 20
    assert counts["refused"] > 100
    assert counts["special"] > 3
    assert {name: value for name, value in counts.items() if name.startswith("bad_") and value} == {}


def test_a_door_that_lets_nonsense_in_is_found_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def foreign(path: Path) -> object:
        raise KeyError(path.name)

    monkeypatch.setitem(hostile_doors.DOORS, "cloud.xyz", (foreign, hostile_doors.anything))
    monkeypatch.setitem(hostile_doors.DOORS, "part.obj", (lambda path: [float("nan")], hostile_doors.finite))
    (tmp_path / "x").write_text("")
    counts = dict.fromkeys(hostile_doors.COUNTS, 0)
    said = [*hostile_doors.judge("cloud.xyz", tmp_path / "x", counts)]
    said += hostile_doors.judge("part.obj", tmp_path / "x", counts)
    assert len(said) == 2
    assert counts["bad_exception"] == counts["bad_content"] == 1


JOB = 'robot = "{robot}"\n[start]\njoints = [0, 0, 0, 0, 0, 0]\n[[move]]\njoints = [0, 0, 0, 0, 0, 0.1]\n'
LIMITLESS = mf.trajectory.MotionLimits.of(1)
PLACES = {
    "include": lambda name: _job(f'include = ["{name}"]\n' + JOB.format(robot="ur5e")),
    "robot": lambda name: _job(JOB.format(robot=name)),
    "mesh": lambda name: _job(JOB.format(robot="ur5e") + f'[[obstacle]]\nname = "m"\nmesh = "{name}"\n'),
    "srdf": lambda name: _job(JOB.format(robot="ur5e") + f'[collision]\nsrdf = "{name}"\n'),
    "job": mf.job.read_job,
    "robot file": lambda name: mf.load(f"{name}.urdf"),
    "recording": lambda name: mf.simulation.Recording.load(f"{name}.npz"),
    "motion": lambda name: mf.trajectory.files.read_trajectory(f"{name}.csv"),
    "grasp": read_grasp,
    "log": lambda name: mf.identification.identify("planar2r", f"{name}.csv"),
    "export": lambda name: mf.trajectory.export(mf.trajectory.quintic([0], [1], 1), f"{name}.csv", LIMITLESS),
}
"""Whatever takes the name of a file."""


def _job(text: str) -> object:
    return mf.job.solve(mf.job.parse_job(text), text, ".")


@pytest.mark.parametrize("name", ["9" * 400, "a\0b", "a/" * 3000 + "b"], ids=["long", "null", "deep"])
@pytest.mark.parametrize("place", PLACES)
def test_names_that_no_file_can_have_are_refused_in_our_words(
    place: str, name: str, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MafsilError) as caught:
        PLACES[place](name.replace("\0", "\\u0000") if place in ("include", "robot", "mesh", "srdf") else name)
    assert caught.value.message("ar") != caught.value.message("en")
