"""Drives from catalogues: against every choice, at scale, with reasons, and against the closed form of one joint."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import mafsil as mf
from mafsil.design import Catalogue, ParametricArm, fit_drives, pick_drives
from mafsil.design.drives import REASONS
from tests.design.test_arm import TABLE


def random_catalogue(count: int, seed: int, weakest: float = 20.0) -> Catalogue:
    rng = np.random.default_rng(seed)
    torque = np.exp(rng.uniform(np.log(weakest), np.log(1500), count))
    ratio = rng.choice([50.0, 80.0, 100.0, 160.0], count)
    peak = torque / ratio
    return Catalogue(
        name=tuple(f"d{k}" for k in range(count)), peak_torque=peak,
        continuous_torque=peak * rng.uniform(0.3, 0.6, count),
        speed=rng.uniform(200, 700, count), rotor_inertia=1e-5 * torque**0.8 / 30, ratio=ratio,
        efficiency=rng.uniform(0.65, 0.9, count),
        mass=np.round(0.6 * (torque / 20) ** 0.6 * rng.uniform(0.8, 1.3, count), 2),
        backlash=rng.uniform(0, 3e-4, count), cost=np.round(50 * torque**0.5 * rng.uniform(0.7, 1.4, count)),
    )  # fmt: skip


def duty(n: int, seed: int, count: int = 40) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A periodic motion of all joints."""
    rng, t = np.random.default_rng(seed), np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    a, p, w = rng.uniform(0.3, 0.9, n), rng.uniform(0, 6, n), rng.integers(1, 3, n)
    return a * np.sin(w * t + p) - 0.3, a * w * np.cos(w * t + p), -a * w**2 * np.sin(w * t + p)


def planar(n: int) -> mf.design.ArmDesign:
    tube = {"outer": 0.08, "wall": 0.004}
    joints = [{"a": 0.4 if k else 0.0, "tube": tube, "drive": {"mass": 2.0}} for k in range(n)]
    table = {"convention": "modified", "gravity": [0.0, -9.81, 0.0], "joint": joints, "tool": {"xyz": [0.3, 0.0, 0.0]}}
    return ParametricArm.of(table).at()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("goal", ["mass", "cost"])
def test_choice_is_the_best_of_all(seed: int, goal: str) -> None:
    """Every choice of a catalogue of twenty for three joints, each judged by the robot that has those drives."""
    arm, catalogue, motion = planar(3), random_catalogue(20, seed), duty(3, seed)
    found = pick_drives(arm, catalogue, *motion, payload=4.0, goal=goal)
    weight = getattr(catalogue, goal)
    # Efforts of all masses from robots: linear in the two drives that move.
    tau = {}
    for m2, m3 in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
        table = {
            "convention": "modified", "gravity": [0.0, -9.81, 0.0], "tool": {"xyz": [0.3, 0.0, 0.0]},
            "joint": [{"a": 0.4 if k else 0.0, "tube": {"outer": 0.08, "wall": 0.004}, "drive": {"mass": m}}
                      for k, m in enumerate((0.0, m2, m3))],
        }  # fmt: skip
        robot = ParametricArm.of(table).robot().with_payload(4.0, com=(0, 0, 0))
        tau[m2, m3] = robot.inverse_dynamics(*motion)
    base, first, second = tau[0, 0], tau[1, 0] - tau[0, 0], tau[0, 1] - tau[0, 0]

    def serves(k: int, joint: int, effort: np.ndarray) -> bool:
        c, w = catalogue, motion[1][:, joint]
        G, eta = c.ratio[k], c.efficiency[k]
        m = effort / G * np.where(effort * w >= 0, 1 / eta, eta) + c.rotor_inertia[k] * G * motion[2][:, joint]
        return bool(
            abs(m).max() <= c.peak_torque[k] and np.sqrt((m**2).mean()) <= c.continuous_torque[k]
            and G * abs(w).max() <= c.speed[k]
        )  # fmt: skip

    best = np.inf
    for row in product(range(20), repeat=2):
        j2, j3 = row
        m2, m3 = catalogue.mass[j2], catalogue.mass[j3]
        effort = base + m2 * first + m3 * second
        if not serves(j3, 2, effort[:, 2]) or not serves(j2, 1, effort[:, 1]):
            continue
        for j1 in range(20):
            if weight[j1] + weight[j2] + weight[j3] < best and serves(j1, 0, effort[:, 0]):
                best = float(weight[j1] + weight[j2] + weight[j3])
    assert found.total == pytest.approx(best)
    assert bool(found) == np.isfinite(best)
    if found:
        assert found.status.name == "BEST"
        assert max(found.peak.max(), found.heat.max(), found.speed.max()) <= 1 + 1e-9


def test_thousand_drives_for_six_joints() -> None:
    arm = ParametricArm.of(TABLE).at(upper=0.5)
    found = pick_drives(arm, random_catalogue(1000, 7, weakest=2.0), *duty(6, 1, 100), payload=5.0)
    assert found.status.name == "BEST"
    assert found.nodes < 2000
    lighter = found.catalogue.mass < found.mass[5]
    assert (found.reasons[5][lighter] > 0).all()


def test_chosen_drives_are_what_the_fitted_arm_has() -> None:
    """The efforts of the arm with its drives, by its own kernels, are within what the drives give."""
    arm, motion = ParametricArm.of(TABLE), duty(6, 1, 100)
    choice = pick_drives(arm.at(upper=0.5), random_catalogue(200, 3, weakest=2.0), *motion, payload=5.0)
    assert choice
    fitted = fit_drives(arm, choice).at(upper=0.5)
    rows, c = choice.chosen, choice.catalogue
    assert fitted.mass - arm.at(upper=0.5).mass == pytest.approx(choice.total - (5 + 5 + 3 + 1 + 1))
    rigid = fitted.robot.with_payload(5.0, com=(0, 0, 0)).inverse_dynamics(*motion)
    rotors = c.rotor_inertia[rows] * c.ratio[rows] ** 2 * motion[2]
    tau = rigid - rotors
    loss = np.where(tau * motion[1] >= 0, 1 / c.efficiency[rows], c.efficiency[rows])
    motor = tau * loss / c.ratio[rows] + c.rotor_inertia[rows] * c.ratio[rows] * motion[2]
    np.testing.assert_allclose(np.abs(motor).max(axis=0) / c.peak_torque[rows], choice.peak, rtol=1e-9)
    np.testing.assert_allclose(np.sqrt((motor**2).mean(axis=0)) / c.continuous_torque[rows], choice.heat, rtol=1e-9)
    assert (np.abs(motion[1]).max(axis=0) <= fitted.robot.limits.velocity).all()
    with pytest.raises(mf.InputError, match="drives"):
        fit_drives(ParametricArm.of({"convention": "modified", "joint": [{}]}), choice)


def test_one_joint_against_the_closed_form_of_reductions() -> None:
    """`size_drive` gives the interval of ratios; a catalogue of one motor with many gears must agree."""
    arm, motion = planar(1), duty(1, 2)
    ratios = np.geomspace(5, 500, 60)
    motor = {"peak_torque": 1.2, "continuous_torque": 0.5, "speed": 400.0, "rotor_inertia": 3e-5, "efficiency": 0.8}
    rows = [{"name": f"g{k}", **motor, "ratio": G, "mass": 1 + 0.01 * k} for k, G in enumerate(ratios)]
    found = pick_drives(arm, Catalogue.of(rows), *motion, payload=3.0)
    tau = arm.robot.with_payload(3.0, com=(0, 0, 0)).inverse_dynamics(*motion)[:, 0]
    rating = mf.one_joint.drives.MotorRating.of(1.2, 0.5, 400.0, 3e-5)
    sized = mf.one_joint.size_drive(rating, tau, motion[1][:, 0], motion[2][:, 0], efficiency=0.8)
    np.testing.assert_array_equal(found.reasons[0] == 0, (ratios >= sized.least) & (ratios <= sized.most))
    assert found.names == (f"g{int(np.flatnonzero(ratios >= sized.least)[0])}",)


def test_reasons_and_no_choice() -> None:
    arm, motion = planar(2), duty(2, 0)
    weak = {
        "peak_torque": 0.01,
        "continuous_torque": 0.01,
        "speed": 1e3,
        "rotor_inertia": 0.0,
        "efficiency": 1.0,
        "ratio": 50.0,
    }
    rows = [
        {"name": "weak", **weak, "mass": 0.1},
        {"name": "slow", **weak, "mass": 0.1, "speed": 1.0},
        {"name": "hot", **weak, "mass": 0.1, "peak_torque": 100.0},
        {"name": "loose", **weak, "mass": 0.1, "peak_torque": 100.0, "continuous_torque": 100.0, "backlash": 0.1},
    ]
    none = pick_drives(arm, Catalogue.of(rows), *motion, backlash=0.01)
    assert not none
    assert none.joint == "joint2"
    assert none.rejected["joint2"] == dict(
        zip(("weak", "slow", "hot", "loose"), ("too_weak", "too_fast", "overheats", "too_much_backlash"), strict=True)
    )
    assert "joint2" in none.explain()
    assert "joint2" in none.explain("ar")
    assert pick_drives(arm, Catalogue.of(rows), *motion).names == ("loose", "loose")
    stopped = pick_drives(arm, Catalogue.of(rows), *motion, max_nodes=1)
    assert not stopped
    assert stopped.status.name == "STOPPED"
    assert set(REASONS) > set(none.rejected["joint1"].values())


def test_files_and_wrong_arguments(tmp_path) -> None:
    head = "name;peak_torque;continuous_torque;speed;rotor_inertia;ratio;efficiency;mass"
    csv = tmp_path / "drives.csv"
    csv.write_text(f"{head}\nA-1;2;1;300;1e-5;100;0.8;1.5\nB-2;4;2;300;2e-5;100;0.8;2.5\n")
    read = Catalogue.of(csv)
    assert read.name == ("A-1", "B-2")
    assert read.mass.tolist() == [1.5, 2.5]
    toml = tmp_path / "drives.toml"
    toml.write_text("".join(
        f'[[drive]]\nname = "{k}"\npeak_torque = 2\ncontinuous_torque = 1\nspeed = 300\nrotor_inertia = 1e-5\n'
        "ratio = 100\n"
        f"efficiency = 0.8\nmass = 1.5\n" for k in "ab"
    ))  # fmt: skip
    assert len(Catalogue.of(toml)) == 2
    csv.write_text(head.replace(";mass", "") + "\nA;2;1;300;1e-5;100;0.8\n")
    with pytest.raises(mf.FileError, match="mass"):
        Catalogue.of(csv)
    csv.write_text(f"{head}\nA;2;1;300;1e-5;100;1.8;1\n")
    with pytest.raises(mf.InputError, match="efficiency"):
        Catalogue.of(csv)
    with pytest.raises(mf.FileError, match="ratio"):
        Catalogue.of([{"name": "a", "peak_torque": 1, "continuous_torque": 1, "speed": 1, "rotor_inertia": 1}])
    arm, motion = planar(2), duty(2, 0)
    with pytest.raises(mf.InputError, match="goal"):
        pick_drives(arm, read, *motion, goal="beauty")  # type: ignore[arg-type]
    with pytest.raises(mf.InputError):
        pick_drives(arm, read, motion[0], motion[1][:5], motion[2])
    with pytest.raises(mf.InputError, match="backlash"):
        pick_drives(arm, read, *motion, backlash=-1.0)
