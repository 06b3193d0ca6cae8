"""A page as one self-contained HTML file: no request leaves it, no script but its own runs in it."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from functools import cache
from importlib import resources
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.messages import direction, say
from mafsil.messages.visible import visible
from mafsil.model.mesh import Surface
from mafsil.report import fragments
from mafsil.report.content import Page, Plot, Scene, Solid

SCENE_SCRIPTS = ("matrix.js", "shapes.js", "renderer.js", "replay.js")
PAGE_SCRIPTS = (*SCENE_SCRIPTS, "plot.js", "main.js")
PICTURE_SCRIPTS = (*SCENE_SCRIPTS, "picture.js")
_LABELS = (
    "replay", "no_scene", "hint", "hint_still", "play", "time", "speed", "path", "frames", "view", "numbers_title",
    "warnings_title", "moves_title", "plots_title", "plots_hint", "joints_title", "source_title", "footer",
)  # fmt: skip


def render(page: Page) -> str:
    """The page as HTML text."""
    slots = _frame(page.language, page.title, PAGE_SCRIPTS) | {
        "header": fragments.header(page.title, page.subtitle, page.verdict),
        "numbers": fragments.figures(page.figures),
        "warnings": fragments.findings(page.findings),
        "moves": fragments.steps(page.steps, page.language),
        "joints": fragments.table(page.joint_table),
        "source": fragments.details(page.details),
        "data": _embedded(_data(page)),
    }
    return _filled("report.html", slots)


def render_picture(title: str, subtitle: str, scene: Scene, language: str) -> str:
    """A page that shows nothing but a scene, as HTML text."""
    slots = _frame(language, title, PICTURE_SCRIPTS) | {
        "header": fragments.header(title, subtitle),
        "data": _embedded({"scene": _scene(scene)}),
    }
    return _filled("picture.html", slots)


def _filled(template: str, slots: dict[str, str]) -> str:
    return re.sub(r"\{\{(\w+)\}\}", lambda match: slots[match.group(1)], _asset(template))


def _frame(language: str, title: str, scripts: tuple[str, ...]) -> dict[str, str]:
    """What every page has: language, labels, style, script and the policy that allows just these two."""
    style, script = _asset("report.css"), '"use strict";\n' + "\n".join(map(_asset, scripts))
    labels = {name: _attribute(say(f"report.{name}", language=language)) for name in _LABELS}
    return labels | {
        "footer": fragments.text(say("report.footer", language=language)),
        "lang": language,
        "dir": direction(language),
        "policy": _policy(style, script),
        "title": _attribute(visible(title)),
        "style": style,
        "script": script,
    }


def _data(page: Page) -> dict[str, Any]:
    return {
        "duration": page.duration,
        "joints": [visible(name) for name in page.joints],
        "time": _packed(page.times),
        "labels": {key: say(f"report.{key}", language=page.language) for key in ("play", "pause", "share")},
        "moves": [{"name": visible(step.name), "from": step.start, "to": step.end} for step in page.steps],
        "plots": [_plot(plot) for plot in page.plots],
        "scene": _scene(page.scene),
    }


def _plot(plot: Plot) -> dict[str, Any]:
    limits = None
    if plot.limits is not None:
        limits = [[float(bound) if np.isfinite(bound) else None for bound in row] for row in plot.limits]
    return {"title": plot.title, "unit": plot.unit, "values": _packed(plot.values), "limits": limits}


def _scene(scene: Scene) -> dict[str, Any]:
    solids = [solid for body in scene.bodies for solid in body.solids]
    surfaces = list({id(s.surface): s.surface for s in solids if s.surface is not None}.values())
    places = {id(surface): k for k, surface in enumerate(surfaces)}

    def drawn(solid: Solid) -> dict[str, Any]:
        form = {"kind": solid.kind, "size": solid.size, "pose": solid.pose, "colour": solid.colour}
        return form if solid.surface is None else form | {"surface": places[id(solid.surface)]}

    return {
        "surfaces": [_surface(surface) for surface in surfaces],
        "bodies": [{"shapes": [drawn(solid) for solid in body.solids]} for body in scene.bodies],
        "period": scene.period,
        "frames": len(scene.tips),
        "poses": _packed(scene.poses),
        "tips": _packed(scene.tips),
        "reference": _packed(scene.references),
        "targets": [{"name": visible(name), "pose": pose.tolist()} for name, pose in scene.targets],
        "centre": scene.centre,
        "size": scene.size,
        "floor": scene.floor,
    }


def _surface(surface: Surface) -> dict[str, Any]:
    """Triangles with corners rounded to 1/65535 of their box: two bytes a coordinate, two or four an index."""
    used, faces = np.unique(surface.faces, return_inverse=True)
    points = surface.vertices[used]
    low, high = points.min(axis=0), points.max(axis=0)
    step: Floats = np.maximum((high - low) / 65535, 1e-12)
    wide = len(used) > 65536
    return {
        "low": low.tolist(),
        "step": step.tolist(),
        "points": _encoded(cast("Floats", np.round((points - low) / step)).astype("<u2")),
        "faces": _encoded(faces.reshape(-1).astype("<u4" if wide else "<u2")),
        "wide": wide,
    }


def _packed(array: Floats) -> str:
    """Little-endian float32, base64."""
    return _encoded(np.ascontiguousarray(array, dtype="<f4"))


def _encoded(array: NDArray[Any]) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


def _embedded(data: dict[str, Any]) -> str:
    """JSON that can stand inside a script element: `<` and `&` never appear."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return (
        text.replace("<", "\\u003c").replace("&", "\\u0026").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    )


def _policy(style: str, script: str) -> str:
    """Content security policy: only this very style and script, nothing from anywhere."""
    allowed = f"style-src '{_digest(style)}'; script-src '{_digest(script)}'"
    return f"default-src 'none'; {allowed}; base-uri 'none'; form-action 'none'"


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


def _attribute(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


@cache
def _asset(name: str) -> str:
    return resources.files("mafsil.report").joinpath("template", name).read_text(encoding="utf-8").strip()
