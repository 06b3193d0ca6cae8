"""Rounding a description to 6 to 14 digits changes no rank, verdict, structure or count, or the answer is in doubt."""

import re
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.geometry import pose
from mafsil.ik import arm_structure, closed_form
from mafsil.ik.structure import structure_in_doubt
from mafsil.performance import characteristic_length, is_singular, rank, singularity
from mafsil.performance.singularities import verdict_in_doubt
from tests.sizes import few, size

pytestmark = pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")

DIGITS = [6, 7, 8, 10, 12, 14]
LIBRARY = [
    "ur5e", "puma560", "stanford_arm", "offset_puma", "offset_stanford", "elbow6r", "arm6r", "rrprrr", "cobra600",
    "planar3r", "rrrp", "panda", "iiwa7",
]  # fmt: skip
EXAMPLES = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
REAL = {
    "ur_description/urdf/ur5_robot.urdf": "ee_link",
    "kinova_description/robots/kinova.urdf": "j2s6s200_end_effector",
    "z1_description/urdf/z1.urdf": "link06",
    "xarm_description/urdf/xarm7.urdf": "link7",
}
ORIGIN = re.compile(r'(?:xyz|rpy)="[^"]*"')
NUMBER = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")
QUARTER = np.pi / 2


def typed(S, home, digits):
    """A robot of screws and home that are written with so many decimals."""
    return mf.Robot.from_screws(np.round(S, digits), np.round(home, digits), normalise=True)


def special_configurations(n, rng):
    """Regular configurations, and some with joints at zero, where axes line up."""
    regular = rng.uniform(-2.5, 2.5, (3, n))
    return np.concatenate(
        [regular, np.zeros((1, n)), *(np.where(np.arange(n) == k, 0.0, regular[:2]) for k in range(n))]
    )


def agree_on_rank(exact, rough, q):
    told = (rank(exact, q) == rank(rough, q)) & (is_singular(exact, q) == is_singular(rough, q))
    assert (told | verdict_in_doubt(exact, q) | verdict_in_doubt(rough, q)).all()


def agree_on_structure(exact, rough):
    families = [None if (form := closed_form(one)) is None else form.pattern.family for one in (exact, rough)]
    assert families[0] is families[1] or structure_in_doubt(exact) or structure_in_doubt(rough)


def agree_on_counts(exact, rough, q):
    for one in q:
        T = exact.forward_kinematics(one)
        answers = [mf.inverse_kinematics(robot, T) for robot in (exact, rough)]
        counts = [len(answer) for answer in answers]
        assert counts[0] == counts[1] or any(answer.in_doubt or not answer.complete for answer in answers), counts


@pytest.mark.parametrize("name", LIBRARY)
def test_library_arms_typed_with_few_digits(name):
    exact, rng = mf.load(name), np.random.default_rng(0)
    q = special_configurations(exact.n, rng)
    S, home = exact.jacobian_space(np.zeros(exact.n)).T, exact.forward_kinematics(np.zeros(exact.n))
    for digits in few(DIGITS, 3):
        rough = typed(S, home, digits)
        agree_on_rank(exact, rough, q)
        agree_on_structure(exact, rough)
        if exact.n <= 6:
            agree_on_counts(exact, rough, q)


@pytest.mark.parametrize("file", REAL)
def test_makers_arms_typed_with_few_digits(file, tmp_path):
    if not (EXAMPLES / file).is_file():
        pytest.skip("example-robot-data is not installed")
    text, rng = (EXAMPLES / file).read_text(), np.random.default_rng(1)
    exact = mf.load(EXAMPLES / file, tip=REAL[file])
    q = special_configurations(exact.n, rng)
    for digits in few((6, 8, 10), 2):
        (tmp_path / "arm.urdf").write_text(
            ORIGIN.sub(lambda a, d=digits: NUMBER.sub(lambda x: f"{float(x.group()):.{d}f}", a.group()), text)
        )
        rough = mf.load(tmp_path / "arm.urdf", tip=REAL[file])
        agree_on_rank(exact, rough, q)
        agree_on_structure(exact, rough)
        if exact.n <= 6:
            agree_on_counts(exact, rough, q)


@st.composite
def special_arms(draw):
    """Screws and home of six joints, each beside the one before by quarter turns; some lengths are zero."""
    T = pose.exp(np.array(draw(st.lists(st.floats(-1, 1), min_size=6, max_size=6))))
    S, length = [], 0.0
    for k in range(6):
        quarters = draw(st.integers(0, 3))
        along, across = (draw(st.sampled_from([0.0, 0.1, 0.37])) for _ in range(2))
        turn = np.array([quarters * QUARTER, 0, 0, 0, 0, 0])
        T = T @ pose.exp(turn) if k else T
        w, p = T[:3, 2], T[:3, 3]
        S.append([*w, *np.cross(p, w)])
        step = np.eye(4)
        step[:3, 3], length = (across, 0, along), length + across + along
        T = T @ step
    return np.array(S), T, length


@settings(max_examples=size(5, 12), deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(special_arms(), st.sampled_from(DIGITS))
def test_arms_of_quarter_turns_typed_with_few_digits(arm, digits):
    S, home, length = arm
    if length == 0.0:
        return
    exact, rough = typed(S, home, 17), typed(S, home, digits)
    q = special_configurations(6, np.random.default_rng(2))
    agree_on_rank(exact, rough, q)
    agree_on_structure(exact, rough)
    classes = [arm_structure(robot).arm_class for robot in (exact, rough)]
    assert classes[0] is classes[1]
    if closed_form(exact) is not None and closed_form(rough) is not None:
        agree_on_counts(exact, rough, q[:4])


@pytest.mark.parametrize("name", ["ur5e", "puma560", "stanford_arm", "offset_puma", "elbow6r", "rrprrr", "planar3r"])
def test_counts_on_a_boundary_are_in_doubt(name):
    robot, rng = mf.load(name), np.random.default_rng(3)
    q = rng.uniform(-2, 2, (400, robot.n))
    T = robot.forward_kinematics(q)
    batch = mf.inverse_kinematics(robot, T)
    # Doubt is for the few: one solution of eight with a relative singular value below 0.0045 raises it.
    assert batch.in_doubt.mean() < 0.25
    for one in special_configurations(robot.n, rng)[3:]:
        if is_singular(robot, one) or verdict_in_doubt(robot, one):
            answer = mf.inverse_kinematics(robot, robot.forward_kinematics(one))
            assert answer.in_doubt
            assert answer.to_dict()["in_doubt"]
            assert "six digits" in answer.explain("en")
            assert mf.inverse_kinematics(robot, robot.forward_kinematics(one)[None]).in_doubt[0]


@pytest.mark.parametrize("beyond", [1e-6, -1e-6])
def test_a_pose_beside_full_reach_is_in_doubt(beyond):
    robot = mf.load("planar2r")
    T = robot.forward_kinematics(np.zeros(2))
    T[0, 3] += beyond
    assert mf.inverse_kinematics(robot, T, task="position").in_doubt
    T[0, 3] += 0.1 * np.sign(beyond)
    assert not mf.inverse_kinematics(robot, T, task="position").in_doubt


def test_a_scara_of_eight_digits_has_a_count_in_doubt():
    scara = mf.load("cobra600")
    S, home = scara.jacobian_space(np.zeros(4)).T, scara.forward_kinematics(np.zeros(4))
    G = pose.exp(np.array([0.3, -0.2, 0.5, 0.1, 0.2, 0.3]))
    exact, rough = (typed(S @ pose.adjoint(G).T, G @ home, digits) for digits in (17, 8))
    T = rough.forward_kinematics(np.array([0.3, 0.5, 0.1, 0.2]))
    assert structure_in_doubt(rough) or not structure_in_doubt(exact)
    answer = mf.inverse_kinematics(rough, T)
    assert len(answer) == 2 or answer.in_doubt or not answer.complete


def test_rank_is_in_doubt_within_rounding_of_the_tolerance():
    robot = mf.load("puma560")
    for bent, doubt in ((0.0, False), (3e-6, True), (1e-2, False)):
        q = np.array([0.3, 0.4, -0.8, 0.7, bent, 0.2])
        answer = singularity(robot, q)
        assert answer.in_doubt is doubt
        assert ("in doubt" in answer.explain("en")) is doubt


@pytest.mark.parametrize("unit", [1.0, 1000.0])
@pytest.mark.parametrize("digits", few([6, 8, 10, 11, 12, 15], 3))
def test_concurrent_axes_have_rank_three(digits, unit):
    rng = np.random.default_rng(0)
    for _ in range(5):
        robot = concurrent(rng, rng.normal(size=(4, 3)), digits, unit)
        assert singularity(robot, rng.uniform(-1, 1, 4)).rank == 3
        wrist = concurrent(rng, [[0, 0, 1], [0, 1, 0], [0, 0, 1]], digits, unit)
        straight = singularity(wrist, [0.3, 0.0, 0.4])
        assert straight.rank == 2
        assert straight.singular


def test_small_arms_keep_their_levers():
    S = np.array([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1e-3, 0.0]])
    home = np.eye(4)
    home[0, 3] = 2e-3
    assert 5e-4 < characteristic_length(mf.Robot.from_screws(S, home)) < 2e-3


def concurrent(rng, directions, digits, unit=1.0):
    """Axes through one random point, and a tool there, in a random frame."""
    G = pose.exp(rng.normal(size=6))
    point = unit * G[:3, 3]
    axes = np.array([G[:3, :3] @ w / np.linalg.norm(w) for w in directions])
    home = np.eye(4)
    home[:3, 3] = point
    return typed(np.concatenate([axes, np.cross(point, axes)], axis=1), home, digits)
