"""Names of robots as people type them."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.model.library as library
else:
    library = lazily("mafsil.model.library")


def known_name(robot: str) -> str:
    """The name of the library in its own letters: PANDA is the panda, unless there is a file of that name."""
    small = robot.lower()
    return small if small in library.names() and not os.path.lexists(robot) else robot
