"""Logs of controllers laid over plans: offset, units, signs and causes are found, and none is named without proof."""

from __future__ import annotations

import struct
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.compare import _replan
from mafsil.cli.main import main
from mafsil.errors import FileError, InputError
from mafsil.job.judging.better_job import better_job, with_key
from mafsil.job.judging.log_comparison import compare_with_log, positions
from mafsil.job.language.reading import parse_job
from mafsil.job.solve import prepare
from tests.sizes import few

ROBOTS = ("ur5e", "ur10e", "puma560", "panda", "iiwa7", "stanford_arm")
CAUSES: dict[str, set[str]] = {
    "none": set(),
    "payload": {"job.log_payload"},
    "friction": {"job.log_friction"},
    "sign": {"job.log_sign"},
}


def job_of(robot):
    arm = mf.load(robot)
    low, high = np.maximum(arm.limits.lower, -1.5), np.minimum(arm.limits.upper, 1.5)
    places = [low + (high - low) * np.linspace(*ends, arm.n) for ends in ((0.35, 0.35), (0.5, 0.75), (0.7, 0.2))]
    moves = "".join(f"[[move]]\njoints = {place.tolist()}\n" for place in (*places[1:], places[0]))
    return f'robot = "{robot}"\n[collision]\nself_collision = false\n[start]\njoints = {places[0].tolist()}\n{moves}'


@cache
def planned(robot):
    text = job_of(robot)
    return parse_job(text), *prepare(parse_job(text), text, Path())


def log(path, robot, plan, kind, rng, *, begin=0.5, offset=0.0, degrees=False, off=0.0):
    """A log as a controller writes it: what it knows nothing of is in the efforts, or in the coordinates."""
    t = np.arange(0.0, plan.duration + 1.0, 0.008)
    now, h, end = np.clip(t - begin, 0.0, plan.duration), 1e-4, plan.duration
    q, after, before = (positions(plan, np.clip(now + shift, 0.0, end)) for shift in (0.0, h, -h))
    qd, qdd = (after - before) / (2 * h), (after - 2 * q + before) / h**2
    arm = robot.with_payload(rng.uniform(0.5, 2.0)) if kind == "payload" else robot
    tau = np.asarray(arm.inverse_dynamics(q, qd, qdd))
    if kind == "friction":
        tau = tau + 0.15 * np.abs(tau).max(axis=0) * np.tanh(qd / 0.01) + 0.1 * qd
    tau = tau + rng.normal(size=tau.shape) * 0.01 * np.abs(tau).max(axis=0)
    factors = np.where(robot.mechanism.angular & degrees, 180.0 / np.pi, 1.0)
    factors[rng.integers(robot.n)] *= -1.0 if kind == "sign" else 1.0
    q = (q + off + rng.normal(size=q.shape) * 1e-5) * factors
    heads = [f"actual_{signal}_{k}" for signal in ("q", "torque") for k in range(robot.n)]
    table = np.column_stack([t + offset, q, tau])
    np.savetxt(path, table, delimiter=",", header=",".join(["timestamp", *heads]), comments="")
    return factors


@pytest.mark.parametrize("robot", few(ROBOTS, 3))
def test_offset_units_signs_and_causes_are_found(robot, tmp_path):
    job, arm, plan = planned(robot)
    rng, right, named = np.random.default_rng(7), 0, 0
    for kind, expected in CAUSES.items():
        for degrees in (False, True):
            begin, offset = rng.uniform(0.1, 0.9), rng.uniform(-2.0, 3.0)
            path = tmp_path / "log.csv"
            factors = log(path, arm, plan, kind, rng, begin=begin, offset=offset, degrees=degrees)
            found = compare_with_log(job, arm, plan, path)
            assert found, found.explain()
            assert found.offset == pytest.approx(begin + offset, abs=1e-3)
            np.testing.assert_array_equal(found.factors, factors)
            causes = {remark.key for remark in found.remarks} - {"job.log_degrees"}
            right += causes == expected
            named += bool(causes - expected - {"job.log_unclear", "job.log_unknown"})
    assert named == 0, "a cause that is not there"
    assert right == 8


def test_a_log_that_misses_targets_is_a_failure_with_the_distance(tmp_path):
    job, arm, plan = planned("ur5e")
    log(tmp_path / "log.csv", arm, plan, "none", np.random.default_rng(0), off=0.02)
    found = compare_with_log(job, arm, plan, tmp_path / "log.csv")
    assert not found
    assert [one.key for one in found.remarks] == ["job.log_missed"] * 3 + ["job.log_zero"] * 6
    assert "°" in found.explain("en")
    assert found.errors.max() == pytest.approx(0.02, abs=1e-4)


def tracked_log(path, arm, plan, kind, rng):
    """A log of joints that follow late, yield to their efforts, or count from another zero; what should be named."""
    t, begin, n = np.arange(0.0, plan.duration + 1.0, 0.008), rng.uniform(0.1, 0.9), arm.n
    late, joint, h = np.full(n, rng.uniform(0.0, 0.02)), rng.integers(n), 1e-4
    shifts = (late.min(), late.min() - h, late.min() + h)
    plain, after, before = (positions(plan, np.clip(t - begin - s, 0.0, plan.duration)) for s in shifts)
    tau = np.asarray(arm.inverse_dynamics(plain, (after - before) / (2 * h), (after - 2 * plain + before) / h**2))
    late[joint] += rng.uniform(0.01, 0.06) if kind == "lag" else 0.0
    shown = [positions(plan, np.clip(t - begin - s, 0.0, plan.duration))[:, k] for k, s in enumerate(late)]
    q, expected = np.stack(shown, axis=1), {joint: late[joint] - late.min()} if kind == "lag" else {}
    if kind == "zero":
        expected = {joint: rng.choice([-1, 1]) * rng.uniform(0.002, 0.02)}
        q[:, joint] += expected[joint]
    if kind == "gain":
        kp = np.abs(tau).max(axis=0) / rng.uniform(0.005, 0.02)
        loaded = np.abs(tau).max(axis=0) > 1e-6
        q[:, loaded] -= tau[:, loaded] / kp[loaded]
        expected = {k: kp[k] for k in np.flatnonzero(loaded)}
    tau += rng.normal(size=tau.shape) * 0.01 * np.abs(tau).max(axis=0)
    q += rng.normal(size=q.shape) * 1e-5
    heads = [f"actual_{signal}_{k}" for signal in ("q", "torque") for k in range(n)]
    np.savetxt(path, np.column_stack([t, q, tau]), delimiter=",", header=",".join(["timestamp", *heads]), comments="")
    return expected


@pytest.mark.parametrize("kind", ["none", "lag", "zero", "gain"])
@pytest.mark.parametrize("robot", few(ROBOTS, 2))
def test_late_soft_and_displaced_joints_are_named_and_no_others(robot, kind, tmp_path):
    job, arm, plan = planned(robot)
    for seed in range(2):
        rng = np.random.default_rng(100 + seed)
        expected = tracked_log(tmp_path / "log.csv", arm, plan, kind, rng)
        found = compare_with_log(job, arm, plan, tmp_path / "log.csv")
        remarks = [one for one in found.remarks if one.key != "job.log_missed"]
        assert {one.key for one in remarks} == ({f"job.log_{kind}"} if expected else set()), found.explain()
        assert {one.details["joint"] for one in remarks} == {arm.joint_names[k] for k in expected}
        if kind == "gain":
            gains = [float(one.details["gain"].split()[0]) for one in remarks]
            assert gains == pytest.approx(list(expected.values()), rel=0.05)


def test_a_late_joint_with_a_wrong_zero_gets_both_names(tmp_path):
    job, arm, plan = planned("ur5e")
    expected = tracked_log(tmp_path / "log.csv", arm, plan, "lag", np.random.default_rng(4))
    (joint,) = expected
    lines = np.genfromtxt(tmp_path / "log.csv", delimiter=",", names=True)
    lines[f"actual_q_{joint}"] += 0.01
    head = ",".join(lines.dtype.names)
    np.savetxt(tmp_path / "log.csv", np.array(lines.tolist()), delimiter=",", header=head, comments="")
    keys = {one.key for one in compare_with_log(job, arm, plan, tmp_path / "log.csv").remarks}
    assert keys - {"job.log_missed"} == {"job.log_lag", "job.log_zero"}


def test_payload_and_friction_together_are_both_named(tmp_path):
    """Leaving out either of them leaves more than twice as much."""
    job, arm, plan = planned("puma560")
    rng = np.random.default_rng(1)
    log(tmp_path / "log.csv", arm.with_payload(2.0), plan, "friction", rng)
    keys = {remark.key for remark in compare_with_log(job, arm, plan, tmp_path / "log.csv").remarks}
    assert keys == {"job.log_friction", "job.log_payload"}


def test_what_is_no_log_of_the_job_is_refused(tmp_path):
    job, arm, plan = planned("ur5e")
    path = tmp_path / "log.csv"
    log(path, arm, plan, "none", np.random.default_rng(0))
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:20]))
    with pytest.raises(InputError, match="less than half"):
        compare_with_log(job, arm, plan, path)
    path.write_text("\n".join(line.split(",", 1)[1] for line in lines))
    with pytest.raises(FileError, match="'t'"):
        compare_with_log(job, arm, plan, path)


def test_the_command_lays_a_log_over_a_job(tmp_path, capsys):
    _, arm, plan = planned("ur5e")
    (tmp_path / "job.toml").write_text(job_of("ur5e"))
    log(tmp_path / "log.csv", arm, plan, "payload", np.random.default_rng(3))
    command = ["compare", "log", str(tmp_path / "job.toml")]
    assert main([*command, "--log", str(tmp_path / "log.csv")]) == 0
    assert "payload" in capsys.readouterr().out
    assert main(command) == 2


def joint_state(time, names, position, effort):
    """A message sensor_msgs/msg/JointState in little-endian CDR, written by its rules alone."""
    data = bytearray()

    def put(kind, *values):
        size = struct.calcsize(kind)
        data.extend(b"\0" * (-len(data) % size if values else 0))
        data.extend(struct.pack(f"<{len(values)}{kind}", *values))

    def text(value):
        put("I", len(value) + 1)
        data.extend(value.encode() + b"\0")

    put("i", int(time))
    put("I", round((time - int(time)) * 1e9))
    text("base")
    put("I", len(names))
    for name in names:
        text(name)
    for values in (position, [], effort):
        put("I", len(values))
        if len(values):
            put("d", *values)
    return b"\0\1\0\0" + bytes(data)


def bag(path, t, names, q, tau):
    writer_module = pytest.importorskip("mcap.writer")
    with path.open("wb") as file:
        writer = writer_module.Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", b"")
        other = writer.register_schema("std_msgs/msg/String", "ros2msg", b"")
        states = writer.register_channel("/joint_states", "cdr", schema)
        words = writer.register_channel("/words", "cdr", other)
        for k, time in enumerate(t.tolist()):
            stamp = round(time * 1e9)
            writer.add_message(words, stamp, b"\0\1\0\0\1\0\0\0\0", stamp)
            message = joint_state(time, names, q[k].tolist(), tau[k].tolist())
            writer.add_message(states, stamp, message, stamp)
        writer.finish()


def test_a_bag_of_joint_states_says_the_same_as_a_table(tmp_path):
    job, robot, plan = planned("ur5e")
    log(tmp_path / "log.csv", robot, plan, "payload", np.random.default_rng(1), offset=1.3)
    numbers = np.loadtxt(tmp_path / "log.csv", delimiter=",", skiprows=1)
    n, order = robot.n, np.random.default_rng(2).permutation(robot.n)
    names = [robot.joint_names[k] for k in order] + ["finger"]
    pad = np.zeros((len(numbers), 1))
    q, tau = (np.hstack([numbers[:, 1 + at : 1 + at + n][:, order], pad]) for at in (0, n))
    bag(tmp_path / "log.mcap", numbers[:, 0], names, q, tau)
    one, two = (compare_with_log(job, robot, plan, tmp_path / f"log.{kind}") for kind in ("csv", "mcap"))
    assert two.status is one.status
    assert two.offset == pytest.approx(one.offset, abs=1e-6)
    np.testing.assert_allclose(two.errors, one.errors, atol=1e-9)
    assert [remark.key for remark in two.remarks] == [remark.key for remark in one.remarks]


def test_a_bag_without_the_joints_or_torn_is_refused(tmp_path):
    job, robot, plan = planned("ur5e")
    t = np.linspace(0.0, 9.0, 50)
    bag(tmp_path / "other.mcap", t, ["a"], np.zeros((50, 1)), np.zeros((50, 1)))
    with pytest.raises(FileError, match="all of the joints"):
        compare_with_log(job, robot, plan, tmp_path / "other.mcap")
    (tmp_path / "no.mcap").write_bytes(b"no bag at all")
    with pytest.raises(FileError, match="damaged"):
        compare_with_log(job, robot, plan, tmp_path / "no.mcap")


def quick_job(robot):
    return job_of(robot).replace("[[move]]", '[[move]]\nprofile = "trapezoid"')


def late_log(path, arm, plan, late):
    """A log of which one joint is late."""
    t = np.arange(0.0, plan.duration + 1.0, 0.008)
    q = positions(plan, np.clip(t - 0.3, 0.0, plan.duration))
    q[:, 1] = positions(plan, np.clip(t - 0.3 - late, 0.0, plan.duration))[:, 1]
    heads = ",".join(["timestamp", *(f"actual_q_{k}" for k in range(arm.n))])
    np.savetxt(path, np.column_stack([t, q]), delimiter=",", header=heads, comments="")


def test_a_better_job_is_slow_enough_for_a_late_drive(tmp_path):
    text = quick_job("ur5e")
    job, (arm, plan) = parse_job(text), prepare(parse_job(text), text, Path())
    late_log(tmp_path / "log.csv", arm, plan, 0.09)
    found = compare_with_log(job, arm, plan, tmp_path / "log.csv")
    assert not found
    assert found.lags[1] == pytest.approx(0.09, abs=0.003)
    better = better_job(job, text, plan, found, partial(_replan, Path()))
    assert [one.key for one in better.remarks] == ["job.better_slower"]
    _, slower = prepare(parse_job(better.text), better.text, Path())
    late_log(tmp_path / "again.csv", arm, slower, 0.09)
    assert compare_with_log(parse_job(better.text), arm, slower, tmp_path / "again.csv")
    late_log(tmp_path / "again.csv", arm, plan, 0.09)
    assert not compare_with_log(job, arm, plan, tmp_path / "again.csv")


def test_what_no_job_can_better_is_not_offered(tmp_path):
    job, arm, plan = planned("ur5e")
    log(tmp_path / "log.csv", arm, plan, "none", np.random.default_rng(2), off=0.02)
    found = compare_with_log(job, arm, plan, tmp_path / "log.csv")
    better = better_job(job, job_of("ur5e"), plan, found, partial(_replan, Path()))
    assert (better.text, [one.key for one in better.remarks]) == ("", ["job.better_none"])


def test_a_better_job_has_the_load_that_the_log_shows(tmp_path, capsys):
    text = job_of("ur5e") + "[tool]\noffset = { position = [0, 0, 0.1] }\nmass = 1.0\ncom = [0, 0, 0.04] # half\n"
    arm, plan = prepare(parse_job(text), text, Path())
    rng = np.random.default_rng(5)
    mass = np.random.default_rng(5).uniform(0.5, 2.0)
    log(tmp_path / "log.csv", arm, plan, "payload", rng)
    (tmp_path / "job.toml").write_text(text)
    command = ["compare", "log", str(tmp_path / "job.toml"), "--log", str(tmp_path / "log.csv")]
    assert main([*command, "--better", str(tmp_path / "better.toml")]) == 0
    assert "better job" in capsys.readouterr().out
    tool = parse_job((tmp_path / "better.toml").read_text()).tool
    assert tool.mass == pytest.approx(1.0 + mass, abs=0.03)
    assert tool.com[2] == pytest.approx((0.04 + 0.1 * mass) / (1.0 + mass), abs=2e-3)
    better = parse_job((tmp_path / "better.toml").read_text())
    again = prepare(better, "", tmp_path)
    assert not [one for one in compare_with_log(better, *again, tmp_path / "log.csv").remarks if "payload" in one.key]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("robot = 'a'\n", "robot = 'a'\n\n[limits]\njerk = 2\n"),
        ("[limits] # own\njerk = 5 # high\n[[move]]\n", "[limits] # own\njerk = 2 # high\n[[move]]\n"),
        ("[limits]\n[tool]\njerk = 1\n", "[limits]\njerk = 2\n[tool]\njerk = 1\n"),
    ],
)
def test_a_key_is_changed_in_its_table_alone(text, expected):
    assert with_key(text, "limits", "jerk", "2").replace("2#", "2 #") == expected


TEN_ROBOTS = (*ROBOTS, "ur3e", "ur5", "fr3", "cobra600")
KINDS = ("none", "payload", "friction", "sign", "degrees", "lag", "zero", "gain", "delay", "noise")
CANDID = {"job.log_unclear", "job.log_unknown", "job.log_missed"}


def test_causes_of_a_hundred_logs_are_named_and_none_is_invented(tmp_path):
    right, cases, path = 0, few(range(100), 14), tmp_path / "log.csv"
    for case in cases:
        rng, kind = np.random.default_rng(900 + case), KINDS[case // 10]
        job, arm, plan = planned(TEN_ROBOTS[case % 10])
        expected = {f"job.log_{kind}"} if kind not in ("none", "delay", "noise") else set()
        if kind in ("lag", "zero", "gain"):
            named = tracked_log(path, arm, plan, kind, rng)
            expected = expected if named else set()
        else:
            begin, offset = rng.uniform(0.1, 0.9), rng.uniform(0.0, 3.0) if kind == "delay" else 0.0
            log(path, arm, plan, kind, rng, begin=begin, offset=offset, degrees=kind == "degrees")
        if kind == "noise":
            table = np.loadtxt(path, delimiter=",", skiprows=1)
            table[:, 1:] += rng.normal(size=table[:, 1:].shape) * np.repeat([2e-4, 0.3], arm.n)
            heads = path.read_text().split("\n", 1)[0]
            np.savetxt(path, table, delimiter=",", header=heads, comments="")
        found = {one.key for one in compare_with_log(job, arm, plan, path).remarks}
        assert not found - expected - CANDID, (case, kind, arm.name, found)
        right += found - {"job.log_missed"} == expected
    assert right >= 0.9 * len(cases)
