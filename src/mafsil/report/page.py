"""A page as one self-contained HTML file: no request leaves it, no script but its own runs in it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from mafsil.messages import direction, say
from mafsil.messages.visible import visible
from mafsil.page.arm import Arm
from mafsil.page.assemble import assemble, styles
from mafsil.page.content import content, sentence
from mafsil.report import fragments
from mafsil.report.content import Page, Plot, Scene, Table
from mafsil.scene import as_data, pack_floats
from mafsil.scene.inline import attribute

MAIN = "report/template/main.js"
LABELS = (
    "numbers_title", "warnings_title", "moves_title", "plots_title", "plots_hint", "joints_title", "limits_title",
    "limits_hint", "variation_title", "variation_hint", "source_title", "save_table", "table_hint", "share",
)  # fmt: skip
"""Of a report alone; no key stands in both."""


def render(page: Page, *others: Page) -> str:
    """The page as HTML text.

    Args:
        page: in the language in which it opens.
        others: the same run in other languages, to which its reader may switch.

    Raises:
        KernelError: LLVM refuses a kernel of the robot.
    """
    texts = _texts(page) | _labels(page.language) | {"varied": "hidden" if page.variation_table is None else ""}
    slots = {
        "header": texts["header"],
        "reading": fill_slots("report.html", texts),
        "languages": "".join(hidden_language(each.language, _texts(each)) for each in others),
        "alone": "" if others else "hidden",
        "state": "recording",
        "style": _asset("report.css"),
    }
    return assemble(_data(page, others), (), MAIN, slots)


def report_style() -> str:
    """The style of reports."""
    return "\n".join((styles(), _asset("report.css")))


def _texts(page: Page) -> dict[str, str]:
    """What stands in the page's `data-slot` elements, as HTML."""
    return {
        "header": fragments.header(page.title, page.subtitle, page.verdict),
        "numbers": fragments.figures(page.figures),
        "warnings": fragments.findings(page.findings),
        "moves": fragments.steps(page.steps, page.language),
        "joints": fragments.table(page.joint_table),
        "limits": fragments.table(page.limit_table),
        "variation": fragments.findings(page.variation_findings) + _optional(page.variation_table),
        "source": fragments.details(page.details),
        "footer": fragments.text(say("report.footer", language=page.language)),
    }


def _optional(content: Table | None) -> str:
    return "" if content is None else f'<div class="wide">{fragments.table(content)}</div>'


def hidden_language(language: str, slots: Mapping[str, str]) -> str:
    """The texts of a language that is not shown, as a template.

    Args:
        language: whose they are.
        slots: HTML by the name of its place.
    """
    texts = "".join(f'<div data-for="{name}">{html}</div>' for name, html in slots.items())
    return f'<template data-language="{language}">{texts}</template>'


def _words(page: Page) -> dict[str, Any]:
    """What the script says in a language besides its sentences."""
    return {
        "title": visible(page.title),
        "moves": [visible(step.name) for step in page.steps if not step.beside],
        "flags": [visible(one.text) for one in page.findings if one.time is not None],
        "plots": [{"title": plot.title, "names": [visible(name) for name in plot.names]} for plot in page.plots],
    }


def fill_slots(template: str, slots: Mapping[str, str]) -> str:
    """A template with its places filled.

    Args:
        template: name of a file beside the style.
        slots: HTML by the name of its place.
    """
    return re.sub(r"\{\{(\w+)\}\}", lambda match: slots[match.group(1)], _asset(template))


def frame(language: str, title: str, style: str, code: str) -> dict[str, str]:
    """What every page has: language, labels, style and script.

    Args:
        language, title: of the page.
        style, code: that stand in it.
    """
    labels = _labels(language)
    return labels | {
        "lang": language,
        "dir": direction(language),
        "title": attribute(visible(title)),
        "style": style,
        "script": code,
    }


def _labels(language: str) -> dict[str, str]:
    return {name: attribute(say(f"report.{name}", language=language)) for name in LABELS} | {
        "other_language": attribute(say("page.other_language", language=language))
    }


def _data(page: Page, others: Sequence[Page]) -> dict[str, Any]:
    """What the page of the robot carries, and the run."""
    scene, every = page.scene, (page, *others)
    drawn = as_data(scene.bodies) | {"centre": scene.centre, "size": scene.size, "floor": scene.floor}
    data = content(Arm(page.robot), page.language, "run.robot", scene=drawn)
    data["robot"]["imports"] = list(page.recipe)
    data["languages"] = {one.language: data["languages"][one.language] for one in every}
    for code, language in data["languages"].items():
        language["sentences"] |= {name: sentence(code, f"report.{name}") for name in LABELS}
    return data | {
        "titles": {one.language: visible(one.title) for one in every},
        "texts": {one.language: _words(one) for one in every},
        "duration": page.duration,
        "joints": [visible(name) for name in page.joints],
        "time": pack_floats(page.times),
        "moves": [{"from": one.start, "to": one.end, "level": one.level} for one in page.steps if not one.beside],
        "flags": [{"time": one.time, "level": one.level} for one in page.findings if one.time is not None],
        "plots": [plot_data(plot) for plot in page.plots],
        "tape": tape_data(scene),
    }


def plot_data(plot: Plot) -> dict[str, Any]:
    """A plot as the script of its page reads it."""
    limits = None
    if plot.limits is not None:
        limits = [[float(bound) if np.isfinite(bound) else None for bound in row] for row in plot.limits]
    names = [visible(name) for name in plot.names]
    drawn = {
        "title": plot.title,
        "unit": plot.unit,
        "values": pack_floats(plot.values),
        "limits": limits,
        "names": names,
    }
    return drawn | {"column": plot.column, "keys": [visible(key) for key in plot.keys]}


def around_data(scene: Scene) -> dict[str, Any]:
    """What stands around the arm, as the script of a page reads it."""
    bodies = [one.body for one in scene.carried] + [body for body, _ in scene.fixed]
    return {
        "targets": [{"name": visible(name), "pose": pose.tolist()} for name, pose in scene.targets],
        "scenery": as_data(bodies),
        "carried": [{"poses": pack_floats(one.poses), "first": one.first, "end": one.end} for one in scene.carried],
        "fixed": [pose.tolist() for _, pose in scene.fixed],
    }


def tape_data(scene: Scene) -> dict[str, Any]:
    """The replay of a run with what stands around the arm, as the script of a page reads it."""
    forces = {} if scene.forces is None else {"forces": pack_floats(scene.forces)}
    return (
        around_data(scene)
        | forces
        | {
            "period": scene.period,
            "end": float(scene.times[-1]),
            "frames": len(scene.q),
            "q": pack_floats(scene.q),
            "tips": pack_floats(scene.tips),
            "reference": pack_floats(scene.references),
        }
    )


@cache
def _asset(name: str) -> str:
    return resources.files("mafsil.report").joinpath("template", name).read_text(encoding="utf-8").strip()
