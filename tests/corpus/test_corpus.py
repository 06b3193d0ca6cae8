"""The corpus: its manifest is sound, and the command fetches, checks, loads, compares and counts."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

from tests.corpus import manifest
from tests.corpus.comparing import judged
from tests.corpus.fetching import checked_out, git_directory, head_of, workspace
from tests.corpus.manifest import Repository, RobotFile
from tests.corpus.running import counted, run

ARM = '<body name="arm"><joint name="j" axis="0 1 0"/><geom type="sphere" size="0.1"/>{}</body>'
MODEL = f"<mujoco><worldbody>{ARM.format('')}</worldbody></mujoco>".encode()


def test_manifest_names_commits_digests_and_licences() -> None:
    rows = list(manifest.read())
    assert len(rows) > 1400
    assert {file.format for _, file in rows} == set(manifest.FORMATS)
    assert {repository.kind for repository, _ in rows} == {"maker", "peer", "collection"}
    assert all(re.fullmatch(r"[0-9a-f]{40}", repository.commit) and repository.licence for repository, _ in rows)
    assert all(re.fullmatch(r"[0-9a-f]{64}", file.sha256) for _, file in rows)
    assert len({file.sha256 for _, file in rows}) == len(rows)


@pytest.mark.parametrize(
    ("path", "text", "form"),
    [
        ("a.xml", "<!-- x --><mujoco><worldbody/></mujoco>", "mjcf"),
        ("a.xml", "<mujoco><visual/></mujoco>", None),
        ("a.xml", "<robot><link name='a'/></robot>", "urdf"),
        ("a.urdf", "<robot/>", None),
        ("a.xacro", '<robot name="r" xmlns:xacro="u"><xacro:include/><xacro:arm/></robot>', "xacro"),
        ("a.xacro", '<robot name="r" xmlns:xacro="u"><xacro:macro><link/></xacro:macro></robot>', None),
        ("a.xacro", '<robot xmlns:xacro="u"><link/></robot>', None),
        ("a.sdf", "<sdf><model/></sdf>", "sdf"),
        ("data/random_urdfs/0.urdf", "<robot><link name='a'/></robot>", None),
    ],
)
def test_formats_are_told_by_the_root(path: str, text: str, form: str | None) -> None:
    assert manifest.format_of(path, text.encode()) == form


def mirror(folder: Path) -> Path:
    """A git directory as a mirror holds it."""
    repo = folder / "owner+name" / "repo"
    repo.mkdir(parents=True)
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b", "-C", str(repo)]
    subprocess.run([*git, "init", "-q"], check=True)
    (repo / "arm.xml").write_bytes(MODEL)
    (repo / "broken.xml").write_bytes(MODEL.replace(b"0 1 0", b"0 0 0"))
    (repo / "notes.txt").write_text("not needed")
    subprocess.run([*git, "add", "."], check=True)
    subprocess.run([*git, "commit", "-qm", "all"], check=True)
    return folder


def test_files_are_fetched_judged_and_counted(tmp_path: Path) -> None:
    place = mirror(tmp_path / "mirror")
    commit = head_of(git_directory(place / "owner+name"))
    repository = Repository("owner/name", commit, "MIT", "peer")
    folder = checked_out(repository, tmp_path / "cache", place)
    assert sorted(path.name for path in folder.glob("*.*") if path.suffix) == ["arm.xml", "broken.xml"]
    files = [
        RobotFile("arm.xml", manifest.digest(MODEL), "mjcf"),
        RobotFile("broken.xml", manifest.digest((folder / "broken.xml").read_bytes()), "mjcf"),
        RobotFile("changed.xml", "0" * 64, "mjcf"),
    ]
    figures = run([(repository, file) for file in files], {repository: folder}, tmp_path / "out")
    assert (figures["files"], figures["absent"], figures["loaded"], figures["compared"]) == (2, 1, 1, 1)
    assert (figures["bad_different"], figures["bad_crashed"], figures["bad_refused"]) == (0, 0, 0)
    assert (figures["taken_by_the_own_reader"], figures["of_those_loaded"]) == (1, 1)
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["refusals"] == {"J0404": 1}


def test_a_difference_is_counted(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_bytes(MODEL)
    verdict = judged(path, "mjcf").as_dict()
    assert verdict["error"] < 1e-12
    about = {"kind": "peer", "format": "mjcf"}
    wrong = [{**about, **verdict, "error": error} for error in (1e-6, float("nan"))]
    assert counted([*wrong, {**about, **verdict}], 0.0)["bad_different"] == 2


XACRO = """<robot name="r" xmlns:xacro="u"><xacro:arg name="l" default=""/>
<xacro:include filename="$(find other)/part.xacro"/><link name="a"/><xacro:part l="$(arg l)"/></robot>"""
PART = """<robot xmlns:xacro="u"><xacro:macro name="part" params="l"><link name="b"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j" type="continuous">
<parent link="a"/><child link="b"/><origin xyz="${l} 0 0"/><axis xyz="0 1 0"/></joint></xacro:macro></robot>"""


def two_makers(folder: Path) -> dict[Repository, Path]:
    """A robot in one repository that needs a package of another one, and both with a package of the same name."""
    places: dict[Repository, Path] = {}
    for owner, packages in (("one", ("mine", "common")), ("two", ("other", "common"))):
        repository = Repository(f"{owner}/name", "0" * 40, "MIT", "maker")
        places[repository] = folder / owner
        for package in packages:
            place = folder / owner / "deep" / f"folder_of_{package}"
            place.mkdir(parents=True)
            (place / "package.xml").write_text(f"<package><name>{package}</name></package>")
    (folder / "one/deep/folder_of_mine/arm.xacro").write_text(XACRO)
    (folder / "two/deep/folder_of_other/part.xacro").write_text(PART)
    return places


def test_workspaces_hold_the_packages_of_all_makers_and_prefer_the_own_ones(tmp_path: Path) -> None:
    places = two_makers(tmp_path)
    one, two = places
    folder = workspace(one, places, tmp_path / "cache")
    assert sorted(path.name for path in folder.iterdir()) == ["common", "mine", "other"]
    assert (folder / "common").resolve() == (places[one] / "deep/folder_of_common").resolve()
    assert (workspace(two, places, tmp_path / "cache") / "common").resolve().is_relative_to(places[two].resolve())


def test_a_robot_finds_the_packages_of_other_repositories_with_its_arguments(tmp_path: Path) -> None:
    places = two_makers(tmp_path)
    one = next(iter(places))
    folder = workspace(one, places, tmp_path / "cache")
    rows = [
        (one, RobotFile("deep/folder_of_mine/arm.xacro", manifest.digest(XACRO.encode()), "xacro", {"l": "0.5"})),
        (one, RobotFile("deep/gone.xacro", "0" * 64, "xacro")),
    ]
    figures = run(rows, places, tmp_path / "out", {one: folder})
    assert (figures["makers_robots"], figures["makers_robots_loaded"], figures["absent"]) == (1, 1, 1)
    (places[one] / rows[0][1].path).write_text("changed")
    assert run(rows, places, tmp_path / "out", {one: folder}, resume=True)["makers_robots_loaded"] == 1
    assert run(rows, places, tmp_path / "out", {one: folder})["absent"] == 2


def test_expansions_of_ros_are_compared(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    places = two_makers(tmp_path)
    path = places[next(iter(places))] / "deep/folder_of_mine/arm.xacro"
    text = PART.replace('<xacro:macro name="part" params="l">', '<link name="a"/>').replace("</xacro:macro>", "")
    path.write_text(text.replace("<robot", '<robot name="r"').replace("${l}", "${0.25 * 2}"))
    plain = path.read_text().replace("${0.25 * 2}", "0.5")
    assert judged(path, "xacro", {}, plain).equal
    assert not judged(path, "xacro", {}, plain.replace('iyy="1"', 'iyy="1.1"')).equal
    assert judged(path, "xacro").error is None


def test_arguments_name_folders_of_packages(tmp_path: Path) -> None:
    file = RobotFile("a.xacro", "0" * 64, "xacro", {"file": "$(find pkg)/a.yaml", "name": "ur"})
    assert file.arguments_in(tmp_path) == {"file": f"{(tmp_path / 'pkg').resolve()}/a.yaml", "name": "ur"}
    assert json.loads(file.line()).keys() == {"path", "sha256", "format", "arguments"}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("<robot><link name='a'/></robot>", ""),
        ("<robot xmlns='u'><link name='a'/></robot>", ""),
        ("<robot><material name='a'/></robot>", "holds no links"),
        ("<robot><link name='a'/><joint><parent link='b'/></joint></robot>", "a part: link b is elsewhere"),
        ("<robot><link", ""),
    ],
)
def test_parts_of_robots_are_told_from_robots(text: str, reason: str) -> None:
    assert manifest.missing_link(text) == reason


SDF = """<sdf version="{version}"><model name="m"><link name="a"><pose>0 0 1 0 0 0.5</pose></link>
<link name="b"><pose {relative}>0.1 0.2 1.5 0.3 0 0</pose><inertial><pose>0 0.1 0 0 0.4 0</pose><mass>2</mass><inertia>
<ixx>1</ixx><iyy>2</iyy><izz>2.5</izz></inertia></inertial></link><joint name="j" type="revolute"><parent>a</parent>
<child>b</child><pose>0 0 0.1 0 0.2 0</pose><axis><xyz {expressed}>0 1 1</xyz>{flag}</axis></joint></model></sdf>"""


@pytest.mark.parametrize(
    ("version", "relative", "expressed", "flag"),
    [
        ("1.4", "", "", ""),
        ("1.6", "", "", "<use_parent_model_frame>1</use_parent_model_frame>"),
        ("1.6", "", "", ""),
        ("1.9", "relative_to='a'", "expressed_in='__model__'", ""),
    ],
)
def test_sdf_is_compared_with_a_second_reader(
    tmp_path: Path, version: str, relative: str, expressed: str, flag: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sdf_peer = pytest.importorskip("tests.corpus.sdf_peer")
    path = tmp_path / "arm.sdf"
    path.write_text(SDF.format(version=version, relative=relative, expressed=expressed, flag=flag))
    assert judged(path, "sdf").equal
    monkeypatch.setattr(sdf_peer, "_pose", lambda element: sdf_peer.pin.SE3.Identity())
    assert judged(path, "sdf").error > 1e-3


def test_what_the_own_reader_takes_and_we_refuse_is_a_failure() -> None:
    about = {"kind": "maker", "format": "mjcf"}
    verdicts = [{**about, "peer": peer, "loaded": loaded} for peer in (True, False, None) for loaded in (True, False)]
    figures = counted(verdicts, 1.0)
    assert (figures["taken_by_the_own_reader"], figures["of_those_loaded"], figures["bad_refused"]) == (2, 1, 1)
