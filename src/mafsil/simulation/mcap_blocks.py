"""MCAP files written in blocks: messages of one length are a table of bytes, written with its index in one piece.

The package `mcap` writes message by message, 2.7 us each; its records are used here but for messages and their index.

Reference: https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
MAGIC = b"\x89MCAP0\r\n"
MESSAGE_RECORD, INDEX_RECORD, CHUNK_RECORD = 5, 7, 6
HEAD = 9
"""Bytes before the contents of a record: its kind and its length."""
INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])


class McapBlocks:
    """A file that grows block by block.

    Args:
        file: to write to; each block is one call of its `write`, then of `flush`.
        library: who writes.

    Attributes:
        size: of the file so far [bytes].

    Raises:
        OSError: it cannot be written.
    """

    def __init__(self, file: BinaryIO, library: str) -> None:
        from mcap.records import Header, Statistics

        self._file, self.size = file, 0
        self._schemas: list[Any] = []
        self._channels: list[Any] = []
        self._waiting: list[Any] = []
        self._chunks: list[Any] = []
        self._notes: list[Any] = []
        self._statistics = Statistics(
            attachment_count=0, channel_count=0, channel_message_counts={}, chunk_count=0, message_count=0,
            metadata_count=0, message_start_time=0, message_end_time=0, schema_count=0,
        )  # fmt: skip
        self._write(MAGIC + _record(Header("", library)))

    def channel(self, topic: str, name: str, descriptor: bytes, metadata: Mapping[str, str]) -> int:
        """A channel of messages of protobuf; it is written with its first block.

        Args:
            topic: of the messages.
            name, descriptor: of the type of the messages.
            metadata: of the channel.
        """
        from mcap.records import Channel, Schema

        number = len(self._channels) + 1
        self._schemas.append(Schema(id=number, data=descriptor, encoding="protobuf", name=name))
        self._channels.append(
            Channel(id=number, topic=topic, message_encoding="protobuf", schema_id=number, metadata=dict(metadata))
        )
        self._waiting += [self._schemas[-1], self._channels[-1]]
        self._statistics.schema_count = self._statistics.channel_count = number
        return number

    def block(
        self, channel: int, times: NDArray[np.int64], first: int, size: int, fill: Callable[[Bytes], None]
    ) -> None:
        """Messages of one length as a chunk with its index.

        Args:
            channel: their channel.
            times: (k,) of the messages, not decreasing [ns].
            first: number of the first of them.
            size: of each [bytes].
            fill: puts them into a table (k, size).

        Raises:
            OSError: it cannot be written.
        """
        from mcap.records import ChunkIndex

        table = np.zeros(len(times), dtype=_message(size))
        table["kind"], table["length"], table["channel"] = MESSAGE_RECORD, table.dtype.itemsize - HEAD, channel
        table["number"] = np.arange(first, first + len(times))
        table["logged"] = table["published"] = times
        fill(table["data"])
        before = b"".join(map(_record, self._waiting))
        data = before + table.tobytes()
        begin, end = int(times[0]), int(times[-1])
        head = struct.pack("<QQQII", begin, end, len(data), zlib.crc32(data), 0) + struct.pack("<Q", len(data))
        chunk = struct.pack("<BQ", CHUNK_RECORD, len(head) + len(data)) + head + data
        entries = np.empty(len(times), dtype=INDEX_ENTRY)
        entries["time"], entries["offset"] = times, len(before) + table.dtype.itemsize * np.arange(len(times))
        listed = entries.tobytes()
        index = struct.pack("<BQHI", INDEX_RECORD, 6 + len(listed), channel, len(listed)) + listed
        known = ChunkIndex(
            message_start_time=begin, message_end_time=end, chunk_start_offset=self.size, chunk_length=len(chunk),
            message_index_offsets={channel: self.size + len(chunk)}, message_index_length=len(index), compression="",
            compressed_size=len(data), uncompressed_size=len(data),
        )  # fmt: skip
        self._write(chunk + index)
        self._waiting.clear()
        self._chunks.append(known)
        self._count(channel, len(times), begin, end)

    def _count(self, channel: int, messages: int, begin: int, end: int) -> None:
        known = self._statistics
        known.message_start_time = min(begin, known.message_start_time) if known.message_count else begin
        known.message_end_time = max(end, known.message_end_time)
        known.message_count += messages
        known.chunk_count += 1
        known.channel_message_counts[channel] = known.channel_message_counts.get(channel, 0) + messages

    def note(self, name: str, texts: Mapping[str, str]) -> None:
        """A record of metadata.

        Args:
            name: of the record.
            texts: by key.

        Raises:
            OSError: it cannot be written.
        """
        from mcap.records import Metadata, MetadataIndex

        record, at = _record(Metadata(name=name, metadata=dict(texts))), self.size
        self._write(record)
        self._notes.append(MetadataIndex(offset=at, length=len(record), name=name))
        self._statistics.metadata_count += 1

    def finish(self) -> None:
        """The end of the data, the summary and its index.

        Raises:
            OSError: it cannot be written.
        """
        from mcap.opcode import Opcode
        from mcap.records import DataEnd, Footer, SummaryOffset

        self._write(_record(DataEnd(0)))
        begin, summary, offsets = self.size, b"", b""
        groups: list[tuple[Opcode, Sequence[Any]]] = [
            (Opcode.SCHEMA, self._schemas), (Opcode.CHANNEL, self._channels), (Opcode.STATISTICS, [self._statistics]),
            (Opcode.CHUNK_INDEX, self._chunks), (Opcode.METADATA_INDEX, self._notes),
        ]  # fmt: skip
        for kind, records in groups:
            group = b"".join(map(_record, records))
            if group:
                offsets += _record(SummaryOffset(kind, begin + len(summary), len(group)))
            summary += group
        at = begin + len(summary)
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, begin, at)
        checksum = zlib.crc32(summary + offsets + footer)
        self._write(summary + offsets + _record(Footer(begin, at, checksum)) + MAGIC)

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._file.flush()
        self.size += len(data)


def _record(record: Any) -> bytes:
    """A record of the package as bytes."""
    from mcap.data_stream import RecordBuilder

    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def _message(size: int) -> np.dtype[Any]:
    """A message record with so many bytes of data."""
    return np.dtype(
        [
            ("kind", "u1"), ("length", "<u8"), ("channel", "<u2"), ("number", "<u4"), ("logged", "<u8"),
            ("published", "<u8"), ("data", "u1", (size,)),
        ]
    )  # fmt: skip
