"""The page as one HTML file: no request leaves it, no script but its own runs in it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

from mafsil.messages import direction
from mafsil.scene import one_script
from mafsil.scene.inline import attribute, embed_json, policy
from mafsil.scene.modules import read

MAIN, SERVED = "page/main.js", "studio/main.js"
_BLANK = re.compile(r" ?(\{) ?|;? ?(\}) ?|(?<=[;:,]) |^ +|^/\*.*\*/\n", re.M)
"""What a style does not need: blanks beside braces and behind marks, the last semicolon of a rule, comments."""
_BOTH = re.compile(r"--([\w-]+): light-dark\((#\w+), (#\w+)\)")
_ROBOT = {"reading": "", "languages": "", "state": "robot", "alone": "", "style": ""}
_NEEDS, _NAME = re.compile(r"^ *needs: \[([^\]]*)\],$", re.M), re.compile(r"[\"'](\w+)[\"']")


def assemble(
    content: Mapping[str, Any], views: Sequence[str] = (), main: str = MAIN, slots: Mapping[str, str] = _ROBOT
) -> str:
    """The page as HTML text.

    Args:
        content: its data, see `mafsil.page.content`.
        views: absolute paths of modules with more views.
        main: the module that opens it; the studio's speaks with the server that the page came from.
        slots: HTML of what differs between a robot and a recording: `header`, `reading` below the application,
            `languages` that wait, `state` as class of the page, `alone` where there is one language, and `style`.

    Raises:
        FileError: a module that cannot be read.
        KernelError: a module with statements that are not understood.
    """
    whole = "\n".join((styles(), slots["style"])).strip()
    style, code = (
        _BLANK.sub(lambda match: match.group(1) or match.group(2) or "", whole),
        script(*views, main),
    )
    title = attribute(content.get("titles", {}).get(content["language"], content["robot"]["name"]))
    filled = (
        {"header": f"<h1><bdi>{title}</bdi></h1>"}
        | dict(slots)
        | {
            "lang": content["language"],
            "dir": direction(content["language"]),
            "title": title,
            "policy": policy(style, code, computes=True, connects=main == SERVED),
            "style": style,
            "script": code,
            "data": embed_json(content),
        }
    )
    return re.sub(r"\{\{(\w+)\}\}", lambda match: filled[match.group(1)], read("page/page.html"))


def styles() -> str:
    """The style of the application; that of its cards stays inside the element that holds them."""
    page, stage, cards = (read(f"page/{name}.css").strip() for name in ("page", "stage", "cards"))
    return f"{_for_older_browsers(page)}\n{stage}\n#views {{\n{cards}\n}}"


def _for_older_browsers(style: str) -> str:
    """A style whose variables have light values, and dark ones where dark is wished: `light-dark()` is of 2024."""
    dark = "".join(f"--{name}: {value}; " for name, _, value in _BOTH.findall(style))
    light = _BOTH.sub(lambda found: f"--{found[1]}: {found[2]}", style)
    asked = f"@media (prefers-color-scheme: dark) {{ :root:not([data-theme=light]) {{ {dark}}} }}"
    return f"{light}\n@media screen {{ {asked}\n:root[data-theme=dark] {{ {dark}}} }}"


def script(*modules: str) -> str:
    """The page's own views and these modules as one script that leaves no names behind.

    Args:
        modules: paths inside the package, or absolute; the last one opens the page.

    Raises:
        FileError: a module that cannot be read.
        KernelError: a module with statements that are not understood.
    """
    return "(() => {\n" + one_script(*own_views(), *modules) + "\n})();"


def needed_quantities(views: Sequence[str]) -> tuple[str, ...]:
    """The quantities of the robot that modules with views ask for, each once: `needs: ["mass_matrix"],` on one line.

    Raises:
        FileError: a module that cannot be read.
    """
    lines = (line for view in views for line in _NEEDS.findall(read(view)))
    return tuple(dict.fromkeys(name for line in lines for name in _NAME.findall(line)))


def own_views() -> list[str]:
    """The modules in `page/views`; each describes one view, but the one with the elements of all."""
    folder = resources.files("mafsil.page").joinpath("views")
    files = sorted(file.name for file in folder.iterdir() if file.name.endswith(".js"))
    return [f"page/views/{name}" for name in files]
