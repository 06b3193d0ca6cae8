"""Grasps in files: TOML or JSON, contacts one by one, with the outline of a plane body and a load if wanted.

[[contact]]  point = [-1, 0]  normal = [1, 0]  mu = 0.5
[load]       moment = 0.0     force = [0, -9.81]
[body]       outline = [[-1, -1], [1, -1], [1, 1], [-1, 1]]     or, in space, mesh = "part.stl"
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import Floats, gate, real_array
from mafsil.errors import FileError, InputError
from mafsil.grasp.body import Body
from mafsil.grasp.contact import Contact, single
from mafsil.grasp.grasp import Grasp
from mafsil.messages import say
from mafsil.toml_source import parsed_toml

LARGEST_FILE = 1_000_000
ON_SURFACE = 1e-6
"""Contacts further than this share of the body's size from its outline are off it."""
MOST_CORNERS = 5000
FLAT = 1e-12
"""Areas below it, relative to the square of the outline's size, are none."""
_KEYS = {"name", "contact", "load", "body"}
_CONTACT_KEYS = {"point", "normal", "mu", "gamma", "curvature", "finger_curvature", "name"}


@dataclass(frozen=True, eq=False)
class Sketch:
    """What a file says.

    Attributes:
        grasp: the contacts.
        load: (m,) external wrench (m, f) on the body, or None.
        outline: (k, 2) corners of a plane body [m], or None.
        body: of triangles, in space, or None.
    """

    grasp: Grasp
    load: Floats | None
    outline: Floats | None
    body: Body | None = None


def read(path: Path) -> Sketch:
    """The sketch in a file.

    Args:
        path: .toml or .json.

    Raises:
        FileError: missing, unreadable, malformed, unknown or missing keys.
        InputError: contacts that make no grasp, or lie off the outline.
    """
    try:
        if path.is_file() and path.stat().st_size > LARGEST_FILE:
            raise FileError("grasp.file_too_large", path=path, limit=LARGEST_FILE)
        text = path.read_text("utf-8")
        data = json.loads(text) if path.suffix.lower() == ".json" else parsed_toml(text)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError("grasp.file_unreadable", path=path, reason=reason) from None
    except (ValueError, RecursionError) as error:
        raise FileError("grasp.file_malformed", path=path, reason=str(error)) from None
    return parse(data, source=path.name, folder=path.parent)


def parse(data: Any, source: str, folder: Path | None = None) -> Sketch:
    """The sketch in plain data.

    Args:
        data: as read from TOML or JSON.
        source: name for errors.
        folder: where mesh files are looked for; the working directory if None.
    """
    if not isinstance(data, dict) or not isinstance(data.get("contact"), list) or not data["contact"]:
        raise FileError("grasp.file_no_contacts", path=source)
    _known(data, _KEYS, source)
    contacts = [_contact(entry, k, source) for k, entry in enumerate(data["contact"])]
    body = data.get("body", {})
    _known(body, {"outline", "mesh"}, source)
    if {"outline", "mesh"} <= body.keys():
        raise InputError("grasp.mesh_and_outline")
    outline = _outline(body["outline"]) if "outline" in body else None
    if outline is not None:
        _require_on(Grasp(contacts), outline)
        contacts = [_on_edge(contact, outline) for contact in contacts]
    grasp = Grasp(contacts, str(data.get("name", "")))
    solid = _solid(grasp, (folder or Path()) / str(body["mesh"])) if "mesh" in body else None
    return Sketch(grasp, _load(data, grasp, source), outline, solid)


def _outline(given: Any) -> Floats:
    """Corners of a plane body in order: it has an area, and its edges do not cross."""
    corners = gate("outline", given, (2,), finite=True)
    if corners.ndim != 2:
        raise InputError("input.shape", name="outline", expected="(corners, 2)", got=corners.shape, hint="")
    if not 3 <= len(corners) <= MOST_CORNERS:
        key = "grasp.few_corners" if len(corners) < 3 else "grasp.many_corners"
        raise InputError(key, got=len(corners), limit=MOST_CORNERS)
    size = float(np.ptp(corners / 2, axis=0).max()) * 2
    if not (np.isfinite(size) and size > 0):
        raise InputError("grasp.no_area")
    at = corners / size - (corners / size).min(axis=0)
    after = np.roll(at, -1, axis=0)
    if crossing := _crossing(at, after):
        raise InputError("grasp.crossing_outline", first=crossing[0], second=crossing[1])
    if abs(float(np.sum(at[:, 0] * after[:, 1] - at[:, 1] * after[:, 0]))) < FLAT:
        raise InputError("grasp.no_area")
    return corners


def _crossing(start: Floats, end: Floats) -> tuple[int, int] | None:
    """The first two edges that cross inside of both."""
    edge = end - start
    for k in range(len(start)):
        ahead = _turn(edge[k], start[k + 1 :] - start[k]) * _turn(edge[k], end[k + 1 :] - start[k])
        other = edge[k + 1 :]
        across = _turn(other, start[k] - start[k + 1 :]) * _turn(other, end[k] - start[k + 1 :])
        found = np.flatnonzero((ahead < -FLAT) & (across < -FLAT))
        if len(found):
            return k, k + 1 + int(found[0])
    return None


def _turn(a: Floats, b: Floats) -> Floats:
    """a_x b_y - a_y b_x."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _solid(grasp: Grasp, path: Path) -> Body:
    if grasp.dimension != 3:
        raise InputError("grasp.needs_space", what="mesh")
    body = Body.of(path)
    body.require_on(list(grasp.contacts))
    return body


def _contact(entry: Any, index: int, source: str) -> Contact:
    if not isinstance(entry, dict) or not {"point", "normal"} <= entry.keys():
        raise FileError("grasp.file_contact", path=source, index=index)
    _known(entry, _CONTACT_KEYS, source)
    numbers = {key: value for key, value in entry.items() if key not in ("point", "normal", "name")}
    for key, value in numbers.items():
        if key in ("curvature", "finger_curvature") and isinstance(value, list):
            continue  # a tensor, which the contact checks
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError("input.numbers", name=f"contact {index}: {key}", got=type(value).__name__)
    name = str(entry.get("name", say("grasp.contact_name", index=index)))
    return Contact(entry["point"], entry["normal"], name=name, **numbers)


def _known(table: Any, keys: set[str], source: str) -> None:
    if not isinstance(table, dict):
        raise FileError("grasp.file_table", path=source, known=", ".join(sorted(keys)))
    for key in table:
        if key not in keys:
            raise FileError("grasp.file_key", path=source, name=key, known=", ".join(sorted(keys)))


def _load(data: dict[str, Any], grasp: Grasp, source: str) -> Floats | None:
    if "load" not in data:
        return None
    _known(data["load"], {"moment", "force"}, source)
    d, k = grasp.dimension, grasp.rows - grasp.dimension
    moment = data["load"].get("moment", np.zeros(k))
    if k == 1 and not real_array("load.moment", moment).ndim:
        moment = [moment]
    moment = single("load.moment", moment, (k,))
    force = single("load.force", data["load"].get("force", np.zeros(d)), (d,))
    return np.concatenate([moment, force])


def _require_on(grasp: Grasp, outline: Floats) -> None:
    if grasp.dimension != 2:
        raise InputError("grasp.needs_plane", what="outline")
    size = float(np.ptp(outline, axis=0).max())
    for index, contact in enumerate(grasp.contacts):
        off = distance_to_outline(contact.point, outline)
        if off > ON_SURFACE * size:
            raise InputError("grasp.off_surface", index=index, distance=off)


def _on_edge(contact: Contact, outline: Floats) -> Contact:
    """A contact inside a straight edge whose curvature was not given is flat."""
    size = float(np.ptp(outline, axis=0).max())
    at_corner = float(np.linalg.norm(outline - contact.point, axis=1).min()) <= ON_SURFACE * size
    if contact.curvature_given or at_corner:
        return contact
    return Contact(
        contact.point, contact.direction, contact.mu, contact.gamma, curvature=0.0,
        finger_curvature=contact.finger_curvature, name=contact.name,
    )  # fmt: skip


def distance_to_outline(point: Floats, outline: Floats) -> float:
    """Distance of a point from a closed polygon [m].

    Args:
        point: (2,) [m].
        outline: (k, 2) corners in order.
    """
    start, edge = outline, np.roll(outline, -1, axis=0) - outline
    along = np.clip(np.sum((point - start) * edge, axis=1) / np.maximum(np.sum(edge**2, axis=1), 1e-300), 0.0, 1.0)
    return float(np.linalg.norm(start + along[:, None] * edge - point, axis=1).min())
