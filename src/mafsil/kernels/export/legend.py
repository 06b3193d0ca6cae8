"""What travels with exported code: what a file says of itself and its names, and stored inputs and outputs.

Names are such as every C compiler and every linker takes. The stored outputs say how far the exported code may be from
them; they come from the expression of the kernel as it is exported (`tapes`).
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.kernels import cache, compiler
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.layout import Port, Signature, identifier
from mafsil.kernels.reduce import reduce
from mafsil.kernels.reference import evaluate
from mafsil.kernels.tape import Tape, from_text, read

ROWS = 8
LIMIT = 64.0
"""Units in the last place of the natural scale: what other sines, compilers and orders of rounding may change."""
_REACH = 3.0
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


@dataclass(frozen=True)
class Vectors:
    """Rows of numbers, port after port.

    Attributes:
        inputs: (rows, elements) for each input port.
        outputs: (rows, elements) for each output port, from the kernel on this processor.
        units: (rows, elements), one unit in the last place of the natural scale of each output.
    """

    inputs: tuple[Floats, ...]
    outputs: tuple[Floats, ...]
    units: tuple[Floats, ...]

    @property
    def rows(self) -> int:
        """How many evaluations."""
        return len(self.outputs[0])


def vectors(kernel: Callable[..., Any], tape: Tape, signature: Signature, *, single: bool = False) -> Vectors:
    """The zero state and others spread over -3..3, with what the kernel answers.

    Args:
        kernel: evaluates batches.
        tape: the same quantity, for the natural scale of every number.
        signature: ports.
        single: inputs and units of float32 numbers.
    """
    inputs = tuple(_spread(signature, single))
    shaped = [x.reshape(ROWS, *port.shape) for x, port in zip(inputs, signature.inputs, strict=True)]
    answer: Any = kernel(*shaped)
    answers = cast("tuple[Any, ...]", answer) if isinstance(answer, tuple) else (answer,)
    outputs = tuple(np.asarray(y, dtype=np.float64).reshape(ROWS, -1) for y in answers)
    scales = [scale for _, scale in evaluate(tape, inputs)]
    return Vectors(inputs, outputs, tuple(_unit(y, s, single) for y, s in zip(outputs, scales, strict=True)))


def _spread(signature: Signature, single: bool) -> list[Floats]:
    count = ROWS * sum(port.size for port in signature.inputs)
    numbers: Floats = (np.arange(1, count + 1, dtype=np.float64) * 0.6180339887498949 % 1.0 * 2.0 - 1.0) * _REACH
    found: list[Floats] = []
    for port in signature.inputs:
        rows, numbers = numbers[: ROWS * port.size].reshape(ROWS, port.size).copy(), numbers[ROWS * port.size :]
        rows[0] = 0.0
        found.append(rows.astype(np.float32).astype(np.float64) if single else rows)
    return found


def _unit(values: Floats, scales: Floats, single: bool) -> Floats:
    size = np.maximum(np.abs(values), np.where(np.isfinite(scales), scales, 0.0))
    size = np.where(np.isfinite(size), size, 1.0)
    return np.spacing(size.astype(np.float32)).astype(np.float64) if single else np.spacing(size)


def tapes(kernel: Kernel) -> tuple[Tape, Tape]:
    """The kernel's expression as it is traced, and reduced as it is compiled."""
    tape = read(kernel.build())
    return tape, reduce(tape)


def reduced_tape(kernel: Kernel) -> Tape:
    """The kernel's reduced expression, from the store where it was traced before."""
    return from_text(compiler.tape_text(kernel.order(cache.default())))
