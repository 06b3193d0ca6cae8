"""Sliding mode: the bound covers every arm within the share, and the error stays below what is promised."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.control import sliding_certificate, sliding_mode
from mafsil.control.laws.sliding_mode import SlidingStatus
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario
from mafsil.trajectory import Motion, quintic


def wrong(robot, rng, share):
    """The same arm with every mass off by up to a share, inertias with it."""
    links = []
    for link in robot.mechanism.links:
        if link.inertial is None:
            links.append(link)
            continue
        factor = 1 + rng.uniform(-share, share)
        body = link.inertial
        links.append(replace(link, inertial=replace(body, mass=factor * body.mass, inertia=factor * body.inertia)))
    return mf.Robot(replace(robot.mechanism, links=tuple(links)))


@pytest.mark.capability("10-86")
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_bound_covers_every_arm_within_the_share(seed):
    rng = np.random.default_rng(seed)
    robot = mf.load("puma560")
    law, other = sliding_mode(robot, share=0.2, margin=0.0), wrong(robot, rng, 0.2)
    q, qd, u, v, a = rng.normal(size=(5, 8, 6))
    wanted = Motion(u, v, a)
    known, bound, s = law.parts(q, qd, wanted)
    true = replace(law, robot=other).parts(q, qd, wanted)[0]
    assert (np.abs(true - known) <= bound * (1 + 1e-9)).all()
    # M s' + C s with Christoffel's C: half the derivative of M in the energy leaves nothing.
    growth, rate = a + law.rates * (v - qd), s + qd
    parts = replace(law, robot=robot, share=0.0)
    assert parts.parts(q, qd, wanted)[2] == pytest.approx(rate - qd)
    on_path = law.parts(u, v, wanted)[0]
    np.testing.assert_allclose(on_path, robot.inverse_dynamics(u, v, a), atol=1e-9)
    assert growth.shape == q.shape


@pytest.mark.capability("10-86")
@pytest.mark.parametrize("seed", range(3))
def test_the_error_stays_below_what_is_promised(seed):
    rng = np.random.default_rng(seed)
    robot = mf.load("puma560")
    arm = wrong(robot, rng, 0.2)
    law = sliding_mode(robot, share=0.2, margin=0.5)
    path = quintic(np.zeros(6), rng.uniform(-0.8, 0.8, 6), 1.0)
    start = 0.05 * rng.normal(size=6)
    run = mf.simulate(
        Scenario(
            robot=robot, plant=Plant(arm, friction=False), trajectory=path, law=law, q=start, qd=np.zeros(6),
            duration=2.5, saturate=False,
        )
    )  # fmt: skip
    found = sliding_certificate(law, arm, path, run.t, run.q, run.qd)
    assert found
    assert found.reached < 1.5
    assert (found.error <= law.error_bound).all()
    for time, said in ((0.5 * found.reached, "boundary layer"), (found.reached + 0.1, "too late")):
        part = slice(0, int(time * 1e3))
        short = sliding_certificate(law, arm, path, run.t[part], run.q[part], run.qd[part])
        assert np.isnan(short.error).all()
        assert said in short.explain("en")
    assert (law.error_bound == 0.002).all()
    s, after = found.distance, found.t > found.reached
    assert (np.abs(s[after]) <= law.width + 1e-12).all()
    # Outside the layer the energy of s falls.
    energy = 0.5 * np.einsum("ki,kij,kj->k", s, arm.mass_matrix(run.q), s)
    far = (np.abs(s) > law.width).all(axis=1)[:-1]
    assert (np.diff(energy)[far] < 0).all()


@pytest.mark.capability("10-86")
def test_an_arm_beyond_the_share_is_named():
    robot = mf.load("puma560")
    arm = mf.Robot(robot.mechanism.with_payload(5.0))
    law, path = sliding_mode(robot, share=0.05, margin=0.1), quintic(np.zeros(6), np.full(6, 0.5), 1.0)
    run = mf.simulate(Scenario(robot=robot, plant=Plant(arm, friction=False), trajectory=path, law=law, saturate=False))
    found = sliding_certificate(law, arm, path, run.t, run.q, run.qd)
    assert found.status is SlidingStatus.BROKEN
    share = np.abs(found.needed) / found.bound
    assert f"{share.max():.1%}" in found.explain("en")
    assert found.explain("ar") != found.explain("en")


@pytest.mark.parametrize(
    ("name", "value"), [("share", -0.1), ("share", np.nan), ("rate", 0.0), ("width", 0.0), ("margin", -1.0)]
)
def test_numbers_out_of_range_are_refused(name, value):
    with pytest.raises(InputError):
        sliding_mode(mf.load("planar2r"), **{name: value})
