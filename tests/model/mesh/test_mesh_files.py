"""Mesh files: what is written is read, what lies is refused, and real files have assimp's extent."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import FileError
from mafsil.model import mesh
from mafsil.model.mesh import MeshLimits
from tests.model.urdf.real_files import FOLDER

WIDE = MeshLimits()
TRIANGLE = np.array([[[0, 0, 0], [1, 0, 0], [0, 2, 0]]], float)


def binary_stl(triangles: np.ndarray, count: int | None = None, header: bytes = b"") -> bytes:
    records = b"".join(struct.pack("<12fH", *([0.0] * 3), *t.ravel(), 0) for t in triangles)
    return header.ljust(80, b"\0") + struct.pack("<I", len(triangles) if count is None else count) + records


def ascii_stl(triangles: np.ndarray) -> bytes:
    def facet(triangle: np.ndarray) -> str:
        corners = "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle.tolist())
        return f"facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n"

    return f"solid a\n{''.join(map(facet, triangles))}endsolid a\n".encode()


def collada(vcount: str = "4", p: str = "0 1 2 3", transform: str = "") -> bytes:
    return f"""<COLLADA><asset><unit meter="0.1"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><diffuse><color>1 0.5 0 1</color></diffuse></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="s"><float_array>0 0 0 1 0 0 1 1 0 0 1 0</float_array></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist material="x"><input semantic="VERTEX" source="#v" offset="0"/><vcount>{vcount}</vcount><p>{p}</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene><node>{transform}<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="x" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes></COLLADA>""".encode()


def read(folder: Path, name: str, data: bytes, limits: MeshLimits = WIDE) -> mesh.Surface:
    path = folder / name
    path.write_bytes(data)
    return mesh.read(path, limits=limits)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-1e3, 1e3, width=32)] * 9), max_size=20))
def test_both_kinds_of_stl_hold_the_same(tmp_path_factory: pytest.TempPathFactory, numbers: list) -> None:
    triangles = np.array(numbers, float).reshape(-1, 3, 3)
    folder = tmp_path_factory.mktemp("stl")
    surfaces = [read(folder, "a.stl", data) for data in (binary_stl(triangles), ascii_stl(triangles))]
    np.testing.assert_array_equal(surfaces[0].vertices, triangles.reshape(-1, 3))
    np.testing.assert_array_equal(surfaces[0].vertices, surfaces[1].vertices)
    np.testing.assert_array_equal(surfaces[0].faces, surfaces[1].faces)
    assert all(len(s.faces) + s.dropped == len(triangles) for s in surfaces)


def test_a_binary_file_may_begin_with_solid(tmp_path: Path) -> None:
    assert len(read(tmp_path, "a.stl", binary_stl(TRIANGLE, header=b"solid lies")).faces) == 1


def test_triangles_without_area_or_with_nan_are_dropped(tmp_path: Path) -> None:
    triangles = np.concatenate([TRIANGLE, TRIANGLE * 0, np.full((1, 3, 3), np.nan), np.full((1, 3, 3), np.inf)])
    surface = read(tmp_path, "a.stl", binary_stl(triangles))
    assert (len(surface.faces), surface.dropped) == (1, 3)


def test_corners_that_are_not_finite_leave_with_their_triangles(tmp_path: Path) -> None:
    text = b"v nan 0 0\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\nf 2 3 4\nf 2 5 4\n"
    surface = read(tmp_path, "a.obj", text)
    assert (surface.vertices.min(axis=0) == 0).all()
    assert (surface.vertices.max(axis=0) == [1, 2, 3]).all()
    assert len(surface.faces) == 2
    assert surface.faces.max() == 3


def test_obj_polygons_negative_indices_and_slashes(tmp_path: Path) -> None:
    text = b"# c\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1/1 3//1 4\nf -4 -3 -2\nusemtl x\n"
    surface = read(tmp_path, "a.obj", text)
    np.testing.assert_array_equal(surface.faces, [[0, 1, 2], [0, 2, 3], [0, 1, 2]])


def test_collada_unit_transform_colour(tmp_path: Path) -> None:
    transform = "<translate>1 2 3</translate><rotate>0 0 1 90</rotate><scale>2 2 2</scale>"
    surface = read(tmp_path, "a.dae", collada(transform=transform))
    corners = surface.vertices[surface.faces]
    np.testing.assert_allclose(corners[0], np.array([[1, 2, 3], [1, 4, 3], [-1, 4, 3]]) / 10, atol=1e-15)
    np.testing.assert_array_equal(surface.colours, [[1, 0.5, 0, 1]] * 2)


def test_mirrored_surface_keeps_its_outside(tmp_path: Path) -> None:
    surface = read(tmp_path, "a.stl", binary_stl(TRIANGLE)).scale((-1.0, 1.0, 1.0))
    a, b, c = surface.vertices[surface.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0


REFUSED = {
    "count lies": ("a.stl", binary_stl(TRIANGLE, count=4_000_000_000), "mesh.count"),
    "binary cut": ("a.stl", binary_stl(TRIANGLE)[:-1], "mesh.count"),
    "header cut": ("a.stl", b"\0" * 50, "mesh.cut"),
    "ascii cut": ("a.stl", ascii_stl(TRIANGLE)[:-20], "mesh.cut"),
    "ascii word": ("a.stl", ascii_stl(TRIANGLE).replace(b"2.0", b"two"), "mesh.line"),
    "obj index": ("a.obj", b"v 0 0 0\nf 1 2 3\n", "mesh.index"),
    "obj zero": ("a.obj", b"v 0 0 0\nf 0 1 1\n", "mesh.line"),
    "obj back too far": ("a.obj", b"v 0 0 0\nf -2 1 1\n", "mesh.line"),
    "obj huge index": ("a.obj", b"f 1 2 99999999999999999999\n", "mesh.line"),
    "collada index": ("a.dae", collada(p="0 1 2 9"), "mesh.index"),
    "collada count": ("a.dae", collada(vcount="5"), "mesh.collada"),
    "collada reference": ("a.dae", collada().replace(b"#g", b"#h"), "mesh.collada"),
    "collada bomb": ("a.dae", b"<!DOCTYPE a [<!ENTITY e 'x'>]><COLLADA/>", "mesh.xml"),
    "collada strips": ("a.dae", collada().replace(b"polylist", b"tristrips"), "mesh.collada"),
    "another format": ("a.exe", b"MZ", "mesh.format"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str, tmp_path: Path) -> None:
    file, data, key = REFUSED[name]
    with pytest.raises(FileError) as caught:
        read(tmp_path, file, data)
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")
    assert file in caught.value.message("ar")


NINE = {
    "binary": ("a.stl", binary_stl(np.repeat(TRIANGLE, 9, 0))),
    "ascii": ("a.stl", ascii_stl(np.repeat(TRIANGLE, 9, 0))),
    "obj": ("a.obj", b"v 0 0 0\n" + b"f 1 1 1\n" * 9),
    "collada": ("a.dae", collada(vcount="4 " * 9, p="0 1 2 3 " * 9)),
}


@pytest.mark.parametrize("name", NINE)
def test_limits(name: str, tmp_path: Path) -> None:
    file, data = NINE[name]
    with pytest.raises(FileError, match="8"):
        read(tmp_path, file, data, MeshLimits(faces=8))
    with pytest.raises(FileError, match="50"):
        read(tmp_path, file, data, MeshLimits(bytes=50))


def test_no_regular_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.stl")
    for path in (tmp_path / "a.stl", tmp_path / "b.stl", tmp_path):
        with pytest.raises(FileError):
            mesh.read(path)


SOUND = (
    (".stl", binary_stl(TRIANGLE)),
    (".stl", ascii_stl(TRIANGLE)),
    (".dae", collada()),
    (".obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(SOUND), st.data())
def test_damaged_files_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, seed: tuple[str, bytes], data: st.DataObject
) -> None:
    suffix, text = seed
    damaged = bytearray(text)
    for _ in range(data.draw(st.integers(1, 6))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    cut = bytes(damaged[: data.draw(st.integers(len(damaged) // 2, len(damaged)))])
    try:
        surface = read(tmp_path_factory.mktemp("mesh"), f"a{suffix}", cut)
    except FileError:
        return
    assert np.isfinite(surface.vertices[surface.faces]).all()


def sample() -> list[Path]:
    known = (".stl", ".obj", ".dae")
    return [path for path in sorted(FOLDER.rglob("*")) if path.suffix.lower() in known][::20]


@pytest.mark.parametrize("path", sample(), ids=lambda path: path.name)
def test_extent_of_real_files_is_assimps(path: Path) -> None:
    coal = pytest.importorskip("coal")
    theirs = np.array(coal.MeshLoader().load(str(path), np.ones(3)).vertices())
    surface = mesh.read(path)
    ours = surface.vertices[np.unique(surface.faces)]
    size = np.abs(theirs).max()
    np.testing.assert_allclose(ours.min(axis=0), theirs.min(axis=0), rtol=0, atol=1e-6 * size)
    np.testing.assert_allclose(ours.max(axis=0), theirs.max(axis=0), rtol=0, atol=1e-6 * size)
