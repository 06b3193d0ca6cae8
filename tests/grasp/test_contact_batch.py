"""Verdicts on batches of contacts: as the single ones, and each with a proof that anyone can check."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.arrays import Floats
from mafsil.grasp import Contact, Grasp, contact_closures, force_wrench
from mafsil.grasp.closure import ClosureStatus

PLANE, SPACE = 2, 3


def drawn(seed: int, d: int, contacts: int, count: int = 40) -> tuple[Floats, Floats, Floats, Floats]:
    """Points on a sphere or circle, normals roughly inward, friction with some zeros, soft fingers in space."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, contacts, d))
    points /= np.linalg.norm(points, axis=-1, keepdims=True)
    normals = (0.3 * rng.normal(size=points.shape) - points) * 10.0 ** rng.uniform(-3, 3, (count, contacts, 1))
    mu = rng.uniform(0.0, 1.0, (count, contacts)) * (rng.random((count, contacts)) < 0.8)
    gamma = rng.uniform(0.0, 0.3, (count, contacts)) * (rng.random((count, contacts)) < 0.3) * (d == SPACE)
    return points + rng.normal(size=(count, 1, d)), normals, mu, gamma


def grasps(points: Floats, normals: Floats, mu: Floats, gamma: Floats) -> list[Grasp]:
    return [
        Grasp([Contact(*one) for one in zip(*rows, strict=True)])
        for rows in zip(points, normals, mu, gamma, strict=True)
    ]


@pytest.mark.capability("03-29", "03-41", "03-43")
@pytest.mark.parametrize(("d", "contacts"), [(PLANE, 2), (PLANE, 4), (SPACE, 2), (SPACE, 3), (SPACE, 5), (SPACE, 8)])
def test_batches_agree_with_single_grasps(d: int, contacts: int) -> None:
    given_ = drawn(contacts, d, contacts)
    batch = contact_closures(*given_)
    single = [grasp.closure(margins=False) for grasp in grasps(*given_)]
    assert [one.verdict for one in batch.status] == [one.verdict for one in single]
    assert len(batch) == len(single)
    assert bool(batch) == all(single)


@pytest.mark.capability("03-29", "03-41")
@given(st.integers(0, 10**6), st.sampled_from([PLANE, SPACE]), st.integers(2, 7))
@settings(max_examples=20, deadline=None)
def test_every_verdict_is_proven(seed: int, d: int, contacts: int) -> None:
    """Forces inside the cones that balance, or a wrench on whose far side every contact wrench lies."""
    given_ = drawn(seed, d, contacts, count=10)
    batch = contact_closures(*given_)
    for i, grasp in enumerate(grasps(*given_)):
        if batch.status[i] is ClosureStatus.CLOSED:
            wrench = grasp.resultant(batch.forces[i])
            for c, force, torsion in zip(grasp.contacts, batch.forces[i], batch.torsions[i], strict=True):
                push = float(force @ c.normal)
                sideways = float(np.linalg.norm(force - push * c.normal))
                assert push > 0
                assert sideways <= c.mu * push + 1e-12
                assert abs(torsion) <= c.gamma * push + 1e-12
                if d == SPACE:
                    wrench[:3] += torsion * c.normal
            assert np.abs(wrench).max() < 1e-9
            assert sum(float(f @ c.normal) for f, c in zip(batch.forces[i], grasp.contacts, strict=True)) == (
                pytest.approx(1.0)
            )
            assert np.isnan(batch.certificate[i]).all()
        else:
            y = batch.certificate[i]
            assert np.linalg.norm(y) == pytest.approx(1.0)
            pushes = y @ grasp.matrix(64)
            assert pushes.min() >= -1e-9 * (1.0 + np.abs(grasp.matrix(64)).max())


@pytest.mark.capability("03-40", "03-43")
def test_marginal_grasps_are_asked_again_and_keep_their_sentence() -> None:
    points = np.array([[[-1.0, 0, 0], [1, 0, 0]], [[-1, 0, 0], [1, 0, 0]]])
    normals = -points
    batch = contact_closures(points, normals, 0.5, [[0.0, 0.0], [0.1, 0.1]])
    assert [status.verdict for status in batch.status] == ["no", "yes"]
    assert (
        batch[0].explain()
        == Grasp([Contact(p, n, 0.5) for p, n in zip(points[0], normals[0], strict=True)]).closure().explain()
    )
    assert "1" in batch.explain()
    assert "2" in batch.explain()
    assert batch.explain(language="ar") != batch.explain()
    assert batch.explain(1) == batch[1].explain()
    assert batch.to_dict()["verdict"] == ["no", "yes"]
    assert [bool(one) for one in batch] == [False, True]
    edge = contact_closures([[-1, 0], [1, 0]], [[1, 0.5], [-1, 0]], 0.5)
    assert edge.status.item().verdict == "marginal"
    assert edge.rechecked == 1


@pytest.mark.capability("03-29", "03-40")
@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_two_opposed_fingers_and_others_on_one_side_are_a_no_that_small_changes_leave(seed: int) -> None:
    """The moment about the line of the two is left, wherever exactly the contacts are: nothing is marginal there."""
    rng = np.random.default_rng(seed)
    points = np.array([[-1.0, 0, 0], [1, 0, 0], [0.3, 1.0, 0.5]])
    normals = np.array([[1.0, 0, 0], [-1, 0, 0], [0, -1, 0]])
    found = Grasp([Contact(p, n, 0.3) for p, n in zip(points, normals, strict=True)]).closure()
    assert found.verdict == "no"
    assert abs(found.certificate) == pytest.approx([1, 0, 0, 0, 0, 0])
    assert found.margin == 0.0
    near = contact_closures(points + 0.01 * rng.normal(size=(50, 3, 3)), normals + 0.01 * rng.normal(size=(3, 3)), 0.3)
    assert all(status.verdict == "no" for status in near.status)
    assert near.rechecked == 0


@pytest.mark.capability("03-25")
@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"points": np.zeros((3, 4))}, "points"),
        ({"points": np.full((2, 3, 3), np.nan)}, "points"),
        ({"normals": np.zeros((2, 3, 3))}, "normals"),
        ({"normals": np.ones((2, 3, 2))}, "normals"),
        ({"mu": -0.1}, "mu"),
        ({"mu": np.ones(7)}, "mu"),
        ({"gamma": np.inf}, "gamma"),
    ],
)
def test_wrong_contacts_are_named(change: dict[str, Floats], named: str) -> None:
    given_ = {"points": np.ones((2, 3, 3)), "normals": np.ones((2, 3, 3)), "mu": 0.5, "gamma": 0.0} | change
    with pytest.raises(mf.InputError, match=named):
        contact_closures(**given_)
    with pytest.raises(mf.InputError, match="gamma"):
        contact_closures(np.ones((3, 2)), np.ones((3, 2)), 0.5, 0.1)


@pytest.mark.capability("03-41")
def test_no_grasps_and_other_shapes_of_batches() -> None:
    points, normals, mu, gamma = drawn(3, SPACE, 4, count=6)
    flat = contact_closures(points, normals, mu, gamma)
    shaped = contact_closures(points.reshape(2, 3, 4, 3), normals.reshape(2, 3, 4, 3), mu.reshape(2, 3, 4), 0 * 0.0)
    assert shaped.status.shape == (2, 3)
    assert shaped[1].status.shape == (3,)
    assert contact_closures(points[:0], normals[:0]).status.shape == (0,)
    assert (flat.force_closure >= contact_closures(points, normals, mu).force_closure).all()


@pytest.mark.capability("03-29", "03-71")
def test_the_margin_waits_until_it_is_asked_for_and_survives_a_pickle() -> None:
    for grasp in grasps(*drawn(5, SPACE, 5, count=8)):
        found = grasp.closure()
        again = pickle.loads(pickle.dumps(found))
        assert again.margin == found.margin
        assert np.isnan(grasp.closure(margins=False).margin)
        assert (found.margin > 0) == bool(found)


@pytest.mark.capability("03-38")
def test_wrenches_that_change_afterwards_do_not_change_the_margin() -> None:
    W = Grasp(
        [
            Contact((0.5, 1), (0, -1)),
            Contact((2, 0.5), (-1, 0)),
            Contact((-0.5, -1), (0, 1)),
            Contact((-2, -0.5), (1, 0)),
        ]
    ).matrix()
    found, again = mf.grasp.closure(W), mf.grasp.closure(W.copy())
    W[:] = 1.0
    assert found.margin == again.margin > 0


def test_force_wrench_is_what_resultant_sums() -> None:
    grasp = Grasp([Contact((1, 2, 3), (0, 0, 1), 0.5), Contact((0, 1, 0), (1, 0, 0), 0.5)])
    forces = np.array([[1.0, 2, 3], [4, 5, 6]])
    assert grasp.resultant(forces) == pytest.approx(
        sum(force_wrench(c.point, f) for c, f in zip(grasp.contacts, forces, strict=True))
    )


@pytest.mark.capability("03-23", "03-28")
@pytest.mark.parametrize("facets", [3, 8, 17])
def test_columns_of_hard_fingers_are_those_of_each_contact(facets: int) -> None:
    points, normals, mu, _ = drawn(11, SPACE, 4, count=10)
    for grasp in grasps(points, normals, mu + 0.1, 0 * mu):
        own = np.hstack([contact.wrenches(facets) for contact in grasp.contacts])
        assert grasp.matrix(facets) == pytest.approx(own, abs=1e-14)
