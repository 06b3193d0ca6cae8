"""The names of the library and how each robot is made."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from types import MappingProxyType

from mafsil.errors import ModelError
from mafsil.model.library import franka, kuka, planar, puma, scara, stanford, textbook, universal_robots
from mafsil.model.mechanism import Mechanism

_MAKERS: tuple[Callable[[], Mechanism], ...] = (
    franka.panda,
    franka.fr3,
    kuka.iiwa7,
    universal_robots.ur3e,
    universal_robots.ur5e,
    universal_robots.ur10e,
    universal_robots.ur5,
    puma.puma560,
    stanford.stanford_arm,
    scara.cobra600,
    planar.planar2r,
    planar.planar3r,
    planar.planar2r_point_masses,
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
ROBOTS: MappingProxyType[str, Callable[[], Mechanism]] = MappingProxyType({make.__name__: make for make in _MAKERS})
DEFAULT = "panda"
_LONGEST = 80


def names() -> tuple[str, ...]:
    """Names of all robots of the library, sorted."""
    return tuple(sorted(ROBOTS))


def load(name: str) -> Mechanism:
    """The robot of that name, with its published or default dimensions.

    Args:
        name: one of `names()`, or `default` (the Panda).

    Raises:
        ModelError: no such robot; the sentence lists close names.
    """
    maker = ROBOTS.get(DEFAULT if name == "default" else name)
    if maker is None:
        raise ModelError("library.unknown", name=name, close=", ".join(close_names(name) or names()))
    return maker()


def close_names(name: str) -> tuple[str, ...]:
    """Names of the library that contain the given one or look like it."""
    wanted = name.lower()[:_LONGEST]
    containing = [known for known in names() if wanted and (wanted in known or known in wanted)]
    similar = get_close_matches(wanted, ROBOTS, n=5, cutoff=0.5)
    return tuple(dict.fromkeys([*containing, *similar]))
