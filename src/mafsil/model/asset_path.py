"""Where a file named inside a robot file may be found: inside the model's root or an allowed package, nowhere else."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from mafsil.model.diagnostics import Fault
from mafsil.model.faults import (
    FILE_NOT_FOUND,
    PACKAGE_NOT_FOUND,
    PATH_ESCAPES,
    PATH_NOT_ALLOWED,
    UNKNOWN_SCHEME,
)
from mafsil.regular_file import regular_bytes

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*)://(.*)", re.DOTALL)
_PACKAGE_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
_SEARCH_PATHS = ("MAFSIL_PACKAGE_PATH", "ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH")
MOST_ANCESTORS = 40
NEAR_ANCESTORS = 5
"""Folders above a robot file in whose neighbourhood packages of other names than their folders are looked for."""
MOST_MANIFESTS = 1000
"""Folders that are looked at for them."""
_MANIFEST_NAME = re.compile(rb"<name>\s*([A-Za-z0-9_][A-Za-z0-9_.-]*)\s*</name>")
_ROOT_MARKS = ("package.xml", ".git", "pyproject.toml", "setup.py", "LICENSE", "LICENSE.txt", "LICENSE.md")
"""Files that stand at the top of what is published together."""


@dataclass(frozen=True, slots=True)
class Resolved:
    """The file behind a reference, or why there is none.

    Attributes:
        path: an existing file inside an allowed directory, or None.
        fault: what was wrong, or None.
        package: name of the package that the reference asks for, or empty.
        similar: a file that differs only by upper and lower case, or empty.
    """

    path: Path | None
    fault: Fault | None = None
    package: str = ""
    similar: str = ""


@dataclass(slots=True)
class Assets:
    """Resolves references of one robot file.

    Attributes:
        folder: where the robot file lies; None for a text, which has no relative files.
        packages: directories that the caller allows: packages themselves, or directories that hold packages.
    """

    folder: Path | None
    packages: tuple[Path, ...] = ()
    _found: dict[str, Path | None] = field(default_factory=dict[str, Path | None])
    _root: Path | None = None
    _by_manifest: dict[str, Path] | None = None

    @classmethod
    def of(cls, folder: Path | None, packages: Iterable[str | Path] = ()) -> Assets:
        """For a robot file in `folder`; the search paths of the environment follow the caller's packages."""
        from_environment = [
            entry for name in _SEARCH_PATHS for entry in os.environ.get(name, "").split(os.pathsep) if entry
        ]
        allowed = (*packages, *from_environment)
        return cls(None if folder is None else folder.resolve(), tuple(Path(entry).resolve() for entry in allowed))

    def beside(self, path: Path) -> Assets:
        """For another file of the same model, which may read the same directories and its own."""
        roots = (*(() if self.root is None else (self.root,)), *self.packages)
        return Assets(path.parent, roots)

    @property
    def root(self) -> Path | None:
        """The top of what the robot file was published with: package, repository, Python package; else its own."""
        if self._root is None and self.folder is not None:
            ancestors = (self.folder, *self.folder.parents)[:MOST_ANCESTORS]
            self._root = next((top for a in ancestors if (top := _top(a)) is not None), self.folder)
        return self._root

    def resolve(self, reference: str) -> Resolved:
        """The file that a reference means.

        Args:
            reference: `package://name/path`, `model://name/path`, `file:///path` or a path relative to the file.
        """
        text = reference.strip()
        scheme = _SCHEME.fullmatch(text)
        if scheme is None:
            return self._relative(text)
        kind, rest = scheme[1].lower(), scheme[2]
        if kind in ("package", "model"):
            return self._in_package(rest)
        if kind == "file":
            return self._absolute(unquote(rest.removeprefix("localhost")))
        return Resolved(None, UNKNOWN_SCHEME)

    def package(self, name: str) -> Path | None:
        """The directory of a package, or None."""
        if name not in self._found:
            self._found[name] = self._search(name)
        return self._found[name]

    def _in_package(self, rest: str) -> Resolved:
        name, _, path = rest.lstrip("/").partition("/")
        if ".." in PurePosixPath(rest.replace("\\", "/")).parts or not _PACKAGE_NAME.fullmatch(name):
            return Resolved(None, PATH_ESCAPES)
        folder = self.package(name)
        if folder is None:
            return Resolved(None, PACKAGE_NOT_FOUND, name)
        return _inside(folder, path, (folder,))

    def _relative(self, path: str) -> Resolved:
        if PurePosixPath(path).is_absolute():
            return self._absolute(path)
        if self.folder is None or self.root is None:
            return Resolved(None, FILE_NOT_FOUND)
        return _inside(self.folder, path, (self.root, *self.packages))

    def _absolute(self, path: str) -> Resolved:
        found = (package for package in self._found.values() if package is not None)
        roots = (*(() if self.root is None else (self.root,)), *self.packages, *found)
        return _inside(Path("/"), path.lstrip("/"), roots)

    def _search(self, name: str) -> Path | None:
        around = () if self.folder is None else (self.folder, *self.folder.parents)[:MOST_ANCESTORS]
        for place in (*self.packages, *around):
            for candidate in (place, place / name, place / "share" / name):
                if candidate.name == name and candidate.is_dir():
                    return candidate.resolve()
        return self._declare(name)

    def _declare(self, name: str) -> Path | None:
        """The package whose package.xml says the name, its folder being called otherwise."""
        if self._by_manifest is None:
            around = () if self.folder is None else (self.folder, *self.folder.parents)[:NEAR_ANCESTORS]
            self._by_manifest = _manifests((*around, *self.packages))
        return self._by_manifest.get(name)


def _manifests(places: Iterable[Path]) -> dict[str, Path]:
    """Packages by the name in their package.xml, among the places and what lies in them; the first of a name counts."""
    found: dict[str, Path] = {}
    left = MOST_MANIFESTS
    for place in places:
        if place == Path(place.anchor) or left <= 0:
            continue
        try:
            folders = [place, *(Path(entry.path) for entry in islice(os.scandir(place), left) if entry.is_dir())]
        except OSError:
            continue
        left -= len(folders)
        for folder in folders:
            try:
                manifest = regular_bytes(folder / "package.xml", 10_000)
            except OSError:
                continue
            if (name := _MANIFEST_NAME.search(manifest)) is not None:
                found.setdefault(name[1].decode("ascii"), folder.resolve())
    return found


def _top(folder: Path) -> Path | None:
    """A folder itself if it is the top of something published, or the outermost Python package that it belongs to.

    Never a home folder or what lies around one: a model in there must not reach everything beside it.
    """
    home = Path.home()
    if folder == home or folder in home.parents or folder == Path(folder.anchor):
        return None
    if any((folder / name).exists() for name in _ROOT_MARKS):
        return folder
    while (folder / "__init__.py").is_file():
        if not (folder.parent / "__init__.py").is_file():
            return folder
        folder = folder.parent
    return None


def _inside(base: Path, path: str, roots: tuple[Path, ...]) -> Resolved:
    """The existing file base/path, if it lies in one of the roots after all links are followed."""
    try:
        target = Path(os.path.normpath(base / path))
        if not any(target.is_relative_to(root) for root in roots):
            return Resolved(None, PATH_NOT_ALLOWED)
        real = target.resolve()
        if not any(real.is_relative_to(root) for root in roots):
            return Resolved(None, PATH_ESCAPES)
        return Resolved(real) if real.is_file() else Resolved(None, FILE_NOT_FOUND, similar=_similar(target))
    except (OSError, ValueError, RuntimeError):
        return Resolved(None, FILE_NOT_FOUND)


def _similar(target: Path) -> str:
    """Name of a file beside the target that differs only by case."""
    folded = target.name.casefold()
    try:
        names = (entry.name for entry in os.scandir(target.parent))
        return next((name for name in names if name.casefold() == folded), "")
    except OSError:
        return ""
