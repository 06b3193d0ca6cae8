"""Jobs among obstacles: what is hit is refused with its place, what can be avoided is; the report says how near."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Checker, SkipReason
from mafsil.errors import JobError
from mafsil.job import solve
from mafsil.job.driving.run import Run
from mafsil.job.judging.judgement import summary
from mafsil.job.language.reading import parse_job
from mafsil.job.remark import Refusal
from mafsil.job.solve import prepare
from mafsil.report.contents import page
from mafsil.report.replay import replay_scene
from mafsil.report.results import as_data

EXAMPLE = (Path(__file__).parents[2] / "examples" / "jobs" / "around_a_wall_panda.toml").read_text("utf-8")
HERE = Path()


def solved(text: str) -> Run | Refusal:
    return solve(parse_job(text), text, HERE)


@pytest.fixture(scope="module")
def run() -> Run:
    found = solved(EXAMPLE)
    assert isinstance(found, Run)
    return found


@pytest.mark.capability("11-50")
def test_the_job_goes_round_the_wall(run: Run) -> None:
    assert run, run.explain("en")
    around = run.plan.surroundings
    assert around is not None
    starts = run.plan.starts
    legs = np.clip(np.searchsorted(starts, run.recording.t, side="right") - 1, 0, len(run.plan.legs) - 1)
    for leg in np.unique(legs):
        checker: Checker = around.checker(run.plan.legs[leg].load)
        near = checker.distance(run.recording.q[legs == leg])
        assert near.distance.min() > 0.8 * 0.02, run.plan.legs[leg].name
    said = run.explain("en")
    assert "planned around it over" in said
    assert "wall" in said
    assert run.explain("ar") != said


def test_numbers_plot_and_bodies_of_the_report(run: Run) -> None:
    numbers = summary(run)
    assert numbers.clearances is not None
    assert 0.0 < numbers.clearances.distance.min() == numbers.clearances.to_dict()["least"]
    shown = page(run, numbers, "en")
    assert {"wall", "table"} <= {body.name for body, _ in shown.scene.fixed}
    plot = next(one for one in shown.plots if one.column == "clearance")
    assert plot.title == "Clearance"
    assert plot.values.shape == (len(shown.times), 1)
    assert json.dumps(numbers.clearances.to_dict())


def test_without_avoid_the_hit_is_named() -> None:
    refused = solved(EXAMPLE.replace("avoid = true", "avoid = false"))
    assert isinstance(refused, Refusal)
    text = refused.explain("en")
    for word in ("to the other side", "wall", "avoid = true"):
        assert word in text
    one = solved(EXAMPLE.replace("avoid = true", "avoid = false").replace('profile = "jerk_limited"', "avoid = true"))
    assert isinstance(one, Run)
    assert one


def test_starts_lines_and_goals_that_are_not_free_are_named() -> None:
    start = solved(EXAMPLE.replace("position = [0.6, 0.0, 0.225]", "position = [0.35, 0.35, 0.4]"))
    assert isinstance(start, Refusal)
    assert "wall" in start.explain("en")
    assert "start" in start.explain("en")
    plate = EXAMPLE + '\n[[obstacle]]\nname = "plate"\nbox = [0.2, 0.2, 0.02]\nposition = [0.45, 0.3, 0.19]\n'
    line = solved(plate)
    assert isinstance(line, Refusal)
    assert "plate" in line.explain("en")


def test_a_floor_and_a_check_of_the_arm_against_itself() -> None:
    text = """robot = "ur5e"
[collision]
[[obstacle]]
floor = true
name = "ground"
position = [0, 0, 0]
[start]
joints = [0, -1.5, 1.5, 0, 0, 0]
"""
    down = solved(text + "[[move]]\njoints = [0, 0.6, 0, 0, 0, 0]\n")
    assert isinstance(down, Refusal)
    assert "ground" in down.explain("en")
    up = solved(text + "[[move]]\njoints = [0.5, -1.2, 1.0, 0, 0, 0]\n")
    assert isinstance(up, Run)
    assert up


def test_kinds_of_obstacles_stand_where_the_file_says(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "scan.xyz", [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0]])
    np.save(tmp_path / "ground.npy", [[0.0, 0.1, 0.0], [0.2, 0.0, 0.1]])
    text = """robot = "ur5e"
angles = "degrees"
[[obstacle]]
cylinder = [0.1, 0.5]
position = [1, 0, 0]
rpy = [90, 0, 0]
[[obstacle]]
capsule = [0.1, 0.5]
position = [0, 2, 0]
[[obstacle]]
sphere = 0.3
position = [0, 0, 3]
[[obstacle]]
cloud = "scan.xyz"
radius = 0.02
scale = 0.001
position = [2, 0, 0]
[[obstacle]]
heights = "ground.npy"
size = [2.0, 1.0]
position = [0, 0, -2]
[[move]]
pause = 0.1
"""
    run = solve(parse_job(text), text, tmp_path)
    assert isinstance(run, Run)
    assert run.plan.surroundings is not None
    cylinder, capsule, sphere, cloud, ground = run.plan.surroundings.scene
    np.testing.assert_allclose(cloud.geometry.points, [[0, 0, 0], [0.1, 0, 0]])
    assert (cloud.geometry.radius, ground.geometry.size, ground.geometry.base) == (0.02, (2.0, 1.0), -0.1)
    balls, hills = (body.solids[0].surface for body, _ in replay_scene(run).fixed[3:])
    assert balls is not None
    assert hills is not None
    assert (len(balls.faces), len(hills.faces)) == (16, 16)
    a, b, c = (hills.vertices[hills.faces[:, k]] for k in range(3))
    # Volume enclosed with the open underside at the base, which adds nothing about its own plane.
    shift = [0.0, 0.0, ground.geometry.base]
    volume = np.einsum("ij,ij->i", a - shift, np.cross(b - shift, c - shift)).sum() / 6
    assert 0.2 < volume < 0.4
    np.testing.assert_allclose(cylinder.T_so[:3, 2], [0, -1, 0], atol=1e-12)
    assert (cylinder.geometry.radius, cylinder.geometry.length) == (0.1, 0.5)
    assert isinstance(capsule.geometry, mf.collision.Capsule)
    assert sphere.geometry.radius == 0.3
    assert sphere.name == "obstacle[2]"


PER_MOVE = """
robot = "panda"
[collision]
clearance = 0.02
avoid = true
seconds = 0.3
[[obstacle]]
name = "wall"
box = [0.5, 0.04, 0.52]
position = [0.6, 0.0, 0.26]
[start]
joints = [0.8, -0.3, 0.0, -2.2, 0.0, 1.9, 0.8]
[[move]]
name = "round"
joints = [-0.8, -0.3, 0.0, -2.2, 0.0, 1.9, 0.8]
clearance = 0.05
planner = "PLANNER"
"""


@pytest.mark.capability("11-39", "11-40")
@pytest.mark.parametrize("planner", ["rrt_connect", "lazy_prm_star", "trajectory_optimisation", "prm"])
def test_a_move_has_its_own_clearance_and_planner(planner):
    """Also planners whose best way keeps just the clearance: what they find is not refused afterwards."""
    text = PER_MOVE.replace("PLANNER", planner)
    _, motion = prepare(parse_job(text), text, Path())
    leg = motion.legs[0]
    assert leg.clearance == 0.05
    assert leg.way.plan.planner == planner
    assert leg.way.contact.second == "wall"
    q = leg.trajectory.at(np.linspace(0.0, leg.trajectory.duration, 2000)).u
    checker = motion.surroundings.checker(leg.load, 0.0)
    assert checker.checking(range(len(checker.bodies)), ()).distance(q).distance.min() > 0.05 - 1e-9
    assert checker.free(q).all()
    assert any(remark.key == "job.went_round" and planner in remark.sentence("en") for remark in motion.remarks)


@pytest.mark.capability("11-40")
def test_report_and_results_have_the_account_and_the_clearance_over_time():
    line = '[[move]]\npose = { relative = "space", position = [0, 0, 0.05] }\npath = "line"\nclearance = 0.0\n'
    text = PER_MOVE.replace("PLANNER", "rrt_connect") + line
    run = solve(parse_job(text), text, Path())
    data = as_data(run, summary(run))
    way = data["steps"][0]["way_round"]
    assert way["planner"] == "rrt_connect"
    assert way["would_hit"][1] == "wall"
    assert way["path"][0] == pytest.approx([0.8, -0.3, 0.0, -2.2, 0.0, 1.9, 0.8])
    assert data["steps"][1]["way_round"] is None
    for language in ("en", "ar"):
        shown = page(run, summary(run), language)
        plot = next(each for each in shown.plots if each.column == "clearance")
        assert set(plot.values[:, 1]) == {0.0, 0.05}
        account = next(each for each in shown.details if each.pairs and "rrt_connect" in each.pairs[0][1])
        assert account.pairs[0][0] == "round"


@pytest.mark.parametrize(
    ("move", "key"),
    [
        ("avoid = false\nplanner = 'prm'", "job.planner_avoid"),
        ("via = [[0, 0, 0, -2, 0, 1.9, 0.8]]\nplanner = 'prm'", "job.planner_avoid"),
        ("planner = 'teleport'", "job.choice"),
        ("clearance = -0.1", "job.bound"),
    ],
)
def test_wrong_planners_and_clearances_are_named(move, key):
    text = PER_MOVE.replace('clearance = 0.05\nplanner = "PLANNER"', move)
    with pytest.raises(JobError) as caught:
        parse_job(text, "job.toml")
    assert caught.value.key == key
    assert "job.toml:1" in caught.value.message("ar")


def test_clearances_of_moves_are_lengths_of_the_file():
    text = 'robot = "panda"\nlengths = "millimetres"\n[[move]]\njoints = [0, 0, 0, -1.5, 0, 1.5, 0]\nclearance = 20\n'
    assert parse_job(text).move[0].clearance == pytest.approx(0.02)


def test_a_clearance_that_the_arm_never_keeps_from_itself_is_said():
    """The wrists of this UR5 stay 9.3 mm apart, whatever its joints do: they keep less, unless that is asked for."""
    robot = Path(__file__).parents[2] / "examples" / "robots" / "ur5.urdf"
    text = f"robot = '{robot}'\n[collision]\nclearance = 0.02\n[start]\njoints = [0.3, -1.9, 1.9, -1.6, -1.6, 0]\n"
    text += "[[move]]\njoints = [0.5, -1.9, 1.9, -1.6, -1.6, 0]\n"
    _, plan = prepare(parse_job(text), text, Path())
    (said,) = (remark for remark in plan.remarks if remark.key == "job.always_near")
    strict = text.replace("clearance = 0.02\n", "clearance = 0.02\nself_clearance = 0.02\n")
    refused = prepare(parse_job(strict), strict, Path())
    assert isinstance(refused, Refusal)
    for language in ("en", "ar"):
        assert "wrist_1 - wrist_3" in said.sentence(language)
        assert "wrist_1" in refused.explain(language)
        assert "self_clearance" in refused.explain(language)
    nearer = text.replace("0.02", "0.009")
    assert not isinstance(prepare(parse_job(nearer), nearer, Path()), Refusal)
    allowed = text.replace("clearance = 0.02\n", "clearance = 20\nself_clearance = 5\n")
    allowed = "lengths = 'millimetres'\n" + allowed
    run = solve(parse_job(allowed), allowed, Path())
    assert isinstance(run, Run)
    assert run.plan.surroundings is not None
    checker = run.plan.surroundings.checker(run.plan.legs[0].load)
    assert (checker.clearance, checker.self_clearance) == (pytest.approx(0.02), pytest.approx(0.005))
    touching = allowed.replace("self_clearance = 5", "self_clearance = 12")
    assert isinstance(prepare(parse_job(touching), touching, Path()), Refusal)


CELL = """
robot = "planar3r"

[collision]
avoid = true
skip = [["link1", "link3"]]

[start]
joints = [0.2, 0.9, 0.3]

[[obstacle]]
name = "casting"
mesh = "casting.stl"
scale = 0.001
hull = true
position = [1.2, 1.2, 0.0]

[[obstacle]]
name = "sheet"
mesh = "casting.stl"
scale = 0.001
position = [-1.2, -1.2, 0.0]

[[obstacle]]
name = "hopper"
cone = [0.1, 0.4]
position = [0.0, -1.8, 0.0]

[[move]]
joints = [1.6, 0.4, 0.2]
"""


@pytest.mark.capability("11-50")
def test_meshes_cones_and_pairs_that_are_left_out(tmp_path: Path) -> None:
    """A tetrahedron of 200 mm in millimetres stands in the way as its hull; what cannot be is named with its line."""
    corners = [(-100, -100, -100), (100, -100, -100), (0, 100, -100), (0, 0, 200)]
    facets = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    rows = [f"vertex {x} {y} {z}" for face in facets for x, y, z in (corners[k] for k in face)]
    threes = ["\n".join(rows[k : k + 3]) for k in (0, 3, 6, 9)]
    loops = [f"facet normal 0 0 0\nouter loop\n{three}\nendloop\nendfacet" for three in threes]
    (tmp_path / "casting.stl").write_text("\n".join(["solid casting", *loops, "endsolid casting"]))
    run = solve(parse_job(CELL), CELL, tmp_path)
    assert isinstance(run, Run)
    assert run, run.explain("en")
    assert "casting" in run.explain("en")
    around = run.plan.surroundings
    assert around is not None
    kinds = [type(each.geometry).__name__ for each in around.obstacles]
    assert kinds == ["ConvexHull", "TriangleMesh", "Cone"]
    checker = around.checker(run.plan.legs[0].load)
    listed = [(each.first, each.second) for each in checker.skipped if each.reason is SkipReason.LISTED]
    assert listed == [("link1", "link3")]
    hull, sheet, hopper = (body.solids[0] for body, _ in replay_scene(run).fixed)
    for solid, count in ((hull, 4), (sheet, 4), (hopper, 46)):
        assert solid.surface is not None
        assert len(solid.surface.faces) == count
        a, b, c = (solid.surface.vertices[solid.surface.faces[:, k]] for k in range(3))
        assert (np.cross(b - a, c - a) * (a - solid.surface.vertices.mean(axis=0))).sum(axis=1).min() > 0.0
    wrong = {
        CELL.replace('"casting.stl"\nscale = 0.001\nh', '"cast.stl"\nh'): r":13: obstacle\[1\].mesh.*cast.stl",
        CELL.replace('mesh = "casting.stl"\n', "sphere = 0.1\n", 1): ":14: scale has an effect beside mesh, cloud",
        CELL.replace("scale = 0.001", "scale = 1.0", 1): "300 m across.*scale = 0.001",
        CELL + '[[obstacle]]\ncloud = "scan.ply"\n': "cloud needs radius",
        CELL + '[[obstacle]]\nheights = "hill.png"\nsize = [1, 1]\nposition = [0, 0, 0]\n': "heights.*hill.png",
        CELL + "[[obstacle]]\nbox = [1, 1, 1]\nradius = 1.0\n": "radius has an effect beside cloud only",
        CELL.replace("skip", 'srdf = "arm.srdf"\nskip'): "collision.srdf.*arm.srdf",
    }
    for text, sentence in wrong.items():
        with pytest.raises(mf.MafsilError, match=sentence):
            solve(parse_job(text), text, tmp_path)


@pytest.mark.capability("11-39")
def test_bodies_that_meet_where_the_robot_is_known_to_be_free_are_named_and_left_out():
    robot = Path(__file__).parents[2] / "examples" / "robots" / "ur5.urdf"
    text = f"robot = '{robot}'\n[start]\njoints = [0.3, -1.9, 2.9, -1.6, -1.6, 0]\n[collision]\nknown_free = false\n"
    text += "[[move]]\njoints = [0.5, -1.9, 1.9, -1.6, -1.6, 0]\n"
    refused = prepare(parse_job(text), text, Path())
    assert isinstance(refused, Refusal)
    assert "upper_arm hits wrist_3" in refused.explain("en")
    resting = text.replace("known_free = false", "known_free = true")
    run = solve(parse_job(resting), resting, Path())
    assert isinstance(run, Run)
    remark = next(each for each in run.plan.remarks if each.key == "job.rest_pairs")
    assert remark.level == "warning"
    assert "upper_arm - wrist_3" in remark.details["pairs"]
    assert "forearm - wrist_3" not in remark.details["pairs"], "what does not meet there is checked"
    assert remark.sentence("en") != remark.sentence("ar")
