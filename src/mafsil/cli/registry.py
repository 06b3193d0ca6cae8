"""The operations of the command line as typed data, of which its grammar, its completion and the docs are made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, TypeAlias, cast

from mafsil.cli.answer import Answer
from mafsil.messages import LANGUAGES
from mafsil.toml_source import own_tables

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


def _parameter(name: str, said: str | Mapping[str, Any]) -> Parameter:
    """A parameter from its words, `kind flag flag`, or from a table that has them as `is`."""
    table: Mapping[str, Any] = {"is": said} if isinstance(said, str) else said
    kind, *flags = str(table["is"]).split()
    fields: dict[str, Any] = dict.fromkeys(flags, True)
    fields |= {
        key: tuple(cast("list[str]", value)) if isinstance(value, list) else value
        for key, value in table.items()
        if key != "is"
    }
    return Parameter(name, cast("Kind", kind), **fields)


def _parameters(table: Mapping[str, Any]) -> tuple[Parameter, ...]:
    said = {name: _TABLES["shared"][name] if words == f"@{name}" else words for name, words in table.items()}
    return tuple(_parameter(name, words) for name, words in said.items() if name not in ("call", "serves"))


_TABLES = own_tables(__file__, "commands.toml")

COMMON = (
    Parameter("json", "flag", explained="cli.json"),
    Parameter("lang", "text", choices=LANGUAGES, explained="cli.lang"),
    Parameter("no_color", "flag", explained="cli.no_color"),
    Parameter("debug", "flag", explained="cli.debug"),
)
"""Options of every command; they may stand before it too."""
ROBOT_OPTIONS = _parameters(_TABLES["robot_options"])
"""Options of every command that takes a robot, applied to it before the command sees it."""
REPEATED = ("lock", "xacro_arg")
"""Those of them that may be given several times."""
UNEQUIPPED = ("lint",)
"""Commands that look at the file of a robot as it is."""
OPERATIONS = tuple(
    Operation(name, table["call"], _parameters(table), table.get("serves", False))
    for name, table in _TABLES["commands"].items()
)
"""All of them, in the order of the help."""


def robot_options(operation: Operation) -> tuple[Parameter, ...]:
    """The options of its robot that an operation takes beside its own."""
    own = [parameter.name for parameter in operation.parameters]
    if "robot" not in own:
        return ()
    allowed = ("xacro_arg", "model") if operation.name in UNEQUIPPED else tuple(option.name for option in ROBOT_OPTIONS)
    return tuple(option for option in ROBOT_OPTIONS if option.name in allowed and option.name not in own)


def operation(name: str) -> Operation:
    """The operation of that name.

    Raises:
        KeyError: there is none.
    """
    return next(item for item in OPERATIONS if item.name == name)
