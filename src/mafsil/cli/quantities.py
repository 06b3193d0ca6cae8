"""Quantities of the catalogue at one state, asked for by name: values for machines, lines for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.table import matrix, number
from mafsil.mechanics.catalogue import quantity
from mafsil.messages import say
from mafsil.robot import Robot


def quantity_values(arm: Robot, names: Sequence[str], state: Mapping[str, Floats]) -> dict[str, Floats]:
    """The named quantities at a state; framed ones belong to the tip.

    Args:
        arm: the robot.
        names: of the catalogue.
        state: q, qd, qdd, tau.

    Raises:
        InputError: no such quantity; the sentence lists what there is.
    """
    rows = [quantity(name) for name in dict.fromkeys(names)]
    return {row.name: np.asarray(arm.routine(row.name)(*(state[name] for name in row.inputs))) for row in rows}


def quantity_lines(values: Mapping[str, Floats]) -> list[str]:
    """Symbol, title and unit, then the numbers; of arrays with three indices one matrix for each first index.

    Args:
        values: of quantities by their names.
    """
    lines: list[str] = []
    for name, value in values.items():
        row = quantity(name)
        lines += ["", say("cli.quantity_title", name=name, symbol=row.symbol, title=row.title, unit=row.unit)]
        if not value.ndim:
            lines.append("  " + number(float(value)))
        elif value.ndim < 3:
            lines += matrix(np.atleast_2d(value))
        else:
            for index in np.ndindex(value.shape[:-2]):
                lines += [f"  {list(index)}", *matrix(value[index])]
    return lines
