"""A studio: one robot, the windows that show it, and what Python does for them."""

from __future__ import annotations

import webbrowser
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from mafsil.errors import InputError
from mafsil.kernels.lazy import lazy
from mafsil.messages import language as current_language
from mafsil.model.loading import RobotLike
from mafsil.page.arm import Arm
from mafsil.page.assemble import assembled
from mafsil.page.content import content
from mafsil.robot import as_robot
from mafsil.studio.broadcast import Broadcast
from mafsil.studio.journal import Journal
from mafsil.studio.protocol import Changes, read
from mafsil.studio.server import HTML, Content, Server

AREAS = ("page", "studio")
"""Of the catalogue, whose sentences the windows have."""


class Studio:
    """A robot served to the browser of this machine.

    Args:
        robot: any robot; a name or a file.
        port: 0 for any that is free.
        language: in which windows open; the current one if None.
        python: expression of the robot in the scripts that windows save; what was given if None.
    """

    def __init__(
        self, robot: RobotLike, *, port: int = 0, language: str | None = None, python: str | None = None
    ) -> None:
        self.arm = Arm(as_robot(robot))
        self.language = language or current_language()
        self._python = python or (repr(str(robot)) if isinstance(robot, str | Path) else repr(self.arm.robot.name))
        self.broadcast = Broadcast(self._everything)
        self.journal = Journal(self.arm, self.broadcast)
        try:
            self.server = Server(port, self._look, {"actions": self._change}, self.broadcast)
        except OSError as error:
            raise InputError("studio.port_taken", port=port, reason=error.strerror or str(error)) from None

    def __enter__(self) -> Studio:
        return self

    def __exit__(self, *_: object) -> None:
        self.server.close()

    @property
    def address(self) -> str:
        """Of the page; whoever knows it can use the studio."""
        return self.server.address

    @lazy
    def html(self) -> str:
        """The page that the server sends."""
        data = content(self.arm, self.language, self._python, AREAS)
        data["studio"] = True
        return assembled(data, _views())

    def serve(self, *, show: bool = False) -> None:
        """Serve until Ctrl-C.

        Args:
            show: open the page in the browser.

        Raises:
            KeyboardInterrupt: Ctrl-C.
        """
        self.html  # noqa: B018 - made before the first window asks
        if show:
            webbrowser.open(self.address)
        self.server.serve_forever()

    def _everything(self) -> Mapping[str, Any]:
        return {"kind": "all", "journal": self.journal.lines(), "rest": {}}

    def _look(self, path: str) -> Content | None:
        return Content(self.html.encode(), HTML) if path == "" else None

    def _change(self, body: bytes) -> Mapping[str, Any]:
        self.journal.change(read(Changes, body))
        return {}


def _views() -> list[str]:
    """Paths of the views that only a studio has."""
    folder = resources.files("mafsil.studio").joinpath("views")
    return sorted(str(file) for file in folder.iterdir() if file.name.endswith(".js"))
