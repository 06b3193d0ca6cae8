"""A recording survives its files; damaged files are refused with the path in the sentence."""

from __future__ import annotations

import csv
import json
import os
import tracemalloc

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque
from mafsil.errors import FileError
from mafsil.trajectory import quintic
from tests.sizes import size

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


def test_flipped_bytes_give_an_error_of_ours_or_the_recording(tmp_path, run):
    """Whatever zip, zlib, the header's parser and JSON say of damage, it comes out as one kind of error."""
    sound = run.save(tmp_path / "a")[0].read_bytes()
    rng, refused, damaged = np.random.default_rng(0), 0, tmp_path / "b.npz"
    for _ in range(size(300, 3000)):
        data = bytearray(sound)
        for place in rng.integers(0, len(data), rng.integers(1, 4)):
            data[place] = rng.integers(256)
        damaged.write_bytes(data[: rng.integers(1, len(data))] if rng.random() < 0.2 else data)
        try:
            mf.Recording.load(damaged)
        except FileError:
            refused += 1
    assert refused > 200


NONSENSE = {
    "not finite": (lambda a: {"q": np.full_like(a["q"], np.nan)}, "'q'"),
    "another shape": (lambda a: {"tau": np.zeros((3, 3, 3))}, "'tau'"),
    "fewer joints": (lambda a: {"q": a["q"][:, :3]}, "'q'"),
    "texts": (lambda a: {"qd": a["qd"].astype(str)}, "'qd'"),
    "backwards": (lambda a: {"t": a["t"][::-1]}, "times"),
    "times twice": (lambda a: {"t": np.zeros_like(a["t"])}, "times"),
    "errors of joints": (lambda a: {"tip_position_error": a["q"]}, "'tip_position_error'"),
    "no joints": (lambda a: {"about": np.array('{"status": "COMPLETED", "format": 1, "metadata": {}}')}, "joints"),
    "a list": (lambda a: {"about": np.array("[1, 2]")}, "what it holds"),
}


@pytest.mark.parametrize("name", NONSENSE)
def test_nonsense_is_refused_naming_the_array(tmp_path, run, name):
    file = run.save(tmp_path / "a")[0]
    change, word = NONSENSE[name]
    arrays = dict(np.load(file))
    np.savez_compressed(file, **{**arrays, **change(arrays)})
    with pytest.raises(FileError, match=word):
        mf.Recording.load(file)


def test_a_bomb_is_refused_before_memory_is_taken(tmp_path, run):
    file = run.save(tmp_path / "a")[0]
    arrays = {**dict(np.load(file)), "q": np.zeros((20_000_000, 7))}
    np.savez_compressed(file, **arrays)
    assert file.stat().st_size < 3e6
    tracemalloc.start()
    with pytest.raises(FileError, match="unpacks"):
        mf.Recording.load(file)
    assert tracemalloc.get_traced_memory()[1] < 3e6
    tracemalloc.stop()


def test_pipes_are_refused_at_once(tmp_path):
    for suffix in (".npz", ".mcap"):
        pipe = tmp_path / f"pipe{suffix}"
        os.mkfifo(pipe)
        with pytest.raises(FileError, match="regular"):
            mf.Recording.load(pipe)


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
