"""Worked examples: every number of the live objects against an independent one, every misprint as a difference."""

import numpy as np
import pytest

import mafsil as mf

EXACT = {
    "2.1": {"four_bar": 3 * (4 - 1 - 4) + 4, "slider_crank": 1, "slotted_slider_crank": 3 * (3 - 1 - 3) + 4},
    "2.2": {"chain": 3, "five_bar": 3 * (5 - 1 - 5) + 5, "stephenson": 3 * (6 - 1 - 7) + 7, "watt": 1},
    "2.3": {"overlapping_joints": 3 * (8 - 1 - 9) + 9, "links": 8, "joints": 9},
    "2.4": {"count": 3 * (5 - 1 - 6) + 6, "true": 1, "locked": 1, "rank": 3},
    "2.5": {"six_ups": 6 * (14 - 1 - 18) + 12 + 6 + 18, "six_sps": 12, "links": 14, "joints": 18},
    "2.6": {"three_upu": 3, "at_home": 5},
    "2.7": {"task": 4, "joints": 4},
    "2.8": {"task": 5, "redundancy": 1, "rank": 6},
    "3.2.2": {"printed_signs": 0, "pinwheel": 1},
    "3.2.4": {"closure": 1, "null": [1, 1, 1, 1]},
    "3.3.1": {"with_friction": 1, "without": 0, "push": 9.81},
    "4.1": {"q": [(np.sqrt(3) - 1) / 2, -(np.sqrt(3) + 1) / 2], "turn": np.pi / 6},
    "4.3.2": {"T_ab": [200, 200, 50], "height": 70, "T_ce_x": -70, "T_ce_z": 160 / np.sqrt(2)},
    "4.3.3.2": {"angle": np.pi / 6, "pole": [1.5 + (2 + np.sqrt(3)) / 2] * 2, "v": [3.366025404, -3.366025404]},
    "5.1.4 3R": {"home": [1, 0, -1]},
    "5.1.4 RRRP": {"home": [1, 0, 0]},
    "5.1.4 6R": {"home": [2, 0, 0]},
    "5.2.2 3R": {"v_2": -np.cross([0, -1, 0], [1, 0, 0]), "v_3": -np.cross([1, 0, 0], [1, 0, -1])},
    "5.2.2 6R": {"v_4": -np.cross([-1, 0, 0], [0, 1, 0]), "v_5": -np.cross([-1, 0, 0], [0, 2, 0])},
    "5.2.2 RRPRRR": {"v_3": [0, 1, 0], "v_5": -np.cross([1, 0, 0], [0, 1, 0])},
    "5.2.4": {"v_1": [-3, 0, 0], "v_4": [0, 0, -2], "v_5": [0, 0, -1]},
    "6.1.1 RRRP": {"v_2": [np.sin(0.4), -np.cos(0.4), 0], "v_4": [0, 0, -1]},
    "6.1.1 RRPRRR": {"length": 1, "rank": 6},
    "9.1.1 particle": {"force": 2.0 * (1.5 + 9.81)},
    "9.1.1 2R": {"tau_1": 36.8921182385, "tau_2": 8.0102989181},
    "10 gear": {"link_share": 100 / 1.001, "motor_share": 1000 / 11, "ratio": np.sqrt(1000), "half": 0.5},
    "10 damper": {"V_2": 3, "F_2": 4, "possible": 1, "conflict": 0},
    "10 door": {"force": 5, "motion": 1},
    "10 chalk": {"smooth_force": 1, "smooth_motion": 5, "sticking_force": 3, "sticking_motion": 3, "lifted_motion": 6},
    "10 eraser": {"force": 3, "motion": 3},
    "10 one-joint arm": {"damping_ratio": 1, "rest": 0.408322, "ki": 9.261},
}  # fmt: skip
MISPRINTS = {
    "2.3": {"links"}, "3.2.2": {"printed_signs"}, "4.3.2": {"height", "T_ce_x", "T_ce_z"}, "4.3.3.2": {"pole", "v"},
    "5.2.2 3R": {"v_3"}, "5.2.2 6R": {"v_4", "v_5"}, "9.1.1 2R": {"tau_1", "tau_2"}, "10 gear": {"link_share"},
}  # fmt: skip


@pytest.mark.parametrize("number", EXACT)
def test_numbers_and_misprints(number: str) -> None:
    example = mf.book.example(number)
    for name, value in EXACT[number].items():
        assert example[name] == pytest.approx(np.asarray(value), rel=2e-6, abs=1e-9), name
    assert {fact.name for fact in example.facts if not fact.agrees} == MISPRINTS.get(number, set())
    if number in MISPRINTS:
        assert example.erratum
    assert example.objects
    for language in ("en", "ar"):
        text = example.explain(language)
        assert number in text
        assert all(example.words(part, language) in text for part in ("", "erratum"))


def test_all_of_them() -> None:
    assert set(mf.book.examples()) == set(EXACT)
    with pytest.raises(mf.errors.InputError, match=r"2\.9"):
        mf.book.example("2.9")


def test_the_printed_torques_are_not_those_of_lagrange() -> None:
    example = mf.book.example("9.1.1 2R")
    printed = [fact.printed for fact in example.facts]
    assert printed == pytest.approx([37.0889539350, -5.7227918050])


def test_the_printed_pole_misses_the_goal() -> None:
    T_sb = mf.book.example("4.1").objects["T_sb"]
    turned = mf.geometry.planar.about_pole(np.pi / 6, [3.0, 3.0]) @ T_sb
    right = mf.geometry.planar.about_pole(np.pi / 6, mf.book.example("4.3.3.2")["pole"]) @ T_sb
    assert np.linalg.norm(turned[:2, 2] - [2.0, 1.0]) > 0.1
    assert right[:2, 2] == pytest.approx([2.0, 1.0])
