"""Meshes of MJCF: where their files lie, their points after reference frame and scale, and what they weigh.

MuJoCo has four rules for the mass of a mesh; from its second moments follow the box and the frame that it is fitted by.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path, PurePosixPath

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.errors import MafsilError, ModelError
from mafsil.model.asset_path import Assets, Resolved
from mafsil.model.faults import NOT_KEPT
from mafsil.model.link import Mesh
from mafsil.model.mesh.reader import read as read_mesh
from mafsil.model.mesh.surface import Faces, Surface, clean_surface
from mafsil.model.mjcf.settings import Settings, choice
from mafsil.model.placement import rotation_from_quaternion
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element

SMALLEST = 1e-15
"""Volume [m^3] or area [m^2] from which a mesh counts, as in MuJoCo."""
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


class MeshInertia(Enum):
    """How a surface of triangles stands for matter."""

    CONVEX = "convex"
    EXACT = "exact"
    LEGACY = "legacy"
    SHELL = "shell"


@dataclass(frozen=True, eq=False, slots=True)
class MeshMass:
    """Mass properties of a mesh of unit density, per volume or, for a shell, per area.

    Attributes:
        volume: [m^3], or area [m^2] of a shell.
        com: (3,) centre of mass [m].
        inertia: (3, 3) about it, of density one.
        vertices: (k, 3) points, for the box that encloses them.
    """

    volume: float
    com: Floats
    inertia: Floats
    vertices: Floats

    @property
    def frame(self) -> PoseMatrix:
        """(4, 4) centre of mass and principal axes, the largest moment first."""
        T = np.eye(4)
        _, axes = np.linalg.eigh(self.inertia)
        axes = axes[:, ::-1]
        T[:3, :3] = axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
        T[:3, 3] = self.com
        return frozen(T)

    @property
    def box(self) -> Floats:
        """(3,) half lengths of the box with the same inertia, along the principal axes."""
        moments = np.linalg.eigvalsh(self.inertia)[::-1]
        return np.sqrt(np.maximum(6 * (moments.sum() - 2 * moments) / self.volume, 0.0)) / 2

    def bounds(self) -> tuple[Floats, Floats]:
        """(3,) middle and half lengths, along the principal axes, of the box that encloses the points."""
        T = self.frame
        inside = (self.vertices - T[:3, 3]) @ T[:3, :3]
        low, high = inside.min(axis=0), inside.max(axis=0)
        return (low + high) / 2, (high - low) / 2


def mesh_mass(surface: Surface, rule: MeshInertia) -> MeshMass:
    """Mass properties of a surface for density one.

    1. The middle of the faces is the tip of a pyramid over every face; by the rule a pyramid counts with its sign, as
       if it were positive, or its face alone counts.
    2. The pyramids give volume and centre of mass; about that centre new pyramids give the second moments. By the rule
       `legacy` that is another volume, and the second one counts.

    Args:
        surface: triangles in the frame of the mesh.
        rule: `exact` wants a closed surface; `convex` takes the hull.

    Raises:
        ModelError: no area or volume, inside out, faces that contradict each other.
    """
    faces = _hull(surface.vertices) if rule is MeshInertia.CONVEX else surface.faces
    if rule is MeshInertia.EXACT:
        _require_consistent(surface)
    points = surface.vertices
    corners = points[surface.faces]
    areas, middles, _ = _faces(corners)
    if areas.sum() < SMALLEST:
        raise ModelError("mesh.no_area", area=float(areas.sum()))
    centre = areas @ middles / areas.sum()
    weights, tops = _pyramids(points[faces] - centre, rule)
    volume = float(weights.sum())
    if volume < SMALLEST:
        raise ModelError("mesh.no_volume", volume=volume)
    com = centre + weights @ tops * (3 / 4) / volume
    about = points[faces] - com
    weights, _ = _pyramids(about, rule)
    second = _second_moments(about, weights, 12 if rule is MeshInertia.SHELL else 20)
    inertia = np.trace(second) * np.eye(3) - second
    return MeshMass(float(weights.sum()), frozen(com), frozen((inertia + inertia.T) / 2), points)


def _faces(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """(f,) areas, (f, 3) middles, (f, 3) normals of twice the area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(normals, axis=1) / 2, corners.mean(axis=1), normals


def _pyramids(corners: Floats, rule: MeshInertia) -> tuple[Floats, Floats]:
    """(f,) what each pyramid over a face from the origin counts, and the middle of its face."""
    areas, middles, normals = _faces(corners)
    if rule is MeshInertia.SHELL:
        return areas, middles
    volumes = np.einsum("fi,fi->f", middles, normals) / 6
    return np.abs(volumes) if rule is MeshInertia.LEGACY else volumes, middles


def _second_moments(corners: Floats, weights: Floats, divisor: int) -> Floats:
    """(3, 3) integral of r r' over pyramids from the origin, or over their faces."""
    total = corners.sum(axis=1)
    products = np.einsum("fki,fkj,f->ij", corners, corners, weights) + np.einsum("fi,fj,f->ij", total, total, weights)
    return products / divisor


def _hull(points: Floats) -> Faces:
    """(f, 3) triangles of the convex hull, seen from outside counter-clockwise."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points, qhull_options="Qt")
    except (QhullError, ValueError):
        raise ModelError("mesh.no_volume", volume=0.0) from None
    faces = hull.simplices.astype(np.int64)
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("fi,fi->f", normals, hull.equations[:, :3]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return faces


def hull_surface(points: Floats) -> Surface:
    """The convex hull of points as a surface: a mesh without faces."""
    return Surface(points, _hull(points))


def _require_consistent(surface: Surface) -> None:
    """No edge is run through twice in one direction."""
    _, same = np.unique(surface.vertices, axis=0, return_inverse=True)
    corners = same.ravel()[surface.faces]
    ways = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    count = len(np.unique(ways, axis=0))
    if count < len(ways):
        raise ModelError("mesh.orientation", edges=len(ways) - count)
