"""The binary interface of a kernel: ports, their core shapes, and the names of the compiled entry points.

A name that every C compiler and every linker takes can be made from any text (`identifier`).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from hashlib import blake2b
from math import prod

_LONGEST = 31
"""C99 promises so many significant characters of an external name."""
BATCH = "mafsil_batch"
"""Symbol of the batch entry, a gufunc inner loop: void (char **args, npy_intp *dims, npy_intp *steps, void *data)."""
SINGLE = "mafsil_single"
"""Symbol of the single entry: void (double *in0, ..., double *out0, ...), one evaluation on contiguous ports."""
LANES = "mafsil_lanes"
"""Symbol of the entry for LANE_COUNT rows side by side: void (double *in, double *out0, ...), element e of row l at
place e LANE_COUNT + l; the inputs lie one after another. Every array begins at a multiple of 64 bytes."""
LANE_COUNT = 8
"""Rows of the LANES entry, whatever the width of the processor's vectors."""
LOOP = "mafsil_loop"
"""Symbol of the batch entry inside a standard floating-point environment, for NumPy."""
ALONE = "mafsil_alone"
"""Symbol of the place where the batch entry looks for the single entry, to which it leaves one row; null: not there."""


@dataclass(frozen=True)
class Port:
    """A named input or output and its core shape, elements in C order; shape () is one number."""

    name: str
    shape: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """Number of elements."""
        return prod(self.shape)


@dataclass(frozen=True)
class Signature:
    """What a kernel takes and gives: its name, its input ports and its output ports.

    Attributes:
        name: of the quantity.
        inputs, outputs: the ports.
        finite: finite inputs have finite results, unless numbers overflow: a call at one point then raises.
    """

    name: str
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    finite: bool = False

    @property
    def ports(self) -> tuple[Port, ...]:
        """Inputs, then outputs: the order of the arguments in both entries."""
        return self.inputs + self.outputs

    @property
    def gufunc(self) -> str:
        """Signature in NumPy's language, every core size frozen, such as `(7),(7)->(4,4)`."""
        return _cores(self.inputs) + "->" + _cores(self.outputs)

    @property
    def core_steps(self) -> tuple[int, ...]:
        """For every port, the index in `steps` where its core strides begin (after one outer stride per port)."""
        first = len(self.ports)
        starts: list[int] = []
        for port in self.ports:
            starts.append(first)
            first += len(port.shape)
        return tuple(starts)


def contiguous_steps(port: Port, itemsize: int = 8) -> tuple[int, ...]:
    """Core strides in bytes of a C-contiguous port."""
    steps: list[int] = []
    for size in reversed(port.shape):
        steps.append(itemsize)
        itemsize *= size
    return tuple(reversed(steps))


def _cores(ports: tuple[Port, ...]) -> str:
    return ",".join("(" + ",".join(map(str, port.shape)) + ")" for port in ports)


def identifier(text: str) -> str:
    """A C identifier that reminds of the text; letters of other scripts become a short hash."""
    slug = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    if not text.isascii() or not slug or len(slug) > _LONGEST:
        slug = (
            f"{slug[:20].strip('_') or 'robot'}_{blake2b(text.encode('utf-8', 'replace'), digest_size=3).hexdigest()}"
        )
    return slug if slug[0].isalpha() else f"r{slug}"
