"""A page as one self-contained HTML file: no request leaves it, no script but its own runs in it."""

from __future__ import annotations

import re
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from mafsil.messages import direction, say
from mafsil.messages.visible import visible
from mafsil.report import fragments
from mafsil.report.content import Page, Plot, Scene
from mafsil.scene import as_data, one_script, packed
from mafsil.scene.inline import attribute, embedded, policy

PAGE_SCRIPTS = ("replay.js", "plot.js", "main.js")
PICTURE_SCRIPTS = ("replay.js", "picture.js")
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
        "data": embedded(_data(page)),
    }
    return _filled("report.html", slots)


def render_picture(title: str, subtitle: str, scene: Scene, language: str) -> str:
    """A page that shows nothing but a scene, as HTML text."""
    slots = _frame(language, title, PICTURE_SCRIPTS) | {
        "header": fragments.header(title, subtitle),
        "data": embedded({"scene": _scene(scene)}),
    }
    return _filled("picture.html", slots)


def _filled(template: str, slots: dict[str, str]) -> str:
    return re.sub(r"\{\{(\w+)\}\}", lambda match: slots[match.group(1)], _asset(template))


def _frame(language: str, title: str, scripts: tuple[str, ...]) -> dict[str, str]:
    """What every page has: language, labels, style, script and the policy that allows just these two."""
    style = _asset("report.css")
    script = "\n".join([one_script("scene/renderer.js", "scene/shapes.js"), *map(_asset, scripts)])
    labels = {name: attribute(say(f"report.{name}", language=language)) for name in _LABELS}
    return labels | {
        "footer": fragments.text(say("report.footer", language=language)),
        "lang": language,
        "dir": direction(language),
        "policy": policy(style, script),
        "title": attribute(visible(title)),
        "style": style,
        "script": script,
    }


def _data(page: Page) -> dict[str, Any]:
    return {
        "duration": page.duration,
        "joints": [visible(name) for name in page.joints],
        "time": packed(page.times),
        "labels": {key: say(f"report.{key}", language=page.language) for key in ("play", "pause", "share")},
        "moves": [{"name": visible(step.name), "from": step.start, "to": step.end} for step in page.steps],
        "plots": [_plot(plot) for plot in page.plots],
        "scene": _scene(page.scene),
    }


def _plot(plot: Plot) -> dict[str, Any]:
    limits = None
    if plot.limits is not None:
        limits = [[float(bound) if np.isfinite(bound) else None for bound in row] for row in plot.limits]
    names = [visible(name) for name in plot.names]
    return {"title": plot.title, "unit": plot.unit, "values": packed(plot.values), "limits": limits, "names": names}


def _scene(scene: Scene) -> dict[str, Any]:
    return as_data(scene.bodies) | {
        "period": scene.period,
        "frames": len(scene.tips),
        "poses": packed(scene.poses),
        "tips": packed(scene.tips),
        "reference": packed(scene.references),
        "targets": [{"name": visible(name), "pose": pose.tolist()} for name, pose in scene.targets],
        "centre": scene.centre,
        "size": scene.size,
        "floor": scene.floor,
    }


@cache
def _asset(name: str) -> str:
    return resources.files("mafsil.report").joinpath("template", name).read_text(encoding="utf-8").strip()
