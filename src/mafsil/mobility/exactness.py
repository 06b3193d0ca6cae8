"""How exact the parts of a linkage must be for a motion that its very numbers do not allow: Bennett's with four digits.

Where a constraint hardly counts, the linkage nearly moves: along the direction of that singular value the loops are
held as close as can be, at steps up to REACH, and the widest gap is the play that the joints need.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.mobility.blocks import blocks
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import configuration, loop_equations, misfit, units
from mafsil.mobility.on_linkage import on_linkage
from mafsil.mobility.tolerances import RANK
from mafsil.solvers.null_ways import STEPS, solved_in_planes

NEARLY = 2e-3
"""Singular values up to this share of the largest are tried: a play of a thousandth of the size would free them."""
MOST = 6
"""Directions tried in each block of loops."""


@dataclass(frozen=True)
class Exactness:
    """A further motion, and how exact parts must be to have it.

    Attributes:
        joints: names of those that move most in it, up to three.
        length: largest gap of a loop along it, at each of its joints alike [m].
    """

    joints: tuple[str, ...]
    length: float


@on_linkage
def exactness(linkage: Linkage, theta: ArrayLike | None = None) -> tuple[Exactness, ...]:
    """Motions that parts allow which are exact to a length only, the one that needs least play first.

    Args:
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m].
    """
    value = configuration(linkage, theta)
    found = [one for each in blocks(linkage)[0] for one in _of_block(each.linkage, value[each.columns])]
    return tuple(sorted(found, key=lambda one: one.length))


def _of_block(linkage: Linkage, value: Floats) -> list[Exactness]:
    u, equations = value / units(linkage), loop_equations(linkage)
    _, s, Vt = np.linalg.svd(equations(u[None])[1][0])
    share = s / max(float(s.max(initial=0.0)), np.finfo(np.float64).tiny)
    few = [k for k in range(len(s) - 1, -1, -1) if RANK < share[k] <= NEARLY][:MOST]
    return [Exactness(_movers(linkage, Vt[k]), _play(linkage, u, Vt[k])) for k in few]


def _play(linkage: Linkage, u: Floats, direction: Floats) -> float:
    """Widest gap [m] on the way along a direction, both ways."""
    equations, widest = loop_equations(linkage), 0.0
    both = np.array([direction, -direction])
    here, before = u + STEPS[0] * both, float(STEPS[0])
    for step in STEPS.tolist():
        ahead = u + (here - u) * (step / before)
        here, _ = solved_in_planes(equations, ahead, both[:, None], step, np.inf)
        widest, before = max(widest, float(misfit(linkage, here * units(linkage)).max())), step
    return widest


def _movers(linkage: Linkage, direction: Floats) -> tuple[str, ...]:
    of_joint = np.array([np.abs(direction[linkage.joint_of == k]).max(initial=0.0) for k in range(len(linkage.joints))])
    most = np.argsort(-of_joint, kind="stable")[:3]
    return tuple(linkage.joints[int(k)].name for k in most)
