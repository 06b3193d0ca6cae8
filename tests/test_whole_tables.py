"""Tables of numbers written and read back to the last bit, and files that are whole or not there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from mafsil.csv_table import csv_text, joint_columns, read_csv_table
from mafsil.errors import FileError
from mafsil.whole_file import write_whole

NUMBERS = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2, max_size=30)


@settings(deadline=None)
@given(values=NUMBERS, separators=st.sampled_from([",", ";", "\t"]))
def test_what_is_written_reads_back_to_the_last_bit(tmp_path_factory, values, separators):
    path = tmp_path_factory.mktemp("tables") / "table.csv"
    text = b"".join(csv_text({"t": np.arange(len(values)), "q[a b]": np.array(values)})).decode()
    path.write_text(text.replace(",", separators), encoding="utf-8")
    table = read_csv_table(path, fewest=1)
    assert_array_equal(table.numbers([1])[:, 0], values)


def test_a_name_with_a_comma_is_one_column(tmp_path):
    path = tmp_path / "table.csv"
    write_whole(path, lambda file: file.writelines(csv_text({"t": np.arange(3.0), "q[3,joint1]": np.ones(3)})))
    assert read_csv_table(path).heads == ["t", "q[3,joint1]"]


def test_joints_by_name_or_number(tmp_path):
    path = tmp_path / "table.csv"
    write_whole(path, b"t,q_2,q[base]\n0,1,2\n1,1,2\n")
    assert read_csv_table(path).joint_columns("q", ("base", "elbow"), required=True) == [2, 1]
    assert read_csv_table(path).joint_columns("qd", ("base", "elbow"), required=False) is None
    with pytest.raises(FileError, match=r"qd\[base\]"):
        read_csv_table(path).joint_columns("qd", ("base", "elbow"), required=True)
    columns = joint_columns(("q",), (np.zeros((3, 2)),), ("base", "elbow"))
    assert list(columns) == ["q[base]", "q[elbow]"]


def test_a_writer_that_fails_leaves_what_was_there(tmp_path):
    path = tmp_path / "table.csv"
    write_whole(path, b"before")

    def fails(file):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    with pytest.raises(FileError, match=r"table\.csv.*No space left"):
        write_whole(path, fails)
    assert path.read_bytes() == b"before"
    assert [file.name for file in tmp_path.iterdir()] == ["table.csv"]
