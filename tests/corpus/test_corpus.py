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
from tests.corpus.fetching import checked_out, git_directory, head_of
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
    assert (figures["bad_different"], figures["bad_crashed"]) == (0, 0)
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
