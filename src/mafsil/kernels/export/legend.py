"""What an exported file says of itself, and names that every C compiler and every linker takes."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from textwrap import wrap

from mafsil.errors import InputError
from mafsil.kernels.identifiers import identifier
from mafsil.kernels.layout import Port, Signature

KEYWORDS = frozenset((
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short", "signed",
    "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile", "while", "bool",
    "true", "false", "and", "or", "not", "xor", "class", "new", "delete", "this", "template", "operator",
    "private", "public", "protected", "namespace", "using",
))  # fmt: skip
_HARMLESS = frozenset(" .,;:()[]{}<>=+-_'!|^%&@#~$")


@dataclass(frozen=True)
class Legend:
    """Words for people, none of which a compiler may stumble over.

    Attributes:
        owner: whose quantity it is, such as the robot's name; any text.
        title: what is computed.
        ports: for a port's name, its meaning, unit and frame.
    """

    owner: str
    title: str
    ports: Mapping[str, str] = field(default_factory=dict[str, str])

    def lines(self, signature: Signature) -> list[str]:
        """The text of a header's comment, every character harmless."""
        found = [f"{harmless(self.owner)}: {harmless(self.title)}", ""]
        for side, ports in (("in", signature.inputs), ("out", signature.outputs)):
            for port in ports:
                words = harmless(self.ports.get(port.name, ""))
                found += wrap_text(f"{side:3} {port_name(port)}{_shape(port)}: {words}".rstrip(": "), "      ")
        found += ["", "Matrices are stored row by row. SI units, radians; a twist is (omega, v), a wrench (m, f)."]
        return [*found, "You may use this file as you like."]


def wrap_text(text: str, indent: str = "") -> list[str]:
    """Lines of at most 110 characters."""
    return wrap(text, 110, subsequent_indent=indent) or [""]


def harmless(text: str) -> str:
    """Text for a comment in any language: letters, digits and plain signs stay; what could end it or hide it goes."""
    kept = "".join(c if c in _HARMLESS or _is_letter(c) else "_" for c in text[:400])
    return " ".join(kept.split())


def symbol(owner: str, quantity: str, given: str | None = None) -> str:
    """Name of the exported function: the given one if C takes it, else made from owner and quantity.

    Raises:
        InputError: the given name is no C identifier, a keyword or reserved.
    """
    if given is None:
        return f"{identifier(owner)}_{identifier(quantity)}"
    name = str(given)
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) or name in KEYWORDS or name == "main":
        raise InputError("export.name", name=given)
    return given


def port_name(port: Port) -> str:
    """The parameter's name in C."""
    name = identifier(port.name) if not port.name.isidentifier() or not port.name.isascii() else port.name
    return f"{name}_" if name in KEYWORDS or re.fullmatch(r"t\d+|_.*", name) else name


def _shape(port: Port) -> str:
    return "".join(f"[{size}]" for size in port.shape) or "[1]"


def _is_letter(character: str) -> bool:
    if character.isascii():
        return character.isalnum()
    return unicodedata.category(character)[0] in "LMN" and ord(character) < 0x10000
