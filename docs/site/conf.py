"""The site: `python -m sphinx -W -c docs/site docs build/site`. A reader's browser fetches nothing from elsewhere.

The pages of docs/ are taken as they are; the reference is made from the docstrings (reference.py), formulas are typeset
(formulas.py), the live pages and the notebooks are made by the package itself (live_pages.py, notebooks.py).
`MAFSIL_SITE_QUICK=1`, as the tests set it, leaves out the pages of source code and most live pages and notebooks.
"""

from __future__ import annotations

import os
import re
import sys
from functools import cache
from pathlib import Path
from posixpath import dirname, normpath
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.domains.python import ObjectEntry, PythonDomain
from sphinx.environment import BuildEnvironment
from sphinx.util import inspect, typing

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE)]
REPOSITORY = "https://github.com/mafsil/mafsil"
OUTSIDE = re.compile(r"\]\((\.\./[^)#]+)")
GROUPS = re.compile(r"^## ([^\n]+)$(.*?)(?=^## |\Z)", re.M | re.S)
PARAMETERS = re.compile(r"<dl>\n((?:<dd>.*</dd>\n)+)</dl>")
LINKED = re.compile(r"\]\(([\w.-]+)\.md")

project = "mafsil"
copyright = "mafsil contributors"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "formulas",
    "live_pages",
    "notebooks",
    "reference",
]
if not os.environ.get("MAFSIL_SITE_QUICK"):  # Its pages of code take longer than all others.
    extensions.append("sphinx.ext.viewcode")
exclude_patterns = ["site"]
master_doc = "index"
default_role = "literal"
highlight_language = "python"

html_theme = "furo"
html_title = "mafsil"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_theme_options = {"top_of_page_buttons": []}
templates_path = ["templates"]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
maximum_signature_line_length = 88
napoleon_google_docstring = True
napoleon_use_ivar = True
napoleon_attr_annotations = False
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
copybutton_exclude = ".linenos, .gp, .go"
suppress_warnings = ["myst.header", "ref.python"]  # attributes of many classes share a name


def link_to_repository(app: Sphinx, document: str, source: list[str]) -> None:
    """Links of the pages to files beside docs/ (examples, source) lead to the repository's address."""

    def address(match: re.Match[str]) -> str:
        path = normpath(f"docs/{dirname(document)}/{match[1]}")
        return match[0] if path.startswith("docs/") else f"]({REPOSITORY}/blob/main/{path}"

    source[0] = OUTSIDE.sub(address, source[0])


def open_home(app: Sphinx, document: str, source: list[str]) -> None:
    """The first page opens with a live arm and cards; the menu has the groups of its headings, in their order."""
    if document == "index":
        title, introduction, tables = source[0].split("\n\n", 2)
        cards = (HERE / "home.md").read_text("utf-8")
        menu = "\n".join(_group(caption, LINKED.findall(table)) for caption, table in GROUPS.findall(source[0]))
        source[0] = "\n\n".join([title, introduction, cards, tables, menu])


def _group(caption: str, pages: list[str]) -> str:
    more = ["reference/index"] if caption == "Reference" else []
    return "\n".join(["```{toctree}", f":caption: {caption}", ":hidden:", "", *dict.fromkeys(pages + more), "```", ""])


def fill_corners(app: Sphinx, doctree: nodes.document) -> None:
    """The empty corner of a table of two entries gets a word for those who listen to it."""
    for head in doctree.findall(nodes.thead):
        for entry in head.findall(nodes.entry):
            if not entry.astext().strip():
                entry += nodes.raw("", '<span class="visually-hidden">Row</span>', format="html")


def turn_arabic_pages(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Pages whose name ends in .ar are Arabic, from right to left."""
    context["language"] = 'ar" dir="rtl' if page.endswith(".ar") else "en"  # the theme writes lang="...", and no dir


def open_parameter_lists(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Parameters on lines of their own are lines: Sphinx writes lists of definitions without a term."""
    if "body" in context:
        context["body"] = PARAMETERS.sub(
            lambda found: re.sub("<dd>(.*)</dd>", r'<span class="sig-line">\1</span>', found[1]), context["body"]
        )


def written_annotations(thing: object, *_: object, **__: object) -> dict[str, Any]:
    """Annotations as the source writes them: evaluated, `ArrayLike` is a union of twelve types in every signature."""
    return inspect.safe_getattr(thing, "__annotations__", {})


def refuse_aliases(aliases: object) -> None:
    """Autodoc takes a signature that it cannot evaluate as it is written."""
    raise NameError("annotations are not evaluated")


typing.get_type_hints = written_annotations  # before autodoc is loaded, which takes the function from there
inspect.TypeAliasNamespace = refuse_aliases  # type: ignore[assignment, misc]


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
    app.connect("source-read", open_home)
    app.connect("doctree-read", fill_corners)
    app.connect("html-page-context", open_parameter_lists)
    app.connect("html-page-context", turn_arabic_pages)
    app.connect("env-check-consistency", look_up_once)
