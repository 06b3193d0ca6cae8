"""Operations as typed data: what the command line (and later the studio's forms and the docs) are generated from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, TypeAlias, cast

from mafsil.cli.answer import Answer

Kind: TypeAlias = Literal["text", "path", "number", "count", "angle", "flag"]
"""What a parameter holds; an angle is a joint coordinate: radians or metres, degrees with a mark."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One argument of an operation.

    Attributes:
        name: as the operation's function calls it; on the command line with dashes.
        kind: what it holds.
        positional: given by its place; otherwise by `--name`.
        many: takes several values.
        required: must be given.
        choices: the texts allowed, if not all are.
        metavar: what stands for the value in the help.
        reads: the value is a file, or may be one, that is read: `-` stands for standard input.
        endings: by which a file for this argument is known.
        explained: key of the sentence that explains it, where several commands share one.
    """

    name: str
    kind: Kind
    positional: bool = False
    many: bool = False
    required: bool = False
    choices: tuple[str, ...] = ()
    metavar: str = ""
    reads: bool = False
    endings: tuple[str, ...] = ()
    explained: str = ""

    @property
    def option(self) -> str:
        """As it is written on the command line, unless it is given by its place."""
        return "--" + self.name.replace("_", "-")

    def recognises(self, word: str) -> bool:
        """Whether a word is one of the choices, or the name of a file with one of the endings."""
        return word in self.choices or Path(word).suffix.lower() in self.endings


@dataclass(frozen=True, slots=True)
class Operation:
    """One thing that mafsil does.

    Attributes:
        name: of the command.
        target: `module:function`, imported at the first call; takes the parameters by name, returns an Answer.
        parameters: in the order in which the help lists them.
        serves: runs until it is stopped.
    """

    name: str
    target: str
    parameters: tuple[Parameter, ...] = field(default=())
    serves: bool = False

    @property
    def words(self) -> str:
        """Its name as keys of the catalogue have it."""
        return self.name.replace("-", "_")

    @property
    def help_key(self) -> str:
        """Key of the sentence that says what it does."""
        return f"cli.{self.words}_help"

    def parameter_key(self, parameter: Parameter) -> str:
        """Key of the sentence that explains a parameter."""
        return parameter.explained or f"cli.{self.words}_{parameter.name}"

    def function(self) -> Callable[..., Answer]:
        """The function behind the name."""
        module, _, name = self.target.partition(":")
        return cast("Callable[..., Answer]", getattr(import_module(module), name))

    def __call__(self, **arguments: Any) -> Answer:
        """Do it."""
        return self.function()(**arguments)
