"""What an expansion takes from outside: included files, YAML files, packages, arguments, the environment.

YAML in which parameters of robots are written: PyYAML's safe loader with the units of xacro, bounded beforehand.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, TypeAlias, cast

from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Diagnostic, Fault, shown
from mafsil.model.faults import (
    XACRO_ARGUMENT,
    XACRO_ENVIRONMENT,
    XACRO_FILE,
    XACRO_INCLUDES,
    XACRO_PACKAGE,
    XACRO_UNUSED_ARGUMENT,
    XACRO_YAML,
)
from mafsil.model.reading import Reading
from mafsil.model.source import load
from mafsil.model.xacro.expression import evaluate
from mafsil.model.xacro.values import Budget, Function, Reported, Value, XacroFault, check_size, literal, wrong
from mafsil.model.xacro.vocabulary import audit
from mafsil.model.xml_tree import Element, ReadLimits, Refusal, parse
from mafsil.regular_file import regular_bytes

Node: TypeAlias = object
"""None, bool, int, float, str, date, list or dict of nodes."""
LARGEST = 200_000
"""Characters of a file."""
MOST_EVENTS, MOST_EVENTS_IN_PYTHON = 150_000, 15_000
"""Values and ends of collections of a file, by the parser in C and by that in Python: a second of either's time."""
DEEPEST = 40
UNITS = {
    "!radians": 1.0,
    "!degrees": math.pi / 180.0,
    "!meters": 1.0,
    "!millimeters": 0.001,
    "!foot": 0.3048,
    "!inches": 0.0254,
}
"""Tags of xacro, and what their numbers are multiplied by."""
MOST_INCLUDED = 40
"""Files inside one another."""
_GLOB = re.compile(r"[*?[]")
COST = 500
"""Steps that reading a file takes."""


class Files:
    """Reads files for an expansion.

    Attributes:
        arguments: of `$(arg name)`: given with the file, or declared by it.
    """

    def __init__(self, reading: Reading, assets: Assets, limits: ReadLimits, budget: Budget) -> None:
        self.reading = reading
        self.assets = assets
        self.limits = limits
        self.budget = budget
        self.arguments = dict(reading.arguments)
        self._used: set[str] = set()
        self._folders: list[Path | None] = [assets.folder]
        self._roots: dict[Path, Element] = {}

    def begin(self) -> Element:
        """The root of the robot file, its elements marked so that they keep their places but offer no repairs."""
        document = self.reading.document
        self.reading.included.append(("", document))
        self._note_file(document.root)
        audit(self.reading, document.root)
        return document.root

    def declare(self, name: str, default: str) -> None:
        """An argument with its default."""
        self._used.add(name)
        self.arguments.setdefault(name, default)

    def included_roots(self, reference: str, *, optional: bool) -> Iterator[Element]:
        """The roots of the files that a reference means, several for a pattern; call `end` after each.

        Raises:
            XacroFault: there is no such file, or too many inside one another.
            Reported: it is no XML; that was reported.
        """
        for path in self._paths(reference, optional=optional):
            if len(self._folders) > MOST_INCLUDED:
                raise XacroFault(XACRO_INCLUDES, file=reference, limit=MOST_INCLUDED)
            self.budget.spend(COST)
            self._folders.append(path.parent)
            yield self._root(path)

    def end(self) -> None:
        """The included file read last is finished."""
        self._folders.pop()

    def commands(self) -> dict[str, Callable[[str], Value]]:
        """What `$(name ...)` does."""
        return {
            "arg": self._argument,
            "find": self._find,
            "env": self._environment,
            "optenv": self._optional_environment,
            "dirname": lambda _: str(self._folders[-1] or "."),
            "cwd": lambda _: os.getcwd(),
            "anon": lambda name: name,
            "eval": self._eval,
        }

    def functions(self) -> dict[str, Value]:
        """Functions of the name space `xacro`."""
        silent = ("message", "warning", "error", "print_location")
        functions: dict[str, Callable[..., Value]] = {
            "load_yaml": self._load_yaml,
            "abs_filename": self._absolute_name,
            "dotify": _unchanged,
            "arg": self._argument_of,
            "tokenize": _tokenize,
            "fatal": lambda *words: _fatal(words),
            **dict.fromkeys(silent, lambda *_, **__: ""),
        }
        return {name: Function(name, call) for name, call in functions.items()}

    def report_unused_arguments(self, root: Element) -> None:
        """Arguments that were given but that the file neither declares nor asks for."""
        for name in self.reading.arguments:
            if name not in self._used:
                known = ", ".join(sorted(self._used)) or "-"
                self.reading.report(XACRO_UNUSED_ARGUMENT, root, None, None, name=name, known=known)

    def diagnostic(self, fault: Fault, element: Element, **details: object) -> Diagnostic:
        """A diagnostic at an element, for a refusal."""
        return Diagnostic(fault, element.line, element.column, details)

    def _note_file(self, root: Element) -> None:
        for element in root.walk():
            element.file = len(self.reading.included)

    def _root(self, path: Path) -> Element:
        if path not in self._roots:
            name = self._shown(path)
            try:
                text = load(path, self.limits)
                document = parse(text.data, self.limits)
            except Refusal as refusal:
                self.reading.diagnostics.append(replace(refusal.diagnostic, file=name, repair=None))
                raise Reported from None
            self._roots[path] = self.reading.include(name, text, document)
            audit(self.reading, document.root)
        return self._roots[path]

    def _shown(self, path: Path) -> str:
        base = self.assets.root
        return shown(str(path.relative_to(base)) if base is not None and path.is_relative_to(base) else str(path))

    def _absolute_name(self, name: Value) -> Value:
        return str(self._absolute(str(name)))

    def _argument_of(self, name: Value) -> Value:
        return self._argument(str(name))

    def _absolute(self, reference: str) -> Path:
        folder = self._folders[-1]
        return Path(reference) if folder is None else folder / reference

    def _resolve(self, reference: str) -> Path | None:
        """The file, if it lies where files may lie."""
        plain = reference if "://" in reference else str(self._absolute(reference))
        return self.assets.resolve(plain).path

    def _paths(self, reference: str, *, optional: bool) -> list[Path]:
        if _GLOB.search(reference):
            pattern = self._absolute(reference)
            folder = pattern.parent
            try:
                names = sorted(entry.name for entry in os.scandir(folder) if fnmatchcase(entry.name, pattern.name))
            except (OSError, ValueError):
                names = []
            found = [self._resolve(str(folder / name)) for name in names[: self.limits.depth]]
            return [path for path in found if path is not None]
        path = self._resolve(reference)
        if path is not None:
            return [path]
        if optional:
            return []
        raise XacroFault(XACRO_FILE, file=reference)

    def _argument(self, name: str) -> Value:
        self._used.add(name)
        if name not in self.arguments:
            raise XacroFault(XACRO_ARGUMENT, name=name)
        return self.arguments[name]

    def _find(self, package: str) -> Value:
        folder = self.assets.package(package)
        if folder is None:
            raise XacroFault(XACRO_PACKAGE, package=package)
        return str(folder)

    def _environment(self, name: str) -> Value:
        if name not in os.environ:
            raise XacroFault(XACRO_ENVIRONMENT, name=name)
        return os.environ[name]

    def _optional_environment(self, words: str) -> Value:
        name, _, default = words.partition(" ")
        return os.environ.get(name, default.strip())

    def _eval(self, expression: str) -> Value:
        return evaluate(expression, _Arguments(self), self.budget)

    def _load_yaml(self, name: Value) -> Value:
        path = self._resolve(str(name))
        if path is None:
            raise XacroFault(XACRO_FILE, file=str(name))
        self.budget.spend(COST)
        try:
            text = regular_bytes(path, LARGEST + 1).decode("utf-8-sig")
            value = parse_yaml(text)
        except YamlFault as fault:
            raise XacroFault(XACRO_YAML, file=self._shown(path), line=fault.line, reason=fault.reason) from None
        except (OSError, ValueError) as error:
            raise XacroFault(XACRO_YAML, file=self._shown(path), line=0, reason=str(error)) from None
        return check_size(value, self.budget)


class _Arguments:
    """Names inside `$(eval ...)`: the arguments, and the other commands as functions."""

    def __init__(self, files: Files) -> None:
        self.files = files

    def lookup(self, name: str) -> Value:
        if name in self.files.arguments:
            return literal(self.files.arguments[name])
        commands = self.files.commands()
        if name in ("arg", "find", "env", "optenv", "dirname"):
            command = commands[name]
            return Function(name, lambda *words: literal(command(" ".join(map(str, words)))))
        constants = {"true": True, "false": False}
        return constants[name]

    def known(self) -> Iterator[str]:
        yield from self.files.arguments


def _tokenize(text: Value, sep: Value = ",; ", skip_empty: Value = True) -> Value:
    words = re.split("[" + re.escape(str(sep)) + "]", str(text))
    return [word for word in words if word] if skip_empty else words


def _unchanged(value: Value) -> Value:
    return value


def _fatal(words: tuple[Value, ...]) -> Value:
    raise wrong(" ".join(map(str, words)))


class YamlFault(ValueError):
    """Not YAML, or more of it than a robot needs.

    Attributes:
        line: from 1.
        reason: what is wrong.
    """

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(f"line {line}: {reason}")
        self.line = line
        self.reason = reason


def parse_yaml(text: str) -> Node:
    """The value of a YAML text.

    What an alias stands for is the same object, so a small file stays small; who writes it out bounds it.

    Raises:
        YamlFault: it is no YAML, too long, nests too deeply, has a foreign tag or several documents; the line is given.
    """
    import yaml

    if len(text) > LARGEST:
        raise YamlFault(1, f"longer than {LARGEST} characters")
    try:
        fast = getattr(yaml, "CSafeLoader", None)
        loader, most = (yaml.SafeLoader, MOST_EVENTS_IN_PYTHON) if fast is None else (fast, MOST_EVENTS)
        _require_small(yaml, text, loader, most)
        return yaml.load(text, Loader=_with_units(loader))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        line = 1 if mark is None else min(mark.line, text.count("\n")) + 1  # the end of the text may be one line on
        raise YamlFault(line, _reason(error)) from None
    except (ValueError, OverflowError) as error:  # a date or number that is none
        if isinstance(error, YamlFault):
            raise
        raise YamlFault(1, str(error)) from None


def _reason(error: Exception) -> str:
    """The parser's own words, in one line."""
    words = getattr(error, "problem", None) or str(error)
    return " ".join(str(words).split())[:200]


def _require_small(yaml: Any, text: str, loader: Any, most: int) -> None:
    """The parser's own recursion would end in an error without a place, its time in none at all."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, Loader=loader)):
        if count > most:
            raise YamlFault(event.start_mark.line + 1, f"more than {most} values")
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise YamlFault(event.start_mark.line + 1, "nested too deeply")


def _with_units(loader: Any) -> Any:
    """A safe loader that also knows the units."""

    class Units(loader):
        """PyYAML asks for a class."""

    for tag, factor in UNITS.items():
        Units.add_constructor(tag, _times(factor))
    return Units


def _times(factor: float) -> Any:
    def made(_loader: Any, node: Any) -> float:
        try:
            value = evaluate(str(node.value)[:200], _Pi(), Budget(1000))
            return float(cast("float", value)) * factor
        except (XacroFault, TypeError, ValueError):
            raise YamlFault(node.start_mark.line + 1, f"{node.tag} takes a number") from None

    return made


class _Pi:
    """The one name that numbers with units know."""

    def lookup(self, name: str) -> Any:
        return {"pi": math.pi}[name]

    def known(self) -> Any:
        return iter(("pi",))
