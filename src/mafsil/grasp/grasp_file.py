"""Grasps in files: TOML or JSON as `description` has it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.grasp.body import GraspedBody
from mafsil.grasp.description import parse_description
from mafsil.grasp.grasp import Grasp
from mafsil.regular_file import reason, whole_text
from mafsil.toml_source import parsed_toml

LARGEST_FILE = 1_000_000


@dataclass(frozen=True, eq=False)
class GraspFile:
    """The contents of a grasp file.

    Attributes:
        grasp: the contacts.
        load: (m,) external wrench (m, f) on the body, or None.
        outline: (k, 2) corners of a plane body [m], or None.
        body: of triangles, in space, or None.
    """

    grasp: Grasp
    load: Floats | None
    outline: Floats | None
    body: GraspedBody | None = None


def read_grasp(path: str | PathLike[str]) -> GraspFile:
    """The grasp in a file.

    Args:
        path: .toml or .json.

    Raises:
        FileError: missing, unreadable, malformed, unknown or missing keys.
        InputError: contacts that make no grasp, or lie off the outline.
    """
    place = Path(path)
    try:
        text = whole_text(place, LARGEST_FILE)
        data = json.loads(text) if place.suffix.lower() == ".json" else parsed_toml(text)
    except (OSError, UnicodeDecodeError) as fault:
        raise FileError("grasp.file_unreadable", path=path, reason=reason(fault)) from None
    except (ValueError, RecursionError) as error:
        raise FileError("grasp.file_malformed", path=path, reason=str(error)) from None
    return parse_grasp_file(data, source=place.name, folder=place.parent)


def parse_grasp_file(data: Any, source: str, folder: Path | None = None) -> GraspFile:
    """The grasp in plain data; arguments and errors as of `description.parse_description`."""
    found = parse_description(data, source, folder)
    return GraspFile(Grasp(found.contacts, found.name), found.load, found.outline, found.body)
