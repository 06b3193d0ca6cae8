"""Properties of an expansion: scopes inside one another, texts with `${expression}` and `$(command)` in them.

The text of a property is evaluated when it is first used.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from mafsil.model.faults import XACRO_CIRCULAR, XACRO_COMMAND, XACRO_TEXT
from mafsil.model.xacro.expression import evaluate
from mafsil.model.xacro.values import Budget, Namespace, Value, XacroFault, check_size, literal, text_of
from mafsil.model.xml_tree import Element


@dataclass(slots=True, eq=False)
class Macro:
    """A macro: its body and its parameters.

    Attributes:
        body: the element `xacro:macro`.
        parameters: names in order; `*name` and `**name` are blocks.
        defaults: for parameters that have one: whether the caller's property of that name comes first, and the text.
    """

    body: Element
    parameters: tuple[str, ...]
    defaults: dict[str, tuple[bool, str | None]]


@dataclass(slots=True, eq=False)
class Scope:
    """Properties, blocks and macros of a file, a name space or a macro call.

    Attributes:
        evaluate: what makes a value of a text in this scope.
        parent: the scope around it, or None.
        is_namespace: whether it belongs to a name space of an include.
        globals: names of functions and constants, behind all scopes.
    """

    evaluate: Callable[[str, Scope], Value]
    globals: dict[str, Value]
    parent: Scope | None = None
    is_namespace: bool = False
    values: dict[str, Value] = field(default_factory=dict[str, Value])
    waiting: dict[str, str] = field(default_factory=dict[str, str])
    blocks: dict[str, Element] = field(default_factory=dict[str, Element])
    macros: dict[str, Macro] = field(default_factory=dict[str, Macro])
    spaces: dict[str, Scope] = field(default_factory=dict[str, "Scope"])
    _resolving: list[str] = field(default_factory=list[str])

    def inner(self, *, is_namespace: bool = False) -> Scope:
        """A new scope inside this one."""
        return Scope(self.evaluate, self.globals, self, is_namespace)

    def around(self) -> Iterator[Scope]:
        """This scope and those around it, outward."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def put(self, name: str, value: Value, *, lazy: bool) -> None:
        """Give a name a value; a text that is no literal is evaluated at first use if it is lazy."""
        self.waiting.pop(name, None)
        value = literal(value)
        if lazy and isinstance(value, str):
            self.waiting[name] = value
        self.values[name] = value

    def remove(self, name: str) -> None:
        """Forget a name here and in all scopes around."""
        for scope in self.around():
            scope.values.pop(name, None)
            scope.waiting.pop(name, None)

    def lookup(self, name: str) -> Value:
        """The value of a property, a name space or a global name.

        Raises:
            KeyError: it is not defined.
            XacroFault: its text has no value, or needs itself.
        """
        for scope in self.around():
            if name in scope.values:
                return scope._resolve(name)
            if name in scope.spaces:
                return Namespace(scope.spaces[name].lookup_here)
        return self.globals[name]

    def lookup_here(self, name: str) -> Value:
        """The value of a property of this scope alone; KeyError if there is none."""
        if name in self.spaces:
            return Namespace(self.spaces[name].lookup_here)
        if name not in self.values:
            raise KeyError(name)
        return self._resolve(name)

    def defines(self, name: str) -> bool:
        """Whether `lookup` would find the name."""
        return name in self.globals or any(name in scope.values for scope in self.around())

    def known(self) -> Iterator[str]:
        """Names of all properties and functions."""
        for scope in self.around():
            yield from scope.values
        yield from self.globals

    def block(self, name: str) -> Element | None:
        """The block of that name, the nearest first."""
        return next((scope.blocks[name] for scope in self.around() if name in scope.blocks), None)

    def macro(self, name: str) -> tuple[Scope, Macro] | None:
        """The macro called `name` or `space.name`, and the scope in which it is expanded."""
        if (found := next((s.macros[name] for s in self.around() if name in s.macros), None)) is not None:
            return self, found
        *spaces, last = name.split(".")
        if not spaces:
            return None
        first = next((s.spaces[spaces[0]] for s in self.around() if spaces[0] in s.spaces), None)
        for space in spaces[1:]:
            first = None if first is None else first.spaces.get(space)
        return (first, first.macros[last]) if first is not None and last in first.macros else None

    def _resolve(self, name: str) -> Value:
        if name in self.waiting:
            if name in self._resolving:
                raise XacroFault(XACRO_CIRCULAR, name=name, chain=" -> ".join([*self._resolving, name]))
            self._resolving.append(name)
            try:
                self.values[name] = literal(self.evaluate(self.waiting[name], self))
            finally:
                self._resolving.remove(name)
            del self.waiting[name]
        return self.values[name]


_PIECE = re.compile(
    r"(?P<escaped>\$\$+[{(])|\$\{(?P<expression>[^}]*)\}|\$\((?P<command>[^)]*)\)|(?P<text>[^$]+|\$[^{($]+|\$$)"
)
DEEPEST = 20
"""Of texts inside texts."""


class Substitution:
    """Evaluates texts.

    Attributes:
        commands: what `$(name arguments)` does, by name.
        budget: of the expansion.
    """

    def __init__(self, commands: Mapping[str, Callable[[str], Value]], budget: Budget) -> None:
        self.commands = commands
        self.budget = budget
        self._depth = 0

    def value(self, text: str, scope: Scope) -> Value:
        """The value of a text: of its only piece as it is, of several pieces as one text.

        Raises:
            XacroFault: something in it has no value.
        """
        if "$" not in text:
            return text
        self.budget.spend(1 + (len(text) >> 6))
        self._depth += 1
        try:
            if self._depth > DEEPEST:
                raise XacroFault(XACRO_TEXT, text=text)
            pieces = self._pieces(text, scope)
        finally:
            self._depth -= 1
        if len(pieces) == 1:
            return pieces[0]
        return check_size("".join(text_of(check_size(piece, self.budget)) for piece in pieces), self.budget)

    def text(self, text: str, scope: Scope) -> str:
        """The value of a text, as text."""
        return text_of(self.value(text, scope)) if "$" in text else text

    def _pieces(self, text: str, scope: Scope) -> list[Value]:
        pieces: list[Value] = []
        at = 0
        while at < len(text):
            found = _PIECE.match(text, at)
            if found is None:
                raise XacroFault(XACRO_TEXT, text=text[at:])
            at = found.end()
            match found.lastgroup:
                case "escaped":
                    pieces.append(found[0][1:])
                case "expression":
                    inner = self.text(found["expression"], scope)
                    pieces.append(evaluate(inner, scope, self.budget))
                case "command":
                    pieces.append(self._command(self.text(found["command"], scope)))
                case _:
                    pieces.append(found[0])
        return pieces

    def _command(self, text: str) -> Value:
        name, _, arguments = text.strip().partition(" ")
        command = self.commands.get(name)
        if command is None:
            raise XacroFault(XACRO_COMMAND, command=name, known=", ".join(self.commands))
        return command(arguments.strip())
