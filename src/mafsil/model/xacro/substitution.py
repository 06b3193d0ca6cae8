"""Texts with `${expression}` and `$(command)` in them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from mafsil.model.faults import XACRO_COMMAND, XACRO_TEXT
from mafsil.model.xacro.expression import evaluate
from mafsil.model.xacro.fault import Budget, XacroFault
from mafsil.model.xacro.scope import Scope
from mafsil.model.xacro.values import Value, check_size, text_of

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
