"""Routines of a robot with loops: those of a state are answered where the loops close, the others are refused.

Poses, twists and energies of the links are the same numbers of the tree and of the closed chain, as long as
coordinates, rates and accelerations are those of closed loops. What depends on which joints may move alone (Jacobians,
efforts, masses) is another number in a closed chain, and `mafsil.parallel.ClosedChain` has it.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil import kernels
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.kernels import Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.robot.degrees import evaluate_in_degrees
from mafsil.robot.routines import signature_of

if TYPE_CHECKING:
    import mafsil.mechanics.loop_constraints as loop_constraints
else:
    loop_constraints = lazily("mafsil.mechanics.loop_constraints")

STATES = frozenset(
    {
        "forward_kinematics", "link_poses", "center_of_mass", "potential_energy", "link_twists", "com_twists",
        "kinetic_energy", "centroidal_momentum", "link_accelerations", "com_accelerations", "centroidal_momentum_rate",
    }
)  # fmt: skip
"""Quantities that are the same for the tree and for the closed chain, in one state."""
TYPED = 1e-5
"""Gap of loops over the size of the robot, or share of given rates, that typed digits leave."""


def loop_size(mechanism: Mechanism) -> float:
    """Largest length of a mechanism with loops [m], which gaps are judged over; at least one: they are angles too."""
    places = [joint.T_pj[:3, 3] for joint in (*mechanism.joints, *mechanism.loops)]
    return max(1.0, float(max(np.linalg.norm(place) for place in places)))


class ClosedState:
    """A routine of states with closed loops: others are refused.

    Args:
        mechanism: with loops.
        name: of the quantity.
        routine: of the tree.
    """

    def __init__(self, mechanism: Mechanism, name: str, routine: Any) -> None:
        self.mechanism, self.name, self.routine = mechanism, name, routine
        self.row = quantity(name)
        self.__name__, self.__doc__, self.__signature__ = name, routine.__doc__, signature_of(self.row)

    def __call__(self, *arrays: Any, **named: Any) -> Floats:
        """As the routine.

        Raises:
            InputError: as the routine; coordinates, rates or accelerations that open a loop.
        """
        if named.pop("degrees", False):
            return evaluate_in_degrees(self.mechanism, self.row, self, arrays, named)
        found: Floats = self.routine(*arrays, **named)
        given = dict(zip(self.row.inputs, arrays, strict=False)) | named
        require_closed(self.mechanism, **{name: given[name] for name in self.row.inputs})
        return found

    def __reduce__(self) -> tuple[type[ClosedState], tuple[Any, ...]]:
        return ClosedState, (self.mechanism, self.name, self.routine)


def require_closed(
    mechanism: Mechanism, q: ArrayLike, qd: ArrayLike | None = None, qdd: ArrayLike | None = None
) -> None:
    """Refuse states that open a loop; rows that are NaN pass, as the NaN that they become.

    Args:
        mechanism: with loops.
        q, qd, qdd: (*batch, n) coordinates, rates, accelerations; what is None is not looked at.

    Raises:
        InputError: which of them opens a loop, by how much, and where in the batch.
    """
    still = np.zeros(mechanism.n)
    given = [np.asarray(still if x is None else x, dtype=np.float64) for x in (q, qd, qdd)]
    gap, facing, rate, acceleration = _left_over(mechanism, given)
    size = loop_size(mechanism)
    error = np.where((facing < 0.0).any(axis=-1), np.inf, np.abs(gap).max(axis=-1) / size)
    fast = np.abs(given[1]).max(axis=-1, initial=0.0)
    scales = np.ones(()), size * (1.0 + fast), size * (1.0 + np.abs(given[2]).max(axis=-1, initial=0.0) + fast * fast)
    errors = error, np.abs(rate).max(axis=-1), np.abs(acceleration).max(axis=-1)
    asked = True, qd is not None, qdd is not None
    for name, said, found, scale in zip(("q", "qd", "qdd"), asked, errors, scales, strict=True):
        wrong = np.asarray(said & (found / scale > TYPED))
        if wrong.any():
            index = tuple(int(k) for k in np.argwhere(wrong)[0])
            gap = float(np.broadcast_to(found, wrong.shape)[index])
            raise InputError(f"robot.loops_open_{name}", robot=mechanism.name, row=row_name(index), gap=gap)


def row_name(index: tuple[int, ...]) -> str:
    """`[3, 0]`, the place of a row in a batch; nothing for a single state."""
    return f"[{', '.join(map(str, index))}]" if index else ""


def _left_over(mechanism: Mechanism, given: list[Floats]) -> list[Floats]:
    """Gaps, facing, and what rates and accelerations open; without moving joints they are constants."""
    if mechanism.n:
        return [np.asarray(x) for x in _kernel(mechanism).evaluate(*given)]
    return [np.array([float(x) for x in column]) for column in _errors(mechanism).outputs]


@lru_cache(maxsize=32)
def _kernel(mechanism: Mechanism) -> kernels.Kernel:
    n = mechanism.n
    m = sum(loop_constraints.rows_of(joint) for joint in mechanism.loops)
    inputs = tuple(Port(name, (n,)) for name in ("q", "qd", "qdd"))
    shapes = {"gap": (m,), "facing": (len(mechanism.loops),), "rate": (m,), "acceleration": (m,)}
    return kernels.compile(
        Signature("loop_errors", inputs, tuple(Port(name, shape) for name, shape in shapes.items())),
        partial(_errors, mechanism),
        key=f"loop_errors {fingerprint(mechanism)}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


def _errors(mechanism: Mechanism) -> Any:
    return loop_constraints.errors_function(mechanism)
