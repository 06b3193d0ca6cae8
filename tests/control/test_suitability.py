"""Which law suits: every task of one or three directions against the rule itself, arms against their numbers."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import mafsil as mf
from mafsil import control
from mafsil.control import Impedance, recommend_controller, selection
from mafsil.control.analysis import (
    ImpedanceClass,
    RecommendedController,
    RecommendedInteraction,
    impedance_class,
    recommend_interaction,
)
from mafsil.errors import InputError
from mafsil.model import Actuator, Friction

WORDS = (("free", 0.0), ("compliant", 3.0))


@pytest.mark.capability("10-1", "10-2", "02-22", "02-23")
def test_tasks_of_the_book_get_their_family():
    assert recommend_controller(["free"] * 6, ["motion"] * 6).status is RecommendedController.MOTION
    chalk = recommend_controller(("free", "free", "rigid"), ("motion", "motion", "force"))
    assert chalk.status is RecommendedController.HYBRID
    assert chalk.direction == "z"
    assert recommend_controller(("rigid", "compliant"), ("force", "force")).status is RecommendedController.FORCE
    haptic = recommend_controller(("compliant",), ("impedance",))
    assert haptic.status is RecommendedController.IMPEDANCE
    for found in (chalk, haptic):
        assert all(callable(getattr(control, name)) for name in found.laws)
        assert found.laws[0] in found.explain("en")
        assert found.explain("ar") != found.explain("en")


@pytest.mark.capability("10-4", "10-59", "02-23")
def test_motion_and_force_along_one_direction_are_refused():
    both = recommend_controller(("free", "compliant"), ("motion", ("motion", "force")), ("along", "into"))
    assert both.status is RecommendedController.BOTH_ASKED
    assert "into" in both.explain("en")
    assert not both.laws
    # Where B is a diagonal, the words say what the rank of the selection says.
    for meets, asked in product(product(WORDS, repeat=3), product(("motion", "force"), repeat=3)):
        found = recommend_controller([word for word, _ in meets], asked)
        choose = np.diag([float(each == "force") for each in asked])
        possible = selection(np.diag([b for _, b in meets]), choose, np.eye(3) - choose)
        assert bool(found) == bool(possible)
    assert recommend_controller(("rigid",), ("motion",)).status is RecommendedController.BLOCKED
    assert recommend_controller(("free",), ("force",)).status is RecommendedController.UNANSWERED
    # Force alone needs an answer in every direction: one that gives none is named.
    alone = recommend_controller(("rigid", "compliant", "free"), ("force",) * 3, ("x", "y", "z"))
    assert alone.status is RecommendedController.UNANSWERED
    assert alone.direction == "z"
    assert (
        recommend_controller(("rigid", "compliant", "compliant"), ("force",) * 3).status is RecommendedController.FORCE
    )
    assert recommend_controller(("free", "rigid"), ("impedance", "force")).status is RecommendedController.MIXED


@pytest.mark.parametrize(
    ("environment", "wanted"),
    [(("soft",), ("motion",)), (("free",), ("rest",)), (("free",), ((),)), (("free",), ()), ((), ())],
)
def test_other_words_are_refused(environment, wanted):
    with pytest.raises(InputError):
        recommend_controller(environment, wanted)


def geared(ratio, dry):
    mechanism = mf.load("planar2r").mechanism
    drive = Actuator(rotor_inertia=1e-4, gear_ratio=ratio)
    joints = tuple(
        replace(j, actuator=drive, friction=Friction(coulomb=dry), limits=replace(j.limits, effort=100.0))
        if j.moves
        else j
        for j in mechanism.joints
    )
    return mf.Robot(replace(mechanism, joints=joints))


@pytest.mark.capability("10-83")
def test_light_arms_take_impedance_control_and_geared_ones_admittance():
    q = np.array([0.3, 0.9])
    light = recommend_interaction(geared(1.0, 0.5), q)
    assert light.status is RecommendedInteraction.IMPEDANCE
    heavy = recommend_interaction(geared(200.0, 0.5), q)
    assert heavy.status is RecommendedInteraction.ADMITTANCE
    M = mf.load("planar2r").mass_matrix(q)
    assert heavy.rotor_share == pytest.approx(4.0 / (np.diag(M) + 4.0))
    rough = recommend_interaction(geared(1.0, 30.0), q)
    assert rough.status is RecommendedInteraction.ADMITTANCE
    assert rough.friction_share == pytest.approx([0.3, 0.3])
    assert "30%" in rough.explain("en")
    assert recommend_interaction(mf.load("puma560"), np.zeros(6)).status is RecommendedInteraction.ADMITTANCE
    assert recommend_interaction(mf.load("planar2r"), q).status is RecommendedInteraction.NOT_KNOWN


@pytest.mark.capability("10-77")
def test_high_and_low_depend_on_what_is_touched():
    law = Impedance.of(2, inertia=2.0, damping=20.0, stiffness=[1000.0, 2000.0])
    soft, hard = Impedance.of(2, stiffness=20.0), Impedance.of(2, stiffness=1e6)
    assert impedance_class(law, soft).status is ImpedanceClass.HIGH
    assert impedance_class(law, hard).status is ImpedanceClass.LOW
    between = impedance_class(law, Impedance.of(2, stiffness=1000.0))
    assert between.status is ImpedanceClass.BETWEEN
    assert between.kept == pytest.approx([1 / 2, 2 / 3])
    # Fast motions meet the mass.
    assert impedance_class(Impedance.of(1, inertia=1.0), Impedance.of(1, stiffness=100.0), 1e3).kept[0] > 0.99
    with pytest.raises(InputError):
        impedance_class(Impedance.of(1, inertia=1.0), Impedance.of(1))
