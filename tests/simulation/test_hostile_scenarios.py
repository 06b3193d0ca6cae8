"""Things that are no scenario are refused by name; runs beyond the memory kept for them before any is taken."""

import numpy as np
import pytest

from mafsil.control import computed_torque, gravity_compensation
from mafsil.errors import InputError
from mafsil.robot import Robot, load
from mafsil.simulation import Scenario, simulate
from mafsil.trajectory import quintic, sequence, trapezoid

ARM = load("planar2r")
MOTION = quintic([0, 0], [1, 1], 1.0)
LAW = computed_torque(ARM)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("robot", None),
        ("trajectory", None),
        ("law", None),
        ("law", lambda t, q: 0),
        ("step", None),
        ("step", "a"),
        ("step", [1e-3]),
        ("duration", "long"),
        ("plant", 3),
        ("noise", 3),
        ("disturbances", 3),
        ("disturbances", (3,)),
    ],
)
def test_wrong_parts_are_named(name, value):
    with pytest.raises(InputError) as caught:
        Scenario(**{"robot": ARM, "trajectory": MOTION, "law": LAW, name: value})
    assert name in caught.value.message("en")
    assert caught.value.message("ar") != caught.value.message("en")


@pytest.mark.parametrize(
    "options",
    [{"step": 1e-12}, {"step": 1e-39}, {"duration": 1e12}, {"q": np.broadcast_to(0.0, (10**9, 2))}],
)
def test_too_much_is_refused_before_memory_is_taken(options):
    with pytest.raises(InputError) as caught:
        Scenario(robot=ARM, trajectory=MOTION, law=LAW, **options)
    assert caught.value.key == "simulation.too_long"


@pytest.mark.parametrize(
    "make",
    [
        lambda: simulate(None),
        lambda: Robot("panda"),
        lambda: load(None),
        lambda: load(b"panda"),
        lambda: computed_torque(None),
        lambda: gravity_compensation(7, 1, 1),
        lambda: sequence(3),
    ],
)
def test_other_things_are_refused_by_kind(make):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.message("ar") != caught.value.message("en")


@pytest.mark.parametrize(
    "make",
    [
        lambda: quintic([0, 0], [1, 1], 1e-300),
        lambda: trapezoid([0, 0], [1, 1], velocity=1e-300, acceleration=1.0),
    ],
)
def test_sizes_that_cannot_be_calculated_with_are_said(make):
    with np.errstate(all="ignore"), pytest.raises(InputError) as caught:
        make()
    assert caught.value.key == "input.size"
