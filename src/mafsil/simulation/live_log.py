"""The live log of a run: an MCAP file that grows with it, so that a process that is killed loses a moment of it.

Ticks as bytes of one length: messages of protobuf whose numbers stand at fixed places, whole blocks at a time.

A message of doubles alone has the same length for every tick: tags and lengths are constants, and a block of ticks is a
table into which the columns of the arrays are copied. Infinities and NaN are numbers like others.

Reference: https://protobuf.dev/programming-guides/encoding.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.util import find_spec
from math import prod
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import BinaryIO, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, positive, require_kind
from mafsil.errors import FileError, InputError
from mafsil.simulation.mcap_blocks import McapBlocks
from mafsil.version import __version__

Bytes: TypeAlias = NDArray[np.uint8]
Shape: TypeAlias = tuple[int, ...]
MESSAGE = "mafsil.tick"
VARINT, FIXED64, LENGTH = 0, 1, 2
"""Kinds of values on the wire."""
OPTIONAL, REPEATED, DOUBLE = 1, 3, 1
"""Labels and type of fields in a descriptor."""
NUMBER = 8
"""Bytes of a double."""
SUFFIX = ".mcap"
TOPIC = "run"
BEGINS, ENDS = "mafsil.run_begins", "mafsil.run_ends"
"""Names of the metadata records before and after the ticks of a run."""
SHAPES = "shapes"
"""Key in the metadata of a channel: names and shapes of its arrays, in the order of their fields."""
CHECKSUM = "log_checksum"
"""Their key for the checksum of all others: MCAP has none for metadata."""
INTERVAL = 5e-3
"""Real time between two blocks of ticks on their way to the file [s]."""
CHUNK = 1 << 20
"""Bytes of a block from which on it is written in parts."""
NANOSECONDS = 1e9


@runtime_checkable
class RunListener(Protocol):
    """What hears of runs while they go on, as a `LiveLog` does.

    Attributes:
        fault: why it hears no more, or empty.
    """

    fault: str

    def begin(self, metadata: Mapping[str, object]) -> None:
        """A run begins."""

    def is_due(self) -> bool:
        """Whether the next block of ticks should be added."""
        ...

    def add(self, rows: Mapping[str, Floats]) -> None:
        """Ticks of the run."""

    def end(self, metadata: Mapping[str, object]) -> None:
        """The run has ended."""


class LiveLog:
    """A log that runs write while they go on: one message a tick, with all that a recording holds, in protobuf.

    What is older than 5 ms, or than the piece that compiled code is just running, is with the operating system: it
    survives the process, killed or not, but not a power cut, for which every block would have to wait for the disk.
    `Recording.load` reads the file, torn or whole, while the run goes on, too; so do Foxglove and the tools of MCAP
    (https://mcap.dev). Numbers that are not finite are kept as they are. If the disk is full, the run goes on without
    its log and says so.

    Args:
        path: of a file with suffix .mcap; what is there is replaced.
        duration: length of the one motion that all runs of the log make together, one after the other [s]; None for
            runs that have nothing to do with each other.

    Attributes:
        path: of the file.
        fault: why the log ends early, or empty.

    Raises:
        InputError: the package `mcap` is not installed, or the suffix is another.
        FileError: the place cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], duration: float | None = None) -> None:
        place = Path(path)
        if place.suffix != SUFFIX:
            raise InputError("simulation.log_suffix", path=str(path), suffix=SUFFIX)
        if duration is not None:
            positive("duration", duration)
        require_mcap()
        self.path, self.duration, self.fault = place, duration, ""
        self._file = _open(place)
        self._writer: McapBlocks | None = None
        self._channels: dict[tuple[tuple[str, Shape], ...], tuple[int, TickBytes]] = {}
        self._start = self._past = self._due = 0.0
        self._count = 0
        try:
            self._writer = McapBlocks(self._file, f"mafsil {__version__}")
        except OSError as fault:
            self._fail(fault)

    def __enter__(self) -> LiveLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def begin(self, metadata: Mapping[str, object]) -> None:
        """A run begins; in the time of the log it follows the one before.

        Args:
            metadata: what one needs to know of it, as JSON can hold it.
        """
        self._start = self._past
        self._note(BEGINS, {**metadata, "log_start": self._start, "log_duration": self.duration})

    def is_due(self) -> bool:
        """Whether the next block of ticks should be added."""
        return perf_counter() >= self._due

    def add(self, rows: Mapping[str, Floats]) -> None:
        """Ticks of the run.

        Args:
            rows: arrays by name, the ticks first; `t` is among them.
        """
        if self.fault or self._writer is None or not len(rows["t"]):
            return
        times = np.rint((rows["t"] + self._start) * NANOSECONDS).astype(np.int64)
        self._past = self._start + float(rows["t"][-1])
        channel, layout = self._channel_for(rows)
        size = len(layout.template)
        most = max(1, CHUNK // size)
        try:
            for first in range(0, len(times), most):
                part = {name: array[first : first + most] for name, array in rows.items()}
                moments, before = times[first : first + most], self._writer.size
                try:
                    self._writer.block(channel, moments, self._count, size, partial(layout.written, part))
                finally:
                    # Ctrl-C may come in between: what stands in the file counts, and nothing else.
                    self._count += len(moments) if self._writer.size > before else 0
        except OSError as fault:
            self._fail(fault)
        self._due = perf_counter() + INTERVAL

    def end(self, metadata: Mapping[str, object]) -> None:
        """The run has ended.

        Args:
            metadata: its `status`, and what became known of it meanwhile.
        """
        self._note(ENDS, metadata)

    def close(self) -> None:
        """No more runs: the file gets its index."""
        if self._file.closed:
            return
        try:
            if not self.fault and self._writer is not None:
                self._writer.finish()
            self._file.close()
        except OSError as fault:
            self._fail(fault)

    def _note(self, name: str, metadata: Mapping[str, object]) -> None:
        if self.fault or self._writer is None:
            return
        texts = {key: json.dumps(value) for key, value in {**metadata, "log_number": self._next_number()}.items()}
        try:
            self._writer.note(name, texts | {CHECKSUM: checksum(texts)})
        except OSError as fault:
            self._fail(fault)

    def _next_number(self) -> int:
        """The number of the next message or note: where one is missing, the reader sees it."""
        self._count += 1
        return self._count - 1

    def _channel_for(self, rows: Mapping[str, Floats]) -> tuple[int, TickBytes]:
        """The channel of messages with these arrays, and how they are written."""
        shapes = tuple((name, np.shape(array)[1:]) for name, array in rows.items())
        if shapes not in self._channels:
            assert self._writer is not None
            layout = TickBytes(dict(shapes))
            about = {SHAPES: json.dumps(shapes)}
            number = self._writer.channel(TOPIC, MESSAGE, layout.descriptor(), about)
            self._channels[shapes] = number, layout
        return self._channels[shapes]

    def _fail(self, fault: OSError) -> None:
        self.fault = fault.strerror or str(fault)
        with suppress(OSError):
            # What is left in its buffer cannot be written either, which is known by now.
            self._file.close()


@contextmanager
def log_of(log: RunListener | str | os.PathLike[str] | None) -> Generator[RunListener | None]:
    """A log to write to: one that is open stays so, one that is named is closed at the end.

    Args:
        log: open, or its path, or None for none.
    """
    if log is None or isinstance(log, RunListener):
        yield log
        return
    require_kind("log", log, "LiveLog or path", *(() if isinstance(log, str) else ("__fspath__",)))
    with LiveLog(log) as opened:
        yield opened


def checksum(texts: Mapping[str, str]) -> str:
    """Of keys and values.

    Args:
        texts: by key.
    """
    return f"{zlib.crc32(json.dumps(sorted(texts.items())).encode()):08x}"


def require_mcap() -> None:
    """Refuse to go on without the package.

    Raises:
        InputError: `mcap` is not installed.
    """
    if find_spec("mcap") is None:
        raise InputError("simulation.no_mcap")


def _open(place: Path) -> BinaryIO:
    try:
        return place.open("wb")
    except OSError as fault:
        raise FileError("file.cannot_write", path=str(place), reason=fault.strerror or str(fault)) from None


@dataclass(frozen=True, eq=False)
class TickBytes:
    """Where the numbers of arrays stand in the bytes of a tick.

    Attributes:
        shapes: of each array of a tick, by name, in the order of their fields.
    """

    shapes: Mapping[str, Shape]

    @cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """First byte and end of the numbers of each array."""
        found: dict[str, tuple[int, int]] = {}
        at = 0
        for number, (name, shape) in enumerate(self.shapes.items(), 1):
            at += len(_head(number, shape))
            found[name] = at, at + NUMBER * prod(shape)
            at = found[name][1]
        return found

    @cached_property
    def template(self) -> Bytes:
        """(size,) a tick whose numbers are zero."""
        heads = (_head(number, shape) + bytes(NUMBER * prod(shape)) for number, shape in self._number())
        return np.frombuffer(b"".join(heads), dtype=np.uint8)

    def _number(self) -> Iterable[tuple[int, Shape]]:
        return enumerate(self.shapes.values(), 1)

    def written(self, rows: Mapping[str, Floats], into: Bytes) -> None:
        """Put ticks into a table.

        Args:
            rows: arrays by name, (k, *shape) each.
            into: (k, size).
        """
        into[:] = self.template
        for name, (first, end) in self.places.items():
            column = np.ascontiguousarray(rows[name], dtype="<f8")
            into[:, first:end] = column.reshape(len(into), -1).view(np.uint8).reshape(len(into), end - first)

    def read(self, ticks: Bytes) -> dict[str, Floats]:
        """Arrays (k, *shape) by name.

        Args:
            ticks: (k, size).

        Raises:
            ValueError: a tick of another size, or with other fields.
        """
        if ticks.shape[1:] != self.template.shape:
            raise ValueError(f"ticks of {ticks.shape[-1]} bytes instead of {len(self.template)}")
        rest = ticks.copy()
        found: dict[str, Floats] = {}
        for name, (first, end) in self.places.items():
            numbers = np.ascontiguousarray(ticks[:, first:end]).view("<f8").astype(np.float64)
            found[name] = numbers.reshape(len(ticks), *self.shapes[name])
            rest[:, first:end] = 0
        if not (rest == self.template).all():
            raise ValueError("ticks with other fields")
        return found

    def descriptor(self) -> bytes:
        """The message for tools that know nothing of it: a FileDescriptorSet, nested arrays flat in C order."""
        fields = b""
        for number, (name, shape) in enumerate(self.shapes.items(), 1):
            field = _text(1, name) + _whole(3, number) + _whole(4, REPEATED if shape else OPTIONAL)
            fields += _text(2, field + _whole(5, DOUBLE) + _text(10, name))
        package, _, message = MESSAGE.rpartition(".")
        file = _text(1, f"{message}.proto") + _text(2, package) + _text(4, _text(1, message) + fields)
        return _text(1, file + _text(12, "proto3"))


def _head(number: int, shape: Shape) -> bytes:
    """What stands before the numbers of a field: its tag, and how many bytes follow if it is an array."""
    if not shape:
        return _varint(number << 3 | FIXED64)
    return _varint(number << 3 | LENGTH) + _varint(NUMBER * prod(shape))


def _varint(value: int) -> bytes:
    """Seven bits in each byte, the lowest first."""
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*found, value])


def _whole(number: int, value: int) -> bytes:
    return _varint(number << 3 | VARINT) + _varint(value)


def _text(number: int, value: bytes | str) -> bytes:
    """A text, or a message inside another."""
    inside = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | LENGTH) + _varint(len(inside)) + inside
