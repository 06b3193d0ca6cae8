"""Identified robots in files: what the format can hold, and a sentence for what it cannot."""

from __future__ import annotations

from pathlib import Path

from mafsil.identification.remark import Remark
from mafsil.model import Mechanism
from mafsil.model.losses import Weight
from mafsil.model.saving import save as save_robot

LEFT_OUT = {".urdf": ("gravity", "actuator", "friction", "limits", "passive", "tip"), ".toml": ("shapes",)}
"""What a format may lose; the remarks say what it did."""


def save(mechanism: Mechanism, path: Path) -> tuple[Remark, ...]:
    """Write a .toml table or a .urdf file and say what it could not keep.

    Args:
        mechanism: what to write.
        path: an existing file is replaced.

    Raises:
        FileError: the place cannot be written.
        ModelError: a mechanism that the format cannot hold.
    """
    losses = save_robot(mechanism, path, without=LEFT_OUT[path.suffix.lower()])
    lost = [loss for loss in losses if loss.weight is not Weight.NOTED]
    return tuple(Remark("identification.lost", {"path": path.name, "loss": loss}) for loss in lost)
