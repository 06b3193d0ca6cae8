"""What a quantity of a robot is: its row, which names its inputs, result, units and frame, and its two methods.

A row stands in the file of its builder, in `mechanics/quantities`. What follows from it: the robot's routine with its
signature and documentation, its stub for type checkers, export, the tables of the documentation, verification by a
second method and against the natural size.

Random states of a robot: positions within its limits, rates, loads and wrenches of its natural size.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields
from importlib import import_module
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.mechanics.arm_size import RATE, TRAVEL, ArmSize
from mafsil.model import JointKind, Mechanism

if TYPE_CHECKING:
    from mafsil.expression import Expression
    from mafsil.mechanics.textbook import Textbook


INPUTS: Mapping[str, tuple[str | int, ...]] = MappingProxyType(
    {
        "q": ("n",),
        "qd": ("n",),
        "qdd": ("n",),
        "tau": ("n",),
        "tip_wrench": (6,),
        "base_twist": (6,),
        "base_acceleration": (6,),
    }
)
"""Core shapes of all inputs; `n` is the number of joint coordinates."""
INPUT_TEXTS: Mapping[str, str] = MappingProxyType(
    {
        "q": "(*batch, n) joint coordinates [rad | m].",
        "qd": "(*batch, n) joint rates [rad/s | m/s].",
        "qdd": "(*batch, n) joint accelerations [rad/s^2 | m/s^2].",
        "tau": "(*batch, n) joint efforts [N m | N].",
        "tip_wrench": "(*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.",
        "base_twist": "(*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.",
        "base_acceleration": "(*batch, 6) time derivative of the base's twist, without gravity; optional.",
        "frame": "name of the link whose frame is meant; the tip frame if None.",
        "degrees": "joint coordinates, rates and accelerations are given in degrees; all else stays SI.",
    }
)
LYNCH = "Lynch & Park, Modern Robotics, "
FEATHERSTONE = "Featherstone, Rigid Body Dynamics Algorithms, "


@dataclass(frozen=True, slots=True)
class SecondMethod:
    """An independent way to the same number, which shares nothing with the builder: what verification compares.

    Attributes:
        key: of the sentence that says how, in the area `verification` of the messages.
        value: the number (b, *shape) for the states (b, ...) of a `Textbook`'s mechanism.
    """

    key: str
    value: Callable[[Textbook, States], Floats]


@dataclass(frozen=True, slots=True)
class Beside:
    """Another builder of the same result, shorter where certain quantities are computed at the same time.

    Attributes:
        others: their names.
        builder: shares their sweep.
    """

    others: tuple[str, ...]
    builder: Callable[..., Expression]


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """One row of the catalogue; a row that lacks one of the first ten attributes is refused when its file is imported.

    All arguments take batches: their axes stand before the core shapes of `gufunc`, and broadcast.

    Attributes:
        name: the public name, also of the routine of Robot.
        symbol: as in the field's texts.
        title: one sentence.
        builder: (tree, *inputs, *optional[, frame]) -> expression; it takes None for optional inputs that are left out.
        inputs: names from INPUTS, in order.
        shape: core shape of the result; `n` joints, `L` links.
        unit: of the result.
        reference: where the algorithm stands in the literature.
        size: natural size of every entry for an arm, broadcast to the core shape: errors are relative to it.
        second: an independent method.
        optional: further inputs that may be left out.
        framed: whether the result belongs to a frame that the caller may choose.
        expressed_in: the frame in which the result is expressed, if it has one.
        regrouped: whether the tree with regrouped inertias gives the same result (and a shorter expression).
        needs_mass: whether it is refused for a robot without any mass, where zeros would look like an answer.
        needs_joints: whether a robot without joints has no such quantity.
        solves_mass_matrix: whether the mass matrix is solved with, which may be singular.
        beside: another builder, for some other quantities computed at the same time.
    """

    name: str
    symbol: str
    title: str
    builder: Callable[..., Expression]
    inputs: tuple[str, ...]
    shape: tuple[str | int, ...]
    unit: str
    reference: str
    size: Callable[[ArmSize], Floats]
    second: SecondMethod
    optional: tuple[str, ...] = ()
    framed: bool = False
    expressed_in: str = ""
    regrouped: bool = True
    needs_mass: bool = False
    needs_joints: bool = True
    solves_mass_matrix: bool = False
    beside: Beside | None = None

    def __post_init__(self) -> None:
        for name in (*self.inputs, *self.optional):
            if name not in INPUTS:
                raise InputError("input.choice", name=f"input of {self.name}", value=name, known=", ".join(INPUTS))

    @property
    def home(self) -> str:
        """Dotted name of the module that holds the row."""
        return self.builder.home if isinstance(self.builder, Deferred) else self.builder.__module__

    @property
    def gufunc(self) -> str:
        """Core shapes, such as `(n),(n)->(n,n)`; the axes of the batch stand before them."""
        cores = [f"({','.join(map(str, INPUTS[name]))})" for name in self.inputs]
        return f"{','.join(cores)}->({','.join(map(str, self.shape))})"

    @property
    def parameters(self) -> str:
        """Arguments of the robot's routine, as Python writes them."""
        optional = [f"{name}=None" for name in self.optional]
        named = [f"{name}=None" for name in (*(("frame",) if self.framed else ()), "out", "threads")]
        return f"({', '.join((*self.inputs, *optional, '*', *named, 'degrees=False'))})"

    @property
    def is_joint_motion(self) -> bool:
        """Whether the result is a vector of joint coordinates or of their time derivatives."""
        return self.shape == ("n",) and self.unit.startswith("rad")

    def chosen_builder(self, others: Collection[str] = ()) -> Callable[..., Expression]:
        """The builder.

        Args:
            others: names of quantities that are computed at the same time.
        """
        beside = self.beside
        return beside.builder if beside and any(name in others for name in beside.others) else self.builder

    def doc(self) -> str:
        """Documentation of the quantity as a routine of a robot: arguments, result, reference."""
        names = (*self.inputs, *self.optional, *(("frame",) if self.framed else ()))
        arguments = "\n".join(f"    {name}: {INPUT_TEXTS[name]}" for name in names)
        shape = "".join(f", {size}" for size in self.shape)
        frame = f", expressed in {self.expressed_in}" if self.expressed_in else ""
        return (
            f"{self.title}\n\nArgs:\n{arguments}\n    out: array for the result.\n"
            "    threads: how many threads share a large batch; all cores if None.\n"
            f"    degrees: {INPUT_TEXTS['degrees']}\n\n"
            f"Returns:\n    {self.symbol} (*batch{shape}) [{self.unit}]{frame}.\n\nRaises:\n"
            "    InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.\n\n"
            f"Reference: {self.reference}"
        )

    def record(self) -> dict[str, Any]:
        """The row without its functions, as plain data."""
        plain = {field.name: getattr(self, field.name) for field in fields(self) if field.name not in _FUNCTIONS}
        beside = None if self.beside is None else list(self.beside.others)
        return plain | {"home": self.home, "second": self.second.key, "beside": beside}

    @classmethod
    def of_record(cls, record: dict[str, Any]) -> Self:
        """The row of a record; its functions are found when they are called."""
        plain: dict[str, Any] = {
            name: tuple(cast("list[Any]", x)) if isinstance(x, list) else x for name, x in record.items()
        }
        home, key, others = plain.pop("home"), plain.pop("second"), plain.pop("beside")
        plain["name"] = sys.intern(plain["name"])  # as a name in code is: attributes are found by identity
        later = {part: Deferred(home, plain["name"], part) for part in _FUNCTIONS}
        second = SecondMethod(key, later["second"])
        beside = None if others is None else Beside(others, later["beside"])
        return cls(**plain, builder=later["builder"], size=later["size"], second=second, beside=beside)


_FUNCTIONS = ("builder", "size", "second", "beside")


@dataclass(frozen=True, slots=True)
class Deferred:
    """A function of a row whose module is imported, and expressions with it, when the function is first called.

    Attributes:
        home: dotted name of the module.
        name: of the quantity.
        part: attribute of the row.
    """

    home: str
    name: str
    part: str

    def __call__(self, *arguments: Any) -> Any:
        """The function of these arguments."""
        module = sys.modules.get(self.home) or import_module(self.home)
        found = getattr(next(row for row in rows_of(module) if row.name == self.name), self.part)
        if self.part == "second":
            return found.value(*arguments)
        return found.builder(*arguments) if self.part == "beside" else found(*arguments)


def rows_of(module: ModuleType) -> list[Quantity]:
    """The rows that a module defines, in the order in which they stand there."""
    return [row for row in vars(module).values() if isinstance(row, Quantity) and row.home == module.__name__]


@dataclass(frozen=True, eq=False, slots=True)
class States:
    """States (b, ...), the arguments of all quantities.

    Attributes:
        q, qd, qdd, tau: (b, n).
        tip_wrench, base_twist, base_acceleration: (b, 6), or None where a quantity is computed without them.
        frame: name of the link whose frame is meant; the tip frame if None.
    """

    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    tip_wrench: Floats | None = None
    base_twist: Floats | None = None
    base_acceleration: Floats | None = None
    frame: str | None = None


def random_states(mechanism: Mechanism, size: ArmSize, count: int, seed: int) -> States:
    """Positions within the limits (at most one turn and half a metre), rates, loads and wrenches of natural size.

    Args:
        mechanism: the robot.
        size: of the robot.
        count: of states.
        seed: of the random numbers.
    """
    rng, n = np.random.default_rng(seed), mechanism.n
    most = np.array([TRAVEL if joint.kind is JointKind.PRISMATIC else np.pi for joint in mechanism.coordinates])
    lower, upper = np.maximum(mechanism.limits.lower, -most), np.minimum(mechanism.limits.upper, most)
    lower, upper = np.where(lower < upper, lower, -most), np.where(lower < upper, upper, most)
    return States(
        rng.uniform(lower, upper, (count, n)),
        rng.uniform(-RATE, RATE, (count, n)) * size.unit,
        rng.uniform(-5, 5, (count, n)) * size.unit,
        rng.uniform(-1, 1, (count, n)) * size.force * size.length / size.unit,
        rng.uniform(-1, 1, (count, 6)) * size.force * np.array([size.length] * 3 + [1.0] * 3),
        rng.uniform(-1, 1, (count, 6)),
        rng.uniform(-3, 3, (count, 6)),
    )
