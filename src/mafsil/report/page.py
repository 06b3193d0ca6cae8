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

PAGE_SCRIPTS = ("replay.js", "plot.js", "table.js", "language.js", "main.js")
PICTURE_SCRIPTS = ("replay.js", "picture.js")
_LABELS = (
    "replay", "no_scene", "hint", "hint_still", "play", "time", "speed", "path", "frames", "view", "numbers_title",
    "warnings_title", "moves_title", "plots_title", "plots_hint", "joints_title", "source_title", "footer",
    "save_table", "table_hint",
)  # fmt: skip


def render(page: Page, *others: Page) -> str:
    """The page as HTML text.

    Args:
        page: in the language in which it opens.
        others: the same run in other languages, to which its reader may switch.
    """
    languages = {one.language: _words(one) for one in (page, *others)} if others else {}
    slots = _frame(page.language, page.title, PAGE_SCRIPTS) | _texts(page)
    slots["data"] = embedded(_data(page) | {"languages": languages})
    slots["languages"] = "".join(map(_kept, others))
    return _filled("report.html", slots)


def _texts(page: Page) -> dict[str, str]:
    """What stands in the page's `data-slot` elements, as HTML."""
    return {
        "header": fragments.header(page.title, page.subtitle, page.verdict),
        "numbers": fragments.figures(page.figures),
        "warnings": fragments.findings(page.findings),
        "moves": fragments.steps(page.steps, page.language),
        "joints": fragments.table(page.joint_table),
        "source": fragments.details(page.details),
        "footer": fragments.text(say("report.footer", language=page.language)),
    }


def _kept(page: Page) -> str:
    """The texts of a language that is not shown, as a template."""
    texts = "".join(f'<div data-for="{name}">{html}</div>' for name, html in _texts(page).items())
    return f'<template data-language="{page.language}">{texts}</template>'


def _words(page: Page) -> dict[str, Any]:
    """What the script says in a language."""
    labels = (*_LABELS, "pause", "share", "other_language")
    return {
        "direction": direction(page.language),
        "title": visible(page.title),
        "labels": {name: say(f"report.{name}", language=page.language) for name in labels},
        "moves": [visible(step.name) for step in page.steps],
        "plots": [{"title": plot.title, "names": [visible(name) for name in plot.names]} for plot in page.plots],
    }


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
        "labels": {
            key: say(f"report.{key}", language=page.language) for key in ("play", "pause", "share", "other_language")
        },
        "moves": [{"name": visible(step.name), "from": step.start, "to": step.end} for step in page.steps],
        "plots": [_plot(plot) for plot in page.plots],
        "scene": _scene(page.scene),
    }


def _plot(plot: Plot) -> dict[str, Any]:
    limits = None
    if plot.limits is not None:
        limits = [[float(bound) if np.isfinite(bound) else None for bound in row] for row in plot.limits]
    names = [visible(name) for name in plot.names]
    drawn = {"title": plot.title, "unit": plot.unit, "values": packed(plot.values), "limits": limits, "names": names}
    return drawn | {"column": plot.column}


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
