"""Motions over time printed: how they ended, and a row for each joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.messages.tables import joint_units, number, table


def joint_table(title: str, names: Sequence[str], q: Floats, peaks: dict[str, Floats]) -> str:
    """A sentence and a table: start, end and largest magnitudes of each joint, over a whole batch.

    Args:
        title: the sentence.
        names: (n,) of the joints.
        q: (k, *batch, n) positions [rad | m].
        peaks: (k, *batch, n) quantities, by the name of their column in the messages.
    """
    n = len(names)
    if not q.size:
        return title
    columns = [_largest(q[0].reshape(-1, n)), _largest(q[-1].reshape(-1, n))]
    columns += [np.abs(values).reshape(-1, n).max(axis=0) for values in peaks.values()]
    rows = [[name, *(number(float(x)) for x in row)] for name, *row in zip(names, *columns, strict=True)]
    names = ("joint", "start", "end", *peaks)
    head = [say(f"simulation.column_{name}") for name in names]
    return "\n".join([title, *table(head, rows, units=joint_units(names))])


def _largest(values: Floats) -> Floats:
    """(n,) of values (batch, n) those of largest magnitude, with their sign."""
    return np.take_along_axis(values, np.abs(values).argmax(axis=0)[None], axis=0)[0]
