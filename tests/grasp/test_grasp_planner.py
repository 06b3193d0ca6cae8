"""Grasps of meshes: real ones from a package, known shapes, broken ones; closure that survives errors."""

from __future__ import annotations

import sysconfig
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mafsil.cli.registry import operation
from mafsil.errors import FileError, InputError
from mafsil.figures.grasp import draw_plan, save_free_motions
from mafsil.grasp import Contact, Grasp, GraspedBody, plan_grasps, robustness
from mafsil.grasp.uncertainty import tolerance

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
    (1, 5, 7), (1, 7, 3),
])  # fmt: skip


def real_meshes(count: int, largest: int = 500_000) -> list[Path]:
    folder = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
    files = [
        p for p in sorted(folder.rglob("*"))
        if p.suffix.lower() in (".stl", ".obj") and 20_000 < p.stat().st_size < largest
    ]  # fmt: skip
    if not files:
        pytest.skip("example-robot-data is not installed")
    return files[:: max(1, len(files) // count)][:count]


@pytest.mark.capability("03-10", "03-11")
def test_ten_real_meshes_are_grasped_by_two_and_by_three_fingers() -> None:
    meshes = real_meshes(10)
    assert len(meshes) == 10
    for path in meshes:
        body = GraspedBody.of(path)
        for fingers in (2, 3):
            plan = plan_grasps(body, fingers=fingers, tries=400, best=2)
            assert plan.grasps, (path.name, fingers)
            for proposal in plan.grasps:
                assert len(proposal.grasp) == fingers
                assert proposal.grasp.closure(margins=False).force_closure
                assert proposal.epsilon > 0
                assert max(body.distance(c.point) for c in proposal.grasp.contacts) < 1e-9 * body.size


@pytest.mark.capability("03-11")
def test_a_trimesh_object_is_taken_as_it_is() -> None:
    trimesh = pytest.importorskip("trimesh")
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
    body = GraspedBody.of(sphere)
    assert body.open_edges == 0
    assert body.centre == pytest.approx(np.zeros(3), abs=1e-9)
    assert (np.einsum("fi,fi->f", body.normals, body.corners.mean(axis=1)) < 0).all()
    assert body.areas.sum() == pytest.approx(sphere.area)
    assert body.distance(np.array([0.1, 0, 0])) == pytest.approx(0.05, abs=5e-4)
    assert body.distance(np.asarray(sphere.triangles_center[7])) < 1e-15
    plan = plan_grasps(sphere, opening=0.2)
    assert plan.grasps[0].opening == pytest.approx(0.1, abs=0.02)


@pytest.mark.capability("03-11")
def test_a_cube_is_held_across_and_never_wider_than_the_hand() -> None:
    body = GraspedBody.from_triangles(CUBE, FACES)
    assert body.centre == pytest.approx([0.5, 0.5, 0.5])
    plan = plan_grasps(body, mu=0.3, best=20)
    for proposal in plan.grasps:
        a, b = (c.normal for c in proposal.grasp.contacts)
        assert a == pytest.approx(-b)
    assert not plan_grasps(body, mu=0.3, opening=0.9).grasps
    assert "None" in plan_grasps(body, mu=0.3, opening=0.9).explain("en")


def test_inside_out_meshes_are_turned_and_holes_are_counted() -> None:
    right, wrong = GraspedBody.from_triangles(CUBE, FACES), GraspedBody.from_triangles(CUBE, FACES[:, ::-1])
    assert wrong.normals == pytest.approx(right.normals)
    holed = GraspedBody.from_triangles(CUBE, FACES[1:])
    assert holed.open_edges == 3
    assert "3 open edges" in plan_grasps(holed, fingers=3).explain("en")


def test_the_same_seed_plans_the_same_grasps() -> None:
    one, two = (plan_grasps(GraspedBody.from_triangles(CUBE, FACES), fingers=4, seed=5) for _ in range(2))
    assert [p.epsilon for p in one.grasps] == [p.epsilon for p in two.grasps]
    assert one.grasps[0].epsilon >= one.grasps[-1].epsilon


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: plan_grasps(SimpleNamespace()), "not a mesh"),
        (lambda: GraspedBody.from_triangles(CUBE, [(0, 1, 9)]), "index 9"),
        (lambda: GraspedBody.from_triangles(CUBE, [(0, 0, 1)]), "area"),
        (lambda: GraspedBody.from_triangles(CUBE * np.nan, FACES), "nan"),
        (lambda: GraspedBody.from_triangles(CUBE, np.zeros((0, 3), int)), "faces"),
        (lambda: plan_grasps(GraspedBody.from_triangles(CUBE, FACES), fingers=1), "at least 2"),
        (lambda: plan_grasps(GraspedBody.from_triangles(CUBE, FACES), gamma=0.0), "Two hard fingers"),
        (lambda: plan_grasps(GraspedBody.from_triangles(CUBE, FACES), tries=0), "tries"),
        (lambda: robustness(Grasp([Contact((0, 0), (1, 0))]), position=-1.0), "position"),
        (lambda: robustness(Grasp([Contact((0, 0), (1, 0))]), samples=0), "samples"),
        (lambda: save_free_motions(Grasp([Contact((0, 0, 0), (1, 0, 0))]), Path("x.gif")), "plane"),
    ],
)
def test_what_cannot_be_held_is_named(call, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call()
    with pytest.raises(FileError):
        GraspedBody.of("no_such_mesh.stl")


@pytest.mark.capability("03-2")
def test_the_ball_proves_how_far_contacts_may_be_off() -> None:
    rng = np.random.default_rng(1)
    pinch = Grasp([Contact((-1, 0), (1, 0), 0.5), Contact((1, 0), (-1, 0), 0.5), Contact((0, -1), (0, 1), 0.5)])
    limits = tolerance(pinch)
    for _ in range(200):
        slid = [
            Contact(c.point + rng.uniform(-1, 1) * 0.999 * t * c.tangents[0], c.normal, c.mu)
            for c, t in zip(pinch.contacts, limits, strict=True)
        ]
        assert Grasp(slid).closure(margins=False).force_closure


@pytest.mark.capability("03-2")
def test_probability_of_closure_falls_with_the_errors() -> None:
    pinch = Grasp([Contact((-1, 0), (1, 0), 0.3), Contact((1, 0), (-1, 0), 0.3)])
    sure = robustness(pinch, samples=400)
    shaken = [robustness(pinch, angle=a, samples=400).probability for a in (0.05, 0.3, 1.0)]
    assert sure.probability == 1.0
    assert sure.low > 0.98
    assert shaken[0] > shaken[1] > shaken[2]
    # Two independent tilts within the friction angle: the share of a normal distribution, squared.
    from math import atan, erf, sqrt

    expected = erf(atan(0.3) / 0.3 / sqrt(2)) ** 2
    found = robustness(pinch, angle=0.3, samples=4000)
    assert found.low - 0.01 <= expected <= found.high + 0.01


@pytest.mark.capability("03-3", "03-30")
def test_pictures_and_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = tmp_path / "cube.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in CUBE] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
    mesh.write_text("\n".join(lines))
    empty = {"facets": None, "steps": False, "fingers": None, "mu": None, "gamma": None, "opening": None}
    answer = operation("grasp")(file=str(mesh), picture=str(tmp_path / "plan.png"), **empty | {"fingers": 3, "mu": 0.6})
    assert answer.refusal is None
    assert len(answer.data["grasps"]) == 10
    assert (tmp_path / "plan.png").stat().st_size > 10_000
    again = Grasp.from_dict({"contact": answer.data["grasps"][0]["contact"]})
    assert again.closure(margins=False).force_closure
    with pytest.raises(InputError, match="steps"):
        operation("grasp")(file=str(mesh), picture=None, **empty | {"steps": True})
    described = tmp_path / "held.toml"
    contact = "[[contact]]\npoint = [{0}, 0.5, 0.5]\nnormal = [{1}, 0, 0]\nmu = 0.5\ngamma = 0.01\n"
    described.write_text(contact.format(0.0, 1) + contact.format(1.0, -1) + '[body]\nmesh = "cube.obj"\n')
    with pytest.raises(InputError, match="fingers"):
        operation("grasp")(file=str(described), picture=None, **empty | {"fingers": 3})
    held = operation("grasp")(file=str(described), picture=str(tmp_path / "held.png"), **empty)
    assert held.data["closure"]["force_closure"]
    described.write_text(contact.format(0.2, 1) + contact.format(1.0, -1) + '[body]\nmesh = "cube.obj"\n')
    with pytest.raises(InputError, match="contact 0"):
        operation("grasp")(file=str(described), picture=None, **empty)


def test_a_plan_is_drawn_small_by_small() -> None:
    plan = plan_grasps(GraspedBody.from_triangles(CUBE, FACES), fingers=3)
    assert len(draw_plan(plan).axes) == 6


@pytest.mark.capability("03-10")
def test_among_equal_radii_the_grasp_through_the_middle_comes_first() -> None:
    block = GraspedBody.from_triangles(CUBE * (0.06, 0.04, 0.1), FACES)
    plan = plan_grasps(block, mu=0.4, tries=800, best=8, seed=3)
    middle, limit = plan.body.centre, 0.95 * max(p.epsilon for p in plan.grasps)
    equal = [p for p in plan.grasps if p.epsilon >= limit]
    assert [p.weight for p in equal] == sorted((p.weight for p in equal), reverse=True)
    assert plan.grasps[0].weight > 1.2 * equal[-1].weight

    def miss(p):
        a, b = (c.point for c in p.grasp.contacts)
        return np.linalg.norm(np.cross(b - a, middle - a)) / np.linalg.norm(b - a)

    assert miss(plan.grasps[0]) < np.median([miss(p) for p in plan.grasps])
    assert all(p.weight is None for p in plan_grasps(block, fingers=3, tries=100, best=3).grasps)
