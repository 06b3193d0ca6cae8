"""Remarks of the book: the numbers that decide them, and where they are said."""

import numpy as np
import pytest

import mafsil as mf


def said(number: str, entry: str, kind: str) -> bool:
    """Whether `explain` of a figure or an example says the remark in both languages."""
    remark, place = mf.book.remark(number), getattr(mf.book, kind)(entry)
    return all(remark.words("caption", language) in place.explain(language) for language in ("en", "ar"))


@pytest.mark.capability("12-2")
def test_computed_torque_needs_no_integral() -> None:
    remark = mf.book.remark("2")
    assert (remark["order"], remark["kp"], remark["kd"]) == (2, 25.0, 10.0)
    assert said("2", "10.11", "figure")


@pytest.mark.capability("12-3")
def test_stiffer_impedance_tracks_closer() -> None:
    remark = mf.book.remark("3")
    for name, k, b in (("soft", 50.0, 10.0), ("stiff", 500.0, 100.0)):
        assert remark[name] == pytest.approx(4.0 / abs(k - 4.0 + 2j * b))
    assert said("3", "10.17", "figure")


@pytest.mark.capability("12-4")
def test_more_kp_changes_the_true_settling_time_only() -> None:
    remark = mf.book.remark("4")
    assert remark["rule"] == pytest.approx([8 * 0.5 / 10.1] * 3)
    assert remark["true"] == pytest.approx([0.39982, 0.38581, 0.35251], abs=1e-5)
    assert said("4", "10.5", "figure")


@pytest.mark.capability("12-5")
def test_the_mass_matrix_never_loses_rank() -> None:
    remark = mf.book.remark("5")
    assert remark["jacobian"] == pytest.approx(0.0, abs=1e-12)
    assert remark["mass"] > 0.01


@pytest.mark.capability("12-6")
def test_half_of_the_torque_at_the_matching_ratio() -> None:
    remark = mf.book.remark("6")
    assert remark["ratio"] == pytest.approx(np.sqrt(1000.0))
    assert remark["share"] == pytest.approx(0.5)
    assert said("6", "10 gear", "example")


@pytest.mark.capability("12-12")
def test_every_because_has_its_therefore() -> None:
    assert mf.book.remarks() == ["1", "2", "3", "4", "5", "6"]
    for number in mf.book.remarks():
        remark = mf.book.remark(number)
        assert "ecause" in remark.words("caption", "en")
        assert "herefore" in remark.words("caption", "en")
        assert "لأن" in remark.words("caption", "ar")
        assert remark.facts
