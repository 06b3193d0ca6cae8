"""Pages that hold all they need: data that can stand in markup, and the policy that lets nothing else in.

The part of something endless that is drawn: of a plane or a line what lies beside that which happens on it.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from typing import Any

from mafsil.arrays import Floats, PoseMatrix


def embed_json(data: Mapping[str, Any]) -> str:
    """JSON that can stand inside a script element: `<` and `&` never appear."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return (
        text.replace("<", "\\u003c").replace("&", "\\u0026").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    )


def policy(style: str, script: str, *, computes: bool = False, connects: bool = False) -> str:
    """Content security policy: only this very style and script, nothing from anywhere.

    Args:
        style, script: the texts that stand in the page.
        computes: the script compiles WebAssembly that it carries.
        connects: the script may speak with the server that the page came from.
    """
    compiling = " 'wasm-unsafe-eval'" if computes else ""
    allowed = f"style-src '{_digest(style)}'; script-src '{_digest(script)}'{compiling}"
    allowed += "; connect-src 'self'" if connects else ""
    return f"default-src 'none'; {allowed}; base-uri 'none'; form-action 'none'"


def attribute(text: str) -> str:
    """Text that can stand between the quotation marks of an attribute, or in an element."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


def patch(T: PoseMatrix, seen: Floats, least: float) -> tuple[Floats, Floats]:
    """Middle and edges (2,) of a rectangle in the x-y plane of a frame, around the feet of points on the plane.

    A plane has no middle: its support point may lie anywhere, far from everything that touches it.

    Args:
        T: (4, 4) pose of a frame on the plane, z out of it.
        seen: (k, 3) points where T is a pose, k > 0: contacts, or where a tip went.
        least: edge of the patch of a single point; half of it is left beside the outermost feet.
    """
    return _around(T, seen, slice(0, 2), least)


def stretch(T: PoseMatrix, seen: Floats, least: float) -> tuple[float, float]:
    """Middle and length of a piece of the z axis of a frame, around the feet of points on it; arguments as `patch`."""
    middle, length = _around(T, seen, slice(2, 3), least)
    return float(middle[0]), float(length[0])


def near_side(T: PoseMatrix, seen: Floats, within: float) -> Floats:
    """Those of points (k, 3) that are on or under the x-y plane of a frame, or about as near as any comes to it.

    Args:
        T: (4, 4) pose of the frame, z towards where the points come from.
        seen: (k, 3) points, k > 0.
        within: distance beyond the nearest that still counts.
    """
    heights = (seen - T[:3, 3]) @ T[:3, 2]
    return seen[heights <= max(float(heights.min()), 0.0) + within]


def _around(T: PoseMatrix, seen: Floats, axes: slice, least: float) -> tuple[Floats, Floats]:
    feet = ((seen - T[:3, 3]) @ T[:3, :3])[:, axes]
    low, high = feet.min(axis=0), feet.max(axis=0)
    return (low + high) / 2.0, high - low + least
