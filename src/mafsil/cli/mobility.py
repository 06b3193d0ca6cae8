"""`mafsil mobility`: how a mechanism can move: counted, by rank, finite, with the reasons where they differ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.numerals import coordinate
from mafsil.cli.table import table
from mafsil.errors import FileError, InputError
from mafsil.messages import say
from mafsil.mobility import Linkage, Mobility, as_linkage, assembled, locked, locked_subsets, mobility


def mobility_of(
    mechanism: str,
    q: Sequence[str] | None,
    rule: str | None,
    locked_joints: Sequence[str] | None,
    actuated: Sequence[str] | None,
    subsets: str | int | None,
    picture: str | None,
) -> Answer:
    """The report on a file of bodies and joints, or on a robot.

    Args:
        mechanism: TOML with bodies and joints, or name or file of a robot.
        q: coordinates at which a robot is drawn; all coordinates of a linkage.
        rule: planar, spherical or spatial.
        locked_joints, actuated: names of joints.
        subsets: lock every choice of so many joints and show what is left.
        picture: file to draw into.

    Raises:
        MafsilError: no such file, no linkage, no such joints.
    """
    values = None if q is None else np.array([coordinate(f"q[{k}]", word)[0] for k, word in enumerate(q)])
    linkage = as_linkage(mechanism, values)
    if linkage.apart:
        linkage = assembled(linkage)
    if actuated is not None:
        linkage = linkage.with_actuators(*actuated)
    if locked_joints:
        linkage = locked(linkage, locked_joints)
    found = mobility(linkage, rule=rule)
    data, lines = found.to_dict(), found.explain().split("\n")
    if subsets is not None:
        left = locked_subsets(linkage, _count(subsets))
        data["locked_subsets"] = [{"joints": list(names), "mobility": count} for names, count in left.items()]
        lines += table(
            (say("cli.mobility_locked_head"), say("cli.mobility_left_head")),
            [(", ".join(n), str(c)) for n, c in left.items()],
        )
    if picture is not None:
        _draw(linkage, found, picture)
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    return Answer(data, tuple(lines), None if found else found.status.sentence(
        name=linkage.name or "-", mobility=found.mobility, counted=found.count.mobility,
        instantaneous=found.instantaneous.mobility,
    ))  # fmt: skip


def _count(value: str | int) -> int:
    try:
        return int(value)
    except ValueError:
        raise InputError("input.numbers", name="--subsets", got=repr(value)) from None


def _draw(linkage: Linkage, found: Mobility, picture: str) -> None:
    from mafsil.figures.linkage import save_linkage
    from mafsil.figures.linkage_motion import save_linkage_motion

    save = save_linkage_motion if picture.lower().endswith(".gif") else save_linkage
    try:
        save(linkage, picture, found=found)
    except OSError as error:
        raise FileError("file.cannot_write", path=picture, reason=error.strerror or str(error)) from None
