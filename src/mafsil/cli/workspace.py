"""`mafsil workspace`: where the tip reaches; `mafsil base-placement`: a base pose from which it reaches all targets."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.cli.answer import PLAIN, Answer, Laid, draw_picture, require_kind
from mafsil.cli.motion_input import PLACES
from mafsil.cli.state import count, number, require_open_chain, shown, unit
from mafsil.cli.state import number as typed
from mafsil.cli.table import brief, table
from mafsil.cli.tolerances import SAME_HEIGHT
from mafsil.collision import Scene
from mafsil.csv_table import read_csv_table
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.performance import workspace_map
from mafsil.performance.workspace import WorkspaceMap
from mafsil.performance.workspace.workspace_answers import View
from mafsil.planning import BasePlacement, optimal_base_placement
from mafsil.robot import Robot, load

if TYPE_CHECKING:
    import mafsil.job.planning.surroundings as surroundings
else:
    surroundings = lazily("mafsil.job.planning.surroundings")


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
        lines.append(draw_picture(partial(save_workspace, flat), picture, data))
    return Answer(data, tuple(lines))


def _flat(arm: Robot) -> bool:
    """Whether the tip keeps its height, whatever the joints do."""
    heights = np.asarray(arm.forward_kinematics(np.random.default_rng(0).uniform(-1, 1, (16, arm.n))))[:, 2, 3]
    return bool(np.ptp(heights) < SAME_HEIGHT)


def _turns_about_z(arm: Robot) -> bool:
    S = np.asarray(arm.jacobian_space(np.zeros(arm.n)))[:, 0]
    return bool(np.allclose(np.abs(S), [0, 0, 1, 0, 0, 0], atol=SAME_HEIGHT))


def _extent(found: WorkspaceMap) -> list[str]:
    head = [say(f"cli.{key}") for key in ("workspace_axis", "workspace_from", "workspace_to")]
    return table(head, [(name, brief(low), brief(high)) for name, (low, high) in found.bounds.items()])


def _voids(found: WorkspaceMap) -> list[str]:
    unit = found.unit.replace("^2", "²").replace("^3", "³")
    places = [("(" + ", ".join(map(brief, void[:-1])) + ")", brief(float(void[-1]))) for void in found.voids()]
    lines = [say("cli.workspace_void", place=place, size=size, unit=unit) for place, size in places]
    return lines or [say("cli.workspace_no_void")]


def base_placement(
    robot: str,
    targets: str,
    scene: str | None,
    x: list[str] | None,
    y: list[str] | None,
    height: list[str] | None,
    yaws: str | None,
    spacing: str | None,
    enough_clearance: str | None,
    stands_on: list[str] | None,
    picture: str | None,
    tip: str | None,
    degrees: bool,
) -> Answer:
    """The base pose from which an arm reaches all targets best.

    Args:
        robot: name or file.
        targets: CSV file with columns x, y, z [m] and roll, pitch, yaw.
        scene: file of `[[obstacle]]` tables.
        x, y: from and to, of the base [m].
        height: of the base [m], one or several.
        yaws: how many turns of the base are tried.
        spacing: of the grid [m].
        enough_clearance: beyond which more does not count [m].
        stands_on: names of obstacles that the base may touch.
        picture: file for the map.
        tip: another tip link.
        degrees: whether angles of the targets are degrees, and angles are printed so.

    Raises:
        MafsilError: no such robot or file, numbers out of range.
    """
    arm = load(robot, tip=tip)
    require_open_chain(arm.mechanism, "base-placement")
    around = Scene() if scene is None else surroundings.scene_in(Path(scene))
    found = optimal_base_placement(
        arm, _targets(targets, degrees=degrees), scene=around,
        region=(_ends("--x", x), _ends("--y", y)),
        heights=[number("--height", word) for word in height or ["0"]],
        yaws=8 if yaws is None else count("--yaws", yaws),
        spacing=0.1 if spacing is None else number("--spacing", spacing),
        enough_clearance=0.1 if enough_clearance is None else number("--enough-clearance", enough_clearance),
        stands_on=stands_on or (),
    )  # fmt: skip
    data = {"robot": arm.name, **found.to_dict()}
    if picture is not None:
        # matplotlib takes half a second to import, and few answers are draw_picture.
        from mafsil.figures.workspace_slice import plot_placement

        plot_placement(found, picture, scene=around)
        data["picture"] = picture
    if not found:
        return Answer(data, (), found.explain(), interrupted=found.interrupted)
    lines = (*found.explain().splitlines(), *_configurations(arm, found, degrees=degrees))
    return Answer(data, lines, interrupted=found.interrupted)


def _targets(file: str, *, degrees: bool) -> PoseMatrix:
    """(m, 4, 4) of the rows of a file."""
    rows = read_csv_table(file, fewest=1)
    columns = list[int]()
    for name in PLACES:
        place = rows.column(name)
        if place is None:
            raise rows.no_column(name)
        columns.append(place)
    values = rows.numbers(columns)
    T = np.tile(np.eye(4), (len(values), 1, 1))
    T[:, :3, 3] = values[:, :3]
    T[:, :3, :3] = rotation.from_rpy(np.radians(values[:, 3:]) if degrees else values[:, 3:])
    return T


def _ends(name: str, words: list[str] | None) -> tuple[float, float]:
    if not words:
        return -1.0, 1.0
    if len(words) != 2:
        raise InputError("cli.base_placement_ends", name=name, got=len(words))
    return number(name, words[0]), number(name, words[1])


def _configurations(arm: Robot, found: BasePlacement, *, degrees: bool) -> list[Laid]:
    joints = arm.mechanism.coordinates
    head = ["", *(f"{joint.name} [{unit(joint.kind, degrees=degrees)}]" for joint in joints)]
    rows = [
        [str(k), *(brief(shown(float(v), joint.kind, degrees=degrees)) for v, joint in zip(row, joints, strict=True))]
        for k, row in enumerate(found.configurations)
    ]
    return [Laid(line) for line in table(head, rows)]
