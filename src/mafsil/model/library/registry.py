"""The names of the library and how each robot is made."""

from __future__ import annotations

from collections.abc import Callable, Collection
from difflib import get_close_matches
from functools import cache
from inspect import signature
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import single
from mafsil.errors import InputError, ModelError, letters_of
from mafsil.lazy_module import lazily
from mafsil.model.library import seven_joints, six_joints, textbook, universal_robots
from mafsil.model.mechanism import Mechanism

if TYPE_CHECKING:
    import mafsil.other_words as other_words
else:
    other_words = lazily("mafsil.other_words")

_MAKERS: tuple[Callable[..., Mechanism], ...] = (
    seven_joints.panda,
    seven_joints.fr3,
    seven_joints.iiwa7,
    six_joints.rv7flm,
    universal_robots.ur3e,
    universal_robots.ur5e,
    universal_robots.ur10e,
    universal_robots.ur5,
    six_joints.puma560,
    six_joints.stanford_arm,
    textbook.cobra600,
    textbook.planar2r,
    textbook.planar3r,
    textbook.planar2r_point_masses,
    textbook.spatial3r,
    textbook.rrrp,
    textbook.elbow6r,
    textbook.arm6r,
    textbook.rrprrr,
    textbook.scara_rrrp,
    textbook.rrprrr_upright,
    textbook.offset_puma,
    textbook.offset_stanford,
    textbook.generalized_puma,
)
ROBOTS: MappingProxyType[str, Callable[..., Mechanism]] = MappingProxyType({make.__name__: make for make in _MAKERS})
DEFAULT = "panda"
_LONGEST = 80


def robots() -> tuple[str, ...]:
    """Names of all robots of the library, sorted."""
    return tuple(sorted(ROBOTS))


def library_name(name: str) -> str | None:
    """The name of the library that a name in other letters stands for: `UR5e`, `Puma 560`; None if there is none.

    Args:
        name: any text; case, blanks, hyphens and underscores do not count.
    """
    return DEFAULT if name == "default" else same_letters(name, ROBOTS)


def same_letters(name: str, known: Collection[str]) -> str | None:
    """The one of some names that has the same letters and digits; None if none has.

    Args:
        name: as typed.
        known: names.
    """
    if name in known:
        return name
    letters = letters_of(name[:_LONGEST])
    return next((one for one in known if letters_of(one) == letters), None)


def load(name: str, **dimensions: ArrayLike) -> Mechanism:
    """The robot of that name, with its published or default dimensions.

    Args:
        name: one of `robots()` in any spelling, see `library_name`, or `default` (the Panda).
        **dimensions: lengths [m], masses [kg] or angles [rad] other than the default, for arms whose maker takes some,
            such as `lengths=(0.4, 0.3)` of `planar2r` or `L1=0.5` of `elbow6r`.

    Raises:
        ModelError: no such robot; the sentence lists close names.
        InputError: an arm has no such dimension, another count of numbers, a number that is not finite.
    """
    known = library_name(name)
    if known is None:
        raise ModelError("library.unknown", name=name, close=", ".join(close_names(name) or robots()))
    if not dimensions:
        return _describe(known)
    maker = ROBOTS[known]
    return maker(**{key: _dimension(maker, key, value) for key, value in dimensions.items()})


@cache
def _describe(name: str) -> Mechanism:
    """With the default dimensions: one description for all who name it, which keeps what was compiled for it."""
    return ROBOTS[name]()


def _dimension(maker: Callable[..., Mechanism], key: str, value: ArrayLike) -> float | tuple[float, ...]:
    """A number, or as many of them as the default has.

    Raises:
        InputError: the arm has no such dimension, or one of another shape.
    """
    known = signature(maker).parameters
    if key not in known:
        listed = ", ".join(known)
        raise InputError(
            "library.dimension" if known else "library.fixed", name=maker.__name__, dimension=key, known=listed
        )
    default = np.asarray(known[key].default)
    numbers: list[float] | float = single(key, value, default.shape).tolist()
    return tuple(numbers) if isinstance(numbers, list) else numbers


def close_names(name: str) -> tuple[str, ...]:
    """Names of the library that contain the given one or look like it."""
    lowered = name.lower()[:_LONGEST]
    other = other_words.NAMES.get(lowered.replace("-", "_").replace(" ", "_"))
    if other is not None and other in ROBOTS:
        return (other,)
    containing = [known for known in robots() if lowered and (lowered in known or known in lowered)]
    similar = get_close_matches(lowered, ROBOTS, n=5, cutoff=0.5)
    return tuple(dict.fromkeys([*containing, *similar]))
