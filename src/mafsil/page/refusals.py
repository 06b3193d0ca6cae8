"""What a robot on a page cannot do, refused with the reason: the same for sessions and for pages with a server."""

from __future__ import annotations

from mafsil.errors import InputError
from mafsil.page.arm import Arm


def require_kernel(kernel: str, arm: Arm) -> None:
    """Refuse what this robot has no kernel for.

    Args:
        kernel: its name.
        arm: with the kernels.

    Raises:
        InputError: it has none.
    """
    if kernel not in arm.kernels:
        raise InputError(f"session.no_{kernel if arm.closed is None else 'loops'}", robot=arm.robot.name)


def require_driven(joint: int, arm: Arm) -> None:
    """Refuse a joint that loops move.

    Args:
        joint: its place in the coordinates.
        arm: with the settings.

    Raises:
        InputError: they do.
    """
    driven = arm.settings["driven"]
    if driven is not None and joint not in driven:
        raise InputError("session.not_driven", value=joint, known=", ".join(map(str, driven)) or "-")


def require_free(joint: int, arm: Arm) -> None:
    """Refuse a joint that the closed form determines.

    Args:
        joint: its place in the coordinates.
        arm: with the settings.

    Raises:
        InputError: it does.
    """
    free = arm.settings["locked"]
    if joint not in free:
        raise InputError("session.not_free", value=joint, known=", ".join(map(str, free)) or "-")
