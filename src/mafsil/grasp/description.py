"""Grasps as plain data: contacts one by one, with the outline of a plane body or a mesh, and a load.

[[contact]]  point = [-1, 0]  normal = [1, 0]  mu = 0.5
[load]       moment = 0.0     force = [0, -9.81]
[body]       outline = [[-1, -1], [1, -1], [1, 1], [-1, 1]]     or, in space, mesh = "part.stl"
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, as_batch, real_array
from mafsil.errors import FileError, InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.grasp.body import GraspedBody
from mafsil.grasp.contact import Contact, require_one_dimension, single
from mafsil.grasp.tolerances import ON_OUTLINE, ROUNDOFF
from mafsil.messages import say

MOST_CORNERS = 5000
_KEYS = {"name", "contact", "load", "body"}
_CONTACT_KEYS = {"point", "normal", "mu", "gamma", "curvature", "finger_curvature", "name"}


@dataclass(frozen=True, eq=False)
class Description:
    """What plain data says of a grasp.

    Attributes:
        contacts: all in the plane or all in space.
        name: for reports.
        load: (m,) external wrench (m, f) on the body, or None.
        outline: (k, 2) corners of a plane body [m], or None.
        body: of triangles, in space, or None.
    """

    contacts: tuple[Contact, ...]
    name: str
    load: Floats | None
    outline: Floats | None
    body: GraspedBody | None = None


def parse_description(data: Any, source: str, folder: Path | None = None) -> Description:
    """The contacts, load and body in plain data, checked.

    Args:
        data: as read from TOML or JSON.
        source: name for errors.
        folder: where mesh files are looked for; the working directory if None.

    Raises:
        FileError: unknown or missing keys, a mesh that cannot be read.
        InputError: contacts that make no grasp, or lie off the body.
    """
    table = _table(data)
    if table is None or not isinstance(table.get("contact"), list) or not table["contact"]:
        raise FileError("grasp.file_no_contacts", path=source)
    _known(table, _KEYS, source)
    contacts = [_contact(entry, k, source) for k, entry in enumerate(cast("list[Any]", table["contact"]))]
    body = _known(table.get("body", {}), {"outline", "mesh"}, source)
    if {"outline", "mesh"} <= body.keys():
        raise InputError("grasp.mesh_and_outline")
    outline = _outline(body["outline"]) if "outline" in body else None
    if outline is not None:
        require_one_dimension(contacts)
        _require_on(contacts, outline)
        contacts = [_on_edge(contact, outline) for contact in contacts]
    require_one_dimension(contacts)
    solid = _solid(contacts, (folder or Path()) / str(body["mesh"])) if "mesh" in body else None
    load = _load(table, contacts[0].dimension, source)
    return Description(tuple(contacts), str(table.get("name", "")), load, outline, solid)


def _outline(given: Any) -> Floats:
    """Corners of a plane body in order: it has an area, and its edges do not cross."""
    corners = as_batch("outline", given, (2,), finite=True)
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
    if abs(float(np.sum(at[:, 0] * after[:, 1] - at[:, 1] * after[:, 0]))) < ROUNDOFF:
        raise InputError("grasp.no_area")
    return corners


def _crossing(start: Floats, end: Floats) -> tuple[int, int] | None:
    """The first two edges that cross inside of both."""
    edge = end - start
    for k in range(len(start)):
        ahead = _turn(edge[k], start[k + 1 :] - start[k]) * _turn(edge[k], end[k + 1 :] - start[k])
        other = edge[k + 1 :]
        across = _turn(other, start[k] - start[k + 1 :]) * _turn(other, end[k] - start[k + 1 :])
        found = np.flatnonzero((ahead < -ROUNDOFF) & (across < -ROUNDOFF))
        if len(found):
            return k, k + 1 + int(found[0])
    return None


def _turn(a: Floats, b: Floats) -> Floats:
    """a_x b_y - a_y b_x."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _solid(contacts: list[Contact], path: Path) -> GraspedBody:
    if contacts[0].dimension != 3:
        raise InputError("grasp.needs_space", what="mesh")
    body = GraspedBody.of(path)
    body.require_on(contacts)
    return body


def _contact(entry: Any, index: int, source: str) -> Contact:
    table = _table(entry)
    if table is None or not {"point", "normal"} <= table.keys():
        raise FileError("grasp.file_contact", path=source, index=index)
    _known(table, _CONTACT_KEYS, source)
    numbers = {key: value for key, value in table.items() if key not in ("point", "normal", "name")}
    for key, value in numbers.items():
        if key in ("curvature", "finger_curvature") and isinstance(value, list):
            continue  # a tensor, which the contact checks
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError("input.numbers", name=f"contact {index}: {key}", got=type(value).__name__)
    name = str(table.get("name", say("grasp.contact_name", index=index)))
    return Contact(table["point"], table["normal"], name=name, **numbers)


def _table(data: Any) -> dict[str, Any] | None:
    return cast("dict[str, Any]", data) if isinstance(data, dict) else None


def _known(data: Any, keys: set[str], source: str) -> dict[str, Any]:
    """The table, refused with any other key."""
    table = _table(data)
    if table is None:
        raise FileError("grasp.file_table", path=source, known=", ".join(sorted(keys)))
    for key in table:
        if key not in keys:
            raise FileError("grasp.file_key", path=source, name=key, known=", ".join(sorted(keys)))
    return table


def _load(data: dict[str, Any], d: int, source: str) -> Floats | None:
    if "load" not in data:
        return None
    _known(data["load"], {"moment", "force"}, source)
    k = 2 * d - 3
    moment = data["load"].get("moment", np.zeros(k))
    if k == 1 and not real_array("load.moment", moment).ndim:
        moment = [moment]
    moment = single("load.moment", moment, (k,))
    force = single("load.force", data["load"].get("force", np.zeros(d)), (d,))
    return np.concatenate([moment, force])


def _require_on(contacts: list[Contact], outline: Floats) -> None:
    if contacts[0].dimension != 2:
        raise InputError("grasp.needs_plane", what="outline")
    size = float(np.ptp(outline, axis=0).max())
    for index, contact in enumerate(contacts):
        off = distance_to_outline(contact.point, outline)
        if off > ON_OUTLINE * size:
            raise InputError("grasp.off_surface", index=index, distance=off)


def _on_edge(contact: Contact, outline: Floats) -> Contact:
    """A contact inside a straight edge whose curvature was not given is flat."""
    size = float(np.ptp(outline, axis=0).max())
    at_corner = float(np.linalg.norm(outline - contact.point, axis=1).min()) <= ON_OUTLINE * size
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
    along = np.clip(
        np.sum((point - start) * edge, axis=1) / np.maximum(np.sum(edge**2, axis=1), LEAST_DIVISOR), 0.0, 1.0
    )
    return float(np.linalg.norm(start + along[:, None] * edge - point, axis=1).min())


def contact_data(contact: Contact) -> dict[str, Any]:
    """One contact as plain data.

    Args:
        contact: what to write.
    """
    data: dict[str, Any] = {"point": contact.point.tolist(), "normal": contact.direction.tolist()}
    for key in ("mu", "gamma"):
        if getattr(contact, key):
            data[key] = getattr(contact, key)
    if contact.curvature_given:
        data["curvature"] = np.asarray(contact.curvature).tolist()
    if contact.finger_shape is not None:
        data["finger_curvature"] = np.asarray(contact.finger_curvature).tolist()
    return data | ({"name": contact.name} if contact.name else {})
