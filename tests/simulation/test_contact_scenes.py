"""Chalk, eraser, door and peg: what each task asks for is done, and what undoes it undoes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import Impedance, impedance_control
from mafsil.control.contact import AtPoints
from mafsil.errors import InputError
from mafsil.simulation import Plant, chalk_on_board, eraser_on_board, open_a_door, peg_in_hole, simulate

ROBOT = mf.load("puma560")
Q = np.array([0.2, 0.6, -0.9, 0.1, 0.7, 0.3])
T = ROBOT.forward_kinematics(Q)


def in_start(run, k=-1):
    """(3,) from where the tip began, in the axes that it began with."""
    return T[:3, :3].T @ (ROBOT.forward_kinematics(run.q[k])[:3, 3] - T[:3, 3])


@pytest.mark.capability("10-68", "10-71")
@pytest.mark.parametrize(("make", "press"), [(chalk_on_board, 5.0), (eraser_on_board, 8.0)])
def test_boards_are_written_on_and_wiped(make, press):
    run = simulate(make(ROBOT, Q, length=0.04, duration=0.8))
    assert run
    assert np.abs(in_start(run) - [0.04, 0, 0]).max() < 1.5e-3
    into = -run.contact_wrench[-100:, 5]
    assert into.mean() == pytest.approx(press, rel=0.05)
    assert (run.contact_wrench[60:, 5] < 0).all()  # never lifted


@pytest.mark.capability("10-68")
def test_a_soft_hand_opens_the_door_and_a_stiff_one_fights_it():
    scenario = open_a_door(ROBOT, Q, angle=-0.3, wrong=0.1, duration=0.8)
    door = scenario.plant.environment
    run = simulate(scenario)
    assert run
    assert door.angle(ROBOT.forward_kinematics(run.q[-1])) == pytest.approx(-0.33, abs=0.02)
    soft = np.abs(run.contact_wrench[:, 3:]).max()
    assert soft < 20.0
    stiff = Impedance.of(6, damping=[8, 8, 8, 600, 600, 600], stiffness=[200, 200, 200, 1e4, 1e4, 1e4])
    law = impedance_control(ROBOT, stiff, scenario.law.reference)
    fought = simulate(replace(scenario, law=law))
    assert np.abs(fought.contact_wrench[:, 3:]).max() > 4 * soft


def test_the_chamfer_leads_the_peg_in_but_not_from_beside_it():
    scenario = peg_in_hole(ROBOT, Q, off=2e-3, duration=1.0)
    run = simulate(scenario)
    assert run
    moved = in_start(run)
    assert moved[2] > 0.03
    assert 1.5e-3 < moved[0] < 2.3e-3
    peg = scenario.plant.environment
    hole = peg.environment
    moved = hole.mouth + 0.03 * T[:3, 0]
    aside = type(hole)(**{key: getattr(hole, key) for key in hole.__dataclass_fields__} | {"mouth": moved})
    plant = Plant(ROBOT, friction=False, environment=AtPoints(aside, peg.points))
    stuck = simulate(replace(scenario, plant=plant))
    assert in_start(stuck)[2] < 0.01


def test_wrong_requests_are_named():
    for make in (chalk_on_board, eraser_on_board, open_a_door, peg_in_hole):
        with pytest.raises(InputError, match="q"):
            make(ROBOT, Q[:4])
        with pytest.raises(InputError, match="duration"):
            make(ROBOT, Q, duration=-1.0)
    for options in ({"press": 0.0}, {"length": np.nan}):
        with pytest.raises(InputError):
            chalk_on_board(ROBOT, Q, **options)
