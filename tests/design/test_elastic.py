"""Deflection and natural frequencies against closed forms of beams, and a chain of rigid pieces with springs."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import mafsil as mf
from mafsil.design import FlexibleArm, ParametricArm, Tube

L, OUTER, WALL, g = 0.8, 0.08, 0.004, 9.81
TUBE = {"outer": OUTER, "wall": WALL, "material": "steel"}
SECTION = Tube(OUTER, WALL, mf.design.parts.MATERIALS["steel"])
E, G, I, A = SECTION.material.young, SECTION.material.shear, SECTION.second_moment, SECTION.area
LINE = SECTION.material.density * A


def beam(**joint: object) -> mf.design.ArmDesign:
    """One link along x, its joint about y."""
    table = {"convention": "frames", "joint": [{"axis": [0.0, 1.0, 0.0], "tube": TUBE, **joint}]}
    return ParametricArm.of({**table, "tool": {"xyz": [L, 0.0, 0.0]}}).at()


def test_section_of_a_tube_is_that_of_two_discs() -> None:
    inner = OUTER - 2 * WALL
    assert pytest.approx(pi / 4 * (OUTER**2 - inner**2)) == A
    assert pytest.approx(pi / 64 * (OUTER**4 - inner**4)) == I
    with pytest.raises(mf.InputError, match="wall"):
        Tube(0.1, 0.06)


def test_cantilever_under_its_weight_a_payload_and_a_wrench() -> None:
    arm = FlexibleArm(beam(), payload=5.0)
    weight, push = LINE * g, 5.0 * g
    sag, slope = (
        weight * L**4 / (8 * E * I) + push * L**3 / (3 * E * I),
        weight * L**3 / (6 * E * I) + push * L**2 / (2 * E * I),
    )
    np.testing.assert_allclose(arm.deflection([0.0]), [0, slope, 0, 0, 0, -sag], rtol=1e-9, atol=1e-15)
    C = FlexibleArm(beam()).compliance([0.0]).reshape(6, 6)
    assert C[0, 0] == pytest.approx(L / (G * 2 * I))
    assert C[3, 3] == pytest.approx(L / (E * A))
    assert C[4, 4] == pytest.approx(L**3 / (3 * E * I))
    assert C[2, 4] == pytest.approx(L**2 / (2 * E * I))
    np.testing.assert_allclose(C, C.T, atol=1e-18)


@pytest.mark.parametrize("payload", [0.0, 2.0, 50.0])
def test_frequencies_of_a_cantilever_with_a_mass_at_its_end(payload: float) -> None:
    """1 + cos b cosh b + mu b (cos b sinh b - sin b cosh b) = 0, mu = payload / mass of the beam."""
    mu = payload / (LINE * L)

    def condition(b: float) -> float:
        return 1 + cos(b) * cosh(b) + mu * b * (cos(b) * sinh(b) - sin(b) * cosh(b))

    first = brentq(condition, 0.1, 1.9)
    second = brentq(condition, 3.8, 4.8)
    wanted = [b**2 / L**2 * sqrt(E * I / LINE) / (2 * pi) for b in (first, second)]
    found = FlexibleArm(beam(), payload=payload).frequencies([0.3], 6)
    # Both planes of a round tube: each frequency twice, and stretch and torsion among them.
    np.testing.assert_allclose(found[:2], wanted[0], rtol=2e-4)
    assert (np.abs(found / wanted[1] - 1) < 5e-3).sum() == 2


def test_spring_of_a_joint_alone() -> None:
    table = {"convention": "frames", "tool": {"xyz": [L, 0.0, 0.0]}}
    design = ParametricArm.of({**table, "joint": [{"axis": [0.0, 1.0, 0.0], "drive": {"stiffness": 3e3}}]}).at()
    arm = FlexibleArm(design, payload=4.0)
    assert arm.deflection([0.0])[5] == pytest.approx(-4.0 * g * L * L / 3e3)
    assert arm.frequencies([0.0], 1)[0] == pytest.approx(sqrt(3e3 / (4.0 * L**2)) / (2 * pi))
    assert np.isinf(arm.frequencies([0.0], 2)[1])


def pieces(
    q: tuple[float, float], lengths: tuple[float, float], springs: tuple[float, float], payload: float, per: int
):
    """A plane arm of rigid pieces with springs between them: sag of the tip and lowest frequency, by virtual work.

    Nothing is shared with the finite elements: positions of midpoints are differentiated with respect to the bends.
    """
    angles, steps, stiffness = [], [], []
    for k, length in enumerate(lengths):
        h = length / per
        # Half pieces at both ends, so that hinges lie where the bending is lumped.
        steps += [h / 2, *([h] * (per - 1)), h / 2]
        stiffness += [springs[k], *([E * I / h] * per)]
        angles += [q[k], *([0.0] * per)]
    directions = np.cumsum(angles)
    ends = np.concatenate(
        [[[0.0, 0.0]], np.cumsum(np.array(steps)[:, None] * np.stack([np.cos(directions), np.sin(directions)], 1), 0)]
    )
    N = len(steps)
    middle = (ends[1:] + ends[:-1]) / 2

    def jacobian(point: np.ndarray, upto: int) -> np.ndarray:
        away = [point - ends[i] if i <= upto else np.zeros(2) for i in range(N)]
        return np.array([[-y, x] for x, y in away]).T

    K, M, load = np.diag(stiffness), np.zeros((N, N)), np.zeros(N)
    for i, h in enumerate(steps):
        J, w = jacobian(middle[i], i), np.array([1.0 if j <= i else 0.0 for j in range(N)])
        M += LINE * h * (J.T @ J + h**2 / 12 * np.outer(w, w))
        load += J.T @ np.array([0.0, -LINE * h * g])
    J = jacobian(ends[-1], N)
    M += payload * J.T @ J
    load += J.T @ np.array([0.0, -payload * g])
    sag = J @ np.linalg.solve(K, load)
    lowest = np.linalg.eigvals(np.linalg.solve(K, M)).real.max()
    return sag, 1 / sqrt(lowest) / (2 * pi)


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.4, 0.9), (1.2, -2.0)])
def test_plane_arm_against_rigid_pieces_with_springs(q: tuple[float, float]) -> None:
    lengths, springs, payload = (0.6, 0.5), (4e4, 2e4), 3.0
    table = {
        "convention": "frames",
        "gravity": [0.0, -g, 0.0],
        "tool": {"xyz": [lengths[1], 0.0, 0.0]},
        "joint": [
            {"tube": TUBE, "drive": {"stiffness": springs[0]}},
            {"xyz": [lengths[0], 0.0, 0.0], "tube": TUBE, "drive": {"stiffness": springs[1]}},
        ],
    }
    arm = FlexibleArm(ParametricArm.of(table).at(), payload=payload)
    sag, lowest = pieces(q, lengths, springs, payload, 80)
    np.testing.assert_allclose(arm.deflection(list(q))[3:5], sag, rtol=0.01, atol=1e-7)
    # The arm also sways out of its plane: its frequency in the plane is among the first.
    found = arm.frequencies(list(q), 4)
    assert np.abs(found / lowest - 1).min() < 0.01
    assert arm.deflection([q, q]).shape == (2, 6)
