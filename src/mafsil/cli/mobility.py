"""`mafsil mobility`: how a mechanism can move: counted, by rank, finite, with the reasons where they differ."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.numerals import coordinate
from mafsil.cli.table import table
from mafsil.errors import FileError, InputError
from mafsil.messages import say
from mafsil.mobility import (
    Linkage,
    Mobility,
    close_drawing,
    configuration_surfaces,
    mobility,
    mobility_with_locked_joints,
)
from mafsil.mobility.linkages import as_linkage, lock_joints


def mobility_of(
    mechanism: str,
    q: Sequence[str] | None,
    rule: str | None,
    play: float | None,
    locked_joints: Sequence[str] | None,
    actuated: Sequence[str] | None,
    subsets: str | int | None,
    surfaces: bool,
    picture: str | None,
) -> Answer:
    """The report on a file of bodies and joints, or on a robot.

    Args:
        mechanism: TOML with bodies and joints, or name or file of a robot.
        q: coordinates at which a robot is drawn; all coordinates of a linkage.
        rule: planar, spherical or spatial.
        play: length to which parts are exact [m].
        locked_joints, actuated: names of joints.
        subsets: lock every choice of so many joints and show what is left.
        surfaces: look for the surfaces of configurations, of a mobility of 2.
        picture: file to draw into: the mechanism, or the first surface.

    Raises:
        MafsilError: no such file, no linkage, no such joints.
    """
    values = None if q is None else np.array([coordinate(f"q[{k}]", word)[0] for k, word in enumerate(q)])
    linkage = as_linkage(mechanism, values)
    if linkage.apart:
        linkage = close_drawing(linkage)
    if actuated is not None:
        linkage = linkage.with_actuators(*actuated)
    if locked_joints:
        linkage = lock_joints(linkage, locked_joints)
    found = mobility(linkage, rule=rule, play=play or 0.0)
    data, lines = found.to_dict(), found.explain().split("\n")
    if actuated is None and len(linkage.closing) and str(mechanism).lower().endswith((".sdf", ".world")):
        lines.append(say("cli.mobility_driven_unknown"))
    if subsets is not None:
        left = mobility_with_locked_joints(linkage, _count(subsets))
        data["mobility_with_locked_joints"] = [
            {"joints": list(names), "mobility": count} for names, count in left.items()
        ]
        lines += table(
            (say("cli.mobility_locked_head"), say("cli.mobility_left_head")),
            [(", ".join(n), str(c)) for n, c in left.items()],
        )
    followed = configuration_surfaces(linkage) if surfaces else None
    if followed is not None:
        data["surfaces"] = followed.to_dict()
        lines += [*repr(followed).split("\n"), *(one.explain().split("\n")[0] for one in followed)]
        lines += followed.surfaces[0].explain().split("\n")[1:] if followed else []
    if picture is not None and followed:
        from mafsil.figures import plot_surface

        _written(lambda: plot_surface(followed.surfaces[0], picture), picture)
    elif picture is not None:
        _draw(linkage, found, picture)
    if picture is not None:
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    return Answer(data, tuple(lines), None if found else found.verdict())


def _count(value: str | int) -> int:
    try:
        return int(value)
    except ValueError:
        raise InputError("input.numbers", name="--subsets", got=repr(value)) from None


def _draw(linkage: Linkage, found: Mobility, picture: str) -> None:
    from mafsil.figures.linkage import save_linkage
    from mafsil.figures.linkage_motion import save_linkage_motion

    save = save_linkage_motion if picture.lower().endswith(".gif") else save_linkage
    _written(lambda: save(linkage, picture, found=found), picture)


def _written(write: Callable[[], object], picture: str) -> None:
    """What draws a picture, or the reason why there is none."""
    try:
        write()
    except OSError as error:
        raise FileError("file.cannot_write", path=picture, reason=error.strerror or str(error)) from None
