"""What a robot keeps of its arm for the next checker and plan: the same answers, and never those of another arm."""

from __future__ import annotations

import gc
import os
import pickle
import threading
import time
import warnings
import weakref
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import regular_file
from mafsil.collision import Box, Checker, Obstacle, Scene, Sphere, clearance_tables
from mafsil.model.mesh import surface
from mafsil.regular_file import FileStamps

START, GOAL = np.array([1.18, -0.7, -2.29, 1.39, 0.16, -1.19]), np.array([-0.09, 2.45, 2.73, -0.89, 0.45, -1.12])
POST = [Obstacle(Box((0.06, 0.06, 0.9)), [0.45, 0.02, 0.3]), Obstacle(Sphere(0.1), [-0.4, 0.6, 0.5])]


def path_bytes(robot: object) -> bytes:
    plan = mf.plan(robot, POST, START, GOAL, radius=0.03)
    assert plan
    return plan.path.tobytes()


@pytest.mark.capability("11-39")
def test_a_second_call_answers_as_the_first_and_as_another_robot():
    robot = mf.load("ur5e")
    first = path_bytes(robot)
    assert path_bytes(robot) == first == path_bytes(mf.load("ur5e"))
    one, two = Checker(robot, POST, radius=0.03), Checker(robot, POST, radius=0.03)
    assert one.laid is two.laid
    q = one.random_configurations(50)
    alone = Checker(mf.load("ur5e"), POST, radius=0.03)
    assert (
        one.distance(q).distance.tobytes() == two.distance(q).distance.tobytes() == alone.distance(q).distance.tobytes()
    )


@pytest.mark.capability("11-39")
@pytest.mark.parametrize(
    "other",
    [
        {"radius": 0.05}, {"skip": [("base", "wrist_1")]}, {"self_collision": False}, {"samples": 300}, {"seed": 4},
        {"skip_never_colliding": True}, {"known_free": np.zeros(6)}, {"attached": [Sphere(0.2)]},
        {"attached": [Obstacle(Sphere(0.2))]},
    ],
)  # fmt: skip
def test_other_settings_are_another_arm(other):
    """Whatever the order of calls, each is what a robot that was never asked before gives."""
    robot, q = mf.load("ur5e"), np.random.default_rng(3).uniform(-3, 3, (60, 6))
    settings = {"radius": 0.03} | other
    Checker(robot, POST, radius=0.03).free(q)
    for _ in range(2):
        kept, alone = Checker(robot, POST, **settings), Checker(mf.load("ur5e"), POST, **settings)
        assert kept.skipped == alone.skipped
        assert (kept.distance(q).distance == alone.distance(q).distance).all()
        assert (kept.in_collision(q) == alone.in_collision(q)).all()


@pytest.mark.capability("11-39")
def test_another_robot_made_of_it_is_another_arm():
    robot = mf.load("ur5e")
    path_bytes(robot)
    q = np.random.default_rng(3).uniform(-3, 3, (40, 6))
    for changed in (robot.with_tool([0.0, 0.0, 0.3]), robot.with_frame("eye", [0.1, 0, 0]), robot.with_tip("forearm")):
        again = mf.Robot(pickle.loads(pickle.dumps(changed.mechanism)))
        kept, alone = (Checker(each, POST, radius=0.03) for each in (changed, again))
        assert (kept.distance(q).distance == alone.distance(q).distance).all()
    assert not pickle.loads(pickle.dumps(robot)).derived


def ball(path: Path, radius: float) -> None:
    """Eight corners of a cube as an STL file; always as many bytes."""
    corners = radius * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], "<f4")
    faces = np.zeros(6, [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    faces["v"] = corners[[(0, 1, 3), (0, 3, 2), (4, 5, 7), (4, 7, 6), (0, 1, 5), (2, 3, 7)]]
    path.write_bytes(bytes(80) + np.uint32(6).tobytes() + faces.tobytes())


MESHED = """<robot name="meshed"><link name="base"/><link name="arm"><collision><origin xyz="0.5 0 0"/>
<geometry><mesh filename="{mesh}"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"""


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("settled", [2.0, -1.0])
def test_a_mesh_file_that_is_written_anew_is_read_anew(tmp_path, monkeypatch, settled):
    """Also within one tick of the clock, with as many bytes and the time that the old one had; kept ones too."""
    monkeypatch.setattr(regular_file, "SETTLED", settled)
    mesh, urdf = tmp_path / "ball.stl", tmp_path / "meshed.urdf"
    urdf.write_text(MESHED.format(mesh=mesh))
    ball(mesh, 0.1)
    robot = mf.load(str(urdf))
    gaps, then = [], os.stat(mesh).st_mtime_ns - 10**11
    for radius in (0.1, 0.2, 0.1, 0.05):
        time.sleep(max(0.0, -0.05 * settled))
        ball(mesh, radius)
        os.utime(mesh, ns=(then, then))
        for _ in range(2):
            gaps.append(float(Checker(robot, [Obstacle(Sphere(0.1), [1.5, 0, 0])]).distance([0.0]).distance))
    np.testing.assert_allclose(gaps, np.repeat([0.8, 0.7, 0.8, 0.85], 2), atol=1e-6)
    assert bool(robot.derived) == (settled < 0.0)
    mesh.unlink()
    with pytest.raises(mf.FileError):
        Checker(robot, ())


@pytest.mark.capability("11-39")
def test_files_that_rest_are_told_from_files_that_may_change_unseen(tmp_path):
    file = tmp_path / "ball.stl"
    assert FileStamps.of(()).settled
    assert FileStamps.of([file]).settled
    file.touch()
    assert not FileStamps.of([file]).settled
    assert not FileStamps.of([file]).has_changed()
    stamps = FileStamps.of([file])
    file.unlink()
    assert stamps.has_changed()


@pytest.mark.capability("11-39")
def test_threads_that_share_a_robot_get_the_paths_that_one_gets():
    robot, found, errors = mf.load("ur5e"), list[bytes](), list[BaseException]()

    def ask():
        try:
            found.extend(path_bytes(robot) for _ in range(20))
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=ask) for _ in range(6)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert not errors
    assert set(found) == {path_bytes(mf.load("ur5e"))}


@pytest.mark.capability("11-39")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_forked_process_answers_the_same():
    robot = mf.load("ur5e")
    expected = path_bytes(robot)
    child = os.fork()
    if not child:
        os._exit(0 if path_bytes(robot) == expected else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert path_bytes(robot) == expected


@pytest.mark.capability("11-39")
def test_what_is_kept_ends_with_the_robot_and_is_bounded():
    robot = mf.load("ur5e")
    for k in range(12):
        Checker(robot, POST, radius=0.03 + 0.001 * k).free(START)
    assert len(robot.derived) == 8
    scene = Scene(POST)
    mf.plan(robot, scene, START, GOAL, radius=0.03)
    gone = weakref.ref(robot), weakref.ref(scene)
    del robot, scene
    gc.collect()
    assert [each() for each in gone] == [None, None]


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("harm", [None, 20, 200, -1])
def test_what_lies_on_disk_gives_the_same_numbers_and_nothing_damaged_does(tmp_path, monkeypatch, harm):
    """Corners of hulls and distances in cells: read by the next process, computed again where a bit is wrong."""
    rng, urdf = np.random.default_rng(1), tmp_path / "arm.urdf"
    links, joints = "", ""
    for k in range(5):
        corners = rng.normal(size=(60, 3)) * 0.06 + [0.1, 0.0, 0.0]
        vertices = "".join("v {} {} {}\n".format(*row) for row in corners)
        (tmp_path / f"{k}.obj").write_text(vertices + "".join(f"f {i} {i + 1} {i + 2}\n" for i in range(1, 59)))
        shape = f'<collision><geometry><mesh filename="{tmp_path}/{k}.obj"/></geometry></collision>'
        links += f'<link name="l{k}">{shape}</link>'
        joints += f"""<joint name="j{k}" type="revolute"><origin xyz="0.22 0 0"/><parent link="l{k - 1}"/>
<child link="l{k}"/><axis xyz="0 {k % 2} {1 - k % 2}"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>"""
    urdf.write_text(f'<robot name="r"><link name="l-1"/>{links}{joints}</robot>')
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "store"))

    def ask() -> bytes:
        surface._CORNERS.clear()
        laid = Checker(mf.load(str(urdf)), POST).laid
        return laid.arm.pieces.vertices.tobytes() + laid.clearances.values.tobytes() + laid.clearances.table.tobytes()

    first, files = ask(), sorted((tmp_path / "store").glob("*.arrays"))
    assert len(files) > 5
    if harm is None:
        monkeypatch.setattr(surface, "_corners_of", None)
        monkeypatch.setattr(clearance_tables, "lower_clearances", None)
        assert ask() == first
        return
    for file in files:
        data = bytearray(file.read_bytes())
        data[harm] ^= 1
        file.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert ask() == first
    assert ask() == first


@pytest.mark.capability("11-39")
def test_a_robot_by_name_is_one_robot():
    """What was laid out and compiled for it stays; with dimensions of its own it is another one."""
    assert mf.load("ur5e").mechanism is mf.load("UR5e").mechanism
    assert mf.load("planar2r", lengths=(0.4, 0.3)).mechanism is not mf.load("planar2r").mechanism
    laid = Checker("ur5e", POST, radius=0.03).laid
    assert Checker("ur5e", radius=0.03).laid is laid
