"""CSV logs: names of columns, separators, units, and complaints that name the line."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError
from mafsil.identification import read_log
from tests.identification.simulated import write_csv

ROBOT = mf.load("planar2r")
HEAD = "t,q[joint1],q[joint2],tau[joint1],tau[joint2]"
ROWS = ["0,1,2,3,4", "0.1,1,2,3,4", "0.2,1,2,3,4"]


def written(tmp_path, *lines):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_columns_in_any_order_and_naming(tmp_path):
    wanted = {"q": [[1, 2]] * 3, "tau": [[3, 4]] * 3}
    for head, cells in (
        (HEAD, "{},1,2,3,4"),
        ("tau[joint2],extra,t,q[joint2],q[joint1],tau[joint1]", "4,9,{},2,1,3"),
        ("time;q1;q2;tau1;tau2", "{};1;2;3;4"),
        ("t\tq_1\tq_2\ttau_joint1\ttau_joint2", "{}\t1\t2\t3\t4"),
        ("# from the arm\n\n" + HEAD, "{},1,2,3,4"),
    ):
        log = read_log(written(tmp_path, head, *(cells.format(0.1 * k) for k in range(3))), ROBOT)
        assert {name: array.tolist() for name, array in log.signals().items()} == wanted
        assert np.allclose(log.times, [0, 0.1, 0.2])


def test_degrees_turn_only_turning_joints(tmp_path):
    robot = mf.load("scara_rrrp")
    n = robot.n
    heads = ["t", *(f"{s}{k}" for s in ("q", "qd", "tau") for k in range(1, n + 1))]
    rows = [",".join(str(x) for x in [k, *([90.0] * 3 * n)]) for k in range(3)]
    log = read_log(written(tmp_path, ",".join(heads), *rows), robot, degrees=True).signals()
    kinds = [joint.kind.value for joint in robot.mechanism.coordinates]
    expected = [90.0 if kind == "prismatic" else np.pi / 2 for kind in kinds]
    assert np.allclose(log["q"], expected)
    assert np.allclose(log["qd"], expected)
    assert np.allclose(log["tau"], 90.0)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ((HEAD, *ROWS, "0.3,1,x,3,4"), ["line 5", "q[joint2]", "'x'"]),
        ((HEAD, ROWS[0], "", "0.1,1,nan,3,4", ROWS[2]), ["line 4", "q[joint2]", "'nan'"]),
        ((HEAD, ROWS[0], "0.1,1,,3,4", ROWS[2]), ["line 3", "''"]),
        ((HEAD, ROWS[0], "0.1,1,2,3", ROWS[2]), ["line 3", "4 cells under 5"]),
        ((HEAD, ROWS[0], ROWS[2], ROWS[1]), ["line 4", "0.1", "0.2"]),
        ((HEAD, ROWS[0], ROWS[0], ROWS[1]), ["line 3", "does not come after"]),
        (("q[joint1],q[joint2],tau[joint1],tau[joint2]", "1,2,3,4", "1,2,3,4", "1,2,3,4"), ["no column 't'"]),
        (("t,q[joint1],q[joint3],tau[joint1],tau[joint2]", *ROWS), ["no column 'q[joint2]'", "q[joint3]"]),
        ((HEAD + ",qd1", *(row + ",5" for row in ROWS)), ["no column 'qd[joint2]'"]),
        (("t,t,q1,q2,tau1,tau2", "0,0,1,2,3,4", "1,1,1,2,3,4"), ["two columns", "'t'"]),
        ((HEAD,), ["0 rows"]),
        ((), ["0 rows"]),
    ],
)
def test_complaints_name_the_place(tmp_path, lines, words):
    with pytest.raises(FileError) as error:
        read_log(written(tmp_path, *lines), ROBOT)
    for language in ("en", "ar"):
        assert error.value.message(language)
    for word in words:
        assert word in error.value.message("en")


def test_files_that_are_none(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_log(tmp_path / "nothing.csv", ROBOT)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(FileError, match="cannot be read as text"):
        read_log(tmp_path / "binary.csv", ROBOT)
    with pytest.raises(FileError, match="cannot be read"):
        read_log(tmp_path, ROBOT)


def test_recordings_of_simulations_are_logs(tmp_path):
    """The names of columns that recordings are saved with."""
    rng = np.random.default_rng(0)
    log = mf.identification.MotionLog(
        t=np.arange(5) * 0.1, q=rng.normal(size=(5, 2)), tau=rng.normal(size=(5, 2)), qd=np.zeros((5, 2))
    )
    write_csv(log, ROBOT, tmp_path / "log.csv")
    again = read_log(tmp_path / "log.csv", ROBOT)
    for name, array in log.signals().items():
        assert np.allclose(again.signals()[name], array)
    assert again.place(2).sentence("en") == "log.csv, line 4"
    assert log.place(2).sentence("en") == "row 2"
