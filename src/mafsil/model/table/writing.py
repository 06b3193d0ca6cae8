"""Robot tables written to files."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict
from os import PathLike

import numpy as np

from mafsil.errors import ModelError
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.loading import of_any_mechanism
from mafsil.model.losses import Document, Loss, Weight, comment_lines, delivered, names_of, settled
from mafsil.model.mechanism import Mechanism
from mafsil.model.table.building import KINDS
from mafsil.model.table.text import toml_text

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
        ModelError: the robot has loops, branches, fixed, mimic or passive joints, or masses of the base, which a table
            cannot hold; write URDF.
        FileError: the file cannot be written.
    """
    return delivered(document(mechanism, without), mechanism.name, path, without)


@of_any_mechanism
def formatted(mechanism: Mechanism) -> str:
    """The text that `write` writes, without a warning.

    Raises:
        ModelError: as `write`.
    """
    return document(mechanism).text


def document(mechanism: Mechanism, without: Collection[str] = ()) -> Document:
    """The text, and what it does not hold; arguments and errors as of `write`, nothing written and no warning."""
    shaped = [link.name for link in mechanism.links if link.visuals or link.collisions]
    lost = [Loss("writing.shapes", Weight.WARNED, "shapes", {"names": names_of(shaped)})] if shaped else []
    losses = settled(lost, CHOICES, without)
    comment = "".join(f"# {line}\n" for line in comment_lines(losses))
    return Document(comment + _table(mechanism), losses)


def _table(mechanism: Mechanism) -> str:
    _require_writable(mechanism)
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


def _require_writable(mechanism: Mechanism) -> None:
    """Nothing that a table would lose, except shapes."""
    base = mechanism.links[0].name
    previous = base
    for joint in mechanism.joints:
        plain = joint.moves and joint.mimic is None and joint.actuated
        if not plain or joint.parent != previous:
            raise ModelError("table.unwritable", robot=mechanism.name, part=joint.name)
        previous = joint.child
    if mechanism.loops:
        raise ModelError("table.unwritable", robot=mechanism.name, part=mechanism.loops[0].name)
    if mechanism.links[0].inertial is not None or mechanism.tip != previous or previous == base:
        raise ModelError("table.unwritable", robot=mechanism.name, part=base)


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
