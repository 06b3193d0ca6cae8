"""Rows R1 and R2 at the size of a pull request; `tests.reliability.random_trees` goes on to any size."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio")
pytest.importorskip("mujoco")

from mafsil.model import JointKind
from mafsil.robot import Robot
from tests.oracles import ours
from tests.oracles.natural_scale import natural_scale
from tests.oracles.states import sample
from tests.reliability import random_trees
from tests.reliability.random_trees import LIMIT, MEDIAN_LIMIT, Figures, errors_of, robot, run

SECONDS = 2.0
ULP_LIMIT = 64 * 2.0**-52


@pytest.mark.capability("05-9", "05-11", "09-38")
@pytest.mark.row("R1")
def test_random_trees_agree_with_pinocchio_and_mujoco() -> None:
    figures = run(range(8), Figures(), None)
    figures = run(range(100_000), figures, None, SECONDS)
    assert figures.robots > 8
    assert {"pinocchio", "mujoco"} <= figures.checks.keys()
    assert not figures.beyond, random_trees.report(figures)
    assert figures.median_below <= MEDIAN_LIMIT


def test_random_trees_have_all_that_they_promise() -> None:
    joints = [joint for number in range(200) for joint in robot(number).joints]
    assert {joint.kind for joint in joints} == {kind for kind in JointKind if kind.freedoms <= 1}
    assert any(joint.mimic for joint in joints)
    assert any(joint.actuator for joint in joints)
    assert any(np.array_equal(np.abs(joint.T_pj[:3, :3]).sum(axis=0), np.ones(3)) for joint in joints)
    assert any(link.inertial is None for number in range(50) for link in robot(number).links[1:])


@pytest.mark.row("R1")
@pytest.mark.row("R2")
@pytest.mark.parametrize("number", [0, 2, 3])
def test_compiled_random_trees_agree_with_the_oracles(number: int) -> None:
    mechanism = robot(number)
    errors, _ = errors_of(number, mechanism, partial(ours.compiled, Robot(mechanism)))
    assert max(errors.values()) < LIMIT, errors


@pytest.mark.row("R2")
@pytest.mark.parametrize("number", [0, 2, 3])
def test_kernels_agree_with_casadi_and_all_ways_to_call_agree_bitwise(number: int) -> None:
    mechanism = robot(number)
    machine, scale = Robot(mechanism), natural_scale(mechanism)
    states = sample(mechanism, 1003, np.random.default_rng(number))
    reference = ours.traced(mechanism, states)
    batch = ours.compiled(machine, states)
    M = reference["mass_matrix"]
    for name, values in batch.items():
        assert np.isfinite(values).all()
        assert scale.error(name, values, reference[name], M).max() < ULP_LIMIT, name
    for rows in (slice(0, 1), slice(5, 8), slice(1, 1002), slice(1002, None), slice(None, None, -3)):
        part = ours.compiled(machine, states.part(rows))
        assert all(np.array_equal(part[name], batch[name][rows]) for name in batch)
    for row in (0, 501, 1002):
        single = ours.compiled(machine, states.part(row))  # type: ignore[arg-type]
        assert all(np.array_equal(single[name], batch[name][row]) for name in batch)


def test_a_run_goes_on_where_it_stopped(tmp_path: Path) -> None:
    arguments = ["--robots", "6", "--output", str(tmp_path)]
    assert random_trees.main([*arguments, "--seconds", "0"]) == 0
    assert random_trees.main([*arguments, "--resume"]) == 0
    place = tmp_path / "6-1-of-1.json"
    figures = json.loads(place.read_text())
    assert (figures["robots"], figures["next"]) == (6, 6)
    before = place.read_bytes()
    assert random_trees.main([*arguments, "--resume"]) == 0
    assert json.loads(before)["worst"] == json.loads(place.read_text())["worst"]


def test_a_wrong_number_is_found() -> None:
    mechanism = robot(2)

    def off_by_a_little(states):
        answers = ours.traced(mechanism, states)
        return answers | {"gravity_torque": answers["gravity_torque"] + 1e-11 * natural_scale(mechanism).size.moment}

    errors, _ = errors_of(2, mechanism, off_by_a_little)
    assert errors["gravity_torque"] > LIMIT
    assert errors["mass_matrix"] < LIMIT
