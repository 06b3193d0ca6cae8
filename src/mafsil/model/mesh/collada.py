"""Meshes in Collada (.dae) and STL files, binary and ASCII: triangles, with their plain colours where a file has some.

Of a Collada scene all geometry instances are read. The unit of the file is applied; its up axis is not, as usual for
meshes of robot files.
"""

from __future__ import annotations

import io
from array import array
from dataclasses import dataclass
from math import radians

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.errors import FileError
from mafsil.model.mesh.surface import Faces, MeshLimits, Surface, clean_surface
from mafsil.model.placement import screw_motion
from mafsil.model.source import load
from mafsil.model.xml_tree import Element, ReadLimits, Refusal, parse

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
MOST_INSTANCES = 10_000
_GREY = (0.6, 0.6, 0.6, 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class _Part:
    """Triangles of one primitive of a geometry: corners (f, 3, 3) and the symbol of their material."""

    corners: Floats
    symbol: str


def read_collada(data: bytes, limits: MeshLimits) -> Surface:
    """The triangles of a Collada file."""
    xml = ReadLimits(bytes=limits.bytes, depth=256, elements=500_000)
    try:
        root = parse(load(data, xml).data, xml).root
    except Refusal as refusal:
        raise FileError("mesh.xml", reason=refusal.diagnostic.fault.code, line=refusal.diagnostic.line) from None
    try:
        return _Scene(root, limits).surface()
    except FileError:
        raise
    except (ValueError, IndexError, KeyError, OverflowError, StopIteration):
        raise FileError("mesh.collada") from None


class _Scene:
    """One Collada document, indexed by the ids of its elements."""

    def __init__(self, root: Element, limits: MeshLimits) -> None:
        self.limits = limits
        self.ids = {e.get("id"): e for e in root.walk() if e.get("id")}
        self.root = root
        self.parts: dict[str, list[_Part]] = {}
        self.corners: list[Floats] = []
        self.colours: list[Floats] = []
        self.faces = 0
        self.instances = 0

    def surface(self) -> Surface:
        """All triangles in one array."""
        unit = next((e for e in self.root.walk() if e.tag == "unit"), None)
        metre = float(unit.get("meter", "1")) if unit is not None else 1.0
        scale = np.diag([metre, metre, metre, 1.0])
        scenes = [scene for library in self.root.all("library_visual_scenes") for scene in library.children]
        for scene in scenes[:1]:
            for node in scene.all("node"):
                self._add_node(node, scale, 0)
        if not self.corners:
            return Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
        corners = np.concatenate(self.corners)
        faces: Faces = np.arange(3 * len(corners)).reshape(-1, 3)
        return clean_surface(corners.reshape(-1, 3), faces, np.concatenate(self.colours))

    def _add_node(self, node: Element, T_above: PoseMatrix, depth: int) -> None:
        """The triangles of a node and of all below it.

        1. Count the node: a document may refer to itself, or name one node many times.
        2. Its transformation follows those above it.
        3. Inner nodes and nodes referred to are walked likewise; instances of geometry give triangles.
        """
        # 1.
        self.instances += 1
        if self.instances > MOST_INSTANCES or depth > 64:
            raise FileError("mesh.collada")
        # 2.
        T = T_above @ _transform(node)
        # 3.
        for child in node.children:
            if child.tag == "node":
                self._add_node(child, T, depth + 1)
            elif child.tag == "instance_node":
                self._add_node(self._refer(child.get("url")), T, depth + 1)
            elif child.tag == "instance_geometry":
                self._add_instance(child, T)

    def _add_instance(self, instance: Element, T: PoseMatrix) -> None:
        url = instance.get("url")
        if url not in self.parts:
            self.parts[url] = self._parts_of(self._refer(url))
        materials = {e.get("symbol"): e.get("target") for e in instance.walk() if e.tag == "instance_material"}
        for part in self.parts[url]:
            self.faces += len(part.corners)
            if self.faces > self.limits.faces:
                raise FileError("mesh.too_many_faces", limit=self.limits.faces)
            self.corners.append(part.corners @ T[:3, :3].T + T[:3, 3])
            colour = self._colour(materials.get(part.symbol, ""))
            self.colours.append(np.tile(colour, (len(part.corners), 1)))

    def _parts_of(self, geometry: Element) -> list[_Part]:
        mesh = geometry.first("mesh")
        if mesh is None:
            return []
        kinds = ("triangles", "polylist", "polygons", "trifans", "tristrips")
        return [self._part(e) for e in mesh.children if e.tag in kinds and e.first("p") is not None]

    def _part(self, primitive: Element) -> _Part:
        if primitive.tag in ("trifans", "tristrips"):
            raise FileError("mesh.collada")
        inputs = primitive.all("input")
        stride = 1 + max(int(e.get("offset", "0")) for e in inputs)
        vertex = next(e for e in inputs if e.get("semantic") == "VERTEX")
        points = self._points(self._refer(vertex.get("source")))
        polygons = self._polygons(primitive, stride, int(vertex.get("offset", "0")))
        if polygons.size and (polygons.max() >= len(points) or polygons.min() < 0):
            raise FileError("mesh.index", index=int(polygons.max()), found=len(points))
        return _Part(points[polygons], primitive.get("material"))

    def _polygons(self, primitive: Element, stride: int, offset: int) -> Faces:
        """(f, 3) indices of points; polygons as fans."""
        lists = [_integers(e.text).reshape(-1, stride)[:, offset] for e in primitive.all("p")]
        if primitive.tag == "triangles":
            return np.concatenate(lists).reshape(-1, 3)
        if primitive.tag == "polygons":
            indices, counts = np.concatenate(lists), np.array([len(one) for one in lists])
        else:
            holder = primitive.first("vcount")
            indices, counts = lists[0], _integers("" if holder is None else holder.text)
        if counts.sum() != len(indices) or (counts.size and counts.min() < 3):
            raise FileError("mesh.collada")
        starts = np.cumsum(counts) - counts
        fans = counts - 2
        first = np.repeat(starts, fans)
        step: Faces = np.arange(int(fans.sum())) - np.repeat(np.cumsum(fans) - fans, fans)
        return np.stack([indices[first], indices[first + step + 1], indices[first + step + 2]], axis=1)

    def _points(self, holder: Element) -> Floats:
        """(v, 3) points of a `vertices` element or of a source."""
        if holder.tag == "vertices":
            position = next(e for e in holder.all("input") if e.get("semantic") == "POSITION")
            holder = self._refer(position.get("source"))
        numbers = holder.first("float_array")
        accessor = next((e for e in holder.walk() if e.tag == "accessor"), None)
        if numbers is None:
            raise FileError("mesh.collada")
        stride = int(accessor.get("stride", "3")) if accessor is not None else 3
        if stride < 3:
            raise FileError("mesh.collada")
        return np.array(numbers.text.split(), np.float64).reshape(-1, stride)[:, :3]

    def _colour(self, target: str) -> tuple[float, ...]:
        """The diffuse colour of a material; grey for a texture or none."""
        material = self.ids.get(target.removeprefix("#"))
        instance = None if material is None else material.first("instance_effect")
        effect = None if instance is None else self.ids.get(instance.get("url").removeprefix("#"))
        diffuse = None if effect is None else next((e for e in effect.walk() if e.tag == "diffuse"), None)
        colour = None if diffuse is None else diffuse.first("color")
        numbers = [] if colour is None else [min(max(float(word), 0.0), 1.0) for word in colour.text.split()]
        return tuple(numbers) if len(numbers) == 4 else _GREY

    def _refer(self, url: str) -> Element:
        return self.ids[url.removeprefix("#")]


def _integers(text: str) -> Faces:
    return np.array(text.split(), np.int64)


def _transform(node: Element) -> PoseMatrix:
    """The product of a node's transformations, first outermost."""
    T = np.eye(4)
    for child in node.children:
        if child.tag not in ("matrix", "translate", "rotate", "scale"):
            continue
        numbers = np.array(child.text.split(), np.float64)
        step = np.eye(4)
        match child.tag:
            case "matrix":
                step = numbers.reshape(4, 4)
            case "translate":
                step[:3, 3] = numbers
            case "scale":
                step[:3, :3] = np.diag(numbers)
            case _:
                axis = numbers[:3] / np.linalg.norm(numbers[:3])
                step = screw_motion(np.concatenate([axis, np.zeros(3)]), radians(numbers[3]))
        T = T @ step
    return T


def read_stl(data: bytes, limits: MeshLimits) -> Surface:
    """The triangles of an STL file; it is ASCII if it begins with `solid` and its length does not fit its count."""
    count = int.from_bytes(data[80:84], "little")
    fits = len(data) >= _HEADER + count * _RECORD.itemsize
    if data[:80].lstrip()[:5].lower() == b"solid" and not (fits and _is_exact(data, count)):
        return _read_ascii(data, limits)
    if len(data) < _HEADER:
        raise FileError("mesh.cut")
    if not fits:
        raise FileError("mesh.count", declared=count, found=(len(data) - _HEADER) // _RECORD.itemsize)
    if count > limits.faces:
        raise FileError("mesh.too_many_faces", limit=limits.faces)
    records = np.frombuffer(data, _RECORD, count, _HEADER)
    vertices = records["corners"].reshape(-1, 3).astype(np.float64)
    return clean_surface(vertices, np.arange(3 * count).reshape(-1, 3))


def _is_exact(data: bytes, count: int) -> bool:
    return len(data) == _HEADER + count * _RECORD.itemsize


def _read_ascii(data: bytes, limits: MeshLimits) -> Surface:
    """Corners line by line, so that memory stays near the size of the numbers."""
    numbers = array("d")
    ended = False
    for number, line in enumerate(io.BytesIO(data), 1):
        words = line.split(None, 4)
        if not words:
            continue
        keyword = words[0].lower()
        if keyword == b"vertex":
            try:
                numbers.extend((float(words[1]), float(words[2]), float(words[3])))
            except (IndexError, ValueError):
                raise FileError("mesh.line", line=number) from None
            if len(numbers) > 9 * limits.faces:
                raise FileError("mesh.too_many_faces", limit=limits.faces)
        ended |= keyword == b"endsolid"
    if not ended or len(numbers) % 9:
        raise FileError("mesh.cut")
    vertices = np.frombuffer(numbers, np.float64).reshape(-1, 3) if numbers else np.zeros((0, 3))
    return clean_surface(vertices, np.arange(len(vertices)).reshape(-1, 3))
