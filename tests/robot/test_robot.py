"""Robot: loading, the ways to call a quantity, and what it says when a call is wrong."""

import copy
import pickle

import numpy as np
import pytest

import mafsil as mf
from mafsil.mechanics.catalogue import CATALOGUE


@pytest.fixture(scope="module")
def arm() -> mf.Robot:
    return mf.load("planar3r")


@pytest.fixture(scope="module")
def q(arm: mf.Robot) -> np.ndarray:
    return np.linspace(-0.5, 0.9, arm.n)


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_quantity_is_a_documented_routine(arm: mf.Robot, name: str) -> None:
    row = CATALOGUE[name]
    routine = getattr(arm, name)
    states = np.random.default_rng(0).uniform(-1, 1, (len(row.inputs), 5, arm.n))
    batch = routine(*states)
    sizes = {"n": arm.n, "L": len(arm.mechanism.links)}
    assert batch.shape == (5, *(size if isinstance(size, int) else sizes[size] for size in row.shape))
    for k in range(5):
        assert (routine(*states[:, k]) == batch[k]).all()
    assert row.title in routine.__doc__
    assert row.unit in routine.__doc__
    named = routine(**dict(zip(row.inputs, states, strict=True)))
    assert (named == batch).all()


@pytest.mark.capability("05-10")
def test_frames_by_name(arm: mf.Robot, q: np.ndarray) -> None:
    poses = arm.link_poses(q)
    for name, pose in zip(arm.mechanism.link_names, poses, strict=True):
        np.testing.assert_allclose(arm.forward_kinematics(q, frame=name), pose, atol=1e-15)
    assert (arm.jacobian_space(q, frame=arm.mechanism.links[0].name) == 0).all()


@pytest.mark.capability("05-65", "09-47", "09-55")
def test_tip_wrench_by_position_and_name(arm: mf.Robot, q: np.ndarray) -> None:
    F = np.array([0.1, -0.2, 0.3, 1.0, 2.0, -3.0])
    rest = arm.inverse_dynamics(q, 0 * q, 0 * q)
    pushed = arm.inverse_dynamics(q, 0 * q, 0 * q, F)
    assert (arm.inverse_dynamics(q, 0 * q, 0 * q, tip_wrench=F) == pushed).all()
    assert (arm.inverse_dynamics(q, 0 * q, 0 * q, tip_wrench=None) == rest).all()
    np.testing.assert_allclose(pushed - rest, arm.jacobian_body(q).T @ F, atol=1e-13)
    np.testing.assert_allclose(arm.forward_dynamics(q, 0 * q, pushed, F), 0, atol=1e-10)


def test_results_into_a_given_array(arm: mf.Robot, q: np.ndarray) -> None:
    out = np.full((4, 4), np.nan)
    assert arm.forward_kinematics(q, out=out) is out
    assert (out == arm.forward_kinematics(q)).all()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda arm, q: arm.forward_kinematics(q[:2]), ["q", "(*batch, 3)", "(2,)"]),
        (lambda arm, q: arm.forward_kinematics(), ["forward_kinematics", "q", "missing"]),
        (lambda arm, q: arm.forward_kinematics(q, q), ["2 arguments", "q"]),
        (lambda arm, q: arm.forward_kinematics(q, joint=q), ["'joint'", "q"]),
        (lambda arm, q: arm.forward_kinematics(q, q=q), ["'q'", "twice"]),
        (lambda arm, q: arm.mass_matrix(q, frame="base"), ["mass_matrix", "frame"]),
        (lambda arm, q: arm.forward_kinematics(["a", "b", "c"]), ["q", "real numbers"]),
        (lambda arm, q: arm.forward_kinematics([0, np.nan, 0]), ["q", "nan", "(1,)"]),
        (lambda arm, q: arm.inverse_dynamics(q, q, q, [0.0] * 5), ["tip_wrench", "(*batch, 6)"]),
        (lambda arm, q: arm.kernel("torque"), ["torque", "inverse_dynamics"]),
        (lambda arm, q: arm.friction_torque(q[:1]), ["qd", "(*batch, 3)"]),
    ],
)
def test_wrong_calls_are_explained(arm: mf.Robot, q: np.ndarray, call, words: list[str]) -> None:
    with pytest.raises(mf.InputError) as caught:
        call(arm, q)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert caught.value.message("ar") != str(caught.value)


def test_unknown_frame_lists_the_links(arm: mf.Robot, q: np.ndarray) -> None:
    with pytest.raises(mf.ModelError, match=arm.mechanism.links[1].name):
        arm.forward_kinematics(q, frame="elbow joint")


def test_bad_rows_stay_alone(arm: mf.Robot) -> None:
    states = np.random.default_rng(1).uniform(-1, 1, (3, 40, arm.n))
    good = arm.inverse_dynamics(*states)
    states[0, 7, 1], states[2, 30, 0] = np.nan, np.inf
    spoiled = arm.inverse_dynamics(*states)
    rows = np.array([7, 30])
    assert not np.isfinite(spoiled[rows]).all(axis=1).any()
    assert (np.delete(spoiled, rows, 0) == np.delete(good, rows, 0)).all()


@pytest.mark.parametrize("shape", [(0,), (1,), (2, 0, 3), (3, 1, 2)])
def test_batch_shapes(arm: mf.Robot, shape: tuple[int, ...]) -> None:
    assert arm.mass_matrix(np.zeros((*shape, arm.n))).shape == (*shape, arm.n, arm.n)
    assert arm.kinetic_energy(np.zeros((*shape, arm.n)), np.zeros(arm.n)).shape == shape


@pytest.mark.row("C2")
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_robots_travel(arm: mf.Robot, q: np.ndarray, protocol: int) -> None:
    for other in (pickle.loads(pickle.dumps(arm, protocol)), copy.copy(arm), copy.deepcopy(arm)):
        assert (other.forward_kinematics(q) == arm.forward_kinematics(q)).all()
        assert repr(other) == repr(arm)
    routine = pickle.loads(pickle.dumps(arm.forward_kinematics, protocol))
    assert (routine(q, frame="link2") == arm.forward_kinematics(q, frame="link2")).all()
    kernel = arm.kernel("mass_matrix")
    assert (pickle.loads(pickle.dumps(kernel, protocol))(q) == kernel(q)).all()


def test_what_cannot_be_loaded(tmp_path) -> None:
    with pytest.raises(mf.FileError, match="panda"):
        mf.load("no_such_robot")
    with pytest.raises(mf.FileError, match=r"\.doc"):
        mf.load(tmp_path / "robot.doc")
    with pytest.raises(mf.FileError):
        mf.load(tmp_path / "missing.urdf")
    with pytest.raises(mf.ModelError, match="tip"):
        mf.load("planar2r", tip="nowhere")


def test_friction(arm: mf.Robot) -> None:
    puma = mf.load("puma560")
    rates = np.array([0.5, -0.5, 0.0, 1.0, -1.0, 2.0])
    effort = puma.friction_torque(rates)
    assert (np.sign(effort) == np.sign(rates)).all()
    assert (arm.friction_torque(np.ones(3)) == 0).all()


@pytest.mark.capability("05-26")
def test_robot_from_a_table_and_from_screws() -> None:
    table = mf.Robot.from_dh([mf.DHRow(a=0.4), mf.DHRow(a=0.3, alpha=np.pi / 2), mf.DHRow(d=0.1)], "classic")
    home = table.forward_kinematics(np.zeros(3))
    screws = table.jacobian_space(np.zeros(3)).T
    same = mf.Robot.from_screws(screws, home)
    q = np.random.default_rng(2).uniform(-3, 3, (50, 3))
    np.testing.assert_allclose(same.forward_kinematics(q), table.forward_kinematics(q), atol=1e-14)


@pytest.mark.parametrize("of_tip", [True, False])
@pytest.mark.parametrize("jacobian", ["jacobian_body", "jacobian_space"])
def test_quantities_together_equal_those_apart(of_tip: bool, jacobian: str) -> None:
    robot = mf.load("stanford_arm")
    frame = None if of_tip else robot.mechanism.links[2].name
    q = np.random.default_rng(3).uniform(-1, 1, (3, 7, robot.n))
    routine = robot.fused_routine("forward_kinematics", jacobian, frame=frame)
    T, J = routine(q)
    np.testing.assert_allclose(T, robot.forward_kinematics(q, frame=frame), atol=2e-15)
    np.testing.assert_allclose(J, getattr(robot, jacobian)(q, frame=frame), atol=2e-15)
    alone = routine(q[1, 2])
    assert (alone[0] == T[1, 2]).all()
    assert (alone[1] == J[1, 2]).all()
    out = (np.empty_like(T), np.empty_like(J))
    assert routine(q, out=out)[1] is out[1]
    assert (out[0] == T).all()
    assert (pickle.loads(pickle.dumps(routine))(q)[0] == T).all()


def test_dynamics_together(arm: mf.Robot) -> None:
    q, qd, qdd, F = (np.random.default_rng(5).uniform(-1, 1, (9, size)) for size in (arm.n, arm.n, arm.n, 6))
    M, tau = arm.fused_routine("mass_matrix", "inverse_dynamics", optional=("tip_wrench",))(q, qd, qdd, F)
    np.testing.assert_allclose(M, arm.mass_matrix(q), rtol=1e-13)
    np.testing.assert_allclose(tau, arm.inverse_dynamics(q, qd, qdd, F), rtol=1e-12, atol=1e-12)


def test_together_says_what_is_wrong(arm: mf.Robot) -> None:
    for key, names, options in (
        ("robot.fused", ("mass_matrix",), {}),
        ("robot.fused", ("mass_matrix", "mass_matrix"), {}),
        ("input.choice", ("mass_matrix", "mass"), {}),
        ("input.choice", ("mass_matrix", "inverse_dynamics"), {"optional": ("tip",)}),
        ("robot.no_frame", ("mass_matrix", "gravity_torque"), {"frame": "link1"}),
        ("robot.frame_name", ("mass_matrix", "jacobian_body"), {"frame": 3}),
    ):
        with pytest.raises(mf.InputError) as caught:
            arm.fused_routine(*names, **options)
        assert caught.value.key == key
        assert caught.value.message("ar") != caught.value.message("en")
