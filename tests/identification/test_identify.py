"""From noisy logs to better models: held-out torque, possible bodies, honest errors, what cannot be identified."""

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError, InputError
from mafsil.identification import MotionLog, identify
from mafsil.identification.regression import physically_consistent
from mafsil.identification.torque_model import TorqueModel
from mafsil.mechanics.friction import SMOOTHING
from tests.identification.simulated import different, noisy_log, torque_errors, write_csv

CASES = (
    ("panda", 0),
    ("panda", 1),
    ("ur5e", 2),
    ("puma560", 3),
    ("scara_rrrp", 4),
    ("planar2r", 5),
    ("stanford_arm", 6),
)


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]}-{case[1]}", scope="module")
def found(request):
    name, seed = request.param
    described, truth = different(name, seed)
    return described, truth, identify(described, noisy_log(truth, seed)), seed


@pytest.mark.capability("09-3")
def test_torque_on_unseen_motion_within_three_percent(found):
    described, truth, result, seed = found
    before, after = torque_errors(described, truth, seed), torque_errors(result.robot, truth, seed)
    assert after.max() < 3.0
    assert (after < before).all()
    assert result.validation.held_out
    assert (result.validation.after < 3.0).all()


@pytest.mark.capability("09-5", "09-29")
def test_every_body_is_possible_and_the_mass_matrix_positive_definite(found):
    _, _, result, seed = found
    robot = result.robot
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (2000, robot.n))
    assert np.linalg.eigvalsh(robot.mass_matrix(q)).min() > 0
    moving = {joint.child for joint in robot.mechanism.joints}
    for link, numbers in zip(robot.mechanism.links, robot.inertial_parameters, strict=True):
        assert link.name not in moving or link.inertial is None or physically_consistent(numbers)
    for joint in robot.mechanism.coordinates:
        assert joint.friction.viscous >= 0
        assert joint.friction.coulomb >= 0


def test_errors_are_as_large_as_the_standard_errors_say(found):
    """The sum of squares in units of the covariance has the mean of chi-square, k, and nearly its spread."""
    _, truth, result, _ = found
    true = result.base.combination @ TorqueModel(truth, SMOOTHING).prior
    wrong = np.array([parameter.value for parameter in result.parameters]) - true
    k = len(wrong)
    quality = wrong @ np.linalg.solve(result.covariance, wrong) / k
    assert 0.3 < quality < 1.0 + 6.0 * np.sqrt(2.0 / k)
    assert np.abs(wrong / np.sqrt(np.diag(result.covariance))).max() < 5.0


@pytest.mark.parametrize(("name", "inertial"), [("panda", 43), ("puma560", 36), ("ur5e", 36), ("planar2r", 6)])
def test_number_of_base_parameters_is_the_known_one(name, inertial):
    """Inertial base parameters as published (Gautier & Khalil: 36 for a PUMA), three of friction a joint besides."""
    robot = mf.load(name)
    base = TorqueModel(robot, SMOOTHING).base
    links = [
        label for label in base.labels if label.rpartition(".")[2] not in ("viscous", "coulomb", "offset", "rotor")
    ]
    assert len(links) == inertial == robot.base_parameters().count
    assert sum(label.endswith((".viscous", ".coulomb", ".offset")) for label in base.labels) == 3 * robot.n


def test_without_noise_everything_is_told_and_right():
    described, truth = different("planar2r", 7)
    result = identify(described, noisy_log(truth, 7, torque_noise=0.0, encoder=None))
    assert result.identifiable_count == len(result.parameters)
    true = result.base.combination @ TorqueModel(truth, SMOOTHING).prior
    after = np.array([parameter.after for parameter in result.parameters])
    assert np.abs(after - true).max() < 5e-3 * np.abs(true).max()
    assert torque_errors(result.robot, truth, 7).max() < 0.2


@pytest.mark.capability("09-3")
def test_rotors_are_found_and_asked_for_when_left_out():
    described, truth = different("ur5e", 8, rotors=True)
    log = noisy_log(truth, 8)
    without, with_rotors = identify(described, log), identify(described, log, rotor_inertia=True)
    assert any(remark.key == "identification.rotors" for remark in without.remarks)
    assert not any(remark.key == "identification.rotors" for remark in with_rotors.remarks)
    assert torque_errors(with_rotors.robot, truth, 8).max() < 3.0
    for joint, other in list(zip(with_rotors.robot.mechanism.coordinates, truth.mechanism.coordinates, strict=True))[
        3:
    ]:
        assert joint.actuator.reflected_inertia == pytest.approx(other.actuator.reflected_inertia, rel=0.2)
    known = identify(truth, log)
    assert [j.actuator.reflected_inertia > 0 for j in known.robot.mechanism.coordinates] == [True] * 6


def test_a_joint_that_stands_still_is_named_and_keeps_its_description():
    described, truth = different("panda", 9)
    result = identify(described, noisy_log(truth, 9, still=(6,)))
    text = result.explain()
    joint = described.joint_names[6]
    assert f"{joint} moved by only 0" in text
    unknown = {label for item in result.unidentifiable if item.reason == "log" for label in item.labels}
    assert f"{joint}.viscous" in unknown
    assert f"{joint}.coulomb" in unknown
    assert np.linalg.eigvalsh(result.robot.mass_matrix(np.zeros((1, 7)))).min() > 0


def test_what_no_motion_shows_is_said_in_words():
    described, truth = different("planar2r", 10)
    result = identify(described, noisy_log(truth, 10))
    text = result.explain("en")
    assert "the mass, mass times centre z" in text
    assert "of link1 never show in the efforts" in text
    never = {label for item in result.unidentifiable if item.reason == "never" for label in item.labels}
    assert never == set(TorqueModel(described, SMOOTHING).base.silent)
    assert "لا تظهر في العزوم قط" in result.explain("ar")
    assert "link2.m" in {
        label for item in result.unidentifiable if item.reason == "combination" for label in item.labels
    }


def test_a_description_without_masses_gets_them():
    described, truth = different("ur5e", 11)
    bare = tuple(replace(link, inertial=None) for link in described.mechanism.links)
    result = identify(mf.Robot(replace(described.mechanism, links=bare)), noisy_log(truth, 11))
    assert sum(remark.key == "identification.invented" for remark in result.remarks) == 6
    assert torque_errors(result.robot, truth, 11).max() < 3.0
    assert np.linalg.eigvalsh(result.robot.mass_matrix(np.zeros((1, 6)))).min() > 0


def test_gaps_and_uneven_sampling_are_said_and_do_no_harm():
    described, truth = different("planar2r", 12)
    log = noisy_log(truth, 12, duration=40.0)
    rng = np.random.default_rng(0)
    keep = rng.random(len(log.times)) > 0.1
    keep[12_000:13_000] = False
    signals = log.signals()
    rough = MotionLog(t=log.times[keep], q=signals["q"][keep], tau=signals["tau"][keep])
    result = identify(described, rough)
    assert [remark.key for remark in result.remarks][:1] == ["identification.gap"]
    assert "identification.uneven" in [remark.key for remark in result.remarks]
    assert torque_errors(result.robot, truth, 12).max() < 3.0


def test_measured_rates_are_used_unless_they_are_late():
    described, truth = different("planar2r", 13)
    log = noisy_log(truth, 13)
    q = log.signals()["q"]
    rates = np.gradient(q, log.times, axis=0)
    good = identify(described, replace(log, qd=rates))
    late = identify(described, replace(log, qd=np.roll(rates, 200, axis=0)))
    assert not any(remark.key == "identification.rates_ignored" for remark in good.remarks)
    assert any(remark.key == "identification.rates_ignored" for remark in late.remarks)
    for result in (good, late):
        assert torque_errors(result.robot, truth, 13).max() < 3.0


def test_several_logs_and_another_for_validation(tmp_path):
    described, truth = different("planar2r", 14)
    first, second, third = (noisy_log(truth, seed, duration=12.0) for seed in (1, 2, 3))
    write_csv(third, described, tmp_path / "third.csv")
    result = identify(described, [first, second], validation=tmp_path / "third.csv")
    assert (result.validation.after < 3.0).all()
    one = identify(described, first, held_out=0.0)
    assert not one.validation.held_out
    assert "nothing was held out" in one.explain()
    assert result.rows > 1.5 * one.rows


def test_better_robots_are_saved_and_read_back(tmp_path):
    described, truth = different("ur5e", 15, rotors=True)
    result = identify(described, noisy_log(truth, 15, duration=12.0), rotor_inertia=True)
    lost = result.save(tmp_path / "better.urdf")
    assert {remark.details["loss"].what for remark in lost} == {"actuator", "friction"}
    again = mf.load(tmp_path / "better.urdf")
    assert np.allclose(
        again.inertial_parameters[: len(result.robot.inertial_parameters)].sum(), result.robot.inertial_parameters.sum()
    )
    assert again.mechanism.coordinates[2].friction.viscous == pytest.approx(
        result.robot.mechanism.coordinates[2].friction.viscous
    )
    (remark,) = result.save(tmp_path / "better.toml")
    assert "shapes" in str(remark.details["loss"])
    q = np.random.default_rng(0).uniform(-2, 2, (3, 5, 6))
    same = mf.load(tmp_path / "better.toml")
    assert np.allclose(same.torque_terms(*q).total, result.robot.torque_terms(*q).total)
    with pytest.raises(FileError, match=r"\.urdf or \.toml"):
        result.save(tmp_path / "better.xml")
    with pytest.raises(FileError, match="cannot be written"):
        result.save(tmp_path / "nowhere" / "better.urdf")


def test_wrong_logs_are_refused_with_the_row():
    robot = mf.load("planar2r")
    t, q = np.arange(100.0), np.zeros((100, 2))
    broken = q.copy()
    broken[17, 1] = np.nan
    with pytest.raises(InputError, match="row 17: tau is nan"):
        MotionLog(t=t, q=q, tau=broken)
    with pytest.raises(InputError, match=r"row 5: the time 4\.0 s does not come after 4\.0 s"):
        MotionLog(t=np.where(t == 5, 4.0, t), q=q, tau=q)
    with pytest.raises(InputError, match="tau"):
        MotionLog(t=t, q=q, tau=q[:, :1])
    with pytest.raises(InputError, match="3 joint columns"):
        identify(robot, MotionLog(t=t, q=np.zeros((100, 3)), tau=np.zeros((100, 3))))
    with pytest.raises(InputError, match="too short"):
        identify(robot, MotionLog(t=t[:4], q=q[:4], tau=q[:4]))
    with pytest.raises(InputError, match="log"):
        identify(robot, 3.0)
    with pytest.raises(InputError, match="list of logs is empty"):
        identify(robot, [])
    for wrong in ({"held_out": 0.95}, {"held_out": -1}, {"bandwidth": 0}, {"prior_spread": -1}, {"smoothing": 0}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            identify(robot, MotionLog(t=t, q=q, tau=q), **wrong)


def test_a_robot_that_stands_still_tells_nothing():
    robot = mf.load("planar2r")
    t = np.arange(2000) * 1e-3
    result = identify(robot, MotionLog(t=t, q=np.full((2000, 2), 0.3), tau=np.full((2000, 2), 1.0)))
    assert result.identifiable_count <= 4
    assert sum(remark.key == "identification.hardly_moved" for remark in result.remarks) == 2
    assert np.isfinite([p.value for p in result.parameters]).all()
    assert np.linalg.eigvalsh(result.robot.mass_matrix(np.zeros((1, 2)))).min() > 0
