"""Parametric arms: numbers of formulas, masses of tubes and drives, and kernels of whole families."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import mafsil as mf
from mafsil.design import ParametricArm
from mafsil.design.family import ArmNumbers

TABLE = {
    "name": "six", "convention": "modified",
    "parameters": {"upper": {"value": 0.4, "low": 0.2, "high": 0.6}, "wall": 0.004},
    "joint": [
        {"d": 0.3, "drive": {"mass": 5.0}},
        {"alpha": "-pi / 2", "tube": {"outer": 0.1, "wall": "wall", "material": "steel"},
         "drive": {"mass": 5.0, "radius": 0.06, "length": 0.1, "stiffness": 2e4}},
        {"a": "upper", "tube": {"outer": 0.08, "wall": "wall"}, "drive": {"mass": 3.0}},
        {"a": 0.05, "d": "1.1 * upper + 0.02 ** 2", "alpha": "-pi / 2", "drive": {"mass": 1.0}},
        {"alpha": "pi / 2", "drive": {"mass": 1.0}},
        {"alpha": "-(pi / 2)", "tube": {"outer": 0.05, "wall": 0.003}},
    ],
    "tool": {"xyz": [0.0, 0.0, 0.1]},
}  # fmt: skip


def test_numbers_of_formulas() -> None:
    arm = ParametricArm.of(TABLE)
    assert arm.free == ("upper",)
    robot = arm.robot(upper=0.5)
    rows = [{"d": 0.3}, {"alpha": -pi / 2}, {"a": 0.5}, {"a": 0.05, "d": 0.5504, "alpha": -pi / 2},
            {"alpha": pi / 2}, {"alpha": -pi / 2}]  # fmt: skip
    tool = np.eye(4)
    tool[2, 3] = 0.1
    plain = mf.Robot.from_dh(rows, "modified", tool=tool)
    q = np.linspace(-1, 1, 6)
    np.testing.assert_allclose(robot.fk(q), plain.fk(q), atol=1e-15)
    assert isinstance(robot.plot, object)


def test_masses_of_tubes_and_drives() -> None:
    arm = ParametricArm.of(TABLE).at(upper=0.5)
    area = lambda outer, wall: pi / 4 * (outer**2 - (outer - 2 * wall) ** 2)  # noqa: E731
    upper = 7850 * area(0.1, 0.004) * 0.5
    fore = 2700 * area(0.08, 0.004) * np.hypot(0.05, 0.5504)
    hand = 2700 * area(0.05, 0.003) * 0.1
    assert arm.mass == pytest.approx(5 + 5 + 3 + 1 + 1 + upper + fore + hand)
    # Shoulder stretched out: weight of each part times its distance, by hand.
    reach = 0.05 + 0.5
    q = np.zeros(6)
    torque = 9.81 * (upper * 0.25 + 3 * 0.5 + fore * (0.5 + 0.025) + (1 + 1 + hand) * reach)
    assert arm.robot.gravity_torque(q)[1] == pytest.approx(-torque)
    # A drive turns with the link before it: drive 2 is the shoulder's and never moves joint 2.
    shoulder = arm.robot.mechanism.links[1].inertial
    assert shoulder is not None
    assert shoulder.mass == 5.0
    assert np.trace(shoulder.inertia) == pytest.approx(5 * (0.06**2 + 0.1**2 / 6))


def test_tube_is_the_difference_of_two_cylinders() -> None:
    tube = mf.design.Tube(0.1, 0.02)
    made = tube.inertial(np.array([0.0, 0.0, 0.7]))
    outer, inner = 2700 * pi * 0.05**2 * 0.7, 2700 * pi * 0.03**2 * 0.7
    assert made.mass == pytest.approx(outer - inner)
    assert made.inertia[2, 2] == pytest.approx(outer * 0.05**2 / 2 - inner * 0.03**2 / 2)
    across = outer * (3 * 0.05**2 + 0.49) / 12 - inner * (3 * 0.03**2 + 0.49) / 12
    assert made.inertia[0, 0] == pytest.approx(across)


def test_kernels_of_a_family_are_those_of_each_robot() -> None:
    arm, rng = ParametricArm.of(TABLE), np.random.default_rng(0)
    designs = [arm.at(upper=value) for value in (0.25, 0.4, 0.55)]
    family = ArmNumbers.stack([ArmNumbers.of(design.robot) for design in designs])
    q, qd, qdd = rng.uniform(-2, 2, (3, 3, 6))
    F = rng.normal(size=(3, 6))
    T, J = family.pose_and_jacobian(q)
    tau = family.torque(q, qd, qdd, F)
    for k, design in enumerate(designs):
        np.testing.assert_allclose(T[k], design.robot.fk(q[k]), atol=1e-14)
        np.testing.assert_allclose(J[k], design.robot.jacobian_body(q[k]), atol=1e-14)
        np.testing.assert_allclose(tau[k], design.robot.inverse_dynamics(q[k], qd[k], qdd[k], F[k]), atol=1e-12)


@pytest.mark.parametrize("name", ["puma560", "panda", "cobra600", "scara_rrrp"])
def test_numbers_of_library_arms(name: str) -> None:
    robot = mf.load(name)
    numbers = ArmNumbers.of(robot)
    q = np.random.default_rng(1).uniform(-1, 1, (5, robot.n))
    np.testing.assert_allclose(numbers.pose_and_jacobian(q)[0], robot.fk(q), atol=1e-14)
    tau = robot.inverse_dynamics(q, q, q) if robot.mechanism.links[1].inertial else np.zeros_like(q)
    np.testing.assert_allclose(numbers.torque(q, q, q, np.zeros(6)), tau, atol=1e-12)


def test_files_and_their_faults(tmp_path) -> None:
    file = tmp_path / "arm.toml"
    text = """
convention = "modified"
[parameters]
l = { value = 0.4, low = 0.2, high = 0.6 }
[[joint]]
tube = { outer = 0.1, wall = 0.01 }
[[joint]]
a = "l"
"""
    file.write_text(text)
    assert ParametricArm.of(file).robot(l=0.3).n == 2
    for old, new, word in (
        ('"l"', '"m"', "'m'"),
        ('"l"', '"l("', "no value"),
        ('"l"', '"1 / 0"', "no value"),
        ('"l"', '"9.0 ** 9999"', "no value"),
        ('"l"', '"(-1.0) ** 0.5"', "no value"),
        ('"l"', '"l.real"', "no value"),
        ('"l"', '"' + "(" * 300 + '"', "no value"),
        ("outer", "out", "outer"),
        ("0.01 }", '0.01, material = "wood" }', "steel"),
        ("low = 0.2", "low = 0.5", "value"),
        ("wall = 0.01", "wall = 0.06", "wall"),
        ("{ outer = 0.1, wall = 0.01 }", "3", "table"),
        ("outer = 0.1, ", "", "outer"),
        ("outer = 0.1", "outer = nan", "number"),
        ("value = 0.4", 'value = "x"', "number"),
        ("[[joint]]\na", "[[joint]]\nb", "b"),
        ("[parameters]", "parameters = 3\n[other]", "parameters"),
    ):
        file.write_text(text.replace(old, new))
        with pytest.raises(mf.MafsilError, match=word):
            ParametricArm.of(file)
    file.write_text(text)
    arm = ParametricArm.of(file)
    for wrong in ({"l": 0.7}, {"m": 0.3}, {"l": float("nan")}, {"l": "x"}):
        with pytest.raises(mf.InputError):
            arm.at(**wrong)
