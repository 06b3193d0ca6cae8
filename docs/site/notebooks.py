"""The tutorials as notebooks: every section of docs/tutorials.md is one, executed while the site is built.

jupytext makes cells of the page's text and code, nbclient runs them, and their outputs stand in the file that readers
download. A cell that fails, fails the build.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jupytext
import nbformat
from nbclient import NotebookClient
from sphinx.application import Sphinx

FOLDER = "notebooks"
SECTION = re.compile(r"^## (.+)$", re.M)
SHOWN = re.compile(r"```text\n.*?```\n", re.S)


def setup(app: Sphinx) -> None:
    """Each section of the page begins with a link to its notebook."""
    app.connect("source-read", link_notebooks)
    app.connect("build-finished", write_notebooks)


def link_notebooks(app: Sphinx, document: str, source: list[str]) -> None:
    """A link below each heading of the tutorials."""
    if document == "tutorials":
        source[0] = SECTION.sub(
            lambda heading: f'{heading[0]}\n\n<a href="{_address(heading[1])}" download>As a notebook</a>\n', source[0]
        )


def write_notebooks(app: Sphinx, failure: Exception | None) -> None:
    """One notebook a section, each with the page's first imports; a quick build makes the first one."""
    if failure or app.builder.format != "html":
        return
    (Path(app.outdir) / FOLDER).mkdir(exist_ok=True)
    for title, notebook in list(notebooks((Path(app.srcdir) / "tutorials.md").read_text("utf-8")))[: _count()]:
        with TemporaryDirectory() as folder:
            NotebookClient(
                notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": folder}}
            ).execute()
        nbformat.write(notebook, Path(app.outdir) / _address(title))


def notebooks(page: str) -> list[tuple[str, Any]]:
    """Title and unexecuted notebook of each section; what the page shows as printed is left to the run."""
    start, *sections = SECTION.split(SHOWN.sub("", page))
    imports = "\n".join(re.findall(r"```python\n.*?```\n", start, re.S))
    pairs = zip(sections[::2], sections[1::2], strict=True)
    return [(title, jupytext.reads(f"# {title}\n\n{imports}\n{text}", fmt="md")) for title, text in pairs]


def _count() -> int | None:
    return 1 if os.environ.get("MAFSIL_SITE_QUICK") else None


def _address(title: str) -> str:
    return f"{FOLDER}/{re.sub(r'[^a-z0-9]+', '-', title.lower()).strip('-')}.ipynb"
