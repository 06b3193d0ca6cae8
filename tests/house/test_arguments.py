"""At every border: NaN stays in its row, empty batches work, wrong lengths are said, in every batched function.

Each entry gives numbers of a batch of configurations or values; rows may hold NaN only where their own input does.
"""

import numpy as np
import pytest

import mafsil as mf
from mafsil import ik, performance
from mafsil.errors import MafsilError
from mafsil.geometry import euler, pose, quaternion, rotation, screw, twist, wrench

ARM = mf.load("ur5e")
ONE = np.ones(6)
RNG = np.random.default_rng(3)
Q = np.array([0.0, -1, 1, 0, 1, 0]) + 0.1 * RNG.standard_normal((3, 6))
R = rotation.exp(RNG.standard_normal((3, 3)))
T = pose.exp(RNG.standard_normal((3, 6)))
V = RNG.standard_normal((3, 6))

MEASURES = ("yoshikawa", "inverse_condition", "smallest", "isotropy")
OF_CONFIGURATIONS = {
    "forward_kinematics": ARM.forward_kinematics,
    "jacobian_body": ARM.jacobian_body,
    "mass_matrix": ARM.mass_matrix,
    "gravity_torque": ARM.gravity_torque,
    "singular_values": lambda q: performance.singular_values(ARM, q),
    "velocity_ellipsoid": lambda q: performance.velocity_ellipsoid(ARM, q).lengths,
    "force_ellipsoid": lambda q: performance.force_ellipsoid(ARM, q).lengths,
    **{f"manipulability {m}": lambda q, m=m: performance.manipulability(ARM, q, m) for m in MEASURES},
    **{f"gradient {m}": lambda q, m=m: performance.manipulability_gradient(ARM, q, m) for m in MEASURES},
    "jacobian_hessian": lambda q: performance.jacobian_hessian(ARM, q),
    "tip_wrench": lambda q: performance.tip_wrench(ARM, q, ONE).F,
    "joint_torque": lambda q: performance.joint_torque(ARM, q, ONE),
    "largest_payload": lambda q: performance.largest_payload(ARM, q).largest,
    "largest_force": lambda q: performance.largest_force(ARM, q, [1, 0, 0]).largest,
    "analytic_jacobian": lambda q: performance.analytic_jacobian(ARM, q),
    "analytic_jacobian quaternion": lambda q: performance.analytic_jacobian(ARM, q, "quaternion"),
    "analytic_jacobian exponential": lambda q: performance.analytic_jacobian(ARM, q, "exponential"),
    "tool_jacobian": lambda q: performance.tool_jacobian(ARM, q),
    "joint_twists": lambda q: performance.joint_twists(ARM, q, ONE),
    "point_velocity": lambda q: performance.point_velocity(ARM, q, ONE),
    "scaled_jacobian": lambda q: performance.scaled_jacobian(ARM, q, at="axes").J,
    "ik.twist_jacobian": lambda q: ik.twist_jacobian(ARM, q),
    "joint_rates": lambda q: ik.joint_rates(ARM, q, ONE).qd,
}
OF_ROTATIONS = {
    "log": rotation.log,
    "to_axis_angle": lambda x: rotation.to_axis_angle(x)[0],
    "to_quaternion": quaternion.to_quaternion,
    "to_rpy": euler.to_rpy,
    "to_euler": lambda x: euler.to_euler(x, "ZXZ"),
    "inverse": rotation.inverse,
    "Rotation": lambda x: mf.Rotation(x).array,
}
OF_POSES = {
    "log": pose.log,
    "inverse": pose.inverse,
    "adjoint": pose.adjoint,
    "chasles": lambda x: screw.chasles(x)[0],
    "Pose": lambda x: mf.Pose(x).array,
    "transform twist": lambda x: twist.transform(x, ONE),
    "transform wrench": lambda x: wrench.transform(x, ONE),
}
ENTRIES = [
    *((f"configurations: {name}", call, Q) for name, call in OF_CONFIGURATIONS.items()),
    *((f"rotations: {name}", call, R) for name, call in OF_ROTATIONS.items()),
    *((f"poses: {name}", call, T) for name, call in OF_POSES.items()),
    ("twists: exp", pose.exp, V),
    ("rotation vectors: exp", rotation.exp, V[:, :3]),
]
NAMES = [name for name, _, _ in ENTRIES]
PASSING = [entry for entry in ENTRIES if not entry[0].endswith((" Rotation", " Pose"))]
"""Functions of arrays; values refuse what is not finite."""


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("call", "values"), [entry[1:] for entry in PASSING], ids=[entry[0] for entry in PASSING])
def test_nan_stays_in_its_row(call, values):
    clean, spoilt = np.asarray(call(values)), values.copy()
    spoilt[1] = np.nan
    found = np.asarray(call(spoilt))
    assert found.shape == clean.shape
    np.testing.assert_allclose(found[[0, 2]], clean[[0, 2]], rtol=1e-9, atol=1e-9)
    assert np.isnan(found[1]).any()


@pytest.mark.parametrize(("call", "values"), [entry[1:] for entry in ENTRIES], ids=NAMES)
def test_empty_batches_work(call, values):
    assert np.asarray(call(values[:0])).shape == (0, *np.asarray(call(values)).shape[1:])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("wrong", [np.ones(5), np.ones((2, 9)), "text", None, [[1.0], [2.0, 3.0]], 1j * np.ones(6)])
@pytest.mark.parametrize("call", [entry[1] for entry in ENTRIES], ids=NAMES)
def test_wrong_shapes_and_kinds_are_said_in_our_words(call, wrong):
    with pytest.raises(MafsilError) as caught:
        call(wrong)
    assert caught.value.message("en") != caught.value.message("ar")


def test_numbers_that_cannot_be_nan_say_so_by_their_own_means():
    spoilt = Q.copy()
    spoilt[1] = np.nan
    assert performance.rank(ARM, spoilt).tolist() == [6, -1, 6]
    assert performance.is_singular(ARM, spoilt).tolist() == [False, False, False]
    found = performance.tip_wrench(ARM, spoilt, ONE)
    assert [status.name for status in found.status] == ["DETERMINED", "NOT_FINITE", "DETERMINED"]
    assert "not finite" in found.explain(1)


def test_the_row_that_is_no_rotation_is_named_not_the_one_with_nan():
    with pytest.raises(MafsilError, match=r"R\[2\]"):
        rotation.log(np.stack([np.eye(3), np.full((3, 3), np.nan), 2 * np.eye(3)]))
