"""Typed values: what has a meaning is right with its frame, everything else is refused with what to do."""

import itertools

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, InputWarning, OperandError
from mafsil.geometry import rotation
from mafsil.geometry.values import Point, Pose, Rotation, ScrewAxis, Twist, Vector, Wrench

P, Q = Point([1.0, 0, 0], "b"), Point([0, 2.0, 0], "b")
V, W = Vector([0, 1.0, 0], "b"), Vector([3.0, 0, 0], "b")
T, U = Twist([1, 2, 3, 4, 5, 6.0], "b"), Twist([1, 0, 0, 0, 0, 1.0], "b")
F, G = Wrench([1, 2, 3, 4, 5, 6.0], "b"), Wrench([0, 1, 0, 0, 1.0, 0], "b")
S = ScrewAxis.of([0, 0, 1.0], [1.0, 0, 0], 0.2, "b")
POSE, TURN = Pose.translation([10.0, 0, 0], ("a", "b")), Rotation.from_rpy([0, 0, np.pi / 2], ("a", "b"))


@pytest.mark.capability("04-5", "04-121")
def test_points_and_vectors_make_an_affine_space():
    assert isinstance(P - Q, Vector)
    assert isinstance(P + V, Point)
    assert isinstance(V + P, Point)
    assert isinstance(P - V, Point)
    np.testing.assert_array_equal((P - V).array, [1, -1, 0])
    np.testing.assert_array_equal((Q + (P - Q)).array, P.array)
    moved = POSE @ (P - V)
    assert isinstance(moved, Point)
    assert moved.frame == "a"
    np.testing.assert_array_equal(moved.array, [11, -1, 0])
    for wrong in (
        lambda: P + Q,
        lambda: -1 * P,
        lambda: P * 2.0,
        lambda: V - P,
        lambda: P - 3.0,
        lambda: P.distance(V),
    ):
        with pytest.raises(OperandError):
            wrong()


@pytest.mark.parametrize(("x", "y"), [(V, W), (T, U), (F, G)])
def test_linear_values_have_the_full_set_of_operators(x, y):
    for value, numbers in (
        (x + y, x.array + y.array),
        (x - y, x.array - y.array),
        (-x, -x.array),
        (+x, x.array),
        (x * 2, 2 * x.array),
        (2 * x, 2 * x.array),
        (np.float64(2) * x, 2 * x.array),
        (x * np.float64(2), 2 * x.array),
        (x / 4, x.array / 4),
        (x - x, 0 * x.array),
        (np.array([1.0, 2.0]) * x, np.outer([1.0, 2.0], x.array)),
    ):
        assert type(value) is type(x)
        assert value.frame == "b"
        np.testing.assert_array_equal(value.array, numbers)


def test_numpy_numbers_leave_the_screw_to_say_what_it_is():
    for twist in (np.float64(2) * S, S * np.float64(2), 2 * S, np.array(2.0) * S):
        assert isinstance(twist, Twist)
        assert twist.frame == "b"
        np.testing.assert_array_equal(twist.array, 2 * S.array)
    assert isinstance(-S, ScrewAxis)
    assert (-S).pitch == pytest.approx(S.pitch)


VALUES = {
    "Point": P,
    "Vector": V,
    "Twist": T,
    "Wrench": F,
    "ScrewAxis": S,
    "Pose": POSE,
    "Rotation": TURN,
    "list": [1.0],
}
MEANINGFUL = {
    "+": {("Point", "Vector"), ("Vector", "Point"), ("Vector", "Vector"), ("Twist", "Twist"), ("Wrench", "Wrench")},
    "-": {("Point", "Vector"), ("Point", "Point"), ("Vector", "Vector"), ("Twist", "Twist"), ("Wrench", "Wrench")},
    "@": {("Pose", "Point"), ("Pose", "Vector"), ("Pose", "Pose"), ("Rotation", "Vector"), ("Rotation", "Rotation")},
}


@pytest.mark.parametrize("sign", MEANINGFUL)
@pytest.mark.parametrize("pair", list(itertools.product(VALUES, VALUES)))
def test_every_other_pair_is_refused_with_what_to_do(sign, pair):
    if pair in MEANINGFUL[sign] or pair == ("list", "list"):
        return
    left, right = (VALUES[name] for name in pair)
    with pytest.raises(OperandError) as caught:
        {"+": lambda: left + right, "-": lambda: left - right, "@": lambda: left @ right}[sign]()
    assert caught.value.message("en") != caught.value.message("ar")
    assert isinstance(caught.value, TypeError)


@pytest.mark.parametrize(
    "wrong",
    [lambda: T.power(T), lambda: T.bracket(F), lambda: V.dot(P), lambda: T * U, lambda: F / "2", lambda: S * None],
)
def test_methods_refuse_the_wrong_kind_too(wrong):
    with pytest.raises(InputError):
        wrong()


@pytest.mark.capability("04-121")
def test_frames_must_agree():
    with pytest.raises(InputError, match="frame"):
        V + Vector([1, 0, 0], "c")
    with pytest.raises(InputError, match="frame"):
        T - Twist([1, 0, 0, 0, 0, 0], "s")
    with pytest.raises(InputError, match="frame"):
        Vector([1, 0, 0], "c") + P


@pytest.mark.capability("04-59")
def test_vee_checks_skewness():
    for wrong in (np.ones((3, 3)) + np.eye(3), np.eye(3), np.stack([np.zeros((3, 3)), np.eye(3)])):
        with pytest.raises(InputError) as caught:
            rotation.vee(wrong)
        assert caught.value.key == "geometry.not_skew"
    w = np.array([1.0, -2.0, 3.0])
    np.testing.assert_array_equal(rotation.vee(rotation.hat(w)), w)
    rows = rotation.vee(np.stack([rotation.hat(w), np.full((3, 3), np.nan)]))
    np.testing.assert_array_equal(rows[0], w)
    assert np.isnan(rows[1]).all()
    assert rotation.vee(np.zeros((0, 3, 3))).shape == (0, 3)


def test_degrees_where_a_person_types():
    for degrees, radians in (
        (Rotation.from_rpy([90, 30, -20], degrees=True), Rotation.from_rpy(np.radians([90, 30, -20]))),
        (Rotation.from_euler([90, 30, 5], "ZYX", degrees=True), Rotation.from_euler(np.radians([90, 30, 5]), "ZYX")),
        (Rotation.from_axis_angle([0, 0, 1], 60, degrees=True), Rotation.from_axis_angle([0, 0, 1], np.pi / 3)),
    ):
        np.testing.assert_array_equal(degrees.array, radians.array)
    with pytest.warns(InputWarning) as caught:
        mf.Rotation.from_rpy([90, 0, 0])
    assert caught[0].filename == __file__
    assert "degrees=True" in str(caught[0].message)


@pytest.mark.parametrize("value", [mf.Rotation(np.eye(3)), mf.Pose(np.eye(4)), mf.Twist(np.zeros(6))])
def test_one_value_is_neither_true_nor_a_sequence_and_says_so(value):
    with pytest.raises(TypeError, match=f"truth value of one {type(value).__name__} is not defined"):
        bool(value)
    with pytest.raises(TypeError, match=f"{type(value).__name__} has no length"):
        len(value)
    batch = type(value)(np.stack([value.array] * 3))
    assert batch
    assert len(batch) == 3
    assert not batch[:0]
