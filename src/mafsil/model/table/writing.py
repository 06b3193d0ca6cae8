"""Robot tables written to files."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import asdict
from os import PathLike

import numpy as np

from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.loading import of_any_mechanism
from mafsil.model.losses import Document, Loss, Weight, comment_lines, deliver, joints_that, names_of, settle_losses
from mafsil.model.mechanism import Mechanism
from mafsil.model.table.building import KINDS
from mafsil.model.table.reading import toml_text

CHOICES = ("shapes",)
"""Words of `without`."""


@of_any_mechanism
def write(mechanism: Mechanism, path: str | PathLike[str] | None = None, *, without: Collection[str] = ()) -> str:
    """An arm as the text of a TOML file that `read` turns into the same mechanism, up to rounding in the last digit.

    The `frames` convention is used, in metres and radians.

    Args:
        mechanism: an arm of moving joints in a row.
        path: of a file to write the text to as well; an existing file is replaced.
        without: what needs no warning: `shapes` of links, which are not part of a table.

    Warns:
        ModelWarning: shapes are left out.

    Raises:
        InputError: a word in `without` that is not in the list.
        ModelError: the robot has loops, branches, fixed, mimic or passive joints, masses of the base, or its tip on
            another link than the last, which a table cannot hold; the sentence names it.
        FileError: the file cannot be written.
    """
    return deliver(document(mechanism, without), mechanism.name, path, without)


@of_any_mechanism
def format_table(mechanism: Mechanism) -> str:
    """The text that `write` writes, without a warning.

    Raises:
        ModelError: as `write`.
    """
    return document(mechanism).text


def document(mechanism: Mechanism, without: Collection[str] = ()) -> Document:
    """The text, and what it does not hold; arguments and errors as of `write`, nothing written and no warning."""
    shaped = [link.name for link in mechanism.links if link.visuals or link.collisions]
    lost = [Loss("writing.shapes", Weight.WARNED, "shapes", {"names": names_of(shaped)})] if shaped else []
    losses = settle_losses((*_refuse(mechanism), *lost), CHOICES, without)
    comment = "".join(f"# {line}\n" for line in comment_lines(losses))
    return Document(comment + _table(mechanism), losses)


def _table(mechanism: Mechanism) -> str:
    return toml_text(
        {
            "name": mechanism.name,
            "convention": "frames",
            "base_link": mechanism.links[0].name,
            "gravity": mechanism.gravity,
            "base": {"matrix": mechanism.T_sb},
            "tool": {"matrix": mechanism.T_lt},
            "provenance": {key: getattr(mechanism.provenance, key) for key in ("source", "licence", "notes")},
        },
        [_joint_fields(joint, link) for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True)],
    )


def _refuse(mechanism: Mechanism) -> Iterator[Loss]:
    """What a table has no place for, the joints in their order."""
    rows: tuple[tuple[str, Callable[[Joint], bool]], ...] = (
        ("fixed", lambda joint: not joint.moves),
        ("follower", lambda joint: joint.mimic is not None),
        ("passive", lambda joint: joint.moves and not joint.actuated),
        ("branch", lambda joint: joint.parent != before[joint.name]),
    )
    links = mechanism.link_names
    before = {joint.name: links[k] for k, joint in enumerate(mechanism.joints)}
    for key, is_so in rows:
        if names := joints_that(mechanism, is_so):
            yield Loss(f"table.lost_{key}", Weight.REFUSED, "", {"names": names})
    if mechanism.loops:
        yield Loss("table.lost_loops", Weight.REFUSED, "", {"names": names_of(loop.name for loop in mechanism.loops)})
    if mechanism.links[0].inertial is not None:
        yield Loss("table.lost_mass", Weight.REFUSED, "", {"names": names_of(links[:1])})
    if mechanism.tip != links[-1] or not mechanism.joints:
        yield Loss("table.lost_tip", Weight.REFUSED, "", {"names": names_of([mechanism.tip]), "last": links[-1]})


def _joint_fields(joint: Joint, link: Link) -> dict[str, object]:
    """Keys of one joint; what has its default value is left out."""
    fields: dict[str, object] = {
        "name": joint.name,
        "link": link.name,
        "kind": next(letter for letter, kind in KINDS.items() if kind is joint.kind),
        "matrix": joint.T_pj,
        "axis": joint.axis,
    }
    if joint.kind is JointKind.HELICAL:
        fields["pitch"] = joint.pitch
    bounds = {name: value for name, value in asdict(joint.limits).items() if np.isfinite(value)}
    if bounds:
        fields["limits"] = bounds
    if link.inertial is not None:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = link.inertial.inertia
        fields["inertial"] = {"mass": link.inertial.mass, "com": link.inertial.com, "inertia": [xx, yy, zz, xy, xz, yz]}
    for name, part in (("actuator", joint.actuator), ("friction", joint.friction)):
        if part is not None:
            fields[name] = {key: value for key, value in asdict(part).items() if value is not None}
    return fields
