"""The site: `python -m sphinx -W -c docs/site docs build/site`. A reader's browser fetches nothing from elsewhere.

The pages of docs/ are taken as they are; the reference is made from the docstrings (reference.py), with their formulas
typeset (formulas.py).
"""

from __future__ import annotations

import os
import re
import sys
from functools import cache
from pathlib import Path
from posixpath import dirname, normpath

from sphinx.application import Sphinx
from sphinx.domains.python import ObjectEntry, PythonDomain
from sphinx.environment import BuildEnvironment

sys.path[:0] = [str(Path(__file__).parent)]
REPOSITORY = "https://github.com/mafsil/mafsil"
OUTSIDE = re.compile(r"\]\((\.\./[^)#]+)")

project = "mafsil"
copyright = "mafsil contributors"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "formulas",
    "reference",
]
if not os.environ.get("MAFSIL_SITE_WITHOUT_CODE"):  # Its pages of code take longer than all others.
    extensions.append("sphinx.ext.viewcode")
exclude_patterns = ["site"]
master_doc = "index"
default_role = "literal"
highlight_language = "python"

html_theme = "furo"
html_title = "mafsil"
html_math_renderer = "mathml"
templates_path: list[str] = []

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_use_ivar = True
napoleon_attr_annotations = False
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header", "ref.python"]  # attributes of many classes share a name
CONTENTS = """
```{toctree}
:hidden:

%s
reference/index
```
"""


def link_to_repository(app: Sphinx, document: str, source: list[str]) -> None:
    """Links of the pages to files beside docs/ (examples, source) lead to the repository's address."""

    def address(match: re.Match[str]) -> str:
        path = normpath(f"docs/{dirname(document)}/{match[1]}")
        return match[0] if path.startswith("docs/") else f"]({REPOSITORY}/blob/main/{path}"

    source[0] = OUTSIDE.sub(address, source[0])


def list_pages(app: Sphinx, document: str, source: list[str]) -> None:
    """The site's menu has the pages in the order of the first page's table, then the rest."""
    if document == "index":
        linked = list(dict.fromkeys(re.findall(r"\]\(([\w.-]+)\.md", source[0])))
        rest = sorted({path.stem for path in Path(app.srcdir).glob("*.md")} - {*linked, "index"})
        source[0] += CONTENTS % "\n".join(linked + rest)


def look_up_once(app: Sphinx, env: BuildEnvironment) -> None:
    """Names in signatures are looked up among all objects, each time anew, most of them in vain: half of a build."""
    domain = env.domains["py"]
    assert isinstance(domain, PythonDomain)
    last = {name.rpartition(".")[2] for name in domain.objects}
    find = cache(domain.find_obj)

    def found(
        env: BuildEnvironment, modname: str, classname: str, name: str, kind: str | None, searchmode: int = 0
    ) -> list[tuple[str, ObjectEntry]]:
        if name.removesuffix("()").rpartition(".")[2] not in last:
            return []
        return find(env, modname, classname, name, kind, searchmode)

    domain.find_obj = found  # type: ignore[method-assign]


def setup(app: Sphinx) -> None:
    """Connects the pieces."""
    os.environ.setdefault("MAFSIL_LANGUAGE", "en")
    app.connect("source-read", link_to_repository)
    app.connect("source-read", list_pages)
    app.connect("env-check-consistency", look_up_once)
