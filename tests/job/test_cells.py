"""Files that a job includes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import FileError, JobError
from mafsil.job import parse_job, solve_file

CELL = """
robot = "planar2r"
angles = "degrees"

[limits]
speed_scale = 0.5
acceleration_scale = 0.6

[variables]
height = 0.2

[frame.feeder]
position = [1.2, 0.3, 0]
rpy = [0, 0, 90]

[frame.table]
position = [1.0, "$height", 0]

[[obstacle]]
name = "far wall"
box = [0.1, 1, 1]
position = [-3, 0, 0]
"""
JOB = """
include = "cells/cell.toml"

[limits]
speed_scale = 0.9

[frame.table]
position = [1.0, 0.5, 0]

[[obstacle]]
name = "post"
sphere = 0.1
position = [-3, -3, 0]

[[move]]
pose = { frame = "feeder", task = "position" }
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cells").mkdir()
    (tmp_path / "cells" / "cell.toml").write_text(CELL)
    (tmp_path / "job.toml").write_text(JOB)
    return tmp_path


@pytest.mark.capability("11-40")
def test_a_cell_counts_as_if_it_were_typed_in_the_job_and_the_job_wins(folder):
    job = parse_job(JOB, "job.toml", folder=folder)
    assert job.robot == "planar2r"
    assert job.angles == "degrees"
    assert (job.limits.speed_scale, job.limits.acceleration_scale) == (0.9, 0.6)
    assert [one.name for one in job.obstacle] == ["post", "far wall"]
    np.testing.assert_allclose(job.move[0].pose.position, [1.2, 0.3, 0.0])
    whole = parse_job(JOB.replace(', task = "position"', ""), folder=folder)
    np.testing.assert_allclose(whole.move[0].pose.quaternion[3], np.sin(np.pi / 4))
    own = parse_job(JOB.replace('"feeder"', '"table"'), folder=folder)
    np.testing.assert_allclose(own.move[0].pose.position, [1.0, 0.5, 0.0])
    bare = parse_job(JOB.replace("[frame.table]\nposition = [1.0, 0.5, 0]", "").replace('"feeder"', '"table"'),
                 "job", {"height": 0.7}, folder=folder)  # fmt: skip
    np.testing.assert_allclose(bare.move[0].pose.position, [1.0, 0.7, 0.0])


def test_a_whole_job_with_a_cell_runs_and_its_copy_runs_beside_it(folder, tmp_path, monkeypatch):
    run = solve_file(folder / "job.toml")
    assert run.status.succeeded
    tip = run.tips()[0][-1, :2, 3]
    np.testing.assert_allclose(tip, [1.2, 0.3], atol=1e-3)
    monkeypatch.chdir(folder)
    assert main(["run", "job.toml", "--out", "results"]) == 0
    script = (folder / "results" / "report.html").read_text(encoding="utf-8")
    assert 'folder=\\".\\"' in script or 'folder="."' in script
    again = solve_file(folder / "results" / "job.toml", folder=folder)
    np.testing.assert_array_equal(again.recording.q, run.recording.q)


def test_files_beside_a_cell_in_another_folder_are_found(folder):
    """A robot, another one, and the mesh of an obstacle lie beside the cell, and nothing of that beside the job."""
    arm = '<robot name="arm"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/>'
    arm += '<child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    (folder / "cells" / "arm.urdf").write_text(arm)
    (folder / "cells" / "own.toml").write_text(
        'robot = "arm.urdf"\n[[other_robot]]\nname = "o"\nrobot = "arm.urdf"\n[[obstacle]]\nmesh = "no.stl"\n'
        "position = [0, 0, 0]\n"
    )
    text = 'include = "cells/own.toml"\n[[move]]\njoints = [0.5]\n'
    job = parse_job(text, folder=folder)
    beside = str((folder / "cells" / "arm.urdf").resolve())
    assert (job.robot, job.other_robot[0].robot, job.obstacle[0].mesh) == (beside, beside, "no.stl")
    (folder / "cells" / "own.toml").write_text('robot = "planar2r"\n[collision]\nsrdf = "arm.urdf"\n')
    job = parse_job(text, folder=folder)
    assert job.collision is not None
    assert (job.robot, job.collision.srdf) == ("planar2r", beside)


def test_cells_include_cells_relative_to_themselves(folder):
    (folder / "cells" / "parts.toml").write_text("[part.cube]\nmass = 0.1\n")
    (folder / "cells" / "cell.toml").write_text('include = ["parts.toml"]\n' + CELL)
    job = parse_job(JOB + '\n[[move]]\npick = "cube"\n', folder=folder)
    assert job.move[1].pick.mass == 0.1


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ('[frame.feeder]\nposishun = [1, 2, 3]\nrobot = "x"', ("cells/cell.toml:2", "posishun")),
        ("[limits]\nacceleration_scale = 7", ("cells/cell.toml:2", "acceleration_scale")),
        ("[[obstacle]]\nbox = [1, 1]", ("cells/cell.toml:2", "box")),
        ("[[move]]\npause = 1", ("cells/cell.toml:1", "move")),
        ('include = "cell.toml"', ("cells/cell.toml:1", "include")),
        ("angles = 3", ("cells/cell.toml:1", "angles")),
        ("[frame.feeder\n", ("cells/cell.toml", "1")),
    ],
)
def test_what_is_wrong_in_a_cell_is_said_with_its_file_and_line(folder, cell, words):
    (folder / "cells" / "cell.toml").write_text(cell + "\n")
    job = JOB if "robot" in cell else 'robot = "planar2r"\n' + JOB if cell.startswith("angles") else JOB
    with pytest.raises((JobError, FileError)) as error:
        parse_job('robot = "planar2r"\n' + job if "robot =" not in job else job, folder=folder)
    for word in words:
        assert word in error.value.message("en")
    assert error.value.message("ar") != error.value.message("en")


def test_units_of_a_cell_are_those_of_its_job(folder):
    with pytest.raises(JobError, match="angles"):
        parse_job('angles = "radians"\n' + JOB, folder=folder)


@pytest.mark.parametrize(
    ("include", "says"),
    [
        ('"nowhere.toml"', "job.toml:2: include: file nowhere.toml"),
        ('"cells"', "job.toml:2: include: cells is a directory"),
        ('["cells/cell.toml", "cells/deep.toml"]', "cells/deep.toml:3: include: file nothing.toml"),
        ('"cells/open.toml"', "job.toml:2: include: cells/open.toml:3: "),
        ('"cells/bytes.toml"', "job.toml:2: include: file cells/bytes.toml is not UTF-8 (line 2"),
        ('"job.toml"', "job.toml:2: include: job.toml includes itself"),
    ],
)
def test_a_file_that_cannot_be_included_is_named_with_the_line_that_names_it(folder, include, says):
    (folder / "cells" / "deep.toml").write_text('\n\ninclude = "nothing.toml"\n')
    (folder / "cells" / "open.toml").write_text("[limits]\nspeed_scale = 0.5\n[frame\n")
    (folder / "cells" / "bytes.toml").write_bytes(b'# first\nrobot = "\xff"\n')
    text = f'robot = "planar2r"\ninclude = {include}\n[[move]]\npause = 1\n'
    (folder / "job.toml").write_text(text)
    with pytest.raises((JobError, FileError)) as error:
        parse_job(text, "job.toml", folder=folder)
    assert error.value.message("en").startswith(says)
    assert "{" not in error.value.message("ar")


@pytest.mark.parametrize("name", ["nowhere.toml", "cells", "/dev/zero", "../" * 30 + "etc/passwd"])
def test_what_cannot_be_included_is_refused(folder, name):
    with pytest.raises((JobError, FileError)):
        parse_job(f'include = "{name}"\nrobot = "planar2r"\n[[move]]\njoints = [0, 0]\n', folder=folder)


@pytest.mark.capability("11-41")
def test_check_of_a_job_plans_it_and_writes_nothing(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before = sorted(folder.rglob("*"))
    assert main(["check-job", "job.toml", "--json"]) == 0
    checked = json.loads(capsys.readouterr().out)
    assert main(["run", "job.toml", "--dry-run", "--json"]) == 0
    assert checked == json.loads(capsys.readouterr().out)
    assert sorted(folder.rglob("*")) == before
    (folder / "job.toml").write_text(JOB.replace('frame = "feeder"', "position = [9, 9, 0]"))
    assert main(["check-job", "job.toml"]) != 0
