"""Loads at the tip from motion and from poses at rest, and what the log does not identify of them."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.identification import MotionLog, estimate_payload
from mafsil.identification.regression import physically_consistent
from mafsil.identification.torque_model import with_load
from mafsil.mechanics.inertial_parameters import parameters_of
from mafsil.model import Inertial
from tests.identification.simulated import different, effort, noisy_log

LOAD = Inertial(
    2.3, np.array([0.02, -0.03, 0.07]), np.array([[0.012, 0.001, 0.0], [0.001, 0.010, -0.002], [0.0, -0.002, 0.008]])
)


@pytest.fixture(params=[("ur5e", 0), ("panda", 1)], ids=lambda case: case[0], scope="module")
def carrying(request):
    name, seed = request.param
    _, known = different(name, seed)
    return known, mf.Robot(with_load(known.mechanism, parameters_of(LOAD))), seed


def poses(robot, count, noise, seed):
    rng = np.random.default_rng(seed)
    lower, upper = np.maximum(robot.limits.lower, -2.5), np.minimum(robot.limits.upper, 2.5)
    q = rng.uniform(lower, upper, (count, robot.n))
    still = np.zeros_like(q)
    tau = effort(robot, q, still, still)
    return MotionLog(t=np.arange(float(count)), q=q, tau=tau + noise * rng.normal(size=q.shape))


def test_a_load_is_carried_as_the_regressor_says(carrying):
    known, loaded, seed = carrying
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, 4, known.n))
    more = loaded.inverse_dynamics(q, qd, qdd) - known.inverse_dynamics(q, qd, qdd)
    assert np.allclose(known.payload_regressor(q, qd, qdd) @ parameters_of(LOAD), more)


def test_motion_tells_all_ten_numbers_within_their_errors(carrying):
    known, loaded, seed = carrying
    found = estimate_payload(known, noisy_log(loaded, seed))
    assert found.certain
    assert found.com_identifiable.all()
    assert found.inertia_identifiable.all()
    assert abs(found.mass - LOAD.mass) < 5 * found.mass_error
    assert (np.abs(found.com - LOAD.com) < 5 * found.com_error).all()
    assert (np.abs(found.inertia - LOAD.inertia) < 6 * found.inertia_error).all()
    assert found.mass_error < 0.02
    assert (found.after < found.before).all()
    q, qd, qdd = np.random.default_rng(2).uniform(-1, 1, (3, 20, known.n))
    assert np.allclose(found.robot.inverse_dynamics(q, qd, qdd), loaded.inverse_dynamics(q, qd, qdd), atol=0.1)


def test_poses_at_rest_tell_mass_and_centre_only(carrying):
    known, loaded, _ = carrying
    found = estimate_payload(known, poses(loaded, 15, 0.2, 3), at_rest=True)
    assert found.certain
    assert found.com_identifiable.all()
    assert not found.inertia_identifiable.any()
    assert abs(found.mass - LOAD.mass) < 5 * found.mass_error
    assert (np.abs(found.com - LOAD.com) < 5 * found.com_error).all()
    assert physically_consistent(parameters_of(Inertial(found.mass, found.com, found.inertia)))
    assert "does not identify the inertia" in found.explain("en")
    assert "poses at rest" in found.explain("en")
    assert "لا يكشف السجل العطالة" in found.explain("ar")


def test_no_load_is_an_honest_no(carrying):
    known, _, seed = carrying
    found = estimate_payload(known, noisy_log(known, seed))
    assert not found.certain
    assert found.mass < 0.02
    assert "no payload is identifiable" in found.explain("en")


def test_a_planar_arm_does_not_tell_what_lies_along_its_axes():
    known = mf.load("planar2r")
    loaded = mf.Robot(with_load(known.mechanism, parameters_of(LOAD)))
    found = estimate_payload(known, noisy_log(loaded, 5))
    assert found.com_identifiable.tolist() == [True, True, False]
    assert "does not identify z of the centre of mass" in found.explain("en")
    assert found.inertia_identifiable.tolist() == [[False] * 3, [False] * 3, [False, False, True]]
    assert abs(found.mass - LOAD.mass) < 5 * found.mass_error


def test_errors_name_what_is_wrong():
    robot = mf.load("planar2r")
    t = np.arange(3.0)
    with pytest.raises(InputError, match="joints"):
        estimate_payload(robot, MotionLog(t=t, q=np.zeros((3, 3)), tau=np.zeros((3, 3))))
    with pytest.raises(InputError, match="too short"):
        estimate_payload(robot, MotionLog(t=t, q=np.zeros((3, 2)), tau=np.zeros((3, 2))))
