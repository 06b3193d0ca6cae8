"""Where a robot file comes from: paths that are no files, sizes, encodings; and where its meshes may lie."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from mafsil.errors import FileError
from mafsil.model import Mesh, urdf
from mafsil.model.asset_path import Assets
from mafsil.model.faults import (
    FILE_NOT_FOUND,
    PACKAGE_NOT_FOUND,
    PATH_ESCAPES,
    PATH_NOT_ALLOWED,
    UNKNOWN_SCHEME,
)
from mafsil.model.xml_tree import ReadLimits
from tests.model.urdf.hostile_files import sound


def test_missing_and_special_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.urdf")
    names = {"none.urdf": "F0101", "pipe.urdf": "F0102", ".": "F0102", "a\0b": "F0102"}
    for name, code in names.items():
        with pytest.raises(FileError, match=code):
            urdf.read(str(tmp_path / name))
        with pytest.raises(FileError):
            urdf.repair(tmp_path / name)
    assert urdf.diagnose("/dev/zero").codes == ("F0102",)


def test_limits_are_the_callers() -> None:
    assert urdf.diagnose(sound(), limits=ReadLimits(bytes=100)).codes == ("F0103",)
    assert urdf.diagnose(sound(), limits=ReadLimits(links=1)).codes == ("F0121",)
    assert urdf.diagnose(sound(), limits=ReadLimits(depth=2)).codes == ("F0122",)


def test_text_path_and_bytes_are_the_same(tmp_path: Path) -> None:
    path = tmp_path / "روبوت ١.urdf"
    path.write_bytes(sound())
    read = [urdf.read(source) for source in (path, str(path), sound(), sound().decode(), "\n " + sound().decode())]
    assert {m.joint_names for m in read} == {("j",)}
    assert read[0].provenance.source == str(path)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "windows-1256", "utf-8-sig"])
def test_encodings_keep_arabic_names(encoding: str) -> None:
    declared = encoding if encoding == "windows-1256" else "UTF-8"
    text = f'<?xml version="1.0" encoding="{declared}"?>\n' + sound().decode().replace('"b"', '"ذراع"')
    assert "ذراع" in urdf.read(text.encode(encoding)).link_names


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """arm/{package.xml, urdf/, meshes/a.stl} and secret.stl outside."""
    for folder in ("arm/urdf", "arm/meshes"):
        (tmp_path / folder).mkdir(parents=True)
    for name in ("arm/package.xml", "arm/meshes/a.stl", "arm/meshes/B.STL", "secret.stl"):
        (tmp_path / name).write_text("x")
    (tmp_path / "arm/meshes/link.stl").symlink_to(tmp_path / "secret.stl")
    return tmp_path / "arm"


def test_where_meshes_are_found(package: Path) -> None:
    mesh = package / "meshes" / "a.stl"
    assets = Assets.of(package / "urdf")
    references = (
        "package://arm/meshes/a.stl",
        "model://arm/meshes/a.stl",
        "../meshes/a.stl",
        f"file://{mesh}",
        str(mesh),
    )
    for reference in references:
        assert assets.resolve(reference).path == mesh, reference
    elsewhere = Assets.of(None, [package.parent])
    assert elsewhere.resolve("package://arm/meshes/a.stl").path == mesh
    assert Assets.of(None, [package]).resolve("package://arm/meshes/a.stl").path == mesh


def test_the_environment_names_packages(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MAFSIL_PACKAGE_PATH", f"/nowhere{os.pathsep}{package.parent}")
    assert Assets.of(None).resolve("package://arm/meshes/a.stl").path == package / "meshes" / "a.stl"


def test_where_meshes_are_not_looked_for(package: Path) -> None:
    assets = Assets.of(package / "urdf")
    expected = {
        "package://arm/../secret.stl": PATH_ESCAPES,
        "package://../secret.stl": PATH_ESCAPES,
        "package://..\\secret.stl": PATH_ESCAPES,
        "package://arm/meshes/link.stl": PATH_ESCAPES,
        "../../secret.stl": PATH_NOT_ALLOWED,
        f"file://{package.parent}/secret.stl": PATH_NOT_ALLOWED,
        f"{package.parent}/secret.stl": PATH_NOT_ALLOWED,
        "file:///etc/passwd": PATH_NOT_ALLOWED,
        "file:///%2e%2e/etc/passwd": PATH_NOT_ALLOWED,
        "package://other/a.stl": PACKAGE_NOT_FOUND,
        "package://arm/meshes": FILE_NOT_FOUND,
        "package://arm/meshes/none.stl": FILE_NOT_FOUND,
        "a" * 5000: FILE_NOT_FOUND,
        "https://example.org/a.stl": UNKNOWN_SCHEME,
    }
    for reference, fault in expected.items():
        resolved = assets.resolve(reference)
        assert (resolved.path, resolved.fault) == (None, fault), reference


def test_a_file_that_differs_by_case_is_offered(package: Path) -> None:
    shape = '<visual><geometry><mesh filename="../meshes/b.stl"/></geometry></visual>'
    path = package / "urdf" / "arm.urdf"
    path.write_bytes(sound().replace(b'<link name="b">\n', f'<link name="b">\n{shape}'.encode()))
    assert "G0613" in urdf.diagnose(path).codes
    text, _ = urdf.repair(path)
    path.write_text(text)
    (visual,) = urdf.read(path).link("b").visuals
    assert isinstance(visual.geometry, Mesh)
    assert visual.geometry.path == package / "meshes" / "B.STL"
