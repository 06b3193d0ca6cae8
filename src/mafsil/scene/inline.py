"""Pages that hold all they need: data that can stand in markup, and the policy that lets nothing else in."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from typing import Any


def embedded(data: Mapping[str, Any]) -> str:
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
