"""`mafsil grasp`: verdicts on a grasp sketch, with their proofs, and the forces against its load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mafsil.cli.answer import Answer
from mafsil.cli.table import number, table
from mafsil.errors import FileError, InputError
from mafsil.grasp import Grasp
from mafsil.grasp.closure import Closure, vector
from mafsil.grasp.elimination import eliminate
from mafsil.grasp.forces import ContactForces
from mafsil.grasp.sketch import Sketch, read
from mafsil.grasp.two_fingers import two_fingers
from mafsil.messages import say

_PICTURES = (".png", ".svg", ".pdf")


def grasp(file: str, facets: str | int | None, steps: bool, picture: str | None) -> Answer:
    """Force closure, form closure, free motions, quality, and contact forces if the file has a load.

    Args:
        file: .toml or .json.
        facets: edges of polyhedral cones; the true round ones if None.
        steps: show the elimination row by row.
        picture: file to draw into.

    Raises:
        MafsilError: no such file, no grasp, an unknown kind of picture.
    """
    if picture is not None and Path(picture).suffix.lower() not in _PICTURES:
        raise InputError("cli.picture_kind", path=picture, known=", ".join(_PICTURES))
    sketch = read(Path(file))
    held, edges = sketch.grasp, None if facets is None else _count(facets)
    found, form, free = held.closure(edges), held.form_closure(), held.free_motions()
    forces = None if sketch.load is None else held.resist(sketch.load)
    data: dict[str, Any] = {
        "grasp": held.to_dict(),
        "closure": found.to_dict(),
        "form_closure": form.to_dict(),
        "free_motions": {"both_ways": free.reversible, "one_way": free.rays},
        "load": None if forces is None else _load_data(sketch, forces),
    }
    lines = [*_head(held), *_verdict(held, found), *held.explain()[1:]]
    if forces is not None:
        lines += _load_lines(forces)
    if steps:
        lines += [say("grasp.steps"), *("  " + line for line in eliminate(held.matrix(edges or 16)).lines())]
    if picture is not None:
        _draw(sketch, found, Path(picture))
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    refusal = forces.explain() if forces is not None and not forces.holds else None
    if refusal is None and not found.force_closure:
        refusal = found.explain()
    return Answer(data, tuple(lines), refusal)


def _count(facets: str | int) -> int:
    try:
        return int(facets)
    except ValueError:
        raise InputError("input.numbers", name="--facets", got=repr(facets)) from None


def _head(held: Grasp) -> list[str]:
    place = say("grasp.in_plane" if held.dimension == 2 else "grasp.in_space")
    rows = [
        (c.name or str(k), vector(c.point), vector(c.normal), number(c.mu, 4), number(c.gamma, 4))
        for k, c in enumerate(held.contacts)
    ]
    head = (say("grasp.contact_head"), say("grasp.point_head"), say("grasp.normal_head"), "mu", "gamma")
    return [say("grasp.title", name=held.name or "-", count=len(held), place=place), *table(head, rows)]


def _verdict(held: Grasp, found: Closure) -> list[str]:
    lines = [found.explain()]
    if found.force_closure:
        key = "grasp.ball" if found.upper <= found.margin * (1 + 1e-9) else "grasp.ball_between"
        lines.append(say(key, radius=found.margin, upper=found.upper, length=1.0))
        if found.weakest is not None:
            lines.append(say("grasp.weakest", wrench=vector(found.weakest)))
    if held.dimension == 2 and len(held) == 2 and all(c.mu > 0 for c in held.contacts):
        lines.append(two_fingers(*held.contacts).case.sentence())
    return lines


def _load_data(sketch: Sketch, forces: ContactForces) -> dict[str, Any]:
    return {
        "wrench": sketch.load,
        "holds": forces.holds,
        "forces": forces.forces if forces.holds else None,
        "total_push": forces.total_push if forces.holds else None,
        "certificate": forces.certificate,
    }


def _load_lines(forces: ContactForces) -> list[str]:
    lines = [forces.explain()]
    if forces.holds:
        rows = [(str(k), vector(f)) for k, f in enumerate(forces.forces)]
        lines += table((say("grasp.contact_head"), say("grasp.force_head")), rows)
    return lines


def _draw(sketch: Sketch, found: Closure, path: Path) -> None:
    from mafsil.figures.grasp import save_grasp

    try:
        save_grasp(sketch.grasp, path, closure=found, outline=sketch.outline)
    except OSError as error:
        raise FileError("cli.cannot_write", path=str(path), reason=error.strerror or str(error)) from None
