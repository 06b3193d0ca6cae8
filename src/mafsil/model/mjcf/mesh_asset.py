"""Meshes of MJCF: where their files lie, their points after reference frame and scale, and what they weigh."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.errors import MafsilError, ModelError
from mafsil.model.asset_path import Assets, Resolved
from mafsil.model.faults import NOT_KEPT
from mafsil.model.mesh.reader import read as read_mesh
from mafsil.model.mesh.surface import Surface, clean_surface
from mafsil.model.mjcf.mesh_mass import MeshInertia, MeshMass, hull_surface, mesh_mass
from mafsil.model.mjcf.settings import Settings, choice
from mafsil.model.placement import rotation_from_quaternion
from mafsil.model.reading import Reading
from mafsil.model.shape import Mesh
from mafsil.model.xml_tree import Element

LONGEST_INLINE = 4_000_000
"""Characters of the numbers of a mesh that stands in the file itself."""
_WORD = "mesh.not_read"


@dataclass(slots=True)
class MeshAssets:
    """The meshes of one model.

    Attributes:
        settings, assets: of the model.
        folders: where each included file lies.
        elements: by name, with their defaults filled in.
    """

    settings: Settings
    assets: Assets
    folders: list[Path]
    elements: dict[str, Element] = field(default_factory=dict[str, Element])
    _masses: dict[str, MeshMass | MafsilError] = field(default_factory=dict[str, "MeshMass | MafsilError"])

    def add(self, element: Element) -> None:
        """A mesh; its file's name is its own if it has none."""
        name = element.get("name") or PurePosixPath(element.get("file").replace("\\", "/")).stem
        self.elements[name] = element

    def shape(self, reading: Reading, name: str) -> tuple[Mesh, PoseMatrix] | None:
        """What is drawn: the file with its scale and the pose (4, 4) of its frame in the geometry's.

        None for a mesh that stands in the model itself; a pose that a scale skews is said.
        """
        element = self.elements[name]
        if not element.get("file"):
            return None
        resolved, reference = self._resolve(element)
        if resolved.fault is not None:
            reading.report(resolved.fault, element, "file", reference=reference, package=resolved.package)
        R, p, scale = self._reference(reading, element)
        if not np.array_equal(R, np.eye(3)) and len(set(scale.tolist())) > 1:
            reading.report(NOT_KEPT, element, "refquat", element="mesh", what="refquat")
            R = np.eye(3)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R.T, -scale * (R.T @ p)
        x, y, z = (float(factor) for factor in scale)
        return Mesh(reference, resolved.path, (x, y, z)), frozen(T)

    def mass(self, reading: Reading, name: str) -> MeshMass:
        """What a mesh weighs for density one, in its own frame.

        Raises:
            MafsilError: why it weighs nothing that can be known.
        """
        if name not in self._masses:
            try:
                self._masses[name] = self._weigh(reading, self.elements[name])
            except MafsilError as error:
                self._masses[name] = error
        found = self._masses[name]
        if isinstance(found, MafsilError):
            raise found
        return found

    def _weigh(self, reading: Reading, element: Element) -> MeshMass:
        known = tuple(rule.value for rule in MeshInertia)
        rule = MeshInertia(choice(reading, element, "inertia", known, MeshInertia.LEGACY.value))
        if element.get("builtin", "none") != "none" or element.first("plugin") is not None:
            raise ModelError(_WORD, what=element.get("builtin") or "plugin")
        if rule is MeshInertia.CONVEX and int(reading.number(element, "maxhullvert", -1.0) or -1) > 0:
            raise ModelError(_WORD, what="maxhullvert")
        surface = self._surface(reading, element)
        return mesh_mass(self._place(reading, element, surface), rule)

    def _surface(self, reading: Reading, element: Element) -> Surface:
        if element.get("file"):
            resolved, reference = self._resolve(element)
            if resolved.path is None:
                raise ModelError(_WORD, what=reference)
            surface = read_mesh(resolved.path)
            points = surface.vertices.astype(np.float32).astype(np.float64)  # single precision, as MuJoCo holds them
            return Surface(points, surface.faces)
        points = _inline(element, "vertex").astype(np.float32).astype(np.float64)
        if "face" not in element.attributes:
            return hull_surface(points)
        faces = _inline(element, "face").astype(np.int64)
        if faces.size and (faces.min() < 0 or faces.max() >= len(points)):
            raise ModelError(_WORD, what="face")
        return clean_surface(points, faces)

    def _place(self, reading: Reading, element: Element, surface: Surface) -> Surface:
        """The surface after its reference pose is taken off and its scale put on."""
        R, p, scale = self._reference(reading, element)
        x, y, z = (float(factor) for factor in scale)
        return Surface((surface.vertices - p) @ R, surface.faces).scale((x, y, z))

    @staticmethod
    def _reference(reading: Reading, element: Element) -> tuple[Floats, Floats, Floats]:
        """(3, 3) and (3,) the pose that is taken off a mesh, (3,) the scale that is put on then."""
        p = np.array(reading.vector(element, "refpos", 3, (0.0, 0.0, 0.0)) or (0.0, 0.0, 0.0))
        quaternion = np.array(reading.vector(element, "refquat", 4, (1.0, 0.0, 0.0, 0.0)) or (1.0, 0.0, 0.0, 0.0))
        size = float(np.linalg.norm(quaternion))
        R = rotation_from_quaternion(quaternion / size) if size > 0.0 else np.eye(3)
        return R, p, np.array(reading.vector(element, "scale", 3, (1.0, 1.0, 1.0)) or (1.0, 1.0, 1.0))

    def _resolve(self, element: Element) -> tuple[Resolved, str]:
        """The file of a mesh: in the mesh folder of the model, or beside the file that names it."""
        name = element.get("file").replace("\\", "/")
        name = PurePosixPath(name).name if self.settings.strip_path else name
        folder = self.settings.mesh_folder.rstrip("/")
        reference = f"{folder}/{name}" if folder and not name.startswith("/") else name
        first = self.assets.resolve(reference)
        if first.path is None and element.file:
            beside = self.folders[element.file - 1]
            for candidate in (beside / reference, beside / name):
                found = self.assets.resolve(str(candidate))
                if found.path is not None:
                    return found, reference
        return first, reference


def _inline(element: Element, attribute: str) -> Floats:
    """(k, 3) numbers that stand in the file itself."""
    try:
        numbers = np.array([float(word) for word in element.get(attribute)[:LONGEST_INLINE].split()])
        return numbers.reshape(-1, 3)
    except ValueError:
        raise ModelError(_WORD, what=attribute) from None
