"""Trajectories in files: what is written is what moves, and nothing is written that breaks a limit."""

from __future__ import annotations

import json

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import mafsil as mf
from mafsil.csv_table import csv_text
from mafsil.errors import FileError, InputError
from mafsil.trajectory import MotionLimits, export, quintic, read_trajectory
from mafsil.trajectory.files.exporting import ExportStatus

UR5E = mf.load("ur5e")
START, GOAL = np.zeros(6), np.array([0.4, -0.6, 0.5, 0.2, -0.3, 0.7])
MOTION = quintic(START, GOAL, 2.0)
FREE = MotionLimits.of(6)


@settings(deadline=None)
@given(duration=st.floats(0.05, 3.0), rate=st.floats(20.0, 500.0))
def test_a_quintic_reads_back_as_itself(tmp_path_factory, duration, rate):
    path = tmp_path_factory.mktemp("files") / "motion.csv"
    motion = quintic(START, GOAL, duration)
    assert export(motion, path, FREE, rate=rate)
    back = read_trajectory(path)
    t = np.linspace(0.0, duration, 77)
    assert_allclose(back.duration, duration, rtol=1e-15)
    assert_allclose(back.at(t).u, motion.at(t).u, atol=1e-9)
    assert_allclose(back.at(t).v * duration, motion.at(t).v * duration, atol=1e-6)


def test_every_sample_is_on_the_trajectory_and_the_last_is_its_end(tmp_path):
    path = tmp_path / "motion.csv"
    answer = export(MOTION, path, UR5E, rate=30.0)
    rows = np.genfromtxt(path, delimiter=",", names=True)
    assert answer.rows == len(rows) == 61
    assert_array_equal(rows["t"][[0, -1]], [0.0, 2.0])
    assert (np.diff(rows["t"]) > 0).all()
    text = path.read_text().splitlines()[0]
    assert text.split(",")[1] == f"q[{UR5E.joint_names[0]}]"


def test_positions_alone_and_positions_with_velocities_make_smooth_motions(tmp_path):
    t = np.linspace(0.0, 2.0, 21)
    u, v, _ = MOTION.at(t)
    for name, columns in (("q", [u]), ("qd", [u, v])):
        path = tmp_path / f"{name}.csv"
        heads = ["time", *(f"{signal}{k}" for signal in ("q", "qd")[: len(columns)] for k in range(1, 7))]
        np.savetxt(path, np.column_stack([t + 5.0, *columns]), delimiter=";", header=";".join(heads), comments="")
        back = read_trajectory(path)
        assert_allclose(back.at(t).u, u, atol=1e-15)
        fine = np.linspace(0.0, 2.0, 333)
        assert_allclose(back.at(fine).u, MOTION.at(fine).u, atol=1e-4)


def test_ros2_messages_in_yaml_and_json_say_the_same(tmp_path):
    assert export(MOTION, tmp_path / "motion.yaml", UR5E, rate=100)
    assert export(MOTION, tmp_path / "motion.json", UR5E, rate=100)
    message = yaml.safe_load((tmp_path / "motion.yaml").read_text())
    assert message == json.loads((tmp_path / "motion.json").read_text())
    assert message["joint_names"] == list(UR5E.joint_names)
    stamps = [p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"] for p in message["points"]]
    assert stamps == [k * 10**7 for k in range(201)]
    for point, stamp in zip(message["points"], stamps, strict=True):
        u, v, a = MOTION.at(stamp * 1e-9)
        assert_allclose(point["positions"], u, atol=1e-9)
        assert_allclose(point["velocities"], v, atol=1e-8)
        assert_allclose(point["accelerations"], a, atol=1e-7)


def test_urscript_serves_every_period_of_the_controller(tmp_path):
    path = tmp_path / "motion.script"
    assert export(quintic(START, GOAL, 1.003), path, UR5E, rate=500)
    lines = path.read_text().splitlines()
    servo = [line for line in lines if line.startswith("  servoj(")]
    assert len(servo) == 502
    assert all("t=0.002," in line for line in servo)
    assert_allclose(json.loads(servo[-1].split("servoj(")[1].split("]")[0] + "]"), GOAL)
    assert lines[0] == "def mafsil_motion():"
    assert lines[-1] == "mafsil_motion()"


def test_a_motion_that_is_too_fast_is_not_written(tmp_path):
    path = tmp_path / "motion.yaml"
    answer = export(quintic(START, GOAL, 0.05), path, UR5E)
    assert not answer
    assert answer.status is ExportStatus.LIMITS_EXCEEDED
    assert "was not written" in answer.explain()
    assert "velocity" in answer.explain()
    assert not path.exists()
    assert answer.to_dict()["violations"]


def test_one_sided_limits_hold_on_their_side(tmp_path):
    one_way = MotionLimits.of(6, velocity=(-0.5, np.inf))
    answer = export(MOTION, tmp_path / "motion.csv", one_way)
    assert [violation.joint for violation in answer.limit_check] == ["joint2"]
    assert answer.limit_check.violations[0].limit == -0.5


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda p: export(MOTION, p / "motion.txt", UR5E), r"\.csv, \.yaml"),
        (lambda p: export(MOTION, p / "motion.csv", UR5E, format="krl"), "ros2_yaml"),
        (lambda p: export(MOTION, p / "motion.csv", UR5E, rate=0.0), "rate"),
        (lambda p: export(MOTION, p / "motion.csv", UR5E, rate=1e12), "lower rate"),
        (lambda p: export(MOTION, p / "motion.csv", FREE, joints=("a", "b")), "6 different names"),
        (lambda p: export(quintic([0.0], [1.0], 9.0), p / "m.script", MotionLimits.of(1)), "six joints"),
        (lambda p: export(quintic(np.zeros((2, 6)), GOAL, 2.0), p / "motion.csv", UR5E), "trajectory"),
    ],
)
def test_wrong_requests_are_named(tmp_path, call, says):
    with pytest.raises(InputError, match=says):
        call(tmp_path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("t,q1\n0,1\n0,2\n1,3\n", "line 3"),
        ("t,q1\n0,1\n1,nan\n2,3\n", "line 3, column q1"),
        ("t,x\n0,1\n1,2\n2,3\n", r"q\[JOINT\]"),
        ("q1\n0\n1\n2\n", "no column 't'"),
        ("", "0 rows"),
    ],
)
def test_files_that_are_no_trajectory_are_named(tmp_path, text, says):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    with pytest.raises(FileError, match=says):
        read_trajectory(path)


def rows_in(path, format):
    """Times, positions and what there is of velocities and accelerations, as the reader of the format has them."""
    if format == "csv":
        table = np.genfromtxt(path, delimiter=",", skip_header=1)
        return table[:, 0], *np.split(table[:, 1:], 3, axis=1)
    if format == "urscript":
        lines = path.read_text().splitlines()
        q = [
            json.loads("[" + line.split("([")[1].split("]")[0] + "]")
            for line in lines
            if "servoj(" in line or "movej(" in line
        ]
        period = float(next(line for line in lines if "servoj(" in line).split("t=")[1].split(",")[0])
        return np.arange(len(q)) * period, np.array(q), None, None
    message = json.loads(path.read_text()) if format == "ros2_json" else yaml.safe_load(path.read_text())
    points = message["points"]
    t = [point["time_from_start"]["sec"] + 1e-9 * point["time_from_start"]["nanosec"] for point in points]
    return np.array(t), *(np.array([p[name] for p in points]) for name in ("positions", "velocities", "accelerations"))


def smooth_motions():
    limits = MotionLimits.of(6, velocity=1.0, acceleration=4.0, jerk=60.0)
    yield "quintic", quintic(START, GOAL, 2.0)
    yield "jerk_limited", mf.trajectory.jerk_limited(START, GOAL, limits)
    yield "spline", mf.trajectory.cubic_through(np.array([START, GOAL, -GOAL, START]), np.array([1.0, 1.5, 1.0]))


@pytest.mark.parametrize("format", ["csv", "ros2_yaml", "ros2_json", "urscript"])
@pytest.mark.parametrize(
    ("name", "motion"), list(smooth_motions()), ids=lambda value: value if isinstance(value, str) else ""
)
def test_what_is_written_moves_as_it_says(tmp_path, name, motion, format):
    """Positions that are read back and differentiated are the velocities of the file, these its accelerations."""
    path, rate = tmp_path / "motion", 500.0
    assert export(motion, path, FREE, rate=rate, format=format, ends=False)
    t, q, qd, qdd = rows_in(path, format)
    assert abs(t[-1] - motion.duration) <= 1.0 / rate
    h = np.diff(t[:-1])
    assert_allclose(h, 1.0 / rate, atol=2e-9)
    u, v, a = motion.at(t[:-1])
    slope = (q[2:-1] - q[:-3]) * rate / 2
    # central differences are off by h^2/6 of the third derivative, by h/4 of a jump of the second
    assert_allclose(q[:-1], u, atol=1e-9)
    assert_allclose(slope, v[1:-1], atol=60.0 / rate**2 + 1e-6)
    if qd is not None:
        assert_allclose(qd[:-1], v, atol=1e-8)
        steep = (qd[2:-1] - qd[:-3]) * rate / 2
        assert_allclose(steep, a[1:-1], atol=100.0 / rate)
        assert_allclose(qdd[:-1], a, atol=1e-7)


def test_a_recording_is_read_as_its_plan(tmp_path):
    """Beside the plan stands what was driven."""
    t = np.linspace(0.0, 2.0, 201)
    plan, driven = MOTION.at(t), quintic(START, GOAL * 0.9, 2.0).at(t)
    columns = {"t": t}
    for suffix, values in (("", driven), ("_ref", plan)):
        for signal, array in zip(("q", "qd", "qdd"), (values.u, values.v, values.a), strict=True):
            columns |= {f"{signal}{suffix}[{name}]": array[:, k] for k, name in enumerate(UR5E.joint_names)}
    path = tmp_path / "recording.csv"
    path.write_bytes(b"".join(csv_text(columns)))
    assert_allclose(read_trajectory(path).at(t).u, plan.u, atol=1e-12)
    assert_allclose(read_trajectory(path, UR5E.joint_names, driven=True).at(t).u, driven.u, atol=1e-12)
    head, *rest = path.read_text().splitlines()
    path.write_text("\n".join([head.replace("q_ref[wrist_3_joint]", "x"), *rest]))
    with pytest.raises(FileError, match=r"q_ref\[wrist_3_joint\]"):
        read_trajectory(path)
