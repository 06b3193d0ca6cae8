"""`mafsil list`: the robots of the library."""

from __future__ import annotations

from typing import Any

from mafsil.cli.answer import Answer
from mafsil.cli.table import table
from mafsil.messages import say
from mafsil.model import JointKind, Mechanism, library

_LETTERS = {JointKind.REVOLUTE: "R", JointKind.PRISMATIC: "P", JointKind.HELICAL: "H"}


def robots() -> Answer:
    """Name, joints, freedoms, masses and description of every robot of the library."""
    entries = [_entry(name, library.load(name)) for name in library.robots()]
    head = [say(f"cli.{key}") for key in ("robot", "kinds", "has_masses", "described_as")]
    rows = [
        [
            entry["name"],
            entry["kinds"],
            say("cli.yes" if entry["masses"] else "cli.no"),
            say(f"library.{entry['name']}"),
        ]
        for entry in entries
    ]
    return Answer({"robots": entries}, (say("cli.list_title", count=len(entries)), *table(head, rows, words=(3,))))


def _entry(name: str, mechanism: Mechanism) -> dict[str, Any]:
    return {
        "name": name,
        "title": say(f"library.{name}"),
        "n": mechanism.n,
        "kinds": "".join(_LETTERS[joint.kind] for joint in mechanism.coordinates),
        "joints": list(mechanism.joint_names),
        "tip": mechanism.tip,
        "masses": any(link.inertial is not None for link in mechanism.links),
        "source": mechanism.provenance.source,
        "licence": mechanism.provenance.licence,
    }
