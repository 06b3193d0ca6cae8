"""Named mechanisms by their names."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from typing import Any, cast

from mafsil.errors import InputError
from mafsil.mobility.library.planar import (
    chain,
    elliptic_trammel,
    five_bar,
    four_bar,
    overlapping_joints,
    parallelogram,
    peaucellier,
    planar_platform,
    quick_return,
    scotch_yoke,
    slider_crank,
    slotted_slider_crank,
    stephenson,
    stretched_four_bar,
    three_cranks,
    three_rpr,
    three_rrr,
    truss,
    watt,
)
from mafsil.mobility.library.platforms import (
    delta,
    eclipse,
    hand,
    radial_three_upu,
    six_sps,
    six_ups,
    stewart_gough,
    three_prs,
    three_rps,
    three_upu,
    tripteron,
)
from mafsil.mobility.library.spatial import (
    bennett,
    door,
    kaleidocycle,
    rccc,
    rssr,
    sarrus,
    screw_press,
    spherical_four_bar,
    universal_shaft,
)
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.model.library import robots, same_letters
from mafsil.other_words import NAMES

MECHANISMS: dict[str, Callable[..., Linkage]] = {
    function.__name__: function
    for function in (
        bennett, chain, delta, door, eclipse, elliptic_trammel, five_bar, four_bar, hand, kaleidocycle,
        overlapping_joints, parallelogram, peaucellier, planar_platform, quick_return, radial_three_upu, rccc,
        rssr, sarrus, scotch_yoke, screw_press, six_sps, six_ups, slider_crank, slotted_slider_crank,
        spherical_four_bar, stephenson, stewart_gough, stretched_four_bar, three_cranks, three_prs, three_rpr,
        three_rps, three_rrr, three_upu, tripteron, truss, universal_shaft, watt,
    )
}  # fmt: skip
"""Functions that draw named mechanisms, by their names."""


def names() -> tuple[str, ...]:
    """Names of all mechanisms."""
    return tuple(MECHANISMS)


def linkage(name: str, **parameters: Any) -> Linkage:
    """A named mechanism.

    Args:
        name: one of `names()`; case, blanks, hyphens and underscores do not count.
        **parameters: of its function.

    Raises:
        InputError: there is none of that name; the sentence lists them.
    """
    known = (
        same_letters(NAMES.get(name.casefold(), name), MECHANISMS) if isinstance(cast("object", name), str) else None
    )
    if known is None:
        close = get_close_matches(str(name), [*MECHANISMS, *robots()], cutoff=0.5)
        raise InputError("mobility.unknown_mechanism", name=name, known=", ".join(close or MECHANISMS))
    return MECHANISMS[known](**parameters)
