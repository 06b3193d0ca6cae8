"""`mafsil grasp`: verdicts on a grasp sketch, with their proofs and the forces against its load; grasps of a mesh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.numerals import number as typed
from mafsil.cli.progress import Progress
from mafsil.cli.table import number, table
from mafsil.errors import FileError, InputError
from mafsil.grasp import Ball, Grasp, GraspPlan, Wiggle, plan_grasps
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
    length: str | float | None = None,
    about: Sequence[str | float] | None = None,
    wiggle: str | float | None = None,
    push: str | float | None = None,
) -> Answer:
    """Verdicts on a sketch, or the best grasps of a mesh.

    Args:
        file: .toml or .json; or .stl, .obj, .dae.
        facets: edges of polyhedral cones; the true round ones if None.
        steps: show the elimination row by row.
        picture: file to draw into.
        fingers, mu, gamma, opening: of the grasps of a mesh.
        length, about: moments of the quality are divided by the one [m] and taken about the other point [m].
        wiggle: clearance of every finger [m].
        push: greatest normal force of each contact against the load [N].

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
        asked = {"length": length, "about": about, "wiggle": wiggle, "push": push}
        _refuse({"facets": facets, "steps": steps or None, **asked}, "grasp.not_for_mesh", file)
        return _plan(file, {name: value for name, value in plan.items() if value is not None}, picture)
    _refuse(plan, "grasp.not_for_sketch", file)
    wanted = _Wanted(
        1.0 if length is None else typed("--length", str(length)),
        None if about is None else [typed("--about", str(v)) for v in about],
        None if wiggle is None else typed("--wiggle", str(wiggle)),
        None if push is None else typed("--push", str(push)),
    )
    return _judge(file, facets, steps, picture, wanted)


@dataclass(frozen=True)
class _Wanted:
    """What is asked beyond the verdicts."""

    length: float
    about: list[float] | None
    clearance: float | None
    push: float | None


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


def _judge(file: str, facets: str | int | None, steps: bool, picture: str | None, wanted: _Wanted) -> Answer:
    """Force closure, form closure, free motions, quality, and contact forces if the file has a load."""
    sketch = read(Path(file))
    held, edges = sketch.grasp, None if facets is None else _count(facets, "facets")
    found, form, free = held.closure(edges), held.form_closure(), held.free_motions()
    forces = None if sketch.load is None else held.resist(sketch.load, push=wanted.push)
    ball = held.quality(wanted.length, about=wanted.about) if found.force_closure else None
    wiggled = None if wanted.clearance is None else held.wiggle(wanted.clearance)
    data: dict[str, Any] = {
        "grasp": held.to_dict(),
        "closure": found.to_dict(),
        "form_closure": form.to_dict(),
        "second_order": held.second_order().to_dict(),
        "free_motions": {"both_ways": free.reversible, "one_way": free.rays},
        "quality": None if ball is None else _ball_data(ball, wanted),
        "wiggle": None if wiggled is None else {"bounded": wiggled.bounded, "range": wiggled.range},
        "load": None if forces is None else _load_data(sketch, forces),
    }
    lines = [*_head(held), *_verdict(held, found, ball, wanted), *held.explain()[1:]]
    if wiggled is not None:
        lines += _wiggle_lines(wiggled)
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


def _ball_data(ball: Ball, wanted: _Wanted) -> dict[str, Any]:
    return {
        "radius": ball.radius, "upper": ball.upper, "met": ball.met, "weakest": ball.weakest,
        "length": wanted.length, "about": wanted.about,
    }  # fmt: skip


def _wiggle_lines(found: Wiggle) -> list[str]:
    key = "grasp.wiggle_bounded" if found.bounded else "grasp.wiggle_open"
    names = ("theta", "x", "y") if len(found.range) == 3 else ("rx", "ry", "rz", "x", "y", "z")
    rows = [
        (name, number(low, 6), number(high, 6)) for name, (low, high) in zip(names, found.range.tolist(), strict=True)
    ]
    head = (say("grasp.coordinate_head"), say("grasp.least_head"), say("grasp.greatest_head"))
    return [say(key, clearance=found.clearance), *table(head, rows)]


def _verdict(held: Grasp, found: Closure, ball: Ball | None, wanted: _Wanted) -> list[str]:
    lines = [found.explain()]
    if ball is not None:
        exact = ball.upper <= ball.radius * (1 + 1e-9)
        key = "grasp.ball" if exact else "grasp.ball_between" if ball.met else "grasp.ball_gap"
        point = vector(np.zeros(held.dimension) if wanted.about is None else np.array(wanted.about))
        lines.append(say(key, radius=ball.radius, upper=ball.upper, length=wanted.length, point=point))
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
