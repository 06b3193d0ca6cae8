"""Pictures of one joint: what they show, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil import figures
from mafsil import one_joint as oj
from mafsil.errors import InputError

LOCUS = oj.root_locus([0.5, 2.1, 2.205, 0.0], [1.0], np.linspace(0, 12, 100))
ARM = oj.JointArm.of(inertia=0.5, mass=1.0, radius=0.1, friction=0.1)


def run_of(ki):
    return oj.simulate_joint(ARM, oj.JointLaw.pid(2.205, ki, 2.0), 0.0, duration=2.0, start=-np.pi / 2, step=0.01)


def texts(path):
    """The words of an SVG file, which matplotlib leaves as comments beside their outlines."""
    return path.read_text()


@pytest.mark.capability("10-29")
def test_the_locus_has_its_meetings_crossings_and_responses(tmp_path):
    figures.plot_root_locus(LOCUS, tmp_path / "a.svg", gains=[0.3, 0.686, 9.261], start=[1.0, 0.0, -4.41])
    words = texts(tmp_path / "a.svg")
    for said in ("K = 0.3", "K = 9.261", "Re s [1/s]", "meet", "cross"):
        assert said in words
    figures.plot_root_locus(LOCUS, tmp_path / "b.png", language="ar")
    assert (tmp_path / "b.png").stat().st_size > 5000
    figures.plot_root_locus(LOCUS, tmp_path / "c.svg", gains=[0.3, 0.686, 9.261], start=[1.0, 0.0, -4.41])
    assert texts(tmp_path / "c.svg") == words


@pytest.mark.capability("10-27", "10-108")
def test_a_measured_response(tmp_path):
    t = np.linspace(0, 3, 400)
    e = oj.SecondOrder.of(6.0, 0.3).response(t)
    figures.plot_error_response(t, e, tmp_path / "a.svg")
    measured = oj.measure_response(t, e)
    assert f"{float(measured.settling_time):.4g}" in texts(tmp_path / "a.svg")
    assert f"{100 * float(measured.overshoot):.4g} %" in texts(tmp_path / "a.svg")
    assert "steady error" in texts(tmp_path / "a.svg")
    figures.plot_error_response(t[:20], e[:20], tmp_path / "cut.svg")  # does not come to rest: no such line
    assert "steady error" not in texts(tmp_path / "cut.svg")


@pytest.mark.capability("10-34", "10-41")
def test_runs_side_by_side_and_the_parts_of_one(tmp_path):
    figures.plot_joint_runs({"PD": run_of(0.0), "PID": run_of(1.0)}, tmp_path / "a.svg")
    assert "PID" in texts(tmp_path / "a.svg")
    figures.plot_joint_runs({"PID": run_of(1.0)}, tmp_path / "b.png", language="ar")
    assert (tmp_path / "b.png").stat().st_size > 5000


@pytest.mark.capability("10-16")
def test_the_six_laws_of_friction(tmp_path):
    laws = {
        "viscous": oj.drives.SpeedFriction.viscous_only(0.5),
        "Coulomb": oj.drives.SpeedFriction.coulomb(0.6),
        "static and viscous": oj.drives.SpeedFriction.static_viscous(0.6, 0.3),
        "static and kinetic": oj.drives.SpeedFriction.static_kinetic(0.9, 0.6),
        "all three": oj.drives.SpeedFriction.static_kinetic_viscous(0.9, 0.6, 0.3),
        "Stribeck": oj.drives.SpeedFriction.stribeck(0.9, 0.6, 0.1, 0.05),
    }
    figures.plot_friction_laws(laws, tmp_path / "a.svg")
    assert all(name in texts(tmp_path / "a.svg") for name in laws)


def test_what_is_no_such_thing_is_refused(tmp_path):
    file = tmp_path / "a.svg"
    for action in (
        lambda: figures.plot_root_locus(3, file),
        lambda: figures.plot_root_locus(LOCUS, file, gains=[13.0]),
        lambda: figures.plot_root_locus(LOCUS, file, gains=[np.nan]),
        lambda: figures.plot_root_locus(LOCUS, tmp_path / "a.txt"),
        lambda: figures.plot_error_response([0, 1], [np.nan, 0], file),
        lambda: figures.plot_error_response(np.zeros((2, 3)), np.zeros((2, 3)), file),
        lambda: figures.plot_joint_runs({}, file),
        lambda: figures.plot_joint_runs({"a": 3}, file),
        lambda: figures.plot_joint_runs({"two": run_of([0.0, 1.0])}, file),
        lambda: figures.plot_friction_laws({str(k): oj.drives.SpeedFriction.coulomb(1.0) for k in range(7)}, file),
        lambda: figures.plot_friction_laws({"a": 3}, file),
    ):
        with pytest.raises(InputError):
            action()
    assert not file.exists()
