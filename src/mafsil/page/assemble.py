"""The page as one HTML file: no request leaves it, no script but its own runs in it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from mafsil.messages import direction
from mafsil.scene import one_script
from mafsil.scene.inline import attribute, embedded, policy
from mafsil.scene.modules import read


def assembled(content: Mapping[str, Any]) -> str:
    """The page as HTML text.

    Args:
        content: its data, see `mafsil.page.content`.
    """
    style, script = _style(), "(() => {\n" + one_script("page/main.js") + "\n})();"
    slots = {
        "lang": content["language"],
        "dir": direction(content["language"]),
        "title": attribute(content["robot"]["name"]),
        "policy": policy(style, script, computes=True),
        "style": style,
        "script": script,
        "data": embedded(content),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: slots[match.group(1)], read("page/page.html"))


@cache
def _style() -> str:
    return read("page/page.css").strip()
