"""Counting, clearances, slices, internal forces, materials, hulls, frames and remarks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.registry import operation
from mafsil.errors import InputError
from mafsil.figures.hull import draw_force_diagram, draw_hull, save_force_diagram, save_hull
from mafsil.grasp import Contact, Grasp, eliminate, patch_contact, three_fingers, two_fingers
from mafsil.grasp.closure import ClosureStatus
from mafsil.grasp.closure_methods import count_contacts
from mafsil.grasp.forces import internal_basis, split_forces
from mafsil.grasp.friction import PairFriction, pair_friction
from mafsil.grasp.grasp import compare_under_load
from mafsil.grasp.hull import convex_hull
from mafsil.grasp.synthesis import least_friction
from mafsil.grasp.three_fingers import planar_slice

RING = [
    Contact((np.cos(t), np.sin(t), 0), (-np.cos(t), -np.sin(t), tilt), 0.6)
    for t, tilt in zip(np.radians([0, 120, 240]), (0.1, -0.2, 0.15), strict=True)
]
PINWHEEL = [
    Contact(p, n) for p, n in (((0.5, 1), (0, -1)), ((2, 0.5), (-1, 0)), ((-0.5, -1), (0, 1)), ((-2, -0.5), (1, 0)))
]


def random_contacts(rng, dimension, kinds):
    coefficients = {"f": (0.0, 0.0), "h": (0.5, 0.0), "s": (0.5, 0.1)}
    return [Contact(rng.normal(size=dimension), rng.normal(size=dimension), *coefficients[k]) for k in kinds]


@pytest.mark.capability("03-75", "03-43")
@pytest.mark.parametrize(
    ("dimension", "frictional", "needed"),
    [
        (2, "", 4),
        (2, "h", 2),
        (2, "hh", 0),
        (3, "", 7),
        (3, "h", 4),
        (3, "s", 3),
        (3, "hh", 2),
        (3, "hhh", 0),
        (3, "hs", 0),
        (3, "ss", 0),
    ],
)
def test_least_numbers_of_contacts(dimension, frictional, needed):
    rng = np.random.default_rng(4)
    for _ in range(5):
        count = count_contacts(random_contacts(rng, dimension, frictional + "f" * 2))
        assert count.needed == needed
        short = random_contacts(rng, dimension, frictional + "f" * max(0, needed - 1))
        if frictional and needed:
            found = Grasp(short).closure()
            assert found.verdict == "no"
            assert found.status is ClosureStatus.COUNTED_OUT
            for c in short:
                g = c.basis.T @ found.certificate
                assert g[0] - c.mu * np.linalg.norm(g[1:dimension]) - c.gamma * np.abs(g[dimension:]).sum() >= -1e-9


@pytest.mark.capability("03-75")
def test_one_frictional_and_two_frictionless_fingers_close_in_the_plane():
    held = Grasp([Contact((0, -1), (0, 1), 0.5), Contact((1, 0.5), (-1, -0.5)), Contact((-1, 0.5), (1, -0.5))])
    assert count_contacts(held.contacts).enough
    assert held.closure().force_closure


@pytest.mark.capability("03-76", "03-77")
def test_a_load_moves_the_body_to_rest():
    held = Grasp(PINWHEEL)
    gaps = np.array([1e-3, 2e-3, 3e-3, 5e-4])
    load = np.array([0.3, 1.0, -2.0])
    found = held.rest_position(load, gaps)
    rates = held.normals_matrix.T @ found.displacement
    assert (rates >= -gaps - 1e-12).all()
    assert rates[list(found.touching)] == pytest.approx(-gaps[list(found.touching)])
    assert found.work == pytest.approx(load @ found.displacement)
    assert found.pushes @ gaps == pytest.approx(found.work)
    assert held.normals_matrix @ found.pushes == pytest.approx(-load)
    open_ = Grasp(PINWHEEL[:2]).rest_position([0, 0, 1.0], 1e-3)
    assert not open_.resisted
    ranked = compare_under_load([Grasp(PINWHEEL[:2]), held], [0, 0, 1.0], 1e-3)
    assert ranked[0][0] is held
    for wrong in ([1e-3, 1e-3], [-1e-3] * 4, [[1e-3] * 4]):
        with pytest.raises(InputError, match="clearance"):
            held.motion_within_clearance(wrong)


@pytest.mark.capability("03-74")
def test_certificates_of_failing_cones():
    rng = np.random.default_rng(2)
    failed = 0
    for _ in range(60):
        contacts = [Contact(c.point, c.normal + 0.6 * rng.normal(size=3), 0.4) for c in RING]
        found = three_fingers(contacts)
        if found.certificate is None:
            continue
        failed += 1
        for c in contacts:
            g = c.basis.T @ found.certificate
            assert g[0] - c.mu * np.hypot(g[1], g[2]) >= -1e-9
    assert failed > 10


@pytest.mark.capability("03-79")
def test_certificates_of_two_fingers_anywhere():
    rng = np.random.default_rng(5)
    open_pairs = 0
    for _ in range(400):
        a, b = (Contact(rng.normal(size=2), rng.normal(size=2), rng.uniform(0.05, 1.5)) for _ in range(2))
        found = two_fingers(a, b)
        assert (found.unresisted is None) == found.force_closure
        if found.unresisted is not None:
            open_pairs += 1
            assert (found.unresisted @ Grasp([a, b]).matrix()).min() >= -1e-9
    assert open_pairs > 100


@pytest.mark.capability("03-80", "03-57")
@pytest.mark.parametrize(("low", "high", "r"), [(0.0, 0.3, 1.0), (-0.2, 0.5, 0.7)])
def test_fingers_at_different_heights(low, high, r):
    least = abs(high - low) / (2 * r)
    for mu, closed in ((least * 1.001, True), (least * 0.999, False)):
        held = Grasp([Contact((-r, low), (1, 0), mu), Contact((r, high), (-1, 0), mu)])
        assert bool(held.closure()) is closed
        assert two_fingers(*held.contacts).force_closure is closed
    assert least_friction(held) == pytest.approx(least, abs=2e-6)


@pytest.mark.capability("03-82", "03-71")
def test_internal_forces():
    basis = internal_basis(RING)
    assert basis.shape == (3, 3, 3)
    grasp = Grasp(RING)
    for eta in basis:
        assert grasp.resultant(eta) == pytest.approx(np.zeros(6), abs=1e-12)
    assert np.linalg.matrix_rank(basis.reshape(3, -1)) == 3
    five = Grasp([*RING, Contact((0.2, 0.1, 1), (0, 0, -1)), Contact((0, -0.3, -1), (0, 0, 1))])
    assert len(internal_basis(five.contacts)) == 15 - 6
    forces = np.random.default_rng(0).normal(size=(3, 3))
    external, internal = split_forces(RING, forces)
    assert external + internal == pytest.approx(forces)
    assert grasp.resultant(internal) == pytest.approx(np.zeros(6), abs=1e-12)
    assert np.einsum("kij,ij->k", basis, external) == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.capability("03-83")
def test_a_slice_is_a_plane_grasp_of_its_own():
    flat, pose = planar_slice(RING)
    assert flat.dimension == 2
    assert flat.closure().force_closure == Grasp(RING).closure().force_closure
    assert pose[:3, 2] @ [0, 0, 1] == pytest.approx(1.0)
    for c, s in zip(flat.contacts, three_fingers(RING).sections, strict=True):
        assert c.alpha == pytest.approx(s.half_angle)
    with pytest.raises(InputError, match="plane"):
        planar_slice([Contact(c.point, (c.normal[0], c.normal[1], 5.0), 0.1) for c in RING])


@pytest.mark.capability("03-84", "03-19")
def test_materials():
    assert pair_friction("steel", "aluminium") == pair_friction("aluminium", "steel")
    assert pair_friction("steel", "steel").law.kinetic == 0.57
    mine = {("cork", "steel"): PairFriction(0.6, 0.4, "own test")}
    assert pair_friction("steel", "cork", mine).source == "own test"
    with pytest.raises(InputError, match="cheese"):
        pair_friction("cheese", "steel")


@pytest.mark.capability("03-85", "03-18")
@pytest.mark.parametrize("speed", [1e-6, 1.0, 1e3])
def test_coulomb_does_not_depend_on_speed(speed):
    from mafsil.grasp.friction import sliding_force

    assert np.linalg.norm(sliding_force(10.0, (0.6 * speed, 0.8 * speed), 0.3)) == pytest.approx(3.0)


@pytest.mark.capability("03-86", "03-50", "03-44")
def test_elimination_is_a_regular_product():
    A = np.array([[-1.0, 0, 1, 0], [0, -1, 0, 1], [0, 0, -2, 2]])
    found = eliminate(A)
    R = np.array(found.right, float)
    reduced = R @ A
    assert abs(np.linalg.det(R)) > 0
    assert reduced[:, list(found.pivots)] == pytest.approx(np.eye(3))
    assert reduced[:, list(found.free)] == pytest.approx(found.S)
    assert found.right_side(np.array([1.0, -2, 3])) == pytest.approx(R @ [1, -2, 3])


@pytest.mark.capability("03-27")
def test_forces_between_contact_and_body():
    rng = np.random.default_rng(1)
    for c in RING:
        force = rng.normal(size=3)
        parts = c.to_contact(force)
        assert c.to_body(parts) == pytest.approx(force)
        assert parts[2] == pytest.approx(force @ c.normal)
        assert c.frame[:3, :3] @ parts == pytest.approx(force)
        assert c.frame[:3, 2] == pytest.approx(c.normal)


@pytest.mark.capability("03-20")
def test_uncommon_friction_is_said_and_allowed(tmp_path: Path):
    strong = Grasp([Contact((-1, 0), (1, 0), 3.0), Contact((1, 0), (-1, 0), 0.5)])
    assert strong.closure()
    said = [
        line for line in strong.explain("en").splitlines() if line.startswith("unusual friction coefficient mu = 3")
    ]
    assert len(said) == 1
    assert "0.1 to 1" in said[0]
    path = tmp_path / "strong.json"
    path.write_text(strong.to_json())
    answer = operation("grasp")(file=str(path), facets=None, steps=False, picture=None)
    assert any(line.startswith("unusual friction coefficient mu = 3 (at contact 0)") for line in answer.lines)
    for mu in (0.0, 0.1, 1.0):
        assert not any(
            line.startswith("unusual friction") for line in strong.with_friction(mu).explain("en").splitlines()
        )


@pytest.mark.capability("03-41")
def test_hulls_of_any_sets():
    rng = np.random.default_rng(0)
    point = convex_hull([[1.0, 2, 3]])
    assert (point.dimension, point.vertices.tolist(), point.contains((1, 2, 3)), point.contains((1, 2, 4))) == (
        0,
        [0],
        True,
        False,
    )
    segment = convex_hull(np.outer([0.0, 2, 1], [1.0, 1, 1]))
    assert (segment.dimension, segment.vertices.tolist()) == (1, [0, 1])
    assert segment.contains((1.5, 1.5, 1.5))
    assert not segment.contains((2.5, 2.5, 2.5))
    square = convex_hull([(0, 0, 5.0), (1, 0, 5), (1, 1, 5), (0, 1, 5), (0.5, 0.5, 5)])
    assert (square.dimension, sorted(square.vertices)) == (2, [0, 1, 2, 3])
    assert square.contains((0.2, 0.7, 5))
    assert not square.contains((0.2, 0.7, 5), strictly=True)
    cube = convex_hull(rng.choice([-1.0, 1.0], size=(200, 4)))
    assert (cube.dimension, len(cube.vertices)) == (4, len(np.unique(cube.points[cube.vertices], axis=0)))
    assert cube.contains(np.zeros(4), strictly=True)
    with pytest.raises(InputError, match="points"):
        convex_hull(np.zeros((0, 2)))


@pytest.mark.capability("03-39", "03-41", "03-40")
def test_the_plane_teaching_case_is_drawn(tmp_path: Path):
    """Both versions of the third column: the origin is red on the boundary, green inside; the cone is part or whole."""
    colours, cones = [], []
    for third in ((-1, 1), (-1, -1)):
        axes = draw_hull(np.array([(1.0, 0), (0, 1), third]).T).axes[0]
        colours.append(axes.lines[-1].get_color())
        sector = axes.patches[0].get_xy()
        cones.append(float(sector[:, 1].min()))
    assert colours == ["#d33f3a", "#2e8b57"]
    assert cones[0] == pytest.approx(0.0, abs=1e-9)
    assert cones[1] < -1.0
    save_hull(np.eye(2), tmp_path / "cone.png")
    assert (tmp_path / "cone.png").stat().st_size > 5_000
    with pytest.raises(InputError, match="coordinates"):
        draw_hull(np.eye(3))


@pytest.mark.capability("03-58")
def test_moments_of_each_finger_and_the_force_diagram(tmp_path: Path):
    pinch = Grasp([Contact((-1, 0.2), (1, 0), 0.5), Contact((1, 0.2), (-1, 0), 0.5)])
    load = np.array([-0.3 * 9.81, 0.0, -9.81])
    held = pinch.resist(load)
    moments = held.moments([c.point for c in pinch.contacts])
    by_hand = [c.point[0] * f[1] - c.point[1] * f[0] for c, f in zip(pinch.contacts, held.forces, strict=True)]
    assert moments == pytest.approx(by_hand)
    assert moments.sum() + load[0] == pytest.approx(0.0, abs=1e-9)
    axes = draw_force_diagram(pinch.contacts, held, load).axes[0]
    ends = [line.get_xydata() for line in axes.lines[2:]]
    assert ends[0][0] == pytest.approx(ends[-1][1], abs=1e-9)
    assert next(t.get_text().split(": ")[-1] for t in axes.texts if t.get_text()) == f"{moments[0]:.4g} N m"
    save_force_diagram(pinch.contacts, held, load, tmp_path / "forces.png")
    assert (tmp_path / "forces.png").stat().st_size > 5_000


@pytest.mark.capability("03-13", "03-87")
def test_soft_patches():
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    soft = patch_contact(corners, (0, 0, 1), mu=0.3, gamma=0.1)
    assert [c.gamma for c in soft] == [0.1] * 3
    inside = Contact((0.3, 0.3, 0), (0, 0, 1), 0.3, 0.1)
    for w in inside.wrenches(8).T:
        held = Grasp(soft).resist(-w)
        assert held.holds


def test_plain_points_and_normals_make_a_grasp():
    assert Grasp([((0, 0), (1, 0)), ((1, 0), (-1, 0), 0.5)]).contacts[1].mu == 0.5
    for wrong in ([3], ["ab"], [((0, 0),)], [(0, 1)]):
        with pytest.raises(InputError, match="entry 0"):
            Grasp(wrong)


@pytest.mark.capability("03-2", "03-4", "03-8")
def test_the_command_takes_length_point_clearance_and_push(tmp_path: Path):
    path = tmp_path / "pinch.json"
    pinch = Grasp([Contact((-1, 0), (1, 0), 0.5), Contact((1, 0), (-1, 0), 0.5)])
    path.write_text(json.dumps({**pinch.to_dict(), "load": {"force": [0, -9.81]}}))
    ask = operation("grasp")
    empty = {"file": str(path), "facets": None, "steps": False, "picture": None}
    held = ask(**empty, length="100mm", about=["0", "0.5"], clearance="1mm", push="20")
    assert held.data["quality"]["epsilon"] == pytest.approx(pinch.quality(0.1, about=(0, 0.5)).epsilon)
    assert held.data["load"]["holds"]
    assert held.data["clearance"]["range"][1] == pytest.approx([-1e-3, 1e-3])
    assert not held.data["clearance"]["bounded"]
    assert not ask(**empty, push="9").data["load"]["holds"]
