"""Mass properties: shapes against integrals, surfaces and grids against shapes, what no body can have."""

import numpy as np
import pytest

from mafsil.errors import InputError, ModelError
from mafsil.model import Inertial
from mafsil.model import mass_properties as mp


def close(a, b, limit=1e-12):
    np.testing.assert_allclose(a.mass, b.mass, rtol=limit)
    np.testing.assert_allclose(a.com, b.com, atol=limit)
    np.testing.assert_allclose(a.inertia, b.inertia, rtol=limit, atol=limit * np.abs(b.inertia).max())


def box_surface(size, centre=(0, 0, 0)):
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size + centre
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


@pytest.mark.capability("09-28")
def test_shapes():
    m, r, h = 3.0, 0.2, 0.7
    np.testing.assert_allclose(mp.box(12.0, [1, 2, 3]).inertia, np.diag([13, 10, 5]))
    cylinder = np.diag([3 * r * r + h * h, 3 * r * r + h * h, 6 * r * r]) * m / 12
    np.testing.assert_allclose(mp.cylinder(m, r, h).inertia, cylinder)
    np.testing.assert_allclose(mp.tube(m, r, r, h).inertia[2, 2], m * r * r)
    np.testing.assert_allclose(mp.sphere(m, r).inertia, np.eye(3) * 0.4 * m * r * r)
    np.testing.assert_allclose(mp.shell(m, r).inertia, np.eye(3) * 2 / 3 * m * r * r)
    np.testing.assert_allclose(mp.rod(m, h).inertia, np.diag([1, 1, 0]) * m * h * h / 12)
    np.testing.assert_allclose(mp.ellipsoid(m, [1, 2, 3]).inertia, np.diag([13, 10, 5]) * m / 5)


@pytest.mark.capability("09-28")
def test_a_tube_is_a_cylinder_less_a_cylinder():
    outer, inner, h = 0.3, 0.2, 0.5
    whole, hole = (mp.cylinder(np.pi * r * r * h, r, h) for r in (outer, inner))
    mass = whole.mass - hole.mass
    rest = Inertial(mass, np.zeros(3), whole.inertia - hole.inertia)
    close(mp.tube(mass, inner, outer, h), rest)


@pytest.mark.capability("09-27")
def test_particles_by_hand():
    """Two equal masses at +-(1, 2, 3): products carry the minus sign inside."""
    body = mp.particles([0.5, 0.5], [[1, 2, 3], [-1, -2, -3]])
    np.testing.assert_allclose(body.inertia, [[13, -2, -3], [-2, 10, -6], [-3, -6, 5]])


@pytest.mark.capability("09-28")
def test_densities():
    """A polynomial density exactly; a ball's edge with the grid; a box of voxels exactly."""
    low, high = np.array([-0.2, 0.1, 0.3]), np.array([0.4, 0.5, 0.9])
    uniform = mp.density(lambda x: np.full(len(x), 800.0), low, high, cells=1)
    size, centre = high - low, (high + low) / 2
    box = mp.box(800 * np.prod(size), size)
    close(uniform, Inertial(box.mass, centre, box.inertia))
    varying = mp.density(lambda x: 1000 * x[:, 2], low, high, cells=1)
    fine = mp.density(lambda x: 1000 * x[:, 2], low, high, cells=5)
    close(varying, fine)
    mean = np.prod(size) * 1000 * (high[2] ** 2 - low[2] ** 2) / 2 / size[2]
    assert varying.mass == pytest.approx(mean)
    ball = mp.density(lambda x: 1000.0 * ((x**2).sum(-1) < 0.25**2), [-0.25] * 3, [0.25] * 3, cells=24)
    close(ball, mp.sphere(1000 * 4 / 3 * np.pi * 0.25**3, 0.25), 2e-3)
    rho = np.full((6, 4, 5), 800.0)
    close(mp.voxels(rho, low, size / rho.shape), uniform)


@pytest.mark.capability("09-28")
def test_closed_surfaces():
    size, centre = np.array([0.3, 0.4, 0.5]), np.array([0.2, -0.1, 0.4])
    vertices, faces = box_surface(size, centre)
    box = mp.box(600 * np.prod(size), size)
    close(mp.surface(vertices, faces, density=600.0), Inertial(box.mass, centre, box.inertia))
    close(mp.surface(vertices, faces, mass=7.0), Inertial(7.0, centre, mp.box(7.0, size).inertia))
    soup = vertices[faces].reshape(-1, 3)
    close(mp.surface(soup, np.arange(36).reshape(-1, 3), density=600.0), Inertial(box.mass, centre, box.inertia))


@pytest.mark.capability("09-28", "09-29")
def test_parts_together():
    """Two half boxes make a box; turning a part turns its inertia."""
    half = mp.box(2.0, [0.1, 0.2, 0.3])
    places = [np.eye(4), np.eye(4)]
    places[0][0, 3], places[1][0, 3] = -0.05, 0.05
    close(mp.combine_bodies([(half, T) for T in places]), mp.box(4.0, [0.2, 0.2, 0.3]))
    turn = np.eye(4)
    turn[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    close(mp.combine_bodies([(half, turn)]), mp.box(2.0, [0.2, 0.1, 0.3]))


@pytest.mark.capability("09-29")
def test_bodies_united_with_massless_ones():
    body, rotor = mp.particles([2.0], [[1.0, 0, 0]]), Inertial(0.0, np.zeros(3), np.diag([1.0, 2, 3]))
    assert mp.unite_bodies() is None
    assert mp.unite_bodies(None, body) is body
    close(mp.unite_bodies(rotor, None, body), Inertial(2.0, body.com, rotor.inertia))
    close(mp.unite_bodies(rotor, rotor), Inertial(0.0, np.zeros(3), 2 * rotor.inertia))
    close(mp.unite_bodies(body, mp.particles([2.0], [[-1.0, 0, 0]])), Inertial(4.0, np.zeros(3), np.diag([0.0, 4, 4])))
    with pytest.raises(ModelError):
        mp.combine_bodies([(rotor, np.eye(4))])


@pytest.mark.capability("09-29")
def test_what_no_body_can_have():
    for body in (mp.box(1.0, [1, 2, 3]), mp.rod(1.0, 1.0), mp.particles([1.0], [[1, 2, 3]])):
        assert mp.require_physical(body) is body
    skew = np.array([[1.0, 0.2, 0], [0, 1, 0], [0, 0, 1]])
    for inertia, mass, key in (
        (np.diag([1.0, 1, 2.5]), 1.0, "dynamics.moments"),
        (np.diag([1.0, -0.1, 1]), 1.0, "dynamics.moments"),
        (skew, 1.0, "model.asymmetric"),
        (np.eye(3), 0.0, "dynamics.mass"),
    ):
        with pytest.raises(ModelError) as caught:
            mp.require_physical(Inertial(mass, np.zeros(3), inertia))
        assert caught.value.key == key
        assert str(caught.value)


def test_wrong_bodies_are_refused():
    vertices, faces = box_surface(np.ones(3))
    cases = {
        "dynamics.radii": lambda: mp.tube(1.0, 0.3, 0.2, 1.0),
        "dynamics.length": lambda: mp.box(1.0, [1, -1, 1]),
        "dynamics.open_surface": lambda: mp.surface(vertices, faces[1:]),
        "dynamics.inside_out": lambda: mp.surface(vertices, faces[:, ::-1]),
        "dynamics.face_index": lambda: mp.surface(vertices[:-1], faces),
        "dynamics.mass": lambda: mp.particles([0.0], [[1, 2, 3]]),
    }
    for key, call in cases.items():
        with pytest.raises(ModelError) as caught:
            call()
        assert caught.value.key == key, key
        assert str(caught.value)
    with pytest.raises(InputError, match="densities"):
        mp.voxels([1.0, 2.0], [0, 0, 0], [1, 1, 1])
    with pytest.raises(InputError, match="density"):
        mp.density(lambda x: x, [0, 0, 0], [1, 1, 1], cells=1)
