"""`mafsil grasp`: verdicts on a grasp file, with their proofs and the forces against its load; grasps of a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.cli.answer import Answer, Toned, draw_picture
from mafsil.cli.state import number as typed
from mafsil.cli.status_line import Progress
from mafsil.cli.table import number, table
from mafsil.cli.tolerances import SAME_QUALITY
from mafsil.errors import InputError
from mafsil.grasp import ClearanceMotion, Grasp, GraspPlan, GraspQuality, plan_grasps
from mafsil.grasp.closure import Closure, vector
from mafsil.grasp.closure_methods import eliminate
from mafsil.grasp.forces import ContactForces
from mafsil.grasp.grasp_file import GraspFile, read_grasp
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
    clearance: str | float | None = None,
    push: str | float | None = None,
) -> Answer:
    """Verdicts on a grasp file, or the best grasps of a mesh.

    Args:
        file: .toml or .json; or .stl, .obj, .dae.
        facets: edges of polyhedral cones; the true round ones if None.
        steps: show the elimination row by row.
        picture: file to draw into.
        fingers, mu, gamma, opening: of the grasps of a mesh.
        length, about: moments of the quality are divided by the one [m] and taken about the other point [m].
        clearance: of every finger [m], for the motion that it leaves.
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
        options = {"length": length, "about": about, "clearance": clearance, "push": push}
        _refuse({"facets": facets, "steps": steps or None, **options}, "grasp.not_for_mesh", file)
        return _plan(file, {name: value for name, value in plan.items() if value is not None}, picture)
    _refuse(plan, "grasp.not_for_grasp_file", file)
    request = _Request(
        1.0 if length is None else typed("--length", str(length)),
        None if about is None else [typed("--about", str(v)) for v in about],
        None if clearance is None else typed("--clearance", str(clearance)),
        None if push is None else typed("--push", str(push)),
    )
    return _judge(file, facets, steps, picture, request)


@dataclass(frozen=True)
class _Request:
    """What is requested beyond the verdicts."""

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
        found = plan_grasps(file, progress=progress.update, **options)
    rows = [
        (number(p.epsilon, 5), *("-" if v is None else number(v, 4) for v in (p.weight, p.opening)),
         " ".join(vector(c.point) for c in p.grasp.contacts))
        for p in found.grasps
    ]  # fmt: skip
    head = (say("grasp.epsilon_head"), say("grasp.weight_head"), say("grasp.finger_head"), say("grasp.contacts_head"))
    lines = [found.explain()]
    if rows:
        lines += [say("grasp.plan_head", name=Path(file).name), *table(head, rows)]
    if picture is not None and found.grasps:
        lines.append(draw_picture(partial(_plan_picture, found), picture, {}))
    return Answer(found.to_dict(), tuple(lines), None if found.grasps else found.explain())


def _plan_picture(plan: GraspPlan, path: Path) -> None:
    from mafsil.figures.grasp import save_plan

    save_plan(plan, path)


def _judge(file: str, facets: str | int | None, steps: bool, picture: str | None, request: _Request) -> Answer:
    """Force closure, form closure, free motions, quality, and contact forces if the file has a load."""
    given = read_grasp(Path(file))
    grasp_, edges = given.grasp, None if facets is None else _count(facets, "facets")
    found, form, free = grasp_.closure(edges), grasp_.form_closure(), grasp_.free_motions()
    forces = None if given.load is None else grasp_.resist(given.load, push=request.push)
    quality = grasp_.quality(request.length, about=request.about) if found.force_closure else None
    moved = None if request.clearance is None else grasp_.motion_within_clearance(request.clearance)
    data: dict[str, Any] = {
        "grasp": grasp_.to_dict(),
        "closure": found.to_dict(),
        "form_closure": form.to_dict(),
        "second_order": grasp_.second_order().to_dict(),
        "free_motions": {"both_ways": free.reversible, "one_way": free.rays},
        "quality": None if quality is None else _quality_data(quality, request),
        "clearance": None if moved is None else moved.to_dict(),
        "load": None if forces is None else {"wrench": given.load, **forces.to_dict()},
    }
    remarks = grasp_.explain().split("\n")[1:]
    lines = [*_head(grasp_), *_verdict(grasp_, found, quality, request), *remarks]
    if moved is not None:
        lines += _clearance_lines(moved)
    if forces is not None:
        lines += _load_lines(forces)
    if steps:
        lines += [say("grasp.steps"), *("  " + line for line in eliminate(grasp_.matrix(edges or 16)).lines())]
    if picture is not None:
        lines.append(draw_picture(partial(_picture, given, found), picture, data))
    refusal = forces.explain() if forces is not None and not forces.holds else None
    if refusal is None and not found.force_closure:
        refusal = found.explain()
    return Answer(data, tuple(lines), refusal)


def _count(value: str | int, name: str) -> int:
    try:
        return int(value)
    except ValueError:
        raise InputError("input.numbers", name=f"--{name}", got=repr(value)) from None


def _head(grasp: Grasp) -> list[str]:
    place = say("grasp.in_plane" if grasp.dimension == 2 else "grasp.in_space")
    rows = [
        (c.name or str(k), vector(c.point), vector(c.normal), number(c.mu, 4), number(c.gamma, 4))
        for k, c in enumerate(grasp.contacts)
    ]
    head = (say("grasp.contact_head"), say("grasp.point_head"), say("grasp.normal_head"), "mu", "gamma")
    return [say("grasp.title", name=grasp.name or "-", count=len(grasp), place=place), *table(head, rows)]


def _quality_data(quality: GraspQuality, request: _Request) -> dict[str, Any]:
    return {**quality.to_dict(), "length": request.length, "about": request.about}


def _clearance_lines(found: ClearanceMotion) -> list[str]:
    key = "grasp.clearance_table" if found.bounded else "grasp.clearance_table_unbounded"
    names = ("theta", "x", "y") if len(found.range) == 3 else ("rx", "ry", "rz", "x", "y", "z")
    rows = [
        (name, number(low, 6), number(high, 6)) for name, (low, high) in zip(names, found.range.tolist(), strict=True)
    ]
    head = (say("grasp.coordinate_head"), say("grasp.least_head"), say("grasp.greatest_head"))
    return [say(key, clearance=found.clearance), *table(head, rows)]


def _verdict(grasp: Grasp, found: Closure, quality: GraspQuality | None, request: _Request) -> list[str]:
    lines: list[str] = [Toned(found.explain(), "good" if found.force_closure else "bad")]
    if quality is not None:
        exact = quality.upper <= quality.epsilon * (1 + SAME_QUALITY)
        key = "grasp.quality" if exact else "grasp.quality_between" if quality.converged else "grasp.quality_gap"
        point = vector(np.zeros(grasp.dimension) if request.about is None else np.array(request.about))
        lines.append(say(key, epsilon=quality.epsilon, upper=quality.upper, length=request.length, point=point))
        if found.weakest_direction is not None:
            lines.append(say("grasp.weakest_direction", wrench=vector(found.weakest_direction)))
    if grasp.dimension == 2 and len(grasp) == 2 and all(c.mu > 0 for c in grasp.contacts):
        lines.append(two_fingers(*grasp.contacts).status.sentence())
    return lines


def _load_lines(forces: ContactForces) -> list[str]:
    lines = [forces.explain()]
    if forces.holds:
        rows = [(str(k), vector(f)) for k, f in enumerate(forces.forces)]
        lines += table((say("grasp.contact_head"), say("grasp.force_head")), rows)
    return lines


def _picture(given: GraspFile, found: Closure, path: Path) -> None:
    from mafsil.figures.grasp import save_free_motions, save_grasp

    if path.suffix.lower() == _MOVING:
        save_free_motions(given.grasp, path, outline=given.outline)
    else:
        save_grasp(given.grasp, path, closure=found, outline=given.outline, body=given.body)
