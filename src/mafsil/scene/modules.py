"""ES modules joined to one script for a page that makes no request.

Only what the modules here use is understood: `import { names } from "./path.js";` on lines of their own, the path
relative or, from `page/` and `scene/`, inside the package; and `export` in front of declarations. All declarations at
the top of the modules share one scope, so their names must differ.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable
from importlib import resources
from pathlib import Path

from mafsil.errors import FileError, KernelError

ROOT = "mafsil"
_IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";\n', re.M)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:const|let|class|function)\b)", re.M)
_DECLARED = re.compile(r"^(?:export )?(?:async )?(?:const|let|class|function\*?) (?:\{([^}]*)\}|(\w+))", re.M)
_COMMENT = re.compile(r"^[ \t]*(?://[^\n]*|/\*\*(?:(?!\*/).)*\*/)\n", re.M | re.S)

_REMARK = re.compile(r"(?<=[;,{}\])]) +//[^\n\"'`]*$|^[ \t]+", re.M)
"""What follows a statement on its line, and what stands before one: neither does anything."""

_GAP = re.compile(r"(?<=[;}])\n\n+(?=\S)")
"""Empty lines between statements."""

_PLAIN = re.compile(r"^(?:[^\n\"'`/]| / |\"(?:[^\"\\\n]|\\.)*\")+$", re.M)
"""A line without templates and expressions of patterns; what it quotes stands in double quotation marks."""

_BLANK = re.compile(r"(\"(?:[^\"\\]|\\.)*\")|(?<=[\w)\]]) ([+\-/]) (?=[\w(\[])| ?([=*<>&|?:,;{}()\[\]]) ?")
"""What is quoted, which stays; blanks beside signs: a plus and a minus could join with others of their kind."""

_BREAK = re.compile(r"(?<=[;{},(\[])\n(?!#)")
"""Ends of lines that end no statement; directives of shaders stand on lines of their own."""

Source = str
"""A module's path inside the package, such as `scene/matrix.js`."""


def one_script(*entries: Source) -> str:
    """The entries and all that they import, each once, what is imported first; comments and blanks left out.

    Args:
        entries: paths inside the package.

    Raises:
        KernelError: a statement that is not understood, a name declared twice.
    """
    order: list[str] = []
    for entry in entries:
        _collect(entry, order)
    owners: dict[str, str] = {}
    for path in order:
        for name in _declare(read(path)):
            if owners.setdefault(name, path) != path:
                raise KernelError("kernels.refused", reason=f"{name} is declared in {owners[name]} and in {path}")
    return '"use strict";\n' + "\n".join(_bare(path) for path in order)


def read(path: Source) -> str:
    """The text of a module.

    Args:
        path: inside the package; or absolute, of a module that somebody else wrote.

    Raises:
        FileError: no such file.
    """
    if posixpath.isabs(path):
        try:
            return Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise FileError("file.unreadable", path=path, reason=str(error)) from None
    return resources.files(ROOT).joinpath(*path.split("/")).read_text(encoding="utf-8")


def _collect(path: Source, order: list[str]) -> None:
    if path in order:
        return
    for _, other in _IMPORT.findall(read(path)):
        _collect(_place(path, other), order)
    if path not in order:
        order.append(path)


def _place(importer: Source, path: str) -> Source:
    """The module that is imported: beside the importer, or by its path inside the package."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(importer), path)) if path.startswith(".") else path


def _declare(text: str) -> Iterable[str]:
    for names, name in _DECLARED.findall(text):
        yield from (part.strip() for part in names.split(",")) if names else (name,)


def _bare(path: Source) -> str:
    text = _GAP.sub("\n", _REMARK.sub("", _COMMENT.sub("", _EXPORT.sub("", _IMPORT.sub("", read(path)))))).strip()
    strange = re.search(r"^(?:import|export)\b.*", text, re.M)
    if strange:
        raise KernelError("kernels.refused", reason=f"{path}: {strange.group(0)}")
    if posixpath.isabs(path):
        return text
    return _BREAK.sub("", _PLAIN.sub(lambda line: _BLANK.sub(lambda part: part[part.lastindex or 0], line[0]), text))
