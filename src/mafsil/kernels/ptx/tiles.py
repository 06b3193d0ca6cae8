"""How a block of threads moves rows of ports through the memory it shares, so that every transfer is contiguous."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.kernels.layout import Port, Signature

SHARED_BYTES = 48 * 1024
"""What every CUDA device gives a block without being asked."""
THREADS = (128, 64, 32)
"""Threads of a block, one row each; fewer where the rows are long."""


@dataclass(frozen=True)
class Tile:
    """Where a port's rows lie in shared memory.

    Attributes:
        port: the port.
        first: index of its first number, or None if its rows are too long and stay where they are.
        stride: numbers from row to row; odd, so that the threads of a block use different banks.
    """

    port: Port
    first: int | None
    stride: int


@dataclass(frozen=True)
class Plan:
    """The rows of a block.

    Attributes:
        threads: threads of a block; thread k computes row k.
        tiles: one for each port, inputs first.
        size: numbers in shared memory.
    """

    threads: int
    tiles: tuple[Tile, ...]
    size: int

    def blocks(self, rows: int) -> int:
        """How many blocks a batch takes."""
        return -(-rows // self.threads)


def plan(signature: Signature) -> Plan:
    """The widest block whose ports fit into shared memory; where none does, the longest rows stay out of it."""
    for threads in THREADS:
        found = _laid_out(signature.ports, signature.ports, threads)
        if 8 * found.size <= SHARED_BYTES:
            return found
    threads = THREADS[1]
    staged = sorted(signature.ports, key=lambda port: port.size)
    while 8 * (found := _laid_out(signature.ports, staged, threads)).size > SHARED_BYTES:
        staged.pop()
    return found


def _laid_out(ports: tuple[Port, ...], staged: tuple[Port, ...] | list[Port], threads: int) -> Plan:
    tiles: list[Tile] = []
    size = 0
    for port in ports:
        stride = port.size | 1
        inside = any(port is other for other in staged)
        tiles.append(Tile(port, size if inside else None, stride))
        size += threads * stride if inside else 0
    return Plan(threads, tuple(tiles), size)
