"""Pages of the reference, written before the site is built: one for each package, from its public names' docstrings.

A package offers the names of its stub; collections of algorithms get a section a module.
"""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path

from sphinx.application import Sphinx

from mafsil.lazy_module import public_names

SOURCE = Path(__file__).parents[2] / "src" / "mafsil"
FOLDER = Path(__file__).parents[1] / "reference"
PACKAGES = {
    "robot": "Robots",
    "model": "Models and files",
    "geometry": "Rigid motions",
    "ik": "Inverse kinematics",
    "performance": "Singularities, statics, workspaces",
    "grasp": "Grasps",
    "collision": "Collision",
    "trajectory": "Trajectories",
    "planning": "Planning",
    "control": "Control",
    "one_joint": "One joint",
    "simulation": "Simulation",
    "identification": "Identification",
    "derivation": "Derivations",
    "verification": "Verification",
    "solvers": "Solvers",
    "kernels": "Kernels",
}
COLLECTIONS = {"mechanics": "Mechanics as expressions", "algebra": "Rigid motion as expressions"}


def setup(app: Sphinx) -> None:
    """The pages are written when the builder starts."""
    app.connect("builder-inited", write_pages)


def write_pages(app: Sphinx) -> None:
    """All pages of the reference and their list; a page that stands as it should is not touched."""
    FOLDER.mkdir(exist_ok=True)
    pages = {package: _page(title, [_names(package)]) for package, title in PACKAGES.items()}
    pages |= {package: _page(title, _modules(package)) for package, title in COLLECTIONS.items()}
    pages["index"] = _page("Reference", [[".. toctree::", *(f"   {name}" for name in pages)]])
    for name, text in pages.items():
        path = FOLDER / f"{name}.rst"
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")


def _page(title: str, sections: list[list[str]]) -> str:
    return "\n".join([title, "=" * len(title), "", *(line for section in sections for line in [*section, ""])])


def _names(package: str) -> list[str]:
    """Directives for what a package offers, in the order of its first file."""
    module = importlib.import_module(f"mafsil.{package}")
    lines = [f".. automodule:: mafsil.{package}", ""]
    for name in public_names(module):
        thing = getattr(module, name)
        if inspect.isclass(thing):
            foreign = not thing.__module__.startswith(f"mafsil.{package}.")
            lines += [
                f".. autoclass:: mafsil.{package}.{name}",
                "   :members:",
                f"   :inherited-members: {'int' if issubclass(thing, int) else 'object'}",
                *(["   :no-index:"] if foreign else []),
                "",
            ]
        elif callable(thing):
            lines += [f".. autofunction:: mafsil.{package}.{name}", ""]
    return lines


def _modules(package: str) -> list[list[str]]:
    """A section for each module of a collection."""
    paths = [path for path in sorted((SOURCE / package).rglob("*.py")) if path.stem != "__init__"]
    dotted = [".".join(("mafsil", *path.relative_to(SOURCE).with_suffix("").parts)) for path in paths]
    return [[name, "-" * len(name), "", f".. automodule:: {name}", "   :members:"] for name in dotted]
