"""A word when somebody types mass properties that no body has; library arms say it in their notes."""

from __future__ import annotations

from mafsil.errors import ModelError, ModelWarning, warn
from mafsil.model.mass_properties import require_physical
from mafsil.model.mechanism import Mechanism


def warned_of_impossible(mechanism: Mechanism) -> Mechanism:
    """The mechanism itself; its numbers are taken as they are.

    Links without mass and inertia are no matter, and inertia without mass stands for a lumped measurement.

    Args:
        mechanism: as its maker described it.

    Warns:
        ModelWarning: for every link whose moments are negative or violate the triangle inequality; the sentence names
            the link and the numbers.
    """
    for link in mechanism.links:
        body = link.inertial
        if body is None or body.mass == 0.0:
            continue
        try:
            require_physical(body)
        except ModelError as error:
            moments = error.details["moments"]
            warn(ModelWarning("serial.impossible_moments", robot=mechanism.name, link=link.name, moments=moments))
    return mechanism
