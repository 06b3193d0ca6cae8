"""A robot on a page: in a notebook, in a file, in the browser."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, cast

from mafsil.errors import FileError, InputError
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.messages import language as current_language
from mafsil.messages.visible import visible
from mafsil.model import Mechanism, library
from mafsil.model.loading import RobotLike
from mafsil.page.arm import Arm
from mafsil.page.assemble import assemble, needed_quantities
from mafsil.page.content import content
from mafsil.regular_file import whole_bytes
from mafsil.robot import Robot, as_open_tree
from mafsil.scene.inline import attribute
from mafsil.whole_file import write_whole

if TYPE_CHECKING:
    import mafsil.mobility as mobility
    import mafsil.mobility.linkages.mechanism_linkage as mechanism_linkage
    import mafsil.parallel as parallel
    import mafsil.parallel.legs.leg_library as described
else:
    mobility = lazily("mafsil.mobility")
    mechanism_linkage = lazily("mafsil.mobility.linkages.mechanism_linkage")
    parallel = lazily("mafsil.parallel")
    described = lazily("mafsil.parallel.legs.leg_library")

Closed: TypeAlias = (
    "mobility.Linkage | mobility.FourBar | parallel.StewartPlatform | parallel.DeltaRobot | parallel.LegMechanism"
)
"""What closes loops and is no description yet."""
UNSEEN = (
    "--headless", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
    "--virtual-time-budget=3000", "--window-size=960,640", "--force-device-scale-factor=2",
)  # fmt: skip
"""Of a browser that draws one picture and ends."""
PATIENCE = 120.0
"""How long it may take [s]."""
LARGEST = 64 << 20
"""Of a picture [bytes]."""
HEIGHT = 720
"""Of the page in a notebook [pixels]."""


@dataclass(frozen=True, eq=False)
class Page:
    """The interactive page of a robot.

    Attributes:
        robot: what is shown.
        language: in which the page opens; its reader may switch.
        python: expression that makes the robot in the scripts that the page writes.
        views: absolute paths of modules with more views.
    """

    robot: Robot
    language: str
    python: str = field(repr=False)
    views: tuple[str, ...] = ()

    @lazy
    def html(self) -> str:
        """The whole page as text; it needs no other file and makes no request."""
        arm = Arm(self.robot, needed_quantities(self.views))
        return assemble(content(arm, self.language, self.python), self.views)

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write the page into a file, which appears whole or not at all.

        Args:
            path: of the file.

        Raises:
            FileError: the place cannot be written.
        """
        place = Path(path)
        write_whole(place, self.html.encode())
        return place

    def _with_postures(self, postures: Mapping[str, Sequence[float]]) -> str:
        """The page with the robot in the first of some postures, the others as ghosts, and a legend."""
        arm = Arm(self.robot, needed_quantities(self.views))
        data, shown = content(arm, self.language, self.python), [[float(x) for x in q] for q in postures.values()]
        data["settings"] = {**data["settings"], "start": shown[0]}
        data["shown"] = [{"name": visible(name), "q": q} for name, q in zip(postures, shown, strict=True)]
        return assemble(data, self.views)

    def photograph(
        self, path: str | os.PathLike[str], *, postures: Mapping[str, Sequence[float]] | None = None
    ) -> Path:
        """Draw the robot as the page does, with scale and axes, into a PNG file, by a Chromium that shows no window.

        Args:
            path: of the file.
            postures: by name, (n,) each [rad | m]: the robot in the first one, the others as ghosts, with a legend;
                where the page begins if None.

        Raises:
            InputError: no Chromium is on the path of commands.
            FileError: the place cannot be written, or the browser draws nothing.
        """
        program, place = chromium(), Path(path)
        if program is None:
            raise InputError("pictures.no_browser", path=str(place))
        with tempfile.TemporaryDirectory(prefix="mafsil-") as folder:
            drawn = Path(folder) / "picture.png"
            page = Path(folder) / "page.html"
            write_whole(page, (self._with_postures(postures) if postures else self.html).encode())
            address = page.as_uri() + "#picture"
            root = hasattr(os, "geteuid") and os.geteuid() == 0  # for whom Chromium has no sandbox
            flags = (*UNSEEN, "--no-sandbox") if root else UNSEEN
            words = [program, *flags, f"--user-data-dir={folder}/profile", f"--screenshot={drawn}", address]
            try:
                said = subprocess.run(words, capture_output=True, timeout=PATIENCE, check=False).stderr
            except subprocess.TimeoutExpired as late:
                said = late.stderr or b""
            if not drawn.is_file():
                raise FileError("file.cannot_write", path=str(place), reason=said.decode(errors="replace")[-200:])
            write_whole(place, whole_bytes(drawn, LARGEST))
        return place

    def open(self) -> Path:
        """Show it in the browser, from a file in the folder for temporary files."""
        place = Path(tempfile.mkdtemp(prefix="mafsil-")) / f"{_file_name(self.robot.name)}.html"
        self.write(place)
        webbrowser.open(place.as_uri())
        return place

    def _repr_html_(self) -> str:
        """For notebooks: the page in a frame of its own, which can reach nothing around it."""
        allowed = "allow-scripts allow-downloads"
        style = f"width: 100%; height: {HEIGHT}px; border: 0"
        return f'<iframe sandbox="{allowed}" style="{style}" srcdoc="{attribute(self.html)}"></iframe>'


def chromium() -> str | None:
    """The program of a Chromium on this machine; None without any."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)


def show(
    robot: RobotLike | Closed, *, language: str | None = None, views: Sequence[str | os.PathLike[str]] = ()
) -> Page:
    """Interactive page of a robot: sliders, inverse kinematics, Jacobian, loads, closed-loop simulation.

    In a notebook the page appears under the cell; `show(robot).open()` shows it in the browser,
    `show(robot).write("panda.html")` makes a file to hand in. Everything that is done there is a line of Python that
    `mafsil.page.Session` repeats to the same bits.

    Args:
        robot: any robot; a name or a file; a linkage of `mafsil.mobility`, a Stewart platform, a Delta robot or legs of
            `mafsil.parallel`. Its numbers stand readable in the page.
        language: `en` or `ar`; the current one if None.
        views: files with views of your own, one each (docs/adding_a_view.md); their script runs in the page.

    Raises:
        ModelError: a robot without joints.
    """
    found = as_open_tree(_description(robot))
    return Page(found, language or current_language(), _python(robot, found), _absolute(views))


def show_as(mechanism: Mechanism, source: str, views: Sequence[str | os.PathLike[str]] = ()) -> Page:
    """The page of a mechanism that came from a name or a file, perhaps with another tip.

    Args:
        mechanism: what is shown.
        source: name or file that scripts load.
        views: files with views of your own.
    """
    return Page(as_open_tree(mechanism), current_language(), repr(source), _absolute(views))


def _description(robot: RobotLike | Closed) -> RobotLike:
    """What describes a robot: a linkage or a platform on legs becomes a tree with loops."""
    if isinstance(robot, str | os.PathLike) or hasattr(robot, "mechanism") or isinstance(robot, Mechanism):
        return cast("RobotLike", robot)
    if isinstance(robot, parallel.StewartPlatform | parallel.DeltaRobot | parallel.LegMechanism):
        return described.mechanism_of_parallel(robot, type(robot).__name__)
    if isinstance(robot, mobility.Linkage | mobility.FourBar):
        return mobility.mechanism_of(mechanism_linkage.as_linkage(robot))
    return robot


def _python(given: RobotLike | Closed, robot: Robot) -> str:
    """The expression for scripts: what was given as text, a name of the library, else a name to be filled in."""
    if isinstance(given, str | os.PathLike):
        return repr(os.fspath(given))
    return repr(robot.name) if robot.name in library.robots() else "robot"


def _absolute(views: Sequence[str | os.PathLike[str]]) -> tuple[str, ...]:
    return tuple(os.path.abspath(view) for view in views)


def _file_name(name: str) -> str:
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name)[:80] or "robot"
