"""`mafsil grasp`: verdicts on a grasp sketch, with their proofs and the forces against its load; grasps of a mesh."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from mafsil.cli.answer import Answer
from mafsil.cli.numerals import number as typed
from mafsil.cli.progress import Progress
from mafsil.cli.table import number, table
from mafsil.errors import FileError, InputError
from mafsil.grasp import Grasp, GraspPlan, plan_grasps
from mafsil.grasp.closure import Closure, vector
from mafsil.grasp.elimination import eliminate
from mafsil.grasp.forces import ContactForces
from mafsil.grasp.sketch import Sketch, read
from mafsil.grasp.two_fingers import two_fingers
from mafsil.messages import say

_PICTURES = (".png", ".svg", ".pdf")
_MOVING = ".gif"
_MESHES = (".stl", ".stlb", ".obj", ".dae")


def grasp(
    file: str,
    facets: str | int | None,
    steps: bool,
    picture: str | None,
    fingers: str | int | None = None,
    mu: str | float | None = None,
    gamma: str | float | None = None,
    opening: str | float | None = None,
) -> Answer:
    """Verdicts on a sketch, or the best grasps of a mesh.

    Args:
        file: .toml or .json; or .stl, .obj, .dae.
        facets: edges of polyhedral cones; the true round ones if None.
        steps: show the elimination row by row.
        picture: file to draw into.
        fingers, mu, gamma, opening: of the grasps of a mesh.

    Raises:
        MafsilError: no such file, no grasp, an unknown kind of picture, an option for the other kind of file.
    """
    mesh = Path(file).suffix.lower() in _MESHES
    kinds = _PICTURES if mesh else (*_PICTURES, _MOVING)
    if picture is not None and Path(picture).suffix.lower() not in kinds:
        raise InputError("cli.picture_kind", path=picture, known=", ".join(kinds))
    plan = {
        "fingers": None if fingers is None else _count(fingers, "fingers"),
        "mu": None if mu is None else typed("--mu", str(mu)),
        "gamma": None if gamma is None else typed("--gamma", str(gamma)),
        "opening": None if opening is None else typed("--opening", str(opening)),
    }
    if mesh:
        _refuse({"facets": facets, "steps": steps or None}, "grasp.not_for_mesh", file)
        return _plan(file, {name: value for name, value in plan.items() if value is not None}, picture)
    _refuse(plan, "grasp.not_for_sketch", file)
    return _judge(file, facets, steps, picture)


def _refuse(options: dict[str, Any], key: str, file: str) -> None:
    for name, value in options.items():
        if value is not None:
            raise InputError(key, name=name, path=file)


def _plan(file: str, options: dict[str, Any], picture: str | None) -> Answer:
    """The best grasps of a mesh."""
    with Progress() as progress:
        progress.enter("plan_grasps")
        found = plan_grasps(file, progress=lambda done, all_: progress.update(done / all_), **options)
    rows = [
        (number(p.radius, 5), *("-" if v is None else number(v, 4) for v in (p.hold, p.opening)),
         " ".join(vector(c.point) for c in p.grasp.contacts))
        for p in found.grasps
    ]  # fmt: skip
    head = (say("grasp.radius_head"), say("grasp.hold_head"), say("grasp.finger_head"), say("grasp.contacts_head"))
    lines = [found.explain()]
    if rows:
        lines += [say("grasp.plan_head", name=Path(file).name), *table(head, rows)]
    if picture is not None and found.grasps:
        _draw(partial(_plan_picture, found), Path(picture))
        lines.append(say("cli.picture_written", path=picture))
    data = {
        "tried": found.tried, "closing": found.closing, "length": found.body.size, "centre": found.body.centre,
        "open_edges": found.body.open_edges,
        "grasps": [
            {"radius": p.radius, "hold": p.hold, "opening": p.opening, **p.grasp.to_dict()} for p in found.grasps
        ],
    }  # fmt: skip
    return Answer(data, tuple(lines), None if found.grasps else found.explain())


def _plan_picture(plan: GraspPlan, path: Path) -> None:
    from mafsil.figures.grasp_plan import save_plan

    save_plan(plan, path)


def _judge(file: str, facets: str | int | None, steps: bool, picture: str | None) -> Answer:
    """Force closure, form closure, free motions, quality, and contact forces if the file has a load."""
    sketch = read(Path(file))
    held, edges = sketch.grasp, None if facets is None else _count(facets, "facets")
    found, form, free = held.closure(edges), held.form_closure(), held.free_motions()
    forces = None if sketch.load is None else held.resist(sketch.load)
    data: dict[str, Any] = {
        "grasp": held.to_dict(),
        "closure": found.to_dict(),
        "form_closure": form.to_dict(),
        "second_order": held.second_order().to_dict(),
        "free_motions": {"both_ways": free.reversible, "one_way": free.rays},
        "load": None if forces is None else _load_data(sketch, forces),
    }
    lines = [*_head(held), *_verdict(held, found), *held.explain()[1:]]
    if forces is not None:
        lines += _load_lines(forces)
    if steps:
        lines += [say("grasp.steps"), *("  " + line for line in eliminate(held.matrix(edges or 16)).lines())]
    if picture is not None:
        _draw(partial(_picture, sketch, found), Path(picture))
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    refusal = forces.explain() if forces is not None and not forces.holds else None
    if refusal is None and not found.force_closure:
        refusal = found.explain()
    return Answer(data, tuple(lines), refusal)


def _count(value: str | int, name: str) -> int:
    try:
        return int(value)
    except ValueError:
        raise InputError("input.numbers", name=f"--{name}", got=repr(value)) from None


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


def _picture(sketch: Sketch, found: Closure, path: Path) -> None:
    from mafsil.figures.grasp import save_grasp
    from mafsil.figures.grasp_motion import save_free_motions

    if path.suffix.lower() == _MOVING:
        save_free_motions(sketch.grasp, path, outline=sketch.outline)
    else:
        save_grasp(sketch.grasp, path, closure=found, outline=sketch.outline, body=sketch.body)


def _draw(task: Callable[[Path], None], path: Path) -> None:
    try:
        task(path)
    except OSError as error:
        raise FileError("cli.cannot_write", path=str(path), reason=error.strerror or str(error)) from None
