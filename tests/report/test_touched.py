"""The replay shows what the tip touches where it is: also holes, and what is hollow so that the arm shows through."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.collision import Obstacle, Plane, distance
from mafsil.geometry import rotation
from mafsil.job import Run, parse_job, solve
from mafsil.model import Box, Cylinder, Sphere
from mafsil.report.replay import drawn, replay_scene
from mafsil.report.touched import shelves, standing
from mafsil.scene import Body, Solid
from mafsil.scene.inline import near_side, patch, stretch

JOB = """
robot = "planar2r"
[start]
joints = [0.3, 0.9]
[[surface]]
point = [0, 0, 0]
sphere = 3
hollow = true
stiffness = 1e4
[[surface]]
point = [0, 3, 0]
cylinder = 0.2
axis = [0, 0, 1]
stiffness = 1e4
[[hole]]
name = "bore"
mouth = [0.5, -1.5, 0]
axis = [0, 1, 0]
clearance = 0.001
chamfer = 0.002
depth = 0.3
[[move]]
pause = 0.05
"""


@pytest.mark.capability("10-70")
def test_holes_and_hollow_surfaces_are_drawn():
    run = solve(parse_job(JOB), JOB, Path())
    assert isinstance(run, Run)
    tips = run.tips()[0][:, :3, 3]
    (ball, _), (bar, _), (bore, place) = standing(run.job, 2.0, tips)
    assert ball.solids[0].kind == "sphere"
    assert ball.solids[0].size == (3.0,)
    assert ball.solids[0].colour[3] < 0.5
    assert bar.solids[0].colour[3] == 1.0
    face, shaft = bore.solids
    assert face.colour[3] < 0.5
    radius, depth = shaft.size
    assert depth == 0.3
    assert radius >= 0.003
    # From the mouth down its axis to the bottom.
    ends = [place @ [0, 0, shaft.pose[2] + side * depth / 2.0, 1.0] for side in (1, -1)]
    np.testing.assert_allclose(ends, [[0.5, -1.5, 0, 1], [0.5, -1.8, 0, 1]], atol=1e-12)


def pose_of(row):
    """Position and quaternion as a pose (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation.from_quaternion(row[3:]), row[:3]
    return T


ENDLESS = """
robot = "planar2r"
[start]
joints = [0.3, 0.9]
[[surface]]
name = "plane"
point = [40, 0, 30]
normal = [0, 0, 1]
stiffness = 1e4
[[surface]]
name = "bar"
point = [0, 3, 25]
cylinder = 0.2
axis = [0, 0, 1]
stiffness = 1e4
[[guide]]
name = "rail"
point = [-60, 1.2, 0]
direction = [1, 0, 0]
stiffness = 1e3
[[guide]]
name = "sheet"
point = [0, 70, 0]
normal = [0, 0, 1]
stiffness = 1e3
[[move]]
joints = [0.6, 0.9]
"""


def solid_in_space(body, T):
    """Middle of a body's first solid in {s}, and its size."""
    (x, y, z), size = body.solids[0].pose[:3], body.solids[0].size
    return (np.asarray(T) @ [x, y, z, 1.0])[:3], size


def test_what_is_endless_is_drawn_where_the_tip_is():
    """Support points lie tens of metres away: they only say which plane or line is meant."""
    run = solve(parse_job(ENDLESS), ENDLESS, Path())
    tips = run.tips()[0][:, :3, 3]
    middle = (tips.min(axis=0) + tips.max(axis=0)) / 2.0
    found = {body.name: solid_in_space(body, T) for body, T in standing(run.job, 2.0, tips)}
    plane, size = found["plane"]
    np.testing.assert_allclose(plane[:2], middle[:2], atol=1e-9)
    assert plane[2] == pytest.approx(30.0, abs=0.01)
    assert np.allclose(size[:2], np.ptp(tips, axis=0)[:2] + 0.9)
    assert abs(found["bar"][0][2] - middle[2]) < 1e-9
    assert found["rail"][0] == pytest.approx([middle[0], 1.2, 0.0])
    assert found["rail"][1][1] == pytest.approx(np.ptp(tips[:, 0]) + 0.9)
    np.testing.assert_allclose(found["sheet"][0][:2], middle[:2], atol=1e-9)
    ((body, T),) = drawn([Obstacle(Plane(), (300.0, -80.0, -1.0), "floor")], 2.0, tips)
    np.testing.assert_allclose(solid_in_space(body, T)[0][:2], middle[:2], atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_a_patch_holds_the_feet_of_all_points_and_lies_on_its_plane(seed):
    rng = np.random.default_rng(seed)
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R * np.sign(np.linalg.det(R)), 1e3 * rng.normal(size=3)
    seen = rng.normal(size=(50, 3))
    middle, edges = patch(T, seen, 0.4)
    feet = ((seen - T[:3, 3]) @ T[:3, :3])[:, :2]
    assert (np.abs(feet - middle) <= edges / 2.0 - 0.2 + 1e-9).all()
    alone, least = patch(T, seen[:1], 0.4)
    np.testing.assert_allclose(alone, feet[0], atol=1e-9)
    np.testing.assert_allclose(least, 0.4)
    along, length = stretch(T, seen, 0.4)
    heights = (seen - T[:3, 3]) @ T[:3, 2]
    assert (np.abs(heights - along) <= length / 2.0 - 0.2 + 1e-9).all()
    T[:3, 3] = seen.mean(axis=0)
    under = near_side(T, seen, 0.05)
    assert 0 < len(under) < len(seen)
    assert ((under - T[:3, 3]) @ T[:3, 2] <= 0.05).all()
    T[:3, 3] -= 100.0 * T[:3, 2]
    nearest = near_side(T, seen, 0.05)
    heights = (seen - T[:3, 3]) @ T[:3, 2]
    assert len(nearest) == (heights <= heights.min() + 0.05).sum()


TOUCHED = """
robot = "panda"
[[surface]]
name = "touched"
point = {point}
{kind}
stiffness = 1e4
[[move]]
pause = 0.1
"""


@pytest.mark.parametrize("seed", range(12))
def test_a_surface_contains_every_path_on_it(seed):
    """Planes, bars and balls somewhere in space: a path on them, short or long, is on what is drawn."""
    rng = np.random.default_rng(seed)
    point, axis, radius = (
        10.0 ** rng.integers(-1, 3) * rng.normal(size=3),
        rng.normal(size=3),
        float(rng.uniform(0.05, 2)),
    )
    axis /= np.linalg.norm(axis)
    across = np.linalg.svd(axis[None])[2][1:]
    path = np.cumsum(rng.normal(size=(int(rng.integers(1, 40)), 2)) * 10.0 ** rng.integers(-3, 1), axis=0)
    turns = np.stack([np.cos(path[:, 0]), np.sin(path[:, 0])], axis=1) @ across
    balls = np.cos(path[:, 1:]) * turns + np.sin(path[:, 1:]) * axis
    kinds = {
        f"normal = {axis.tolist()}": point + path @ across,
        f"cylinder = {radius}\naxis = {axis.tolist()}": point + radius * turns + path[:, 1:] * axis,
        f"sphere = {radius}": point + radius * balls,
    }
    for kind, tips in kinds.items():
        job = parse_job(TOUCHED.format(point=point.tolist(), kind=kind))
        ((body, T),) = standing(job, float(rng.uniform(0.3, 3)), tips)
        (solid,) = body.solids
        shape = {"box": lambda *size: Box(size), "cylinder": Cylinder, "sphere": Sphere}[solid.kind](*solid.size)
        balls_at = np.tile(np.eye(4), (len(tips), 1, 1))
        balls_at[:, :3, 3] = tips
        gaps = distance(shape, Sphere(1e-9), np.asarray(T) @ pose_of(np.array(solid.pose)), balls_at).distance
        assert np.max(gaps) < 1e-8 * (1.0 + np.linalg.norm(point))


@pytest.mark.capability("10-70")
def test_what_presses_on_the_tip_is_in_the_replay():
    text = (Path(__file__).parents[2] / "examples/jobs/polish_a_plate_puma560.toml").read_text(encoding="utf-8")
    run = solve(parse_job(text), text, Path())
    assert isinstance(run, Run)
    scene, tape = replay_scene(run), run.recording
    assert scene.forces is not None
    assert tape.contact_wrench is not None
    rows = np.searchsorted(tape.t, scene.times)
    np.testing.assert_array_equal(scene.forces, tape.contact_wrench[np.minimum(rows, len(tape.t) - 1)][:, 3:])
    # Where it presses, the tip is over the plate that is drawn, as deep as the plate gives way.
    (table,) = run.job.surface
    ((plate, place),) = [(body.solids[0], pose_of(T)) for body, T in scene.fixed if body.name == table.name]
    pressing = np.linalg.norm(scene.forces, axis=1) > 0.0
    at = (scene.tips[pressing, :3] - place[:3, 3]) @ place[:3, :3] - plate.pose[:3]
    assert len(at) > 20
    assert (np.abs(at[:, :2]) <= np.array(plate.size[:2]) / 2.0).all()
    give = np.linalg.norm(scene.forces, axis=1).max() / table.stiffness
    assert (np.abs(at[:, 2] - plate.size[2] / 2.0) <= give + 1e-6).all()
    # The plate lies level: what it exerts is upwards, but for friction, and as large as the job presses.
    R = np.asarray(run.robot.fk(scene.q))[:, :3, :3]
    pressed = (R @ scene.forces[:, :, None])[:, :, 0]
    assert pressed[:, 2].min() >= -1e-9
    assert np.linalg.norm(pressed, axis=1).max() > 5.0


def thing(x: float, y: float, z: float, size: tuple[float, float, float] = (0.1, 0.1, 0.1), turn: float = 0.0):
    """A box whose middle is there."""
    T = np.eye(4)
    c, s = np.cos(turn), np.sin(turn)
    T[:2, :2], T[:3, 3] = [[c, -s], [s, c]], (x, y, z)
    return Body("thing", (Solid("box", size),)), T


def test_what_hangs_in_the_air_gets_a_tray_that_touches_it_and_a_post_to_the_floor():
    ((body, T),) = shelves([thing(0.4, 0.2, 0.5, turn=np.pi / 4)], [], -0.1, 1.0)
    plate, post = body.solids
    np.testing.assert_allclose(T[:3, 3], [0.4, 0.2, 0.45])
    assert min(plate.size[:2]) > np.sqrt(2) * 0.1
    np.testing.assert_allclose(plate.pose[2] + plate.size[2] / 2, 0.0, atol=1e-15)
    np.testing.assert_allclose(T[2, 3] + post.pose[2] - post.size[1] / 2, -0.1)


@pytest.mark.parametrize(
    ("lying", "others", "trays"),
    [
        ([thing(0, 0, 0.05)], [], 0),
        ([thing(0, 0, 0.5), thing(0, 0, 0.6)], [], 1),
        ([thing(0, 0, 0.5), thing(0.12, 0, 0.5), thing(0.24, 0, 0.5)], [], 1),
        ([thing(0, 0, 0.5), thing(0.24, 0, 0.5), thing(0.12, 0, 0.5)], [], 1),
        ([thing(0, 0, 0.5), thing(0.8, 0, 0.5)], [], 2),
        ([thing(0, 0, 0.5), thing(0.0, 0.05, 0.7)], [], 2),
        ([thing(0, 0, 0.5)], [thing(0.3, 0, 0.4, (1.0, 1.0, 0.1))], 0),
        ([thing(0, 0, 0.5)], [thing(2.0, 0, 0.4, (1.0, 1.0, 0.1))], 1),
        ([thing(0, 0, 0.5)], [thing(0.3, 0, 0.8, (1.0, 1.0, 0.1))], 1),
        ([thing(0, 0, 0.5)], [(Body("pin", (Solid("cylinder", (0.1, 0.9)),)), np.eye(4))], 0),
    ],
)
def test_one_tray_for_what_lies_side_by_side_and_none_for_what_lies_on_something(lying, others, trays):
    assert len(shelves(lying, others, 0.0, 1.0)) == trays
