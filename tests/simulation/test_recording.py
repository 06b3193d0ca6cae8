"""A recording survives its files; damaged files are refused with the path in the sentence."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque
from mafsil.errors import FileError
from mafsil.trajectory import quintic

Q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])


@pytest.fixture(scope="module")
def panda():
    return mf.load("panda")


@pytest.fixture(scope="module")
def run(panda):
    scenario = mf.Scenario(robot=panda, trajectory=quintic(Q, Q + 0.2, 0.05), law=computed_torque(panda), q=Q + 0.01)
    return mf.simulate(scenario)


@pytest.fixture(scope="module")
def batch(panda):
    starts = Q + np.array([[0.0], [0.01]])
    return mf.simulate(
        mf.Scenario(robot=panda, trajectory=quintic(Q, Q + 0.2, 0.02), law=computed_torque(panda), q=starts)
    )


def test_round_trip(tmp_path, run, batch):
    for recording in (run, batch):
        paths = recording.save(tmp_path / "a.run")
        assert [path.name for path in paths] == ["a.run.npz", "a.run.csv", "a.run.json"]
        back = mf.Recording.load(paths[0])
        for name, array in recording.arrays().items():
            np.testing.assert_array_equal(back.arrays()[name], array)
        assert back.status is recording.status
        assert back.metadata == recording.metadata
        assert back.explain("en") == recording.explain("en")
    assert {path.name for path in tmp_path.iterdir()} == {"a.run.npz", "a.run.csv", "a.run.json"}


def test_table_reads_back_exactly(tmp_path, run, batch):
    for recording in (run, batch):
        _, table, note = recording.save(tmp_path / "b")
        with table.open(newline="") as file:
            head, *rows = list(csv.reader(file))
        values = np.array(rows, dtype=float)
        for name, column in recording.columns().items():
            np.testing.assert_array_equal(values[:, head.index(name)], column)
        about = json.loads(note.read_text())
        assert about["status"] == "COMPLETED"
        assert about["worst"]["tip_position_error"] == recording.tip_position_error.max()
    assert "q[1,joint3]" in batch.columns()
    assert "tip_position_error" in run.columns()


def test_damaged_files_are_refused(tmp_path, run):
    whole, _, _ = run.save(tmp_path / "c")
    data = whole.read_bytes()
    for cut in (0, 10, len(data) // 2, len(data) - 30):
        whole.write_bytes(data[:cut])
        with pytest.raises(FileError, match=r"c\.npz"):
            mf.Recording.load(tmp_path / "c")
    np.savez(whole, q=np.zeros(3))
    with pytest.raises(FileError, match=r"c\.npz"):
        mf.Recording.load(tmp_path / "c")
    with pytest.raises(FileError, match="no such file"):
        mf.Recording.load(tmp_path / "missing")


def test_other_formats_are_named(tmp_path, run):
    about = json.dumps({"format": 99, "status": "COMPLETED", "metadata": run.metadata})
    np.savez(tmp_path / "d.npz", about=np.array(about), **run.arrays())
    with pytest.raises(FileError, match="99"):
        mf.Recording.load(tmp_path / "d")


def test_an_impossible_place_is_named_and_leaves_nothing(tmp_path, run):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        run.save(tmp_path / "file" / "e")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
