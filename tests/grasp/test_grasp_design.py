"""Forces, second order, regions, synthesis, task quality, files and pictures."""

from __future__ import annotations

import json

import numpy as np
import pytest
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from mafsil.cli.registry import operation
from mafsil.errors import FileError, InputError, MafsilError
from mafsil.figures.grasp import draw_grasp
from mafsil.grasp import Contact, FrictionLaw, Grasp, GraspedBody, corner_contact, line_contact, patch_contact
from mafsil.grasp.friction import sliding_force, split
from mafsil.grasp.grasp_file import read_grasp
from mafsil.grasp.synthesis import (
    best_next_finger,
    box_fixture,
    fixture,
    least_friction,
    polygon_contacts,
)
from mafsil.grasp.uncertainty import (
    ellipsoid_scale,
    frictionless_regions,
    smallest_singular_value,
    task_scale,
    two_finger_regions,
)


def pinch(mu=0.5):
    return Grasp([Contact((-1, 0), (1, 0), mu), Contact((1, 0), (-1, 0), mu)])


@pytest.mark.capability("03-13", "03-14", "03-60", "03-1")
def test_lines_patches_and_corners():
    table = Grasp(
        [patch_contact([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (0, 0, 1)), line_contact((0, 0, 1), (1, 0, 1), (0, 0, -1))]
    )
    assert len(table) == 5
    corner = Grasp([corner_contact((0, 0), [(-1, 0), (0, -1)]), Contact((-1, 2), (1, 0)), Contact((2, -1), (0, 1))])
    assert corner.closure()
    assert Grasp.from_dict(json.loads(corner.to_json())).matrix() == pytest.approx(corner.matrix())
    with pytest.raises(InputError, match="corner 2"):
        patch_contact([(0, 0, 0), (1, 0, 0), (0, 1, 0.1)], (0, 0, 1))


@pytest.mark.capability("03-18", "03-19", "03-21", "03-17")
def test_friction_laws():
    law = FrictionLaw(0.5, 0.3, viscous=0.1, aging=0.02)
    assert law.sliding(0.0) == pytest.approx(0.5)
    assert law.sliding(1.0) == pytest.approx(0.4)
    assert law.at_rest(9.0) == pytest.approx(0.5 + 0.02 * np.log(10))
    assert law.breakaway_drop() == pytest.approx(0.4)
    assert sliding_force(10.0, (3, 4), 0.3) == pytest.approx([-1.8, -2.4])
    along, across = split((1, 2, 3), (0, 0, 2))
    assert along == pytest.approx([0, 0, 3])
    assert across == pytest.approx([1, 2, 0])
    for call in (lambda: FrictionLaw(0.3, 0.4), lambda: sliding_force(1.0, (0, 0), 0.3)):
        with pytest.raises(InputError):
            call()


@pytest.mark.capability("03-8", "03-9", "03-11")
def test_torque_limits_of_a_hand():
    hand = np.zeros((2, 4))
    hand[0, 0], hand[1, 2] = 0.1, -0.1
    weight = [0, 0, -9.81]
    held = pinch().resist(weight, jacobian=hand, torque=[1.0, 1.0])
    assert held.holds
    assert held.torques == pytest.approx([0.981, 0.981])
    weak = pinch().resist(weight, jacobian=hand, torque=[0.97, 0.97])
    assert not weak.holds
    assert weak.certificate is None
    with pytest.raises(InputError, match="belong together"):
        pinch().resist(weight, torque=[1.0])


@pytest.mark.capability("03-37", "03-33")
def test_refused_load_has_a_certificate():
    grasp = Grasp([Contact((-1, 0, 0), (1, 0, 0), 0.5), Contact((1, 0, 0), (-1, 0, 0), 0.5)])
    twist = [1.0, 0, 0, 0, 0, 0]
    answer = grasp.resist(twist)
    assert not answer.holds
    assert answer.certificate @ -np.array(twist) < 0
    assert (grasp.matrix(64).T @ answer.certificate).min() >= -1e-9
    held = grasp.resist([0, 0, 0, 0, 3.0, 4.0])
    assert held.total_push == pytest.approx(10.0)
    assert grasp.resultant(held.forces) == pytest.approx([0, 0, 0, 0, -3, -4], abs=1e-9)


def test_two_finger_regions_hold_everywhere_inside():
    regions = two_finger_regions([(0, 0), (4, 0)], [(4, 1), (0, 1)], 0.5)
    assert regions.length == pytest.approx(0.5)
    rng = np.random.default_rng(0)
    for s, t in rng.uniform(0.001, 0.999, (50, 2)):
        p = regions.first[0] + s * (regions.first[1] - regions.first[0])
        q = regions.second[0] + t * (regions.second[1] - regions.second[0])
        assert Grasp([Contact(p, (0, 1), 0.5), Contact(q, (0, -1), 0.5)]).closure(margins=False)
    assert two_finger_regions([(0, 0), (1, 0)], [(9, 1), (8, 1)], 0.2) is None


def test_frictionless_regions_hold_everywhere_inside():
    places = (((0.5, 1), (0, -1)), ((2, 0.5), (-1, 0)), ((-0.5, -1), (0, 1)), ((-2, -0.5), (1, 0)))
    seed = Grasp([Contact(p, n) for p, n in places])
    reach = frictionless_regions(seed)
    assert (reach[:, 0] < 0).all()
    assert (reach[:, 1] > 0).any()
    rng = np.random.default_rng(1)
    for _ in range(60):
        shifts = rng.uniform(np.maximum(reach[:, 0], -1), np.minimum(reach[:, 1], 1))
        moved = [Contact(c.point + s * c.tangents[0], c.normal) for c, s in zip(seed.contacts, shifts, strict=True)]
        assert Grasp(moved).closure().margin >= 0.5 * seed.closure().margin - 1e-9


@pytest.mark.capability("03-10", "03-11")
def test_synthesis():
    outline = [(-2, -1), (2, -1), (2, 1), (-2, 1)]
    three = Grasp([Contact((0.5, 1), (0, -1)), Contact((2, 0.5), (-1, 0)), Contact((-0.5, -1), (0, 1))])
    placed = best_next_finger(three, polygon_contacts(outline, 9))
    assert placed.epsilon > 0
    assert Grasp([*three.contacts, placed.contact]).closure()
    locators, clamp = box_fixture((1, 1, 1))
    assert fixture(locators, clamp).holds
    assert Grasp([*locators, clamp]).closure()
    assert fixture(locators, Contact((0.9, 0.9, 0.5), (1, 0, 0))).unloaded
    assert not fixture([*locators[:5], locators[0]], clamp).determined
    ring = [Contact(p, (-p[0], -p[1], 0.2)) for p in ((1, 0, 0), (-0.5, 0.8, 0), (-0.5, -0.8, 0))]
    assert least_friction(Grasp(ring), 1e-4) == pytest.approx(0.2, abs=0.02)
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
    for contact in GraspedBody.from_triangles(cube, faces).contacts(20, 0.5):
        assert (contact.point + 0.1 * contact.normal - 0.5) @ contact.normal < 0.0


def test_task_quality():
    assert task_scale(pinch(), [(0, 0, -1), (0, 0, 1)])[0] == pytest.approx(0.5)
    assert ellipsoid_scale(pinch(), np.eye(3)) == pytest.approx(1 / 3)
    assert smallest_singular_value(pinch(0.0)) == 0.0
    together = pinch().quality(together=True)
    assert together.upper >= pinch().quality().epsilon


@pytest.mark.capability("03-30")
def test_drawn_cones_have_the_friction_angle():
    flat, _ = draw_grasp(pinch(0.5), pinch(0.5).closure()).axes
    cones = [np.asarray(patch.get_xy()) for patch in flat.patches]
    assert len(cones) == 2
    for cone, contact in zip(cones, pinch().contacts, strict=True):
        edges = cone[1:3] - contact.point
        cosines = edges @ contact.normal / np.linalg.norm(edges, axis=1)
        assert cosines == pytest.approx(np.cos(np.arctan(0.5)))
    ball = Grasp([Contact((-1, 0, 0), (1, 0, 0), 0.5), Contact((1, 0, 0), (-1, 0, 0), 0.0)])
    (space,) = draw_grasp(ball, ball.closure()).axes
    surfaces = [each for each in space.collections if isinstance(each, Poly3DCollection)]
    assert len(surfaces) == 1  # the contact without friction has a normal and no cone


@pytest.mark.capability("03-1", "03-15")
def test_command_reads_grasp_files_and_draws(tmp_path):
    described = tmp_path / "pinch.json"
    described.write_text(json.dumps({**pinch().to_dict(), "load": {"force": [0, -9.81]}}))
    picture = tmp_path / "pinch.png"
    answer = operation("grasp")(file=str(described), facets=None, steps=True, picture=str(picture))
    assert answer.refusal is None
    assert answer.data["load"]["total_push"] == pytest.approx(19.62)
    assert picture.stat().st_size > 10_000
    assert any("R1" in line for line in answer.lines)
    assert "all bodies are assumed rigid" in answer.lines
    assert answer.data["closure"]["assumes"] == "rigid bodies"
    with pytest.raises(InputError, match="--facets"):
        operation("grasp")(file=str(described), facets="x", steps=False, picture=None)


def test_wrong_files_are_named(tmp_path):
    good = {"contact": [{"point": [0, 0], "normal": [1, 0]}]}
    wrong = {
        "no contacts": {},
        "lacks point": {"contact": [{"point": [0, 0]}]},
        "not known": {**good, "kontact": 1},
        "off the outline": {**good, "body": {"outline": [[1, 1], [2, 1], [2, 2]]}},
        "corners enclose": {**good, "body": {"outline": [[1, 1], [2, 1]]}},
        "expected real numbers": {"contact": [{"point": [0, 0], "normal": [1, 0], "mu": "much"}]},
        "table is expected": {**good, "load": 3},
    }
    path = tmp_path / "described.json"
    for words, data in wrong.items():
        path.write_text(json.dumps(data))
        with pytest.raises(MafsilError, match=words):
            read_grasp(path)
    path.write_text("{")
    with pytest.raises(FileError, match="well formed"):
        read_grasp(path)
    with pytest.raises(FileError, match="cannot be read"):
        read_grasp(tmp_path / "none.toml")
