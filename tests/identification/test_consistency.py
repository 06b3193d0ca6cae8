"""Charts of possible bodies: every point is one, derivatives are right, the origin is the body of before."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.identification.regression import (
    BodyParameterisation,
    ball,
    nearest_consistent,
    parameters_of_pseudo,
    physically_consistent,
    pseudo_inertia,
)
from mafsil.mechanics.inertial_parameters import inertial_of, parameters_of
from mafsil.model import Inertial
from mafsil.model import mass_properties as mp

BOX = mp.box(2.0, [0.1, 0.2, 0.3])
BODY = parameters_of(Inertial(BOX.mass, [0.1, -0.2, 0.3], BOX.inertia))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=10, max_size=10))
def test_every_point_of_a_parameterisation_is_a_possible_body(x):
    parameters, _ = BodyParameterisation.around(BODY).at(np.array(x))
    assert physically_consistent(parameters)
    inertial = inertial_of(parameters)
    a, b, c = np.linalg.eigvalsh(inertial.inertia)
    assert inertial.mass > 0
    assert a > 0
    assert c < (a + b) * (1 + 1e-9)


def test_the_origin_and_the_derivatives():
    chart = BodyParameterisation.around(BODY)
    assert np.allclose(chart.at(np.zeros(10))[0], BODY)
    x, h = np.random.default_rng(0).normal(0, 0.5, 10), 1e-6
    _, rates = chart.at(x)
    for k, e in enumerate(np.eye(10)):
        numeric = (chart.at(x + h * e)[0] - chart.at(x - h * e)[0]) / (2 * h)
        assert np.allclose(rates[:, k], numeric, atol=1e-8)


def test_pseudo_inertia_there_and_back():
    parameters = np.random.default_rng(1).normal(size=10)
    assert np.allclose(parameters_of_pseudo(pseudo_inertia(parameters)), parameters)


def test_a_ball_is_a_ball():
    body = inertial_of(ball(3.0, 0.2, np.array([0.1, 0.2, 0.3])))
    assert body.mass == pytest.approx(3.0)
    assert np.allclose(body.com, [0.1, 0.2, 0.3])
    assert np.allclose(body.inertia, 0.4 * 3 * 0.2**2 * np.eye(3))


@pytest.mark.parametrize("inertia", [np.zeros(3), [1.0, 1.0, 3.0], [0.1, 0.2, -0.1]])
def test_impossible_bodies_become_possible_and_keep_mass_and_centre(inertia):
    parameters = np.array([2.0, 0.2, 0.4, -0.2, 0, 0, 0, 0, 0, 0])
    c = parameters[1:4] / 2
    about = np.diag(inertia) + 2 * (c @ c * np.eye(3) - np.outer(c, c))
    parameters[4:] = about[0, 0], about[1, 1], about[2, 2], about[0, 1], about[0, 2], about[1, 2]
    near = nearest_consistent(parameters, 1.0)
    assert not physically_consistent(parameters)
    assert physically_consistent(near)
    assert np.allclose(near[:4], parameters[:4])
    assert np.allclose(nearest_consistent(near, 1.0), near)
    assert np.array_equal(nearest_consistent(BODY, 1.0), BODY)
