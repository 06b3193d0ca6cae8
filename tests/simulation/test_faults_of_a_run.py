"""Whatever a law, a sensor, a gain or a user does: the run ends safely, says what it was, and keeps what it had."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import SpringDamper, TaskCoordinates, Wall, add_delay, computed_torque, pid, task_computed_torque
from mafsil.control.contact import virtual_environment
from mafsil.control.laws import TipOfJoints
from mafsil.errors import InputError
from mafsil.simulation import Plant, Recording, Scenario, simulate
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest

ARM = mf.load("planar2r")
PATH = quintic([0.2, 0.9], [0.6, 0.5], 0.3)
BAD = 120
"""Tick at which things go wrong."""


class Faulty:
    """Computed torque until a tick, then something else."""

    def __init__(self, wrong):
        self.inner, self.wrong = computed_torque(ARM), wrong

    def __call__(self, t, q, qd, reference):
        right = self.inner(t, q, qd, reference)
        return self.wrong(right) if t > BAD * 1e-3 - 1e-9 else right

    def session(self, period):
        return self


def _raise(error):
    raise error


def _run(law=None, **options):
    return simulate(Scenario(**{"robot": ARM, "trajectory": PATH, "law": law or computed_torque(ARM)} | options))


def _kept(run, folder, ticks=BAD):
    """All ticks before the fault are there, finite, the same as without it, and on disk."""
    good = _run()
    assert not run
    assert len(run.t) == ticks
    assert np.array_equal(run.q, good.q[:ticks])
    assert all(np.isfinite(array).all() for array in run.arrays().values())
    run.save(folder / "run")
    again = Recording.load(folder / "run")
    assert again.status is run.status
    assert again.explain("en") == run.explain("en")
    assert run.explain("ar") != run.explain("en")


@pytest.mark.capability("10-2")
@pytest.mark.parametrize(
    ("wrong", "status", "words"),
    [
        (lambda x: _raise(RuntimeError("out of order")), "LAW_RAISED", "RuntimeError: out of order"),
        (lambda x: np.linalg.inv(np.zeros((2, 2))), "LAW_RAISED", "LinAlgError"),
        (lambda x: x[:1], "LAW_NONSENSE", "(1,) float64"),
        (lambda x: x + 0j, "LAW_NONSENSE", "complex128"),
        (lambda x: x.tolist(), "LAW_NONSENSE", "list"),
        (lambda x: None, "LAW_NONSENSE", "NoneType"),
        (lambda x: x.astype(object), "LAW_NONSENSE", "object"),
        (lambda x: x * np.inf, "NOT_FINITE", "not finite"),
        (lambda x: x * np.nan, "NOT_FINITE", "not finite"),
        (lambda x: _raise(KeyboardInterrupt), "INTERRUPTED", "Ctrl-C"),
    ],
)
def test_laws_that_fail_are_named(wrong, status, words, tmp_path):
    run = _run(Faulty(wrong))
    assert run.status is SimulationStatus[status]
    assert words in run.explain("en")
    assert words.startswith("not") or words == "Ctrl-C" or "Faulty" in run.explain("en")
    _kept(run, tmp_path)


def test_infinite_efforts_are_no_saturation(tmp_path):
    limited = mf.load("panda")
    start = np.array([0, -0.4, 0, -1.8, 0, 1.6, 0.5])

    class Endless:
        def __call__(self, t, q, qd, reference):
            return np.full_like(q, np.inf)

        def session(self, period):
            return self

    run = simulate(Scenario(robot=limited, trajectory=rest(start, 0.1), law=Endless()))
    assert run.status is SimulationStatus.NOT_FINITE
    assert len(run.t) == 0
    run.save(tmp_path / "empty")
    assert Recording.load(tmp_path / "empty").explain() == run.explain()


def test_a_law_that_fails_at_once_leaves_an_empty_recording_and_nonsense_an_error():
    run = _run(add_delay(Faulty(lambda x: _raise(ValueError("no"))), 0.0), duration=0.3)
    assert run.metadata["law"] == "Faulty"
    assert len(run.t) == BAD

    class Wrong(Faulty):
        def __call__(self, t, q, qd, reference):
            return 1j * q

    with pytest.raises(InputError, match="complex"):
        _run(Wrong(None))


def test_a_sensor_without_numbers_is_named(tmp_path):
    class Broken:
        seed = 0

        def drawn(self, ticks, shape):
            noise = np.zeros((2, ticks, *shape))
            noise[0, BAD, 1] = np.nan
            return noise[0], noise[1]

    run = _run(noise=Broken())
    assert run.status is SimulationStatus.BLIND
    assert ARM.joint_names[1] in run.explain("en")
    _kept(run, tmp_path)


def test_unstable_gains_end_at_the_last_good_state():
    run = _run(pid(2, kp=1e6, kd=0.0), q=[0.3, 0.9], duration=5.0, saturate=False)
    assert run.status is SimulationStatus.BLOWN_UP
    assert "lower gains" in run.explain("en")
    assert np.isfinite(run.q).all()
    assert len(run.t) > 1


def test_a_singular_pose_is_named():
    through = quintic([0.4, 0.1], [0.2, -0.1], 0.5)
    task = TaskCoordinates(rows=(3, 4))
    run = _run(task_computed_torque(ARM, TipOfJoints(ARM, through), coordinates=task), trajectory=through)
    assert np.abs(run.qd).max() > 100.0
    assert "Near a singularity" in run.explain("en")
    assert run.metadata["near_singular"]["ratio"] < 0.02
    fine = _run(Faulty(lambda x: x * np.nan))
    assert "singular" not in fine.explain("en")


def test_saturated_actuators_are_named_with_their_share():
    arm = mf.load("panda")
    goal = np.array([0, -0.4, 0, -1.8, 0, 1.6, 0.5])
    run = simulate(Scenario(robot=arm, trajectory=quintic(goal, goal + 0.8, 0.25), law=computed_torque(arm)))
    shares = run.saturated.mean(axis=0)
    worst = int(shares.argmax())
    assert shares[worst] > 0.05
    assert f"{arm.joint_names[worst]} during {100 * shares[worst]:.3g} % of the run" in run.explain("en")
    calm = simulate(Scenario(robot=arm, trajectory=rest(goal, 0.1), law=computed_torque(arm)))
    assert "clipped" not in calm.explain("en")


@pytest.mark.capability("10-69")
def test_contact_that_chatters_is_named_and_ends():
    floor = float(ARM.forward_kinematics(np.array([0.4, 1.1]))[1, 3])
    wall = Wall(np.array([0, floor, 0]), np.array([0, 1.0, 0]), stiffness=1e5, damping=3000.0)

    class Down:
        def __call__(self, t, q, qd, reference):
            J = ARM.jacobian_body(q)
            R = ARM.forward_kinematics(q)[:3, :3]
            return ARM.gravity_torque(q) + J[3:].T @ (R.T @ [0, -200.0, 0]) - 0.5 * qd

        def session(self, period):
            return self

    plant = Plant(ARM, environment=wall)
    run = simulate(Scenario(robot=ARM, plant=plant, trajectory=rest([0.4, 1.1], 0.6), law=Down(), q=[0.405, 1.1]))
    touching = run.contact_wrench.any(axis=-1)
    assert int((touching[1:] & ~touching[:-1]).sum()) > 8
    assert "Contact chatter" in run.explain("en")
    assert np.isfinite(run.q).all()
    soft = Plant(ARM, environment=Wall(wall.point, wall.normal, stiffness=2e3, damping=400.0))
    calm = simulate(Scenario(robot=ARM, plant=soft, trajectory=rest([0.4, 1.1], 0.6), law=Down(), q=[0.405, 1.1]))
    assert "Contact chatter" not in calm.explain("en")


def test_contact_that_is_too_stiff_for_the_step_is_named():
    """A ball of mass m bounces off a spring k within pi sqrt(m/k): 0.3 steps here, then 30."""
    floor = float(ARM.forward_kinematics(np.array([0.4, 1.1]))[1, 3])

    def dropped(stiffness, step=1e-3):
        wall = Wall(np.array([0, floor - 0.01, 0]), np.array([0, 1.0, 0]), stiffness=stiffness)
        law = virtual_environment(ARM, SpringDamper([0, 0, 0], stiffness=[0.0, 80.0, 0.0]))
        plant = Plant(ARM, friction=False, environment=wall)
        return simulate(
            Scenario(robot=ARM, plant=plant, trajectory=rest([0.4, 1.1], 0.5), law=law, step=step, saturate=False)
        )

    stiff, sound = dropped(1e8), dropped(1e4)
    for run in (stiff, sound):
        touching = run.contact_wrench.any(axis=-1)
        assert int((touching[1:] & ~touching[:-1]).sum()) >= 1
    assert "too stiff for the step" in stiff.explain("en")
    assert "too stiff" not in sound.explain("en")
    assert stiff.explain("ar") != sound.explain("ar")


def test_ctrl_c_leaves_the_results_of_what_was_simulated(tmp_path):
    job = tmp_path / "long.toml"
    job.write_text('robot = "planar2r"\n[[move]]\njoints = [0.5, 0.5]\n[[move]]\npause = 100.0\n')
    words = [
        sys.executable,
        "-m",
        "mafsil",
        "run",
        str(job),
        "--real-time",
        "--progress",
        "--out",
        str(tmp_path / "out"),
    ]
    with subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stderr:
            if "simul" in line:
                break
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Ctrl-C" in out
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert results["status"] == "stopped"
    tape = Recording.load(Path(tmp_path / "out" / "recording"))
    assert tape.status is SimulationStatus.INTERRUPTED
    assert 0.1 < tape.t[-1] < 60.0
    assert (tmp_path / "out" / "report.html").exists()


def test_a_law_cannot_write_into_the_state_of_the_arm_or_the_reference():
    """q *= 2 doubled the arm's own angles, and the recording said that the motion blew up."""
    arm, q = mf.load("planar2r"), np.array([0.3, 0.8])

    class Writing:
        def __init__(self, change):
            self.change = change

        def __call__(self, t, q, qd, reference):
            if t > 0.01:
                self.change(q, qd, reference)
            return np.zeros(2)

        def session(self, period):
            return self

    changes = (lambda q, qd, r: q.__imul__(2), lambda q, qd, r: qd.fill(0.0), lambda q, qd, r: r.u.__isub__(q))
    for change in changes:
        scenario = mf.Scenario(robot=arm, trajectory=rest(q, 0.05), law=Writing(change))
        run = mf.simulate(scenario)
        assert run.status is SimulationStatus.LAW_RAISED
        assert "read-only" in run.explain("en")
        assert len(run.t) == 11
        np.testing.assert_array_equal(run.q_ref, np.tile(q, (11, 1)))


@pytest.mark.capability("10-2")
def test_a_plain_function_drives_an_arm_and_is_named():
    def pd(t, q, qd, reference):
        return 400.0 * (reference.u - q) + 40.0 * (reference.v - qd) + ARM.gravity_torque(q)

    run = simulate(Scenario(robot=ARM, trajectory=PATH, law=pd))
    assert run
    assert run.metadata["law"] == "pd"
    late = simulate(Scenario(robot=ARM, trajectory=PATH, law=add_delay(lambda t, q, qd, u: q[[3]], 2e-3)))
    assert late.status is SimulationStatus.LAW_RAISED
    assert "IndexError" in late.explain("en")
    with pytest.raises(InputError, match="reference"):
        Scenario(robot=ARM, trajectory=PATH, law=lambda t, q: q)
