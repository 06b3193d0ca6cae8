"""States of joints from ROS 2 bags in MCAP: `sensor_msgs/msg/JointState` messages in CDR.

Reference: OMG, DDS-XTypes, section 7.4 (plain CDR): numbers are aligned to their size, sequences begin with a count.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.regular_file import open_regular
from mafsil.simulation.live_log import require_mcap

SCHEMA = "sensor_msgs/msg/JointState"
MOST_MESSAGES = 2_000_000


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
