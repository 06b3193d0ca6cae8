"""`mafsil workspace`: where the tip reaches, as numbers and as a picture."""

from __future__ import annotations

from typing import cast

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.loops import require_open_chain
from mafsil.cli.numerals import count
from mafsil.cli.numerals import number as typed
from mafsil.cli.picture import PLAIN, drawn, require_kind
from mafsil.cli.table import brief, table
from mafsil.messages import say
from mafsil.performance import workspace_map
from mafsil.performance.workspace import WorkspaceMap
from mafsil.performance.workspace.workspace_answers import View
from mafsil.robot import Robot, load

SAMPLES = 300_000


def workspace(
    robot: str,
    view: str | None,
    samples: str | None,
    cell: str | None,
    seed: str | None,
    picture: str | None,
    tip: str | None,
) -> Answer:
    """A map of random configurations: size with its error, extent, holes.

    Args:
        robot: name or file.
        view: grid of the map; `xy` for arms that move in that plane and `xyz` for others if None.
        samples: how many configurations, as typed.
        cell: edge of a cell, as typed.
        seed: of the configurations, as typed.
        picture: file to draw a flat map into.
        tip: another tip link.

    Raises:
        MafsilError: no such robot or view, no whole number, a spatial view to be drawn, a prismatic joint without
            limits.
    """
    if picture is not None:
        require_kind(picture, PLAIN)
    arm = load(robot, tip=tip)
    require_open_chain(arm.mechanism, "workspace")
    how_many = SAMPLES if samples is None else count("samples", samples)
    first = 0 if seed is None else count("seed", seed)
    edge = None if cell is None else typed("--cell", cell)
    natural = "xy" if _flat(arm) else "xyz"
    chosen = cast("View", view or natural)
    found = workspace_map(arm, how_many, view=chosen, cell=edge, seed=first)
    data = found.to_dict()
    lines = [found.explain(), *_extent(found), *_voids(found)]
    if picture is not None:
        from mafsil.figures.workspace_slice import save_workspace

        flat = found
        if view is None and natural == "xyz":
            flat = workspace_map(arm, how_many, view="radial" if _turns_about_z(arm) else "xz", seed=first)
        drawn(lambda path: save_workspace(flat, path), picture)
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    return Answer(data, tuple(lines))


def _flat(arm: Robot) -> bool:
    """Whether the tip keeps its height, whatever the joints do."""
    heights = np.asarray(arm.forward_kinematics(np.random.default_rng(0).uniform(-1, 1, (16, arm.n))))[:, 2, 3]
    return bool(np.ptp(heights) < 1e-9)


def _turns_about_z(arm: Robot) -> bool:
    S = np.asarray(arm.jacobian_space(np.zeros(arm.n)))[:, 0]
    return bool(np.allclose(np.abs(S), [0, 0, 1, 0, 0, 0], atol=1e-9))


def _extent(found: WorkspaceMap) -> list[str]:
    head = [say(f"cli.{key}") for key in ("workspace_axis", "workspace_from", "workspace_to")]
    return table(head, [(name, brief(low), brief(high)) for name, (low, high) in found.bounds.items()])


def _voids(found: WorkspaceMap) -> list[str]:
    unit = found.unit.replace("^2", "²").replace("^3", "³")
    places = [("(" + ", ".join(map(brief, void[:-1])) + ")", brief(float(void[-1]))) for void in found.voids()]
    lines = [say("cli.workspace_void", place=place, size=size, unit=unit) for place, size in places]
    return lines or [say("cli.workspace_no_void")]
