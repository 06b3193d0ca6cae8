"""Named mechanisms by parameters, each drawn in a configuration that closes; `linkage("bennett")`, `names()`."""

from collections.abc import Callable
from typing import Any, cast

from mafsil.errors import InputError
from mafsil.mobility.library.planar import chain as chain
from mafsil.mobility.library.planar import elliptic_trammel as elliptic_trammel
from mafsil.mobility.library.planar import five_bar as five_bar
from mafsil.mobility.library.planar import four_bar as four_bar
from mafsil.mobility.library.planar import overlapping_joints as overlapping_joints
from mafsil.mobility.library.planar import parallelogram as parallelogram
from mafsil.mobility.library.planar import peaucellier as peaucellier
from mafsil.mobility.library.planar import planar_platform as planar_platform
from mafsil.mobility.library.planar import quick_return as quick_return
from mafsil.mobility.library.planar import scotch_yoke as scotch_yoke
from mafsil.mobility.library.planar import slider_crank as slider_crank
from mafsil.mobility.library.planar import slotted_slider_crank as slotted_slider_crank
from mafsil.mobility.library.planar import stephenson as stephenson
from mafsil.mobility.library.planar import stretched_four_bar as stretched_four_bar
from mafsil.mobility.library.planar import three_cranks as three_cranks
from mafsil.mobility.library.planar import three_rpr as three_rpr
from mafsil.mobility.library.planar import three_rrr as three_rrr
from mafsil.mobility.library.planar import truss as truss
from mafsil.mobility.library.planar import watt as watt
from mafsil.mobility.library.platforms import delta as delta
from mafsil.mobility.library.platforms import eclipse as eclipse
from mafsil.mobility.library.platforms import hand as hand
from mafsil.mobility.library.platforms import radial_three_upu as radial_three_upu
from mafsil.mobility.library.platforms import six_sps as six_sps
from mafsil.mobility.library.platforms import six_ups as six_ups
from mafsil.mobility.library.platforms import stewart_gough as stewart_gough
from mafsil.mobility.library.platforms import three_prs as three_prs
from mafsil.mobility.library.platforms import three_rps as three_rps
from mafsil.mobility.library.platforms import three_upu as three_upu
from mafsil.mobility.library.platforms import tripteron as tripteron
from mafsil.mobility.library.spatial import bennett as bennett
from mafsil.mobility.library.spatial import door as door
from mafsil.mobility.library.spatial import kaleidocycle as kaleidocycle
from mafsil.mobility.library.spatial import rccc as rccc
from mafsil.mobility.library.spatial import rssr as rssr
from mafsil.mobility.library.spatial import sarrus as sarrus
from mafsil.mobility.library.spatial import screw_press as screw_press
from mafsil.mobility.library.spatial import spherical_four_bar as spherical_four_bar
from mafsil.mobility.library.spatial import universal_shaft as universal_shaft
from mafsil.mobility.linkage import Linkage

MECHANISMS: dict[str, Callable[..., Linkage]] = {
    function.__name__: function
    for function in (
        bennett, chain, delta, door, eclipse, elliptic_trammel, five_bar, four_bar, hand, kaleidocycle,
        overlapping_joints, parallelogram, peaucellier, quick_return, radial_three_upu, rccc, rssr, sarrus, scotch_yoke,
        screw_press, six_sps, six_ups, slider_crank, slotted_slider_crank, spherical_four_bar, stephenson,
        stretched_four_bar, three_cranks, three_prs, three_rpr, three_rps, three_rrr, three_upu, tripteron, truss,
        universal_shaft, watt,
    )
}  # fmt: skip
"""Functions that draw named mechanisms, by their names."""


def names() -> tuple[str, ...]:
    """Names of all mechanisms."""
    return tuple(MECHANISMS)


def linkage(name: str, **parameters: Any) -> Linkage:
    """A named mechanism.

    Args:
        name: one of `names()`.
        **parameters: of its function.

    Raises:
        InputError: there is none of that name; the sentence lists them.
    """
    if not isinstance(cast("object", name), str) or name not in MECHANISMS:
        raise InputError("mobility.unknown_mechanism", name=name, known=", ".join(MECHANISMS))
    return MECHANISMS[name](**parameters)
