"""Every profile on the same way: shortest durations by formula, shares of limits, honest infinities."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import InputError
from mafsil.figures import plot_profiles
from mafsil.trajectory import MotionLimits, check, compare_profiles
from mafsil.trajectory.profiles import LAWS

LIMITS = MotionLimits.of(2, velocity=[1.0, 2.0], acceleration=(-2.0, 3.0), jerk=20.0)
POINTS = [[0.0, 0.0], [1.5, -0.4], [0.2, 0.6]]


@pytest.mark.parametrize("points", [POINTS, POINTS[:2]])
def test_each_profile_uses_a_limit_fully_and_none_more(points):
    found = compare_profiles(points, LIMITS)
    assert found
    assert {run.name for run in found} == {*LAWS, "jerk_limited", "time_optimal"}
    assert [run.duration for run in found] == sorted(run.duration for run in found)
    for run in found:
        motion = run.trajectory
        np.testing.assert_allclose(motion.at([0.0, motion.duration]).u, [points[0], points[-1]], atol=1e-9)
        assert max(run.velocity, run.acceleration) <= 1.0 + 1e-9
        if run.name not in ("time_optimal", "jerk_limited"):  # these know both directions; laws keep the lesser limit
            own = MotionLimits.of(2, velocity=[1.0, 2.0], acceleration=2.0)
            # The exponential law begins at a speed, and is said to exceed the acceleration.
            assert check(motion, own, tolerance=1e-9) or run.name == "exponential"
            assert ("acceleration" in run.exceeds) == (run.name == "exponential")
        assert bool(check(motion, LIMITS, tolerance=1e-6)) == (not run.exceeds)
        assert run.jerk == np.inf or run.jerk > 0.0
    assert found["jerk_limited"].jerk <= 20.0 * (1 + 1e-9)
    assert found["quintic"].jerk < np.inf == found["trapezoid"].jerk
    assert np.isnan(found["quintic"].effort)
    assert "effort" not in found.explain()


def test_by_hand():
    """1 rad with |v| <= 10 and |a| <= 4: bang-bang 2 sqrt(1/4), cubic sqrt(6/4), quintic sqrt(10/sqrt(3)/4)."""
    found = compare_profiles([[0.0], [1.0]], MotionLimits.of(1, velocity=10.0, acceleration=4.0))
    expected = {"bang_bang": 1.0, "time_optimal": 1.0, "cubic": 1.5**0.5, "quintic": (10 / 3**0.5 / 4) ** 0.5}
    for name, duration in expected.items():
        assert found[name].duration == pytest.approx(duration, rel=1e-9)
    assert "jerk_limited" not in {run.name for run in found}, "nothing limits the jerk"


def test_efforts_are_those_of_the_robot():
    robot = mf.load("panda")
    q = np.array([[0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.5], [0.6, -0.2, 0.3, -1.4, 0.2, 1.9, 0.1]])
    found = compare_profiles(q, robot)
    run = found["quintic"]
    t = np.linspace(0.0, run.duration, 501)
    here = run.trajectory.at(t)
    tau = robot.inverse_dynamics(here.u, here.v, here.a) + robot.friction_torque(here.v)
    used = np.abs(tau) / robot.limits.effort
    assert run.effort == pytest.approx(used.max(), rel=1e-3)
    assert run.mean_effort == pytest.approx(np.sqrt(np.mean(used.max(axis=1) ** 2)), rel=1e-2)
    weak = MotionLimits.of(7, velocity=50.0, acceleration=500.0)
    strong = compare_profiles(q, weak, robot=robot)
    assert not strong
    assert "%" in strong.explain("en")
    assert strong.explain("ar") != strong.explain("en")
    assert json.dumps(found.to_dict()["status"])


@pytest.mark.parametrize(
    ("points", "limits", "name"),
    [
        ([[0.0, 0.0]], LIMITS, "points"),
        ([[0.0, 0.0], [np.nan, 1.0]], LIMITS, "points"),
        ([[1.0, 1.0], [1.0, 1.0]], LIMITS, "points"),
        (POINTS, MotionLimits.of(2, velocity=1.0), "limits"),
        (POINTS, MotionLimits.of(3, velocity=1.0, acceleration=1.0), "limits"),
    ],
)
def test_what_is_no_question_is_refused(points, limits, name):
    with pytest.raises(InputError, match=name):
        compare_profiles(points, limits)


def test_the_command_and_the_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file, picture = tmp_path / "points.csv", tmp_path / "profiles.svg"
    file.write_text("q1,q2,q3,q4,q5,q6\n0,-1,1,0,0.5,0\n0.8,-0.8,1.1,0.1,0.5,0.2\n")
    command = ["trajectory", "compare", "ur5e", str(file), "--acceleration", "5", "--jerk", "50"]
    assert main([*command, "--out", str(picture)]) == 0
    assert "jerk_limited" in capsys.readouterr().out
    assert picture.stat().st_size > 10_000
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["runs"]["quintic"]["acceleration"] == pytest.approx(1.0)
    assert main([*command[:4], "--curve", "stops"]) == 2
    with pytest.raises(InputError):
        plot_profiles(compare_profiles(POINTS, LIMITS), picture, coordinate=2)
