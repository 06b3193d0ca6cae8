"""Logs that grow with a run: they survive the process, are read torn anywhere, and never change the run."""

from __future__ import annotations

import errno
import os
import signal
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

import mafsil as mf
from mafsil.control import Wall, closed_gravity_compensation, computed_torque, gravity_compensation
from mafsil.errors import FileError, InputError, MafsilError
from mafsil.job import Run, parse_job, solve
from mafsil.parallel import ClosedChain
from mafsil.simulation import (
    LiveLog,
    MuJoCoPlant,
    Plant,
    Recording,
    Scenario,
    SensorNoise,
    WrenchPulse,
    live_log,
    log_reading,
    simulate,
)
from mafsil.simulation.live_log import TickBytes
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest
from tests.parallel.closed_chains import four_bar

ARM = mf.load("planar2r")
PATH = quintic([0, 0], [0.5, 0.4], 0.1)
SHORT = Scenario(robot=ARM, trajectory=PATH, law=computed_torque(ARM), step=0.01, period=0.05)


def tick(t: float) -> bytes:
    """How a tick begins: its first field."""
    return b"\x09" + struct.pack("<d", t)


@pytest.fixture
def eager(monkeypatch):
    """Every tick in a block of its own."""
    monkeypatch.setattr(live_log, "INTERVAL", 0.0)


def same(one: Recording, other: Recording) -> None:
    assert one.arrays().keys() == other.arrays().keys()
    for name, array in one.arrays().items():
        assert np.array_equal(array, other.arrays()[name]), name


ODD = np.array([[1.0, np.nan], [np.inf, -0.0], [-np.inf, 5e-324]])
KINDS = {
    "plain": (SHORT, False),
    "compiled": (Scenario(robot=ARM, trajectory=PATH, law=computed_torque(ARM)), True),
    "pushed, noisy": (
        Scenario(
            robot=ARM, trajectory=PATH, law=computed_torque(ARM), noise=SensorNoise(1e-4, 1e-3, 1),
            disturbances=(WrenchPulse(0.03, 0.02, np.array([0, 0, 0, 3.0, 0, 0])),),
        ),
        None,
    ),
    "batch": (Scenario(robot=ARM, trajectory=PATH, law=computed_torque(ARM), q=np.zeros((3, 2))), False),
    "compiled batch": (Scenario(robot=ARM, trajectory=PATH, law=computed_torque(ARM), q=np.ones((3, 2))), True),
    "touching": (
        Scenario(
            robot=ARM, trajectory=rest([0.4, 1.1], 0.05), law=gravity_compensation(ARM, [30, 20], [6, 4]),
            plant=Plant(ARM, environment=Wall(np.array([0, 1.2, 0]), np.array([0, 1.0, 0]), 1e3, 10.0)),
        ),
        False,
    ),
    "mujoco": (Scenario(robot=ARM, trajectory=PATH, law=computed_torque(ARM), plant=MuJoCoPlant(ARM)), False),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_log_holds_the_recording_and_leaves_the_run_as_it_is(kind, tmp_path, eager):
    scenario, fused = KINDS[kind]
    alone = simulate(scenario, fused=fused)
    logged = simulate(scenario, fused=fused, log=tmp_path / "run.mcap")
    back = Recording.load(tmp_path / "run.mcap")
    same(alone, logged)
    same(logged, back)
    assert back.status is logged.status is SimulationStatus.COMPLETED
    assert back.explain("ar") == logged.explain("ar")
    assert back.metadata == logged.metadata


def test_loops_are_logged_too(tmp_path, eager):
    chain = ClosedChain(four_bar())
    start = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    law = closed_gravity_compensation(chain, 50.0, 10.0)
    scenario = Scenario(robot=mf.Robot(four_bar()), trajectory=rest(start, 0.02), law=law)
    logged = simulate(scenario, log=tmp_path / "run.mcap")
    same(simulate(scenario), logged)
    same(logged, Recording.load(tmp_path / "run.mcap"))


def test_other_tools_read_it(tmp_path):
    run = simulate(SHORT, log=tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        messages = list(reader.iter_messages(topics="run"))
        names = [record.name for record in reader.iter_metadata()]
    assert summary.statistics.message_count == len(messages) == len(run.t)
    assert [message.log_time for _, _, message in messages] == [round(1e9 * t) for t in run.t]
    assert names == ["mafsil.run_begins", "mafsil.run_ends"]


@pytest.mark.parametrize("law", ["raises", "nonsense", "unstable"])
def test_runs_that_fail_are_logged_up_to_there(law, tmp_path, eager):
    class Failing:
        def __call__(self, t, q, qd, reference):
            if t < 0.05:
                return 0.0 * q
            if law == "raises":
                raise RuntimeError("no more")
            return np.zeros(5) if law == "nonsense" else q + 1e9

        def session(self, period):
            return self

    scenario = Scenario(robot=ARM, trajectory=PATH, law=Failing(), saturate=False)
    run = simulate(scenario, log=tmp_path / "run.mcap")
    back = Recording.load(tmp_path / "run.mcap")
    assert not back
    assert back.status is run.status
    assert back.explain("en") == run.explain("en")
    same(run, back)


CHILD = """
import os, struct, sys
import mafsil as mf
from mafsil.control import computed_torque
from mafsil.simulation import Scenario, simulate
from mafsil.trajectory import quintic

arm, seen = mf.load("planar2r"), os.open(sys.argv[2], os.O_RDWR | os.O_CREAT)
inner = computed_torque(arm)

class Watched:
    def __call__(self, t, q, qd, reference):
        os.pwrite(seen, struct.pack("d", t), 0)
        return inner(t, q, qd, reference)
    def session(self, period):
        return self

path = quintic([0, 0], [0.5, 0.4], float(sys.argv[4]))
scenario = Scenario(robot=arm, trajectory=path, law=Watched() if sys.argv[3] == "plain" else inner)
simulate(Scenario(robot=arm, trajectory=quintic([0, 0], [0.5, 0.4], 0.1), law=inner), fused=sys.argv[3] == "fused")
print("begins", flush=True)
if sys.argv[3] == "plain":
    simulate(scenario, clock="real", log=sys.argv[1])
else:
    simulate(scenario, fused=True, log=sys.argv[1])
"""


@pytest.mark.parametrize("kind", ["plain", "fused"])
def test_kill_9_loses_only_the_last_milliseconds(kind, tmp_path):
    log, seen = tmp_path / "run.mcap", tmp_path / "seen"
    # Compiled, a thousand seconds take some of the clock's.
    length = 300.0 if kind == "plain" else 1500.0
    words = [sys.executable, "-c", CHILD, log, seen, kind, str(length)]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as child:
        assert child.stdout.readline() == b"begins\n"
        while not log.exists() or log.stat().st_size < 40_000:
            assert child.poll() is None
        if kind == "fused":
            torn = Recording.load(log)  # while it goes on
            assert torn.status is SimulationStatus.LOG_TORN
        child.send_signal(signal.SIGKILL)
        child.wait()
    assert child.returncode == -signal.SIGKILL
    back = Recording.load(log)
    assert not back
    assert back.status is SimulationStatus.LOG_TORN
    assert f"{length:g} s" in back.explain("en")
    assert np.array_equal(back.t, 1e-3 * np.arange(len(back.t)))
    if kind == "plain":
        (last,) = struct.unpack("d", seen.read_bytes())
        # Two blocks of 5 ms, and what a busy machine adds.
        assert last - back.t[-1] < 0.05
    else:
        assert len(back.t) >= len(torn.t)
    path = quintic([0, 0], [0.5, 0.4], length)
    whole = Scenario(robot=ARM, trajectory=path, law=computed_torque(ARM), duration=back.duration)
    same(back, simulate(whole, fused=kind == "fused"))


def test_a_log_torn_anywhere_gives_what_stands_before(tmp_path, eager):
    log, torn = tmp_path / "run.mcap", tmp_path / "torn.mcap"
    run = simulate(SHORT, log=log)
    torn.write_bytes(log.read_bytes())
    counts = []
    for size in reversed(range(torn.stat().st_size)):
        os.truncate(torn, size)
        try:
            back = Recording.load(torn)
        except FileError as error:
            assert "torn.mcap" in str(error)  # noqa: PT017
            counts.append(0)
            continue
        counts.append(len(back.t))
        assert np.array_equal(back.tau, run.tau[: len(back.t)])
        assert np.array_equal(back.q, run.q[: len(back.t)])
    assert counts == sorted(counts, reverse=True)
    assert sorted(set(counts)) == list(range(len(run.t) + 1))


def test_a_flipped_byte_never_gives_other_numbers(tmp_path, eager):
    log, bent = tmp_path / "run.mcap", tmp_path / "bent.mcap"
    run = simulate(SHORT, log=log)
    data, rng = log.read_bytes(), np.random.default_rng(0)
    for place in rng.integers(0, len(data), 500):
        changed = bytearray(data)
        changed[place] ^= 1 << int(rng.integers(8))
        bent.write_bytes(changed)
        try:
            back = Recording.load(bent)
        except FileError:
            continue
        for name, array in back.arrays().items():
            assert np.array_equal(array, run.arrays()[name][: len(back.t)])
        known = run.metadata | {"seconds": back.metadata.get("seconds", 0.0)}
        assert back.metadata == {name: known[name] for name in back.metadata}


def test_foreign_files_are_refused_by_name(tmp_path):
    place = tmp_path / "foreign.mcap"

    def written(
        *messages,
        topic="run",
        encoding="protobuf",
        shapes='[["t", []], ["q", [1]]]',
        compression=CompressionType.NONE,
        begun=True,
    ):
        with place.open("wb") as file:
            writer = Writer(file, compression=compression)
            writer.start()
            if begun:
                texts = {"joints": "[]", "log_number": "0"}
                writer.add_metadata("mafsil.run_begins", texts | {live_log.CHECKSUM: live_log.checksum(texts)})
            channel = writer.register_channel(topic, encoding, 0, {"shapes": shapes})
            for number, text in enumerate(messages, begun):
                writer.add_message(channel, 0, text, 0, number)
            writer.finish()

    layout = TickBytes({"t": (), "q": (1,)})
    sound = np.empty((1, len(layout.template)), dtype=np.uint8)
    layout.written({"t": np.zeros(1), "q": np.ones((1, 1))}, sound)
    message = sound.tobytes()
    for arguments, options in (
        ((message,), {"begun": False}),
        ((message,), {"topic": "camera"}),
        ((message,), {"compression": CompressionType.ZSTD}),
        ((b"\x00\x01",), {}),
        ((message + b"\x00",), {}),
        ((b"\x11" + message[1:],), {}),
        ((message, message[:-1]), {}),
        ((message,), {"shapes": "{}"}),
        ((message,), {"shapes": '[["q", [1]]]'}),
        ((message,), {"shapes": '[["t", [-1]]]'}),
        ((message,), {"shapes": '[["t", [2]]]'}),
        ((message,), {}),  # the arrays of no recording
    ):
        written(*arguments, **options)
        with pytest.raises(FileError, match=r"foreign\.mcap"):
            Recording.load(place)
    for contents in (b"", b"PK\x03\x04 a zip archive", b"\x89MCAP0\r\n", bytes(1000)):
        place.write_bytes(contents)
        with pytest.raises(FileError, match=r"foreign\.mcap"):
            Recording.load(place)
    with pytest.raises(FileError, match="no such file"):
        Recording.load(tmp_path / "none.mcap")
    with pytest.raises(FileError):
        Recording.load(tmp_path)


@pytest.mark.parametrize("last", [b"MCAP", b"joints", tick(0.0), tick(0.05), b"log_start", None])
def test_a_full_disk_ends_the_log_and_not_the_run(last, tmp_path, monkeypatch, eager):
    alone = simulate(SHORT, log=tmp_path / "run.mcap")
    data = (tmp_path / "run.mcap").read_bytes()
    room = len(data) - 20 if last is None else data.index(last)

    class Full:
        """A file on a disk with so much room."""

        def __init__(self, path):
            self.file, self.room = path.open("wb"), room

        def write(self, data):
            kept = data[: max(self.room, 0)]
            self.file.write(kept)
            self.file.flush()
            self.room -= len(data)
            if self.room < 0:
                raise OSError(errno.ENOSPC, "No space left on device")
            return len(data)

        def __getattr__(self, name):
            return getattr(self.file, name)

    monkeypatch.setattr(live_log, "_open", Full)
    run = simulate(SHORT, log=tmp_path / "run.mcap")
    assert run
    same(run, alone)
    assert run.metadata["log_fault"] == "No space left on device"
    assert "No space left" in run.explain("en")
    assert "No space left" in run.explain("ar")
    kept = {tick(0.05): 1, None: len(run.t)}.get(last, 0)
    if not kept:
        with pytest.raises(FileError):
            Recording.load(tmp_path / "run.mcap")
    else:
        back = Recording.load(tmp_path / "run.mcap")
        assert len(back.t) == kept
        assert np.array_equal(back.q, run.q[:kept])


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_device_that_is_always_full(tmp_path):
    (tmp_path / "full.mcap").symlink_to("/dev/full")
    run = simulate(SHORT, log=tmp_path / "full.mcap")
    assert run
    assert run.metadata["log_fault"]


def test_several_runs_of_one_log_keep_apart(tmp_path):
    other = mf.load("puma560")
    second = Scenario(robot=other, trajectory=rest(np.zeros(6), 0.03), law=computed_torque(other))
    with LiveLog(tmp_path / "runs.mcap") as log:
        runs = [
            simulate(SHORT, log=log),
            simulate(second, log=log),
            simulate(KINDS["compiled"][0], fused=True, log=log),
        ]
        assert not log.fault
    back = Recording.load_runs(tmp_path / "runs.mcap")
    assert len(back) == 3
    for one, its in zip(runs, back, strict=True):
        same(one, its)
        assert its.metadata == one.metadata
    with pytest.raises(FileError, match="3 runs"):
        Recording.load(tmp_path / "runs.mcap")
    with (tmp_path / "runs.mcap").open("rb") as file:
        times = [message.log_time for _, _, message in make_reader(file).iter_messages()]
    assert times == sorted(times)


JOB = """
robot = "planar2r"
[simulation]
step = 0.005
[[move]]
joints = [0.2, 0.1]
[[move]]
joints = [0.4, 0.1]
"""


def test_the_log_of_a_job_is_one_motion(tmp_path):
    run = solve(parse_job(JOB), JOB, Path(), log=tmp_path / "job.mcap")
    assert isinstance(run, Run)
    back = Recording.load(tmp_path / "job.mcap")
    same(run.recording, back)
    assert back.status is SimulationStatus.COMPLETED
    assert back.metadata["end"] == pytest.approx(run.plan.duration)
    part = (tmp_path / "job.mcap").read_bytes()
    (tmp_path / "part.mcap").write_bytes(part[: len(part) // 2])
    assert Recording.load(tmp_path / "part.mcap").status is SimulationStatus.LOG_TORN


def test_wrong_places_are_named(tmp_path, monkeypatch):
    for place in (tmp_path / "run.npz", tmp_path / "run", "run.MCAP"):
        with pytest.raises(InputError, match="mcap"):
            simulate(SHORT, log=place)
    with pytest.raises(FileError, match="cannot be written"):
        simulate(SHORT, log=tmp_path / "nowhere" / "run.mcap")
    with pytest.raises(InputError, match="log"):
        simulate(SHORT, log=3)
    with pytest.raises(InputError, match="duration"):
        LiveLog(tmp_path / "run.mcap", duration=-1.0)
    simulate(SHORT, log=tmp_path / "run.mcap")
    monkeypatch.setattr(live_log, "find_spec", lambda name: None)
    for action in (lambda: simulate(SHORT, log=tmp_path / "b.mcap"), lambda: Recording.load(tmp_path / "run.mcap")):
        with pytest.raises(MafsilError, match="mafsil\\[record\\]"):
            action()


def test_numbers_that_are_not_finite_come_back_as_they_were(tmp_path):
    with LiveLog(tmp_path / "run.mcap") as log:
        log.begin({})
        log.add({"t": np.arange(3.0), "x": ODD})
    (run,) = log_reading.logged_runs(tmp_path / "run.mcap")
    assert not run.ended
    assert run.rows()["x"].tobytes() == ODD.tobytes()


def fields(data: bytes):
    """Number, kind and value of each field of a message: the format read from its specification."""
    at = 0

    def varint():
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(data):
        key = varint()
        if key & 7 == 0:
            yield key >> 3, varint()
        else:
            length = 8 if key & 7 == 1 else varint()
            yield key >> 3, data[at : at + length]
            at += length


def test_the_descriptor_of_a_tick_tells_other_tools_what_its_messages_hold(tmp_path):
    run = simulate(KINDS["batch"][0], log=tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        found = list(make_reader(file, validate_crcs=True).iter_messages())
    schema, channel, _ = found[0]
    assert (schema.encoding, schema.name, channel.message_encoding) == ("protobuf", "mafsil.tick", "protobuf")
    ((_, file),) = fields(schema.data)
    about = dict(fields(file))
    assert (about[2], about[12]) == (b"mafsil", b"proto3")
    message = list(fields(about[4]))
    assert message[0] == (1, b"tick")
    described = [dict(fields(field)) for number, field in message if number == 2]
    assert [each[1].decode() for each in described] == list(run.arrays())
    assert all(each[5] == 1 for each in described), "doubles"
    for k, (_, _, each) in enumerate(found):
        values = dict(fields(each.data))
        for field in described:
            numbers = np.frombuffer(values[field[3]], dtype="<f8")
            array = run.arrays()[field[1].decode()][k]
            assert (field[4] == 3) is (array.ndim > 0), "arrays are repeated"
            assert np.array_equal(numbers, np.ravel(array))


def test_long_blocks_are_written_in_parts(tmp_path, monkeypatch):
    monkeypatch.setattr(live_log, "CHUNK", 2000)
    run = simulate(KINDS["compiled"][0], fused=True, log=tmp_path / "run.mcap")
    same(run, Recording.load(tmp_path / "run.mcap"))
    with (tmp_path / "run.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary.statistics.chunk_count >= 10
    assert summary.statistics.message_count == len(run.t)
