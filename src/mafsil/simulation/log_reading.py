"""Logs read back: runs of this package, whole or torn at their end, and states of joints from ROS 2 bags.

Of a torn log all is read that stands before the tear. Bags are MCAP with `sensor_msgs/msg/JointState` messages in CDR.

Reference: OMG, DDS-XTypes, section 7.4 (plain CDR): numbers are aligned to their size, sequences begin with a count.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, BinaryIO, NamedTuple, cast

import msgspec
import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.regular_file import open_regular
from mafsil.simulation.live_log import BEGINS, CHECKSUM, ENDS, SHAPES, TOPIC, TickBytes, checksum, require_mcap

if TYPE_CHECKING:
    from mcap.records import Chunk, McapRecord


SCHEMA = "sensor_msgs/msg/JointState"
MOST_MESSAGES = 2_000_000
BLOCK = 1024
"""Ticks that are held as bytes until they become arrays."""
MAGIC_SIZE = 8


@dataclass(slots=True)
class LoggedRun:
    """One run of a log.

    Attributes:
        metadata: of its beginning, and of its end if it came to one.
        ended: whether it did.
        blocks: arrays by name, in order.
    """

    metadata: dict[str, Any]
    ended: bool = False
    blocks: list[dict[str, Floats]] = field(default_factory=list[dict[str, Floats]])

    def rows(self) -> dict[str, Floats]:
        """Arrays by name, the ticks first."""
        names = self.blocks[0] if self.blocks else {}
        joined = {name: np.concatenate([block[name] for block in self.blocks]) for name in names}
        if not joined:
            return {}
        # A run that Ctrl-C met while it wrote may have written a block again.
        _, fresh = np.unique(joined["t"], return_index=True)
        return {name: array[fresh] for name, array in joined.items()}


class ForeignLogError(ValueError):
    """The file is sound, but holds something else than runs of ours."""


def logged_runs(path: Path) -> list[LoggedRun]:
    """The runs of a log that have ticks, one after the other, as far as the file holds them.

    1. Records are read in order until the file ends or makes no sense: a record longer than the file, a wrong
       checksum, a number that is missing in the count of ticks and notes.
    2. Metadata begin and end runs; the messages of every chunk are their ticks.

    Args:
        path: of the file.

    Raises:
        InputError: the package `mcap` is not installed.
        FileError: there is no such file, or it is no log of runs.
    """
    require_mcap()
    from mcap.exceptions import InvalidMagic
    from mcap.records import Chunk, Metadata

    reading = _Reading()
    try:
        for record in _records(path):
            if isinstance(record, Metadata) and record.name in (BEGINS, ENDS):
                reading.note(record.name, record.metadata)
            elif isinstance(record, Chunk):
                reading.unpack(record)
            if reading.torn:
                break
        reading.close_block()
    except FileNotFoundError:
        raise FileError("simulation.no_file", path=str(path)) from None
    except (OSError, InvalidMagic) as fault:
        raise FileError("simulation.bad_file", path=str(path), fault=str(fault)) from None
    except ForeignLogError as fault:
        raise FileError("simulation.foreign_log", path=str(path), fault=str(fault)) from None
    runs = [run for run in reading.runs if run.blocks]
    if not runs:
        raise FileError("simulation.empty_log", path=str(path))
    return runs


def _records(path: Path) -> Iterator[McapRecord]:
    """All records before the tear, if there is one."""
    from mcap.exceptions import InvalidMagic, McapError
    from mcap.stream_reader import StreamReader

    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        try:
            stream = cast("BinaryIO", _Until(file, size))
            yield from StreamReader(stream, emit_chunks=True, record_size_limit=size).records
        except InvalidMagic:
            if file.tell() <= MAGIC_SIZE:
                raise
        except (McapError, struct.error, UnicodeDecodeError, OverflowError, MemoryError):
            return


class _Until:
    """A file as long as it is now: a run that goes on may write faster than its log is read."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file, self._left = file, size

    def read(self, size: int = -1) -> bytes:
        data = self._file.read(self._left if size < 0 else min(size, self._left))
        self._left -= len(data)
        return data


class _Reading:
    """What has been read so far."""

    def __init__(self) -> None:
        self.runs: list[LoggedRun] = []
        self.torn = False
        self._ours: dict[int, TickBytes] = {}
        self._ticks: list[bytes] = []
        self._layout: TickBytes | None = None
        self._count = 0

    def note(self, name: str, metadata: Mapping[str, str]) -> None:
        """A metadata record of ours."""
        self.close_block()
        texts = dict(metadata)
        if texts.pop(CHECKSUM, None) != checksum(texts):
            self.torn = True
            return
        values: dict[str, Any] = {key: json.loads(text) for key, text in texts.items()}
        if not self._follows(values.pop("log_number", None)):
            return
        if name == BEGINS:
            self.runs.append(LoggedRun(values))
        elif self.runs:
            self.runs[-1].metadata |= values
            self.runs[-1].ended = True

    def unpack(self, chunk: Chunk) -> None:
        """A chunk: channels, of which others than ours may stand beside it, and messages."""
        from mcap.exceptions import McapError
        from mcap.records import Channel, Message
        from mcap.stream_reader import breakup_chunk

        if chunk.compression:
            raise ForeignLogError(f"compression {chunk.compression}")
        try:
            records = breakup_chunk(chunk, validate_crc=True)
        except (McapError, struct.error, ValueError, OverflowError, MemoryError):
            self.torn = True
            return
        for record in records:
            if isinstance(record, Channel) and record.topic == TOPIC and SHAPES in record.metadata:
                self._ours[record.id] = _layout(record.metadata[SHAPES])
            elif isinstance(record, Message) and record.channel_id in self._ours and self._follows(record.sequence):
                self._take(record.data, self._ours[record.channel_id])

    def _follows(self, number: object) -> bool:
        """Whether nothing is missing before a tick or note of this number."""
        self.torn = self.torn or number != self._count
        self._count += 1
        return not self.torn

    def _take(self, tick: bytes, layout: TickBytes) -> None:
        if not self.runs:
            raise ForeignLogError("messages before a run")
        if len(tick) != len(layout.template):
            raise ForeignLogError(f"a message of {len(tick)} bytes instead of {len(layout.template)}")
        if layout is not self._layout:
            self.close_block()
        self._layout = layout
        self._ticks.append(tick)
        if len(self._ticks) >= BLOCK:
            self.close_block()

    def close_block(self) -> None:
        """The ticks held as bytes become arrays."""
        if not self._ticks or self._layout is None:
            return
        table = np.frombuffer(b"".join(self._ticks), dtype=np.uint8).reshape(len(self._ticks), -1)
        try:
            block = self._layout.read(table)
        except ValueError as fault:
            raise ForeignLogError(str(fault)) from None
        before = self.runs[-1].blocks
        if before and _shapes(before[0]) != _shapes(block):
            raise ForeignLogError("ticks of different shapes")
        before.append(block)
        self._ticks = []


def _layout(text: str) -> TickBytes:
    """Where the numbers of a channel's messages stand, from its metadata."""
    try:
        shapes = msgspec.json.decode(text, type=list[tuple[str, tuple[Annotated[int, msgspec.Meta(ge=0)], ...]]])
    except (msgspec.DecodeError, msgspec.ValidationError) as fault:
        raise ForeignLogError(str(fault)) from None
    if "t" not in dict(shapes) or dict(shapes)["t"]:
        raise ForeignLogError("messages without t")
    return TickBytes(dict(shapes))


def _shapes(block: Mapping[str, Floats]) -> dict[str, tuple[int, ...]]:
    return {name: array.shape[1:] for name, array in block.items()}


class JointStates(NamedTuple):
    """What a bag says of some joints.

    Attributes:
        t: (k,) times of the stamps, increasing [s].
        q: (k, n) positions [rad | m].
        efforts: (k, n) [N m | N]; None where no message has any.
    """

    t: Floats
    q: Floats
    efforts: Floats | None


def joint_states(path: Path, joints: tuple[str, ...]) -> JointStates:
    """The states of joints in a bag, messages without them left out.

    Args:
        path: of the MCAP file.
        joints: their names.

    Raises:
        InputError: the package `mcap` is not installed.
        FileError: there is no such file, it is no MCAP file or damaged, or no message has all the joints.
    """
    require_mcap()
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    rows = list[tuple[float, list[float], list[float]]]()
    try:
        with open_regular(path) as file:
            for schema, channel, message in make_reader(file).iter_messages():
                if schema is None or schema.name != SCHEMA or channel.message_encoding != "cdr":
                    continue
                time, names, position, effort = _state(message.data)
                if set(joints) <= set(names) and len(position) == len(names):
                    order = [names.index(joint) for joint in joints]
                    loads = effort if len(effort) == len(names) else (0.0,) * len(names)
                    rows.append((time, [position[k] for k in order], [loads[k] for k in order]))
                if len(rows) > MOST_MESSAGES:
                    raise FileError("simulation.bag_long", path=str(path), most=MOST_MESSAGES)
    except FileNotFoundError:
        raise FileError("simulation.no_file", path=str(path)) from None
    except (OSError, McapError, struct.error, UnicodeDecodeError) as fault:
        raise FileError("simulation.bad_file", path=str(path), fault=str(fault)) from None
    if not rows:
        raise FileError("simulation.bag_joints", path=str(path), joints=", ".join(joints), schema=SCHEMA)
    times, q, efforts = (np.array([row[k] for row in rows]) for k in (0, 1, 2))
    t, first = np.unique(times, return_index=True)
    return JointStates(t, q[first], efforts[first] if efforts.any() else None)


def _state(data: bytes) -> tuple[float, list[str], tuple[float, ...], tuple[float, ...]]:
    """Time of the stamp [s], names, positions and efforts of a message."""
    cdr = _Cdr(data)
    seconds, nanoseconds = cdr.numbers("i", 1)[0], cdr.numbers("I", 1)[0]
    cdr.text()
    names = [cdr.text() for _ in range(cdr.count())]
    position, _, effort = (cdr.numbers("d", cdr.count()) for _ in range(3))
    return seconds + 1e-9 * nanoseconds, names, position, effort


class _Cdr:
    """A message from its beginning on.

    Args:
        data: with the four bytes that say its byte order.
    """

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data[4:], 0
        self._order = "<" if len(data) > 1 and data[1] & 1 else ">"

    def numbers(self, kind: str, count: int) -> tuple[float, ...]:
        """So many numbers of a kind of `struct`."""
        size = struct.calcsize(kind)
        if count:
            self._place += -self._place % size
        found = struct.unpack_from(f"{self._order}{count}{kind}", self._data, self._place)
        self._place += count * size
        return found

    def count(self) -> int:
        """Of what follows: never more than there are bytes left."""
        count = int(self.numbers("I", 1)[0])
        if count > len(self._data) - self._place:
            raise struct.error(f"{count} > {len(self._data) - self._place}")
        return count

    def text(self) -> str:
        """A string without its last zero."""
        size = self.count()
        self._place += size
        return self._data[self._place - size : self._place].rstrip(b"\0").decode()
