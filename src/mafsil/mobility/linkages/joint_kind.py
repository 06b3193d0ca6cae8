"""Kinds of joints by freedoms: each expanded into the screws of joints of one freedom."""

from __future__ import annotations

from enum import Enum

import numpy as np

from mafsil.arrays import Floats


class Kind(Enum):
    """How a joint lets its child move against its parent. Members: (name, symbol, freedoms, freedoms in a plane).

    Attributes:
        title: as files write it.
        symbol: letters of the field: R, P, H, C, U, S, E (planar), F (floating), RP (pin in a slot).
        freedoms: f, number of independent motions.
        planar: whether it may stand in a linkage of the plane.
        letters: the joints of one freedom that it is made of, from the parent to the child.
    """

    FIXED = ("fixed", "0", "", True)
    REVOLUTE = ("revolute", "R", "R", True)
    PRISMATIC = ("prismatic", "P", "P", True)
    HELICAL = ("helical", "H", "H", False)
    CYLINDRICAL = ("cylindrical", "C", "PR", False)
    UNIVERSAL = ("universal", "U", "RR", False)
    SPHERICAL = ("spherical", "S", "RRR", False)
    PLANAR = ("planar", "E", "PPR", True)
    FLOATING = ("floating", "F", "PPPRRR", False)
    PIN_IN_SLOT = ("pin_in_slot", "RP", "PR", True)

    def __init__(self, title: str, symbol: str, letters: str, planar: bool) -> None:
        self.title = title
        self.symbol = symbol
        self.letters = letters
        self.planar = planar

    @property
    def freedoms(self) -> int:
        """Number of independent motions."""
        return len(self.letters)

    def screws(self, point: Floats, axis: Floats, second: Floats, pitch: float) -> Floats:
        """(6, f) screws (omega, v) in the frame of the drawing, from the parent to the child, as columns.

        A point moves with omega x p + v. Revolute (w, -w x p), prismatic (0, w), helical (w, -w x p + h w).

        Args:
            point: (3,) on the axis [m].
            axis: (3,) unit direction; of planar joints the normal.
            second: (3,) unit: the second axis of a universal joint, the direction of the slot of a pin.
            pitch: advance per angle [m/rad].

        Reference: Lynch & Park, Modern Robotics, sec. 3.3.2.2.
        """
        none = np.zeros(3)

        def rotation(w: Floats, advance: float = 0.0) -> Floats:
            return np.concatenate([w, np.cross(point, w) + advance * w])

        def translation(w: Floats) -> Floats:
            return np.concatenate([none, w])

        columns: list[Floats] = []
        match self:
            case Kind.FIXED:
                return np.zeros((6, 0))
            case Kind.REVOLUTE:
                columns = [rotation(axis)]
            case Kind.PRISMATIC:
                columns = [translation(axis)]
            case Kind.HELICAL:
                columns = [rotation(axis, pitch)]
            case Kind.CYLINDRICAL:
                columns = [translation(axis), rotation(axis)]
            case Kind.UNIVERSAL:
                columns = [rotation(axis), rotation(second)]
            case Kind.PIN_IN_SLOT:
                columns = [translation(second), rotation(axis)]
            case Kind.PLANAR:
                columns = [*map(translation, across(axis)), rotation(axis)]
            case Kind.SPHERICAL:
                columns = [rotation(w) for w in np.eye(3)]
            case Kind.FLOATING:
                columns = [*map(translation, np.eye(3)), *(rotation(w) for w in np.eye(3))]
        return np.column_stack(columns)


KINDS = {kind.title: kind for kind in Kind} | {kind.symbol: kind for kind in Kind}
"""By the names and letters that files write."""
ALIASES = {
    "hinge": Kind.REVOLUTE, "pin": Kind.REVOLUTE, "rotary": Kind.REVOLUTE, "linear": Kind.PRISMATIC,
    "translational": Kind.PRISMATIC, "slider": Kind.PRISMATIC, "screw": Kind.HELICAL, "ball": Kind.SPHERICAL,
    "ball_and_socket": Kind.SPHERICAL, "hooke": Kind.UNIVERSAL, "cardan": Kind.UNIVERSAL,
    "free": Kind.FLOATING, "pr": Kind.PIN_IN_SLOT,
}  # fmt: skip
"""Other names of the field."""


def kind_named(word: str) -> Kind | None:
    """The kind of a name, a letter or an alias, in any case, with blanks or hyphens; None if there is none."""
    title = word.strip().lower().replace(" ", "_").replace("-", "_")
    return KINDS.get(word) or KINDS.get(title) or ALIASES.get(title) or KINDS.get(word.strip().upper())


def across(normal: Floats) -> Floats:
    """(2, 3) two unit directions that make a right-handed frame with a unit normal; x and y for z."""
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = least - normal * float(least @ normal)
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)], dtype=np.float64)
