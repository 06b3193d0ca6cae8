"""Robots with loops on the command line: numbers of the closed chain, or none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.arrays import Floats, JointVector
from mafsil.errors import InputError, ModelError
from mafsil.lazy_module import lazily
from mafsil.model import Mechanism
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.parallel as parallel
    from mafsil.parallel import ClosedChain
else:
    parallel = lazily("mafsil.parallel")

TYPED = 1e-5
"""Gap of loops over the size of the robot that typed digits leave."""


def require_open_chain(mechanism: Mechanism, command: str) -> None:
    """Refuse a robot with loops where only numbers of its open tree are known.

    Args:
        mechanism: any.
        command: that was typed.

    Raises:
        ModelError: it has loops.
    """
    if mechanism.loops:
        raise ModelError("cli.loops_open", robot=mechanism.name, command=command)


def chain_at(arm: Robot, q: JointVector) -> ClosedChain:
    """The closed chain of a robot with loops, where they are closed.

    Args:
        arm: with loops.
        q: (n,) coordinates.

    Raises:
        InputError: they leave a loop open.
    """
    chain = parallel.ClosedChain(arm)
    gap = float(chain.error(q))
    if gap <= TYPED * chain.size:
        return chain
    nearest = chain.close_loops(q, hold=chain.actuated) if len(chain.actuated) else chain.close_loops(q)
    nearest = nearest if nearest else chain.close_loops(q)
    if not nearest:
        raise InputError("cli.loops_never", robot=arm.name, gap=gap)
    raise InputError("cli.loops_gape", robot=arm.name, gap=gap, values=parse_numbers(nearest.q))


def parse_numbers(values: Floats) -> str:
    """Numbers as they may be typed."""
    return " ".join(f"{round(float(x), 9) + 0.0:.7g}" for x in values)
