"""What a studio opens with: a robot, a job or recordings, told apart by what they are."""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.studio.studio import Studio

DEFAULT_ROBOT = "panda"


def studio_of(what: Sequence[str], port: int) -> Studio:
    """The studio of what was given.

    Args:
        what: names and files.
        port: 0 for any that is free.

    Raises:
        MafsilError: it cannot be read, or the port is taken.
    """
    return Studio(what[0] if what else DEFAULT_ROBOT, port=port)
