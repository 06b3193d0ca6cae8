"""Function generation: planted linkages are found with their angles, and functions between precision points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import fsolve

from mafsil.errors import InputError
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.answers import SynthesisStatus
from tests.mobility.planted_bars import planted, wrapped


def angle_error(one, theta, phi):
    """Error of the rocker's and of the crank's angles, from the first position on."""
    C = np.array([one.moving_pivots(t, m)[1] for t, m in zip(one.theta, one.modes, strict=True)]) - one.D
    rocker = np.arctan2(C[:, 1], C[:, 0])
    gaps = [(rocker - rocker[0]) - (phi - phi[0]), (one.theta - one.theta[0]) - (theta - theta[0])]
    return max(np.abs(wrapped(gap)).max() for gap in gaps)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([3, 4, 5]))
def test_angles_of_a_linkage_give_it_back(seed, count):
    plant = planted(np.random.default_rng(seed), count)
    theta, phi = plant.theta + (0.4 if count == 5 else 0.0), plant.rocker + (0.7 if count > 3 else 0.0)
    found = syn.synthesise_function(theta, phi, ground=plant.bar.ground)
    hits = [one for one in found if np.abs(one.linkage.lengths - plant.bar.lengths).max() < 1e-4]
    assert hits
    assert len(found) <= {3: 1, 4: 2, 5: 3}[count]
    assert max(angle_error(one, theta, phi) for one in found) < 1e-8
    assert max(one.residual for one in found) < 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_five_pairs_miss_no_solution_of_freudensteins_equation(seed):
    """Its five unknowns K1, K2, K3 and both lines, by MINPACK from many starts."""
    rng = np.random.default_rng(seed)
    plant = planted(rng, 5)

    def equations(x):
        theta, phi = plant.theta + x[3], plant.rocker + x[4]
        return x[0] * np.cos(phi) - x[1] * np.cos(theta) + x[2] - np.cos(theta - phi)

    found = syn.synthesise_function(plant.theta, plant.rocker)
    known = np.array([one.linkage.lengths for one in found])
    hits = 0
    for start in rng.normal(scale=2, size=(200, 5)):
        x, _, flag, _ = fsolve(equations, start, xtol=1e-13, full_output=True)
        if flag != 1 or np.abs(equations(x)).max() > 1e-10 or np.abs(x[:2]).min() < 0.02 or np.abs(x).max() > 50:
            continue
        a, c = 1 / x[0], 1 / x[1]
        square = a * a + c * c + 1 - 2 * a * c * x[2]
        if square > 1e-3:
            hits += 1
            lengths = np.array([abs(a), np.sqrt(square), abs(c), 1.0])
            assert np.abs(known - lengths).max(axis=1).min() < 1e-4 * lengths.max()
    assert hits


def test_chebyshev_spacing_of_the_textbook():
    """x from 1 to 2 with three points: 1.067, 1.500, 1.933 (Uicker, Pennock, Shigley, Theory of Machines, ch. 11)."""
    np.testing.assert_allclose(syn.chebyshev_spacing(1, 2, 3), [1.067, 1.5, 1.933], atol=5e-4)
    x = syn.chebyshev_spacing(-1, 1, 6)
    np.testing.assert_allclose(np.cos(6 * np.arccos(x)), 0, atol=1e-12)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_a_function_is_met_at_its_precision_points_and_nearly_between(count):
    task = syn.FunctionTask(np.log10, (1, 2), (np.radians(30), np.radians(90)), (np.radians(240), np.radians(330)))
    found = task.synthesise(count)
    x = syn.chebyshev_spacing(1, 2, count)
    good = [k for k, one in enumerate(found) if one]
    for k in good:
        error = task.structural_error(found, k)
        assert error.desired[0] == 0
        np.testing.assert_allclose(np.interp(x, error.x, error.error), 0, atol=2e-4)
        signs = np.sign(error.error[np.abs(error.error) > 1e-7])
        assert (np.diff(signs) != 0).sum() >= count
    assert good or count == 3


def test_more_precision_points_leave_less_error():
    task = syn.FunctionTask(np.log10, (1, 2), (0.5, 0.5 + np.radians(60)), (0.3, 0.3 + np.radians(90)))
    least = []
    for count in (4, 5):
        found = task.synthesise(count)
        least.append(min(task.structural_error(found, k).largest for k in range(len(found))))
    assert least[1] < least[0] < 1e-3


def test_equal_angles_are_a_parallelogram_of_any_length():
    angles = np.array([0.3, 0.9, 1.7, 2.2, 2.9])
    for count in (3, 4, 5):
        found = syn.synthesise_function(angles[:count], angles[:count])
        assert found.status is SynthesisStatus.INFINITE
        assert found.explain("en") != found.explain("ar")


def test_wrong_angles_are_refused():
    for inputs, outputs, words in (
        ([0, 1], [0, 1], "3 to 5"),
        ([0, 1, 1 + 2 * np.pi], [0, 1, 2], "positions 2 and 3"),
        ([0, 1, 2], [0, 1], "outputs"),
        ([0, 1, np.nan], [0, 1, 2], "nan"),
    ):
        with pytest.raises(InputError) as caught:
            syn.synthesise_function(inputs, outputs)
        assert words in caught.value.message("en")
    with pytest.raises(InputError, match="ground"):
        syn.synthesise_function([0, 1, 2], [0, 1, 3], ground=-1)
    with pytest.raises(InputError, match="same value"):
        syn.FunctionTask(lambda x: x * (1 - x), (0, 1), (0, 1), (0, 1))
    with pytest.raises(InputError, match="different"):
        syn.FunctionTask(np.sin, (1, 1), (0, 1), (0, 1))
    with pytest.raises(InputError), np.errstate(all="ignore"):
        syn.FunctionTask(np.log, (0, 1), (0, 1), (0, 1))
