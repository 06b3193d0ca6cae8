"""Measures and their gradients, isotropy, workspaces against closed forms, determinism, memory."""

import sys
from types import ModuleType

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.model.library import textbook
from mafsil.performance import (
    characteristic_length,
    dexterous_annuli,
    force_ellipsoid,
    isotropic_configurations,
    jacobian_hessian,
    manipulability,
    manipulability_gradient,
    reachable_annulus,
    task_jacobian,
    tool_jacobian,
    velocity_ellipsoid,
    workspace_map,
)
from mafsil.performance.dexterity import ellipsoid_of

MEASURES = ("yoshikawa", "inverse_condition", "smallest", "isotropy")


@pytest.mark.capability("05-80", "05-84")
@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("name", ["puma560", "panda", "stanford_arm"])
def test_gradients_of_measures(name, measure):
    robot = mf.load(name)
    q = np.random.default_rng(3).uniform(-1, 1, (5, robot.n))
    for task in ("pose", "position"):
        step = 1e-6 * np.eye(robot.n)
        ahead, behind = (manipulability(robot, q[:, None] + s * step, measure, task=task) for s in (1, -1))
        gradient = manipulability_gradient(robot, q, measure, task=task)
        np.testing.assert_allclose(gradient, (ahead - behind) / 2e-6, atol=2e-8)


@pytest.mark.capability("05-48")
def test_second_derivatives():
    robot = mf.load("panda")
    q, step = np.random.default_rng(3).uniform(-1, 1, (4, 7)), 1e-6 * np.eye(7)
    numeric = (tool_jacobian(robot, q[:, None] + step) - tool_jacobian(robot, q[:, None] - step)) / 2e-6
    np.testing.assert_allclose(jacobian_hessian(robot, q), numeric, atol=1e-8)


@pytest.mark.capability("05-85")
def test_measures_do_not_depend_on_the_unit_of_length():
    lengths = np.array([1.0, 0.8])
    q = [0.3, 0.9]
    metre, millimetre = (mf.Robot(textbook.planar2r(k * lengths)) for k in (1.0, 1000.0))
    assert characteristic_length(millimetre) == pytest.approx(1000 * characteristic_length(metre))
    for measure in MEASURES:
        a, b = (manipulability(r, q, measure, task="planar_position") for r in (metre, millimetre))
        assert a == pytest.approx(b, rel=1e-12)
    with pytest.raises(InputError, match="yoshikawa"):
        manipulability(metre, q, "beauty")


@pytest.mark.capability("05-82", "05-83", "05-86")
def test_ellipsoid_is_the_image_of_the_sphere():
    robot = mf.load("puma560")
    q = np.random.default_rng(3).uniform(-1, 1, (6, 6))
    J, found = task_jacobian(robot, q, "position"), velocity_ellipsoid(robot, q)
    ends = J @ found.joint_vectors
    np.testing.assert_allclose(ends, found.axes * found.lengths[:, None, :], atol=1e-13)
    force = force_ellipsoid(robot, q)
    np.testing.assert_allclose(np.sort(force.lengths * found.lengths[:, ::-1]), 1.0, atol=1e-10)
    weighted = velocity_ellipsoid(robot, q, weighted=True)
    assert (weighted.lengths[:, 0] > 0).all()
    with pytest.raises(InputError, match="fewer task rows"):
        ellipsoid_of(np.eye(3)[:, :2])
    with pytest.raises(InputError, match="no limit"):
        velocity_ellipsoid(mf.load("planar2r"), [0, 1], "planar", weighted=True)
    with pytest.raises(InputError, match="angular"):
        velocity_ellipsoid(robot, q, "mixed")


@pytest.mark.capability("05-83")
def test_force_grows_where_velocity_collapses():
    found = force_ellipsoid(mf.load("planar2r"), [0.0, 0.0], "planar")
    assert found.lengths.max() > 1e12
    assert found.ratio > 1e12


@pytest.mark.capability("05-84", "05-87")
def test_search_for_isotropic_configurations():
    arm = mf.Robot(textbook.planar2r((2**0.5, 1.0)))
    found = isotropic_configurations(arm, "planar_position")
    assert found.found
    np.testing.assert_allclose(np.abs(np.cos(found.q[:, 1])), 2**-0.5, atol=1e-7)
    assert velocity_ellipsoid(arm, found.q, "planar").isotropic().all()
    none = isotropic_configurations(mf.load("planar2r"), "planar_position")
    assert not none.found
    assert none.condition_number[0] == pytest.approx((1 + 5**0.5) / 2, rel=1e-6)
    assert "not proven" in none.explain("en")
    assert found.explain("ar") != found.explain("en")


@pytest.mark.capability("05-88")
@pytest.mark.parametrize("lengths", [(1.0, 0.6), (1.0, 1.0), (1.0, 0.5, 0.2)])
def test_planar_workspace_is_its_ring(lengths):
    arm = mf.Robot(textbook.planar2r(lengths) if len(lengths) == 2 else textbook.planar3r(lengths))
    found, ring = workspace_map(arm, 300_000, view="xy"), reachable_annulus(lengths)
    area, error = found.volume()
    assert abs(area - ring.area) < error < 0.1 * area
    voids = found.voids()
    assert len(voids) == (1 if ring.inner > 0 else 0)
    if voids:
        assert voids[0][-1] == pytest.approx(np.pi * ring.inner**2, rel=0.2)
        np.testing.assert_allclose(voids[0][:2], 0, atol=3 * found.cell)
    assert found.contains([(ring.inner + ring.outer) / 2, 0.0])
    assert not found.contains([ring.outer + 3 * found.cell, 0.0])
    assert ring.contains([ring.outer, 0.0])
    assert "300000" in found.explain("en")
    assert found.explain("ar") != found.explain("en")


@pytest.mark.capability("05-88")
def test_dexterous_ring_of_a_planar_3r():
    assert dexterous_annuli((1.0, 0.8, 0.1))[-1].outer == pytest.approx(1.7)
    assert dexterous_annuli((1.0, 0.2, 0.5)) == ()
    assert len(dexterous_annuli((1.0, 0.8, 0.5))) == 2
    rng = np.random.default_rng(0)
    for _ in range(40):
        L = rng.uniform(0.1, 1.0, 3)
        rings, first_two = dexterous_annuli(L), reachable_annulus(L[:2])
        r = rng.uniform(0, 2.5, 400)
        angle = np.linspace(0, 2 * np.pi, 721)
        wrist = np.stack(
            [r[:, None] - L[2] * np.cos(angle), np.broadcast_to(L[2] * np.sin(angle), (400, 721))], axis=-1
        )
        every = first_two.contains(wrist).all(axis=1)
        truth = np.any([np.zeros(400, bool), *((r >= x.inner) & (r <= x.outer) for x in rings)], axis=0)
        clear = np.all([np.ones(400, bool), *(np.abs(r - e) > 1e-3 for x in rings for e in (x.inner, x.outer))], axis=0)
        np.testing.assert_array_equal(every[clear], truth[clear])


@pytest.mark.capability("05-88")
def test_maps_are_deterministic_and_slices_agree():
    robot = mf.load("puma560")
    first, second = (workspace_map(robot, 100_000, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first.counts, second.counts)
    assert not np.array_equal(first.counts, workspace_map(robot, 100_000, seed=6).counts)
    assert first.counts.sum() == first.inside == 100_000
    radial = workspace_map(robot, 300_000, view="radial", dexterous=True)
    assert radial.dexterity.max() <= 1.0
    assert radial.dexterous(0.5).sum() < radial.reached.sum()
    assert radial.settled.any()
    limited, free = (workspace_map(robot, 200_000, view="radial", limited=x).volume()[0] for x in (True, False))
    assert free > limited
    cut = workspace_map(robot, 200_000, view="xz", at=0.1)
    assert 0 < cut.inside < 200_000


def test_maps_by_dask(monkeypatch):
    """Chunks go through dask, with a stand-in where dask is not installed."""
    robot = mf.load("planar2r")
    plain = workspace_map(robot, 150_000, view="xy")
    base, delayed = ModuleType("dask.base"), ModuleType("dask.delayed")
    base.compute = lambda *jobs: tuple(job() for job in jobs)
    delayed.delayed = lambda function: lambda: function
    for name, module in (("dask", ModuleType("dask")), ("dask.base", base), ("dask.delayed", delayed)):
        monkeypatch.setitem(sys.modules, name, module)
    np.testing.assert_array_equal(workspace_map(robot, 150_000, view="xy", dask=True).counts, plain.counts)
    monkeypatch.setitem(sys.modules, "dask.base", None)
    with pytest.raises(InputError, match="pip install dask"):
        workspace_map(robot, 10, dask=True)


def test_maps_that_make_no_sense():
    robot = mf.load("planar2r")
    for named, match in (
        ({"view": "oblique"}, "radial"),
        ({"samples": 0}, "positive"),
        ({"cell": -1.0}, "positive"),
        ({"cell": 1e-6}, "larger cells"),
        ({"at": 0.0}, "third axis"),
    ):
        with pytest.raises(InputError, match=match):
            workspace_map(robot, **{"samples": 10, **named})
    with pytest.raises(InputError, match="dexterous=True"):
        _ = workspace_map(robot, 10).dexterity
    for wrong in ([-1.0, 1.0], []):
        with pytest.raises(InputError, match="not lengths"):
            reachable_annulus(wrong)
    with pytest.raises(InputError):
        dexterous_annuli([1.0, 1.0])
