"""`mafsil list | singular | statics | workspace | dh`: numbers against the package and formulas made by hand."""

import json
import re

import numpy as np
import pytest

from mafsil import messages
from mafsil.cli.main import main
from mafsil.cli.table import width
from mafsil.model import library, urdf
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.textbook import planar2r
from mafsil.robot import Robot, load


@pytest.fixture(autouse=True)
def _english(monkeypatch):
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.delenv("MAFSIL_LANG", raising=False)


ARABIC = re.compile(r"[\u0600-\u06ff]")
Q = ["0.3", "-0.5", "0", "0.2", "0.4", "-0.1"]


def data_of(capsys, *words: str, code: int = 0) -> dict:
    assert main([*words, "--json"]) == code, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def test_list_tells_every_robot(capsys):
    robots = data_of(capsys, "list")["robots"]
    assert [robot["name"] for robot in robots] == list(library.robots())
    for robot in robots:
        mechanism = library.load(robot["name"])
        assert (robot["n"], robot["joints"]) == (mechanism.n, list(mechanism.joint_names))
        assert robot["masses"] == any(link.inertial is not None for link in mechanism.links)
        slides = [j.name for j in mechanism.coordinates if j.kind.value == "prismatic"]
        assert robot["kinds"].count("P") == len(slides)
    assert main(["list", "--lang", "ar"]) == 0
    out = capsys.readouterr().out
    assert all(name in out for name in library.robots())
    assert len(ARABIC.findall(out)) > 300


def test_singular_tells_rank_and_cause(capsys):
    wrist = ["0.1", "-0.4", "0.3", "0.2", "0", "0.5"]
    data = data_of(capsys, "singularity", "puma560", *wrist)
    assert (data["singular"], data["rank"], data["full_rank"]) == (True, 5, 6)
    assert np.shape(data["lost_twists"]) == np.shape(data["carried_wrenches"]) == (1, 6)
    J = load("puma560").jacobian_space(np.array(wrist, float))
    assert np.abs(J @ np.array(data["null_rates"][0])).max() < 1e-9
    power = np.array(data["carried_wrenches"][0]) @ J
    assert np.abs(power).max() < 1e-9
    regular = data_of(capsys, "singularity", "puma560", *wrist[:4], "0.6", "0.5")
    assert (regular["singular"], regular["rank"], regular["causes"]) == (False, 6, [])
    assert main(["singularity", "puma560", *wrist]) == 0
    out = capsys.readouterr().out
    assert "lost:" in out
    assert "rank 5 of 6" in out
    assert data_of(capsys, "singularity", "panda", "0,0,0,-1,0,1,0", "--task", "position")["full_rank"] == 3
    assert main(["singularity", "puma560", *wrist, "--task", "poise"]) == 2


@pytest.mark.parametrize("given_in", ["body", "space", "tip"])
def test_statics_of_a_wrench(capsys, given_in):
    F = np.array([0.1, -0.2, 0.3, 4.0, 5.0, -6.0])
    robot, q = load("puma560"), np.array(Q, float)
    words = ["statics", "puma560", *Q, "--wrench", *map(str, F), "--given-in", given_in]
    data = data_of(capsys, *words)
    T = robot.forward_kinematics(q)
    R, p = T[:3, :3], T[:3, 3]
    J = robot.jacobian_space(q)
    m, f = F[:3], F[3:]
    if given_in == "body":
        m, f = R @ m, R @ f
    if given_in != "space":
        m = m + np.cross(p, f)
    np.testing.assert_allclose(data["tau"], J.T @ np.concatenate([m, f]), atol=1e-9)
    gravity = robot.gravity_torque(q)
    np.testing.assert_allclose(data["hold"], np.array(data["tau"]) + gravity, atol=1e-9)
    assert main(words) == 0
    assert "N m" in capsys.readouterr().out


def test_statics_of_efforts_and_back(capsys):
    efforts = ["1", "-2", "0.5", "0.1", "0.2", "0.05"]
    data = data_of(capsys, "statics", "puma560", *Q, "--tau", *efforts)
    back = data_of(capsys, "statics", "puma560", *Q, "--wrench", *map(repr, data["tip_wrench"]), "--given-in", "tip")
    np.testing.assert_allclose(back["tau"], np.array(efforts, float), atol=1e-9)
    # Stretched along x, a force along x needs no effort and an effort of the first joint alone moves the arm.
    assert main(["statics", "planar2r", "0", "0", "--tau", "1", "0.5"]) == 0
    assert "carried by the structure" in capsys.readouterr().out
    assert main(["statics", "planar2r", "0", "0", "--tau", "1", "0.5", "--lang", "ar"]) == 0
    assert ARABIC.search(capsys.readouterr().out)
    both = ["statics", "planar2r", "0", "0", "--tau", "1", "1", "--wrench", "0", "0", "0", "0", "0", "0"]
    assert main(both) == 2
    assert main(["statics", "planar2r", "0", "0", "--wrench", "1", "2", "--lang", "en"]) == 2
    assert "--wrench: 2 numbers were given" in capsys.readouterr().err.splitlines()[-1]


def test_workspace_of_a_planar_arm_is_its_ring(capsys, tmp_path):
    """Links of 1 m and 0.5 m reach the ring between 0.5 m and 1.5 m."""
    path, picture = tmp_path / "ring.urdf", tmp_path / "ring.png"
    path.write_text(urdf.write(planar2r((1.0, 0.5)), without=["gravity"]), encoding="utf-8")
    data = data_of(capsys, "workspace", str(path), "--seed", "1", "--picture", str(picture))
    assert (data["view"], data["unit"]) == ("xy", "m^2")
    assert abs(data["size"] - np.pi * (1.5**2 - 0.5**2)) <= data["error"] < 0.5
    for low, high in data["bounds"].values():
        assert (low, high) == (pytest.approx(-1.5, abs=data["cell"]), pytest.approx(1.5, abs=data["cell"]))
    (hole,) = data["voids"]
    np.testing.assert_allclose(hole["place"], 0, atol=2 * data["cell"])
    assert hole["size"] == pytest.approx(np.pi * 0.25, rel=0.15)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_workspace_in_space_and_its_options(capsys, tmp_path):
    words = ["workspace", "ur5", "--samples", "20000"]
    spatial, cells = data_of(capsys, *words), data_of(capsys, *words, "--cell", "100mm")
    assert (spatial["view"], spatial["samples"], cells["cell"]) == ("xyz", 20000, 0.1)
    assert data_of(capsys, *words) == spatial
    assert data_of(capsys, *words, "--seed", "3")["size"] != spatial["size"]
    assert data_of(capsys, *words, "--view", "radial")["bounds"].keys() == {"ρ", "z"}
    picture = tmp_path / "map.svg"
    assert main([*words, "--picture", str(picture), "--lang", "ar"]) == 0
    assert picture.read_bytes().startswith(b"<?xml")
    assert main([*words, "--picture", str(picture), "--view", "xyz"]) == 2
    assert main(["workspace", "ur5", "--samples", "many"]) == 2
    assert main(["workspace", "ur5", "--picture", "x.bmp"]) == 2


@pytest.mark.parametrize("name", ["puma560", "ur5e", "panda", "rrrp", "stanford_arm", "planar2r"])
def test_dh_tables_are_the_robot(capsys, name):
    robot = load(name)
    q = np.random.default_rng(4).uniform(-1, 1, (8, robot.n))
    for convention, table in data_of(capsys, "dh", name)["tables"].items():
        rows = [DHRow(**row) for row in table["rows"]]
        arm = Robot(mechanism_from_dh(rows, convention, base=np.array(table["base"]), tool=np.array(table["tool"])))
        np.testing.assert_allclose(arm.forward_kinematics(q), robot.forward_kinematics(q), atol=1e-9)


def test_dh_is_printed_in_degrees_or_radians(capsys, tmp_path):
    assert main(["dh", "ur5e", "--convention", "classic"]) == 0
    degrees = capsys.readouterr().out
    assert "alpha_i [°]" in degrees
    assert "Rot(z, theta_i) Trans(z, d_i) Trans(x, a_i) Rot(x, alpha_i)" in degrees
    # The maker's own table: a_2 = -0.425 m, a_3 = -0.3922 m, d_1 = 0.1625 m, twists 90, 0, 0, 90, -90, 0 degrees.
    rows = [line.split() for line in degrees.splitlines() if re.match(r"  [1-6]  ", line)]
    assert [abs(float(row[2])) for row in rows] == [90, 0, 0, 90, 90, 0]
    assert [abs(float(row[3])) for row in rows] == [0, 0.425, 0.3922, 0, 0, 0]
    assert main(["dh", "ur5e", "--radians", "--picture", str(tmp_path / "frames.png"), "--lang", "ar"]) == 0
    radians = capsys.readouterr().out
    assert "1.571" in radians
    assert ARABIC.search(radians)
    assert (tmp_path / "frames.png").exists()


def _lines(capsys, *words: str) -> list[str]:
    main([*words])
    return capsys.readouterr().out.splitlines()


TABLES = [
    ["list"],
    ["show", "panda"],
    ["fk", "panda", "0", "0", "0", "-1", "0", "1", "0"],
    ["ik", "ur5e", "--pose", "0.4", "-0.2", "0.5", "3", "0", "0", "--all"],
    ["dynamics", "panda", "--q", "0", "0", "0", "-1", "0", "1", "0"],
    ["singularity", "panda", "0", "0", "0", "-1", "0", "1", "0"],
    ["statics", "panda", "0", "0", "0", "-1", "0", "1", "0", "--wrench", "0", "0", "0", "0", "0", "9"],
    ["dh", "panda"],
    ["convert", "--pose", "1", "0", "0", "1", "0", "0", "-1", "2", "0", "1", "0", "3"],
]


@pytest.mark.parametrize("columns", [72, 80, 200])
@pytest.mark.parametrize("words", TABLES, ids=lambda words: words[0])
def test_tables_fit_the_terminal(capsys, monkeypatch, words, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    for language in ("en", "ar"):
        lines = _lines(capsys, *words, "--lang", language)
        wide = [line for line in lines if re.match("  +[^ ]", line) and "  " in line.strip() and width(line) > columns]
        assert not wide, wide


@pytest.mark.parametrize("words", TABLES, ids=lambda words: words[0])
def test_every_number_and_name_of_arabic_output_reads_in_order(capsys, monkeypatch, words):
    """The bidirectional algorithm itself, in terminals that set lines from the left and from the right."""
    bidi = pytest.importorskip("bidi")
    monkeypatch.setenv("COLUMNS", "80")
    lines = _lines(capsys, *words, "--lang", "ar")
    assert any(ARABIC.search(line) for line in lines)
    for line in lines:
        bare = re.sub("[\u200e\u200f\u2066-\u2069]", "", line)
        tokens = re.findall(r"[-+]?\d[\w.+-]*|[A-Za-z][\w.]*", bare)
        seen = {base: bidi.get_display(line, base_dir=base) for base in "LR"}
        for base, text in seen.items():
            for token in tokens:
                assert token in text, (base, token, bare)
        cells = [cell for cell in re.split("  +", bare.strip()) if not ARABIC.search(cell)]
        if len(cells) > 2 and len(set(cells)) == len(cells):
            left = _order(seen["L"], cells)
            right = _order(seen["R"], cells)
            assert left in (sorted(left), sorted(left, reverse=True)), bare
            assert right in (sorted(right), sorted(right, reverse=True)), bare


def _order(text: str, cells: list[str]) -> list[int]:
    """Where each cell stands; a cell that is part of another one is looked for as a whole word."""
    bare = re.sub("[\u200e\u200f\u2066-\u2069]", "", text)
    return [f" {bare} ".index(f" {cell} ") for cell in cells]
