"""Exercises: the answer by another road, right in every equivalent form, mistakes by name, words in both languages."""

import re
from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Oracle

import mafsil as mf
from mafsil.book.exercise import Exercise
from mafsil.errors import InputError
from mafsil.messages import keys, say
from tests.reliability.exercise_mistakes import tally

FAMILIES = mf.book.exercises()
Planted = list[tuple[str, Any, str]]


@pytest.mark.parametrize("number", FAMILIES)
def test_right_answers_are_right_and_mistakes_get_their_name(number: str) -> None:
    one = tally(3 if ": " in number else 9, number)
    assert one.alarms == []
    assert len(one.missed) <= one.planted // 10, one.missed


@pytest.mark.parametrize("number", FAMILIES)
def test_words_in_both_languages(number: str) -> None:
    for level in (2,) if ": " in number else (1, 2, 3):
        exercise = mf.book.exercise(number, seed=5, level=level)
        for language in ("en", "ar"):
            assert exercise.number in exercise.explain(language)
            assert exercise.words("title", language)
            assert exercise.words("text", language)
            assert len(exercise.hints(language)) == 3
            assert len(exercise.solution(language)) >= 3
            said = keys(language, "book_exercises")
            assert {f"mistake_{name}" for part in exercise.asked for name, _ in part.mistakes} <= said


def test_each_section_that_computes_has_three_questions() -> None:
    for number in mf.book.sections():
        page = mf.book.section(number)
        if page and not page.within and number != "1":
            assert len(page.exercises) >= 3, number
            assert len({one.partition(": ")[2] for one in page.exercises}) >= 3, number


@pytest.mark.parametrize("seed", range(6))
def test_questions_made_of_a_family_by_another_road(seed: int) -> None:
    def result(m: float, mu: float) -> float:
        return m * 9.81 / (2 * mu)

    inverse = mf.book.exercise("3.3.1 squeeze: inverse", seed=seed)
    m, mu, x = inverse.facts["m"], inverse.facts["mu"], inverse.asked[0].value.item()
    assert x == (m if inverse.hidden == "m" else mu)
    assert f"{result(m, mu):.4g}" in inverse.words("text")
    assert " X " in inverse.words("text", "en") or "= X" in inverse.words("text", "en")
    slip = next((x for name, (x,) in inverse.asked[0].mistakes if name == "not_halved"), None)
    if slip is not None:
        wrong = (slip, mu) if inverse.hidden == "m" else (m, slip)
        assert 2 * result(*wrong) == pytest.approx(result(m, mu), rel=1e-3)
    scaling = mf.book.exercise("3.3.1 squeeze: scaling", seed=seed)
    first, second = (float(str(scaling.facts[name]).split()[0]) for name in ("x_first", "x_second"))
    assert scaling.asked[0].value == pytest.approx(second / first if scaling.hidden == "m" else first / second)
    choose = mf.book.exercise("3.3.1 squeeze: choose", seed=seed)
    options = re.findall(r"\((\d)\) ([-\d.]+\d)", choose.words("text", "en"))
    right = f"{result(choose.facts['m'], choose.facts['mu']):.4g}"
    assert [int(k) for k, value in options if value == right] == [choose.asked[0].value]
    wrong = mf.book.exercise("3.3.1 squeeze: mistake", seed=seed)
    text = wrong.words("text", "en")
    causes = dict(re.findall(r"\((\d)\) ([^;:]+?)(?=; \(|\. Which)", text))
    given = float(re.search(r"gives [^=]+= ([-\d.]+\d)", text)[1])  # type: ignore[index]
    factor = {"not_halved": 2, "no_g": 1 / 9.81, "friction_times": wrong.facts["mu"] ** 2, "negated": -1}
    name = next(name for name, by in factor.items() if given == pytest.approx(by * wrong.asked[1].value, rel=1e-3))
    assert causes[str(wrong.asked[0].value.astype(int))] == say(f"book_exercises.mistake_{name}", language="en")
    assert wrong.asked[1].value == pytest.approx(result(wrong.facts["m"], wrong.facts["mu"]))


def test_a_seed_is_an_exercise() -> None:
    first, again, other = (mf.book.exercise("4.3.2 frames", seed=seed, level=2) for seed in (3, 3, 4))
    assert first.explain() == again.explain() != other.explain()
    assert mf.book.exercise("4").number in mf.book.exercises("4")
    assert {mf.book.exercise("4.2.5", seed=seed).number for seed in range(9)} == set(mf.book.exercises("4.2.5"))


@pytest.mark.parametrize(("number", "arguments", "key"), [
    ("4.9", {}, "book_exercises.unknown"), ("4.2", {"level": 4}, "book_exercises.level"), ("4.2", {"seed": -1},
    "input.whole"),
])  # fmt: skip
def test_wrong_questions_are_refused(number: str, arguments: dict[str, int], key: str) -> None:
    with pytest.raises(InputError) as caught:
        mf.book.exercise(number, **arguments)
    assert caught.value.key == key or key == "input.whole"


def test_texts_are_read() -> None:
    angle = mf.book.exercise("3.3.3 two fingers", seed=1)
    beta = angle.asked[0].value.item()
    for text in (
        f"{np.degrees(beta):.4f}°",
        f"{np.degrees(beta):.4f} deg",
        f"{beta:.5f} rad",
        f"{beta / pi:.6f}*pi",
        beta,
    ):
        assert angle.check({"friction_angle": text}).verdicts[0].mistake == "", text
    arabic = f"{beta:.4f}".translate(str.maketrans("0123456789.", "٠١٢٣٤٥٦٧٨٩٫"))
    assert angle.check({"friction_angle": arabic}).verdicts[0].mistake == ""
    right = "نعم" if angle.asked[1].value else "لا"
    assert angle.check({"closure": right}).verdicts[1].mistake == ""
    for text in ("abc", "30 m", "1/0", "°", "--3"):
        with pytest.raises(InputError):
            angle.check({"friction_angle": text})
    with pytest.raises(InputError):
        angle.check({"beta": 1.0})
    assert [verdict.mistake for verdict in angle.check({})] == ["empty", "empty"]
    assert not angle.check("5 3")
    assert angle.check({"closure": bool(angle.asked[1].value)}).verdicts[1].mistake == ""
    for given in (object(), [1, "a"], [0.5, None], float("nan"), 1j, {1: 2}, "9e999", {"friction_angle": np.inf}):
        with pytest.raises(InputError):
            angle.check(given)
    assert angle.check(None).verdicts[0].mistake == "empty"


def _rotation_mistakes(exercise: Exercise) -> Planted:
    """From another library: rotations in the wrong order, degrees as radians, the other storage of a quaternion."""
    angles = np.array([exercise.facts[name] for name in ("alpha", "beta", "gamma")], float)
    right = Oracle.from_euler("ZYX", angles, degrees=True)
    x, y, z, w = right.as_quat()
    assert exercise.check(
        {"R": right.as_matrix(), "q": [w, x, y, z], "r": right.as_rotvec(), "zyz": right.as_euler("ZYZ")}
    )
    fixed = Oracle.from_euler("zyx", angles, degrees=True)
    return [
        ("R", right.as_matrix().T, "transposed"), ("R", fixed.as_matrix(), "rotations_reversed"),
        ("R", Oracle.from_euler("ZYX", angles).as_matrix(), "degrees"), ("q", [x, y, z, w], "scalar_last"),
        ("q", [-w, x, y, z], "transposed"), ("r", right.as_rotvec(degrees=True), "degrees"),
        ("r", right.inv().as_rotvec(), "transposed"), ("zyz", right.as_euler("ZYZ", degrees=True), "degrees"),
    ]  # fmt: skip


def _frame_mistakes(exercise: Exercise) -> Planted:
    beta, gamma = np.radians([exercise.facts["beta"], exercise.facts["gamma"]])
    b, c = exercise.facts["p_b"], exercise.facts["p_c"]
    turn = Oracle.from_euler("z", beta)
    assert exercise.check({"p": turn.inv().apply(c - b), "R": Oracle.from_euler("z", gamma - beta).as_matrix()})
    return [
        ("p", b + turn.apply(c), "not_inverted"), ("p", turn.apply(c - b), "transposed"), ("p",
        turn.inv().apply(c) - b, "origin_not_turned"),
        ("R", Oracle.from_euler("z", gamma + beta).as_matrix(), "not_inverted"), ("p", 1000 * turn.inv().apply(c - b),
        "millimetres"),
    ]  # fmt: skip


def _jacobian_mistakes(exercise: Exercise) -> Planted:
    l1, l2, t1, t2 = (float(exercise.facts[name]) for name in ("L1", "L2", "t1", "t2"))
    rates = exercise.facts["rates"]

    def J(a: float, b: float) -> Any:
        s1, c1, s12, c12 = np.sin(a), np.cos(a), np.sin(a + b), np.cos(a + b)
        return np.array([[-l1 * s1 - l2 * s12, -l2 * s12], [l1 * c1 + l2 * c12, l2 * c12]])

    right = J(*np.radians([t1, t2]))
    assert exercise.check({"J": right, "v": right @ rates})
    return [
        ("J", right.T, "transposed"), ("J", J(t1, t2), "degrees"), ("J", [-right[0], right[1]], "term_sign"),
        ("J", right - [[right[0, 1], 0], [right[1, 1], 0]], "last_link_left_out"),
    ]  # fmt: skip


def _solution_mistakes(exercise: Exercise) -> Planted:
    rows = exercise.asked[0].value
    lengths, phi = exercise.facts["L"], np.radians(exercise.facts["phi"])
    for row in rows:
        at = np.cumsum(row)
        assert [lengths @ np.cos(at), lengths @ np.sin(at)] == pytest.approx([exercise.facts["x"], exercise.facts["y"]])
        assert np.cos(at[2] - phi) == pytest.approx(1.0)
    assert exercise.check(rows[::-1] + 2 * pi)
    return [
        ("solutions", rows[:1], "missed"), ("solutions", np.degrees(rows), "degrees"),
        ("solutions", [rows[0], rows[1] + [0.3, 0, 0]], "solution"),
    ]  # fmt: skip


def _torque_mistakes(exercise: Exercise) -> Planted:
    l1, l2, m1, m2 = (exercise.facts[name] for name in ("l1", "l2", "m1", "m2"))
    a, b = np.radians([exercise.facts["t1"], exercise.facts["t2"]])
    (da, db), qdd, h = exercise.facts["qd"], exercise.facts["qdd"], m2 * l1 * l2
    M12, c = m2 * l2**2 + h * np.cos(b), np.array([-h * np.sin(b) * (2 * da * db + db**2), h * np.sin(b) * da**2])
    M = np.array([[(m1 + m2) * l1**2 + m2 * l2**2 + 2 * h * np.cos(b), M12], [M12, m2 * l2**2]])
    g = 9.81 * np.array([(m1 + m2) * l1 * np.cos(a) + m2 * l2 * np.cos(a + b), m2 * l2 * np.cos(a + b)])
    assert exercise.check({"M": M, "tau": M @ qdd + c + g})
    return [
        ("tau", M @ qdd + c, "no_gravity"),
        ("tau", M @ qdd + g, "no_velocity_terms"),
        ("tau", M @ qdd + c - g, "gravity_sign"),
    ]


def _screw_mistakes(exercise: Exercise) -> Planted:
    w, q, h = (exercise.facts[name] for name in ("w", "q", "h"))
    v = np.cross(q, w) + h * np.asarray(w)
    assert exercise.check([*w, *v])
    return [
        ("S", [*v, *w], "parts_swapped"),
        ("S", [*w, *(np.cross(w, q) + h * w)], "cross_order"),
        ("S", [*w, *np.cross(q, w)], "no_pitch"),
    ]


def _count_mistakes(exercise: Exercise) -> Planted:
    f = exercise.facts
    ones = f["pins"] + f["sliders"]
    N, J, total = f["links"], ones + f["slots"], ones + 2 * f["slots"]
    M = 3 * (N - 1 - J) + total
    assert exercise.check({"mobility": M, "loops": J - N + 1})
    return [
        ("mobility", 3 * (N - J) + total, "ground_moves"),
        ("mobility", 3 * (N - 2 - J) + total, "ground_left_out"),
        ("loops", J - N, "loops_no_one"),
    ]


def _circle_mistakes(exercise: Exercise) -> Planted:
    r, q, c = exercise.facts["r"], exercise.facts["q"], exercise.facts["c"]
    for theta in exercise.asked[0].value.ravel():
        assert np.linalg.norm(r * np.array([np.cos(theta), np.sin(theta), 0.0]) - q) == pytest.approx(c)
    x, y = exercise.asked[0].value.ravel()
    return [("angles", [x], "missed"), ("angles", [x - (x + y) / 2, y - (x + y) / 2], "middle_left_out")]


def _projector_mistakes(exercise: Exercise) -> Planted:
    a, inertia, P = exercise.facts["a"], exercise.facts["inertia"], exercise.asked[0].value
    assert a @ np.linalg.inv(inertia) @ P == pytest.approx(np.zeros(2), abs=1e-12)
    assert P @ P == pytest.approx(P)
    tangent = inertia @ [-a[1], a[0]]
    assert P @ tangent == pytest.approx(tangent)
    flat = np.eye(2) - np.outer(a, a) / (a @ a)
    return [("projector", flat, "metric_left_out"), ("projector", np.eye(2) - P, "other_part")]


def _oscillator_mistakes(exercise: Exercise) -> Planted:
    A, x0, t = exercise.facts["A"], exercise.facts["x0"], exercise.facts["t"]
    w = float(np.sqrt(-A[1, 0]))
    x = x0[0] * np.cos(w * t) + x0[1] / w * np.sin(w * t)
    v = -x0[0] * w * np.sin(w * t) + x0[1] * np.cos(w * t)
    assert exercise.check([x, v])
    return [("state", [x0[0] + t * x0[1], x0[1] - w * w * t * x0[0]], "first_order")]


def _body_screw_mistakes(exercise: Exercise) -> Planted:
    p, angle, S = exercise.facts["p"], exercise.facts["angle"], np.array(exercise.facts["S"])
    turn = Oracle.from_euler("z", angle, degrees=True).inv()
    w, v = turn.apply(S[:3]), turn.apply(S[3:] - np.cross(p, S[:3]))
    assert exercise.check([*w, *v])
    return [("B", [*w, *turn.apply(S[3:])], "only_turned"), ("B", [*v, *w], "parts_swapped")]


def _chain_mistakes(exercise: Exercise) -> Planted:
    q, m, along = (np.asarray(exercise.facts[name]) for name in ("q", "m", "along"))
    turn, d = Oracle.from_euler("z", exercise.facts["theta"], degrees=True), exercise.facts["d"]
    p = q + turn.apply(m + d * along - q)
    assert exercise.check(p)
    return [("p", q + turn.apply(m - q) + d * along, "order"), ("p", q + turn.inv().apply(m + d * along - q),
        "rotation_reversed"), ("p", 1000 * p, "millimetres")]  # fmt: skip


def _body_points_mistakes(exercise: Exercise) -> Planted:
    n, space = exercise.facts["count"], exercise.facts["space"]
    assert exercise.check(n * space - space * (space + 1) // 2)
    return [("independent", n * (n - 1) // 2, "all_distances")]


INDEPENDENT: dict[str, Callable[[Exercise], Planted]] = {
    "2.2.1 linkage": _count_mistakes, "4.2.3 five forms": _rotation_mistakes, "4.3.2 frames": _frame_mistakes,
    "4.3.3.1 screw": _screw_mistakes, "6.1.1 jacobian": _jacobian_mistakes, "7.0 all solutions": _solution_mistakes,
    "9.1.1 torques": _torque_mistakes, "7.1.2 circle and sphere": _circle_mistakes,
    "10.4.2 projector": _projector_mistakes, "4.2.5.1 oscillator": _oscillator_mistakes,
    "5.2.4 body screw": _body_screw_mistakes, "5.2.1 product": _chain_mistakes, "2.1 points": _body_points_mistakes,
}  # fmt: skip


@pytest.mark.parametrize("number", INDEPENDENT)
def test_answers_and_mistakes_by_another_road(number: str) -> None:
    named = []
    for seed in range(12):
        exercise = mf.book.exercise(number, seed=seed, level=1 + seed % 3)
        for part, given, mistake in INDEPENDENT[number](exercise):
            verdict = next(v for v in exercise.check({part: given}) if v.part == part)
            named.append(verdict.mistake == mistake)
    assert np.mean(named) >= 0.9


def test_a_solution_in_letters() -> None:
    exercise = mf.book.exercise("6.1.1 jacobian", seed=1)
    assert "J_p" in exercise.derive("en")
    assert "1." in exercise.derive("ar")
    assert mf.book.exercise("4.3.3.1 screw").derive() == ""


def test_a_mistake_without_a_result_somewhere_in_the_range_is_left_out() -> None:
    """Between two values of the given where a mistake's result changes its sign it has none in the middle."""
    one = mf.book.exercise("10.3 force loop: inverse", seed=158, level=3)
    assert one.check({part.name: part.value for part in one.asked})
