"""Singular configurations: invariance, the five cases built on purpose, factored determinants, loci."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.derivation.arm import symbolic_arm
from mafsil.derivation.determinant import determinant as derived_determinant
from mafsil.errors import InputError
from mafsil.geometry import pose, screw
from mafsil.performance import (
    characteristic_length,
    determinant_factors,
    generic_rank,
    is_singular,
    singular_values,
    singularity,
    singularity_locus,
    task_jacobian,
)
from tests.sizes import size

SQUARE = (
    "puma560", "ur5e", "ur3e", "stanford_arm", "cobra600", "planar2r", "planar3r", "arm6r", "elbow6r", "rrprrr",
    "rrprrr_upright", "scara_rrrp", "offset_puma", "offset_stanford", "generalized_puma",
)  # fmt: skip


@pytest.mark.capability("05-73")
@given(seed=st.integers(0, 10**6))
@settings(max_examples=size(5, 15), deadline=None)
def test_base_and_tool_change_no_singular_value(seed):
    rng = np.random.default_rng(seed)
    S, q = rng.normal(size=(6, 6)), rng.normal(size=(3, 6))
    S = screw.from_axis(S[:, :3], S[:, 3:])
    P, Q, M = (pose.exp(rng.normal(size=6)) for _ in range(3))
    plain = mf.Robot.from_screws(S, M)
    moved = mf.Robot.from_screws(S @ pose.adjoint(P).T, P @ M @ Q, normalise=True)
    np.testing.assert_allclose(
        singular_values(moved, q, length=0.7), singular_values(plain, q, length=0.7), rtol=1e-9, atol=1e-10
    )


def places(count):
    """Where the chosen axes stand in the arm: random ones between them, lest they depend on each other always."""
    return tuple(int(k) for k in np.round(np.linspace(0, 5, count)))


def built(*axes):
    """A 6-joint arm whose axes at zero include (direction, point), or (direction,) if prismatic; others are random."""
    rng = np.random.default_rng(4)
    columns = [screw.from_axis(rng.normal(size=3), rng.normal(size=3)) for _ in range(6)]
    for k, axis in zip(places(len(axes)) if axes else (), axes, strict=True):
        columns[k] = np.r_[0, 0, 0, axis[0]] if len(axis) == 1 else screw.from_axis(axis[0], axis[1])
    return mf.Robot.from_screws(np.array(columns, dtype=float), np.eye(4), normalise=True)


X, Y, Z = np.eye(3)
C, N = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -1.0]) / np.sqrt(6)
U = np.cross(N, X) / np.linalg.norm(np.cross(N, X))
W = np.cross(N, U)
BUILT = {
    "collinear_same": [(N, C), (N, C + 2 * N)],
    "collinear_opposite": [(N, C), (-N, C - N)],
    "parallel_coplanar": [(N, C), (N, C + U), (-N, C + 3 * U)],
    "concurrent": [(X, C), (Y, C), (Z, C), (N, C)],
    "coplanar": [(U, C), (W, C + U), (U + W, C - 2 * W), (U - 2 * W, C + 3 * U)],
    "one_line": [(v, C + k * N) for k, v in enumerate([X, Y, Z, X + Y, Y - 2 * Z, X + 3 * Z])],
    "pencil": [(U, C), (W, C), (U + W, C)],
    "parallel_prismatic": [(N,), (-N,)],
    "coplanar_prismatic": [(U,), (W,), (U + W,)],
    "prismatic_across": [(N, C), (N, C + U), (W,)],
    "coplanar_prismatic_normal": [(U, C), (W, C + U), (U + W, C - 2 * W), (N,)],
    "planar_motion": [(N, C), (N, C + U), (U,), (W + U,)],
    "one_plane_of_directions": [(v, p) for v, p in zip(
        [U, W, U + W, U - W, 2 * U + W, U - 3 * W], np.random.default_rng(1).normal(size=(6, 3)), strict=True)],
}  # fmt: skip
NUMBERED = {"collinear_same": "I", "collinear_opposite": "I", "parallel_coplanar": "II", "concurrent": "III",
            "coplanar": "IV", "one_line": "V"}  # fmt: skip


@pytest.mark.capability("05-74", "05-75", "05-76", "05-77", "05-78", "05-79")
@pytest.mark.parametrize("case", BUILT)
def test_a_case_built_on_purpose_is_named(case):
    arm = built(*BUILT[case])
    found = singularity(arm, np.zeros(6))
    assert found.singular
    cause = next(cause for cause in found.causes if cause.case == case)
    assert cause.joints == places(len(BUILT[case]))
    assert cause.number == NUMBERED.get(case, "")
    assert cause.names[0] in cause.sentence("en")
    assert cause.sentence("ar") in found.explain("ar")
    np.testing.assert_allclose(arm.jacobian_space(np.zeros(6)) @ found.null_rates.T, 0, atol=1e-9)
    if case == "concurrent":
        np.testing.assert_allclose(cause.point, C, atol=1e-9)


@pytest.mark.capability("05-74")
@pytest.mark.parametrize("miss", [1e-2, 1e-3])
def test_nearly_collinear_is_not_singular(miss):
    arm = built((N, C), (N + miss * U, C))
    assert not singularity(arm, np.zeros(6)).singular
    assert is_singular(arm, np.zeros(6), tolerance=0.1)


@pytest.mark.capability("05-70", "05-71", "05-80")
@pytest.mark.parametrize("name", SQUARE)
def test_lost_twists_and_carried_wrenches(name):
    robot = mf.load(name)
    locus = singularity_locus(robot, samples=6)
    for component in locus.components:
        if component.empty or locus.determinant.task != "pose":
            continue
        found = singularity(robot, component.samples[0], tolerance=1e-5)
        J = robot.jacobian_space(component.samples[0])
        np.testing.assert_allclose(found.wrenches @ J, 0, atol=1e-5)
        assert len(found.lost_twists) == found.generic_rank - found.rank
        for V in found.lost_twists:
            assert np.abs(found.wrenches @ V).max() > 1e-3, "a lost twist works against a carried wrench"
            rest = V - J @ np.linalg.lstsq(J, V, rcond=1e-6)[0]
            assert np.linalg.norm(rest) > 1e-3 * np.linalg.norm(V)
        assert len(found.lost_screws) == len(found.lost_twists)


@pytest.mark.capability("05-70", "05-71")
def test_a_scara_loses_one_translation():
    robot = mf.load("scara_rrrp")
    assert generic_rank(robot) == 4
    found = singularity(robot, np.zeros(4))
    (screw_,) = found.lost_screws
    np.testing.assert_allclose(screw_.direction, [1, 0, 0], atol=1e-9)
    assert np.isinf(screw_.pitch)
    assert found.cases == ("II (joint1, joint2, joint3)",)
    assert "II" in found.explain("en")


@pytest.mark.capability("05-73", "05-79")
@pytest.mark.parametrize("name", SQUARE)
def test_factored_determinant_is_the_determinant(name):
    robot = mf.load(name)
    found = determinant_factors(robot)
    q = np.random.default_rng(8).uniform(-3, 3, (200, robot.n))
    truth = np.linalg.det(task_jacobian(robot, q, found.task))
    np.testing.assert_allclose(found.evaluate(q), truth, atol=1e-12 * np.abs(truth).max() + 1e-300, rtol=1e-9)
    for factor, value in zip(found.factors, found.each(q), strict=True):
        assert factor.form is not None
        np.testing.assert_allclose(factor.form(q), value, atol=1e-11)
    assert len(found.factors) == (3 if robot.n == 6 else 1)


@pytest.mark.capability("05-73")
@pytest.mark.parametrize("name", ["puma560", "ur5e", "stanford_arm", "elbow6r"])
def test_another_road_to_the_determinant(name):
    """The derivation in letters and the geometric factors vanish together: same product up to sign."""
    robot = mf.load(name)
    letters = derived_determinant(symbolic_arm(robot.mechanism))
    assert letters is not None
    q = np.random.default_rng(8).uniform(-3, 3, (50, robot.n))
    arm = symbolic_arm(robot.mechanism)
    values = arm.values(q) if hasattr(arm, "values") else None
    if values is None:
        pytest.skip("the derivation offers no values of its letters")
    product = np.prod([factor.evaluate(values) for factor in letters.factors], axis=0)
    np.testing.assert_allclose(np.abs(product), np.abs(determinant_factors(robot).evaluate(q)), rtol=1e-8, atol=1e-12)


@pytest.mark.capability("05-79")
@pytest.mark.parametrize("name", SQUARE)
def test_singularity_locus(name):
    robot = mf.load(name)
    locus = singularity_locus(robot, samples=24)
    assert locus.verified
    assert all(len(component.samples) == 24 for component in locus.components)
    assert name in locus.explain("en")
    assert locus.explain("ar") != locus.explain("en")


@pytest.mark.capability("05-79")
def test_singularity_locus_names_what_books_name():
    puma = singularity_locus(mf.load("elbow6r"))
    conditions = {component.condition for component in puma.components}
    assert conditions == {"-cos(q2) - cos(q2 + q3) = 0", "q3 = 0, pi", "q5 = 0, pi"}
    arm = determinant_factors(mf.load("arm6r", tip=None))
    assert {f.form.text() for f in arm.factors} == {"sin(q5) + sin(q4 + q5)", "sin(q4)", "cos(q2)"}
    ur = singularity_locus(mf.load("ur5e"))
    assert {component.condition for component in ur.components} >= {"q3 = 0, pi", "q5 = 0, pi"}


@pytest.mark.capability("05-70")
def test_what_has_no_determinant():
    with pytest.raises(InputError, match="not square"):
        determinant_factors(mf.load("panda"))
    with pytest.raises(InputError, match="vanishes at every configuration"):
        determinant_factors(mf.load("spatial3r"))
    with pytest.raises(InputError, match="one configuration"):
        singularity(mf.load("puma560"), np.zeros((2, 6)))


def test_generic_arms_do_not_split():
    arm = built()
    found = determinant_factors(arm)
    assert [factor.kind for factor in found.factors] == ["whole"]
    form = found.factors[0].form
    assert form is not None
    assert form.joints == (1, 2, 3, 4), "neither base nor tool side matters"
    assert "does not split" in found.explain("en")
    assert len(found.explain("en")) < 1000
    assert singularity_locus(arm, samples=10).verified
    assert characteristic_length(arm) > 0


@pytest.mark.capability("05-70")
def test_a_redundant_arm():
    panda = mf.load("panda")
    found = singularity(panda, np.zeros(7))
    assert (found.rank, found.generic_rank) == (5, 6)
    assert found.null_rates.shape == (2, 7)
    assert ("joint1", "joint3") in {cause.names for cause in found.causes}
    regular = singularity(panda, [0.1, 0.4, 0.2, -1.5, 0.3, 1.2, 0.4])
    assert regular.causes == ()
    assert "not singular" in regular.explain("en")
