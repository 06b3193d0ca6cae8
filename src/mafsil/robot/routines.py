"""The quantities of the catalogue as attributes of a robot: `robot.mass_matrix(q)`.

Type checkers read `routines.pyi` instead, which `docs/make_robot_stub.py` writes from the same rows.
"""

from __future__ import annotations

from inspect import Parameter, Signature
from typing import Any

from mafsil.kernels.lazy import lazy
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.mechanics.quantity import Quantity


class Routine(lazy[Any]):
    """A quantity as an attribute: of a robot its compiled routine, made at the first use; of the class, its words.

    Args:
        row: of the catalogue.
    """

    def __init__(self, row: Quantity) -> None:
        def compute(robot: Any) -> Any:
            return robot.routine(row.name)

        compute.__name__, compute.__doc__ = row.name, row.doc()
        super().__init__(compute)
        self.row = row
        self.__name__ = row.name

    def __call__(self, robot: Any, *arrays: Any, **named: Any) -> Any:
        """`Robot.mass_matrix(robot, q)`, as of any method."""
        return getattr(robot, self.row.name)(*arrays, **named)

    @property
    def __signature__(self) -> Signature:
        own = Parameter("self", Parameter.POSITIONAL_ONLY)
        return Signature([own, *signature_of(self.row).parameters.values()])


class Routines:
    """One attribute for each quantity of the catalogue."""


for _row in CATALOGUE.values():
    setattr(Routines, _row.name, Routine(_row))


def signature_of(row: Quantity) -> Signature:
    """What `inspect.signature` says of a robot's routine: `row.parameters` as an object."""
    named = (*(("frame",) if row.framed else ()), "out", "threads")
    return Signature(
        [
            *(Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in row.inputs),
            *(Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, default=None) for name in row.optional),
            *(Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in named),
            Parameter("degrees", Parameter.KEYWORD_ONLY, default=False),
        ]
    )
