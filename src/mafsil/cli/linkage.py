"""`mafsil linkage`: links as plates and one turn of the crank; `mafsil mobility`: how it can move; `mafsil synthesis`.

Mobility is counted, by rank and finite, with the reasons where they differ; synthesis gives the linkages for the poses,
points or function of a file, with their defects.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.cli.answer import Answer, draw_picture
from mafsil.cli.state import coordinate, count
from mafsil.cli.state import number as typed
from mafsil.cli.table import number, table
from mafsil.csv_table import csv_text
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.mobility import (
    Linkage,
    Mobility,
    close_drawing,
    configuration_surfaces,
    mobility,
    mobility_with_locked_joints,
)
from mafsil.mobility.linkages import CrankTurn, lock_joints, turn_crank
from mafsil.mobility.linkages.mechanism_linkage import as_linkage
from mafsil.mobility.linkages.plates import plates, write_plates
from mafsil.mobility.synthesis import (
    Candidate,
    ChainCandidate,
    ChainSynthesis,
    FunctionTask,
    Synthesis,
    synthesise_file,
)
from mafsil.mobility.synthesis import cognates as cognates_of
from mafsil.mobility.synthesis.answers import rows_of
from mafsil.whole_file import write_whole

MOST_SHOWN = 12
"""Rows of the table: all linkages of a finite problem, the best ones of a family."""
KINDS = (".html", ".csv", ".svg", ".dxf")
"""Of files for `--out`: animated page, table of the turn, links as plates."""
OF_TURNS = (".html", ".csv")


def linkage_of_file(
    file: str, turn: bool, crank: str | None, speed: float | None, rows: str | int | None, picture: str | None,
    out: Sequence[str] | None,
) -> Answer:  # fmt: skip
    """Links and their lengths, or one turn of the crank.

    Args:
        file: TOML with bodies and joints, or a name of the library.
        turn: drive it once round.
        crank: name of the driven joint; the actuated one if None.
        speed: of the crank [rad/s | m/s]; 1 if None.
        rows: configurations of one turn; 360 if None.
        picture: file for the plot of the turn.
        out: files: .html animated page, .csv table of the turn, .svg and .dxf links as plates.

    Raises:
        MafsilError: no such file, no such joint, a mobility that is not 1, an ending of no such file.
    """
    endings = [Path(each).suffix.lower() for each in out or ()]
    for each, ending in zip(out or (), endings, strict=True):
        if ending not in KINDS:
            raise InputError("pictures.ending", path=each, known=", ".join(KINDS))
    if not turn and (picture is not None or set(endings) & set(OF_TURNS)):
        raise InputError("cli.linkage_needs_turn")
    steps = 360 if rows is None else count("rows", str(rows))
    found = (
        turn_crank(file, crank, speed=1.0 if speed is None else typed("speed", str(speed)), rows=steps)
        if turn
        else None
    )
    linkage = as_linkage(file) if found is None else found.linkage
    data, lines = _links(linkage) if found is None else (found.to_dict(), repr(found).split("\n"))
    for each, ending in zip(out or (), endings, strict=True):
        _write(linkage, found, each, ending)
        lines.append(say("cli.linkage_written", path=each))
    if picture is not None and found is not None:
        from mafsil.figures.crank_turn import plot_crank_turn

        lines.append(draw_picture(partial(plot_crank_turn, found), picture, data))
    return Answer(data, tuple(lines), None if found is None or found else found.explain().split("\n")[0])


def _links(linkage: Linkage) -> tuple[dict[str, Any], list[str]]:
    """Distances of the pins of each link, as draw_picture."""
    rows: list[tuple[str, str, str]] = []
    links: list[dict[str, Any]] = []
    for each in plates(linkage):
        for i in range(len(each.pins)):
            for j in range(i):
                length = float(np.linalg.norm(each.pins[i] - each.pins[j]))
                rows.append((each.body, f"{each.names[j]} - {each.names[i]}", number(length)))
                links.append({"body": each.body, "pins": [each.names[j], each.names[i]], "length": length})
    heads = (say("cli.link"), say("cli.linkage_pins"), say("cli.linkage_length"))
    return {"links": links}, [repr(linkage), *table(heads, rows)]


def _write(linkage: Linkage, turn: CrankTurn | None, path: str, ending: str) -> None:
    if turn is None or ending not in OF_TURNS:
        write_plates(linkage, path)
    elif ending == ".csv":
        write_whole(Path(path), b"".join(csv_text(turn.series())))
    else:
        from mafsil.report.crank_turn import write_crank_turn

        write_crank_turn(turn, path)


def mobility_of(
    mechanism: str,
    q: Sequence[str] | None,
    rule: str | None,
    play: float | None,
    locked_joints: Sequence[str] | None,
    actuated: Sequence[str] | None,
    subsets: str | int | None,
    surfaces: bool,
    picture: str | None,
) -> Answer:
    """The report on a file of bodies and joints, or on a robot.

    Args:
        mechanism: TOML with bodies and joints, or name or file of a robot.
        q: coordinates at which a robot is draw_picture; all coordinates of a linkage.
        rule: planar, spherical or spatial.
        play: length to which parts are exact [m].
        locked_joints, actuated: names of joints.
        subsets: lock every choice of so many joints and show what is left.
        surfaces: look for the surfaces of configurations, of a mobility of 2.
        picture: file to draw into: the mechanism, or the first surface.

    Raises:
        MafsilError: no such file, no linkage, no such joints.
    """
    values = None if q is None else np.array([coordinate(f"q[{k}]", word)[0] for k, word in enumerate(q)])
    linkage = _with_choices(as_linkage(mechanism, values), actuated, locked_joints)
    found = mobility(linkage, rule=rule, play=play or 0.0)
    data, lines = found.to_dict(), found.explain().split("\n")
    if actuated is None and len(linkage.closing) and str(mechanism).lower().endswith((".sdf", ".world")):
        lines.append(say("cli.mobility_driven_unknown"))
    if subsets is not None:
        lines += _locked_lines(linkage, _count(subsets), data)
    followed = configuration_surfaces(linkage) if surfaces else None
    if followed is not None:
        data["surfaces"] = followed.to_dict()
        lines += [*repr(followed).split("\n"), *(one.explain().split("\n")[0] for one in followed)]
        lines += followed.surfaces[0].explain().split("\n")[1:] if followed else []
    if picture is not None and followed:
        from mafsil.figures import plot_surface

        lines.append(draw_picture(partial(plot_surface, followed.surfaces[0]), picture, data))
    elif picture is not None:
        lines.append(draw_picture(partial(_draw, linkage, found), picture, data))
    return Answer(data, tuple(lines), None if found else found.verdict())


def _with_choices(linkage: Linkage, actuated: Sequence[str] | None, locked_joints: Sequence[str] | None) -> Linkage:
    """The linkage with its drawing closed, with other actuators and joints locked, where that is asked for."""
    if linkage.apart:
        linkage = close_drawing(linkage)
    if actuated is not None:
        linkage = linkage.with_actuators(*actuated)
    return lock_joints(linkage, locked_joints) if locked_joints else linkage


def _locked_lines(linkage: Linkage, together: int, data: dict[str, Any]) -> list[str]:
    """A table of what is left of the mobility, a row for each choice of joints that are locked together."""
    left = mobility_with_locked_joints(linkage, together)
    data["mobility_with_locked_joints"] = [{"joints": list(names), "mobility": count} for names, count in left.items()]
    head = (say("cli.mobility_locked_head"), say("cli.mobility_left_head"))
    return table(head, [(", ".join(names), str(count)) for names, count in left.items()])


def _count(value: str | int) -> int:
    try:
        return int(value)
    except ValueError:
        raise InputError("input.numbers", name="--subsets", got=repr(value)) from None


def _draw(linkage: Linkage, found: Mobility, path: Path) -> None:
    from mafsil.figures.linkage import save_linkage
    from mafsil.figures.linkage_motion import save_linkage_motion

    save = save_linkage_motion if path.suffix.lower() == ".gif" else save_linkage
    save(linkage, path, found=found)


def synthesis_of(
    file: str, candidate: str | int | None = None, cognates: bool = False, picture: str | None = None
) -> Answer:
    """Linkages for a task in a file.

    Args:
        file: TOML with poses, points or a function.
        candidate: number of the one that is described and drawn, from 1 on.
        cognates: show the two other four-bars that draw its coupler curve.
        picture: file to draw into.

    Raises:
        MafsilError: no such file, no task, no such candidate, a file that cannot be written.
    """
    found, task = synthesise_file(file)
    shown = 1 if candidate is None else count("candidate", str(candidate))
    if candidate is not None and not 1 <= shown <= len(found):
        raise InputError("input.whole", name="candidate", value=shown, low=1, high=len(found))
    data, lines = found.to_dict(), found.explain().split("\n")
    if found.best is not None:
        lines = lines[: 2 if found.method else 1]
        head, rows = found.rows() if isinstance(found, ChainSynthesis) else rows_of(found.candidates)
        lines += table(head, rows[:MOST_SHOWN], words=(len(head) - 1,))
        if len(found) > MOST_SHOWN:
            lines.append(say("messages.more_rows", count=len(found) - MOST_SHOWN))
        lines += found[shown - 1].explain().split("\n")
        if task is not None:
            lines.append(_error_between(found, task, shown - 1, data))
        if cognates:
            three = cognates_of(_four_bar(found[shown - 1]))
            data["cognates"] = three.to_dict()
            lines += repr(three).split("\n")
    if picture is not None:
        from mafsil.figures.synthesis import plot_synthesis

        lines.append(draw_picture(partial(plot_synthesis, found, index=shown - 1), picture, data))
    return Answer(data, tuple(lines), None if found else found.explain().split("\n")[0])


def _four_bar(one: Candidate | ChainCandidate) -> Candidate:
    """The candidate, which has cognates.

    Raises:
        InputError: a six-bar or a spherical four-bar.
    """
    if isinstance(one, ChainCandidate):
        raise InputError("synthesis.cognate_kind")
    return one


def _error_between(found: Synthesis | ChainSynthesis, task: FunctionTask, index: int, data: dict[str, Any]) -> str:
    """The sentence about the error between the precision points; the number goes into the data."""
    largest = task.structural_error(found, index).largest
    lower, upper = task.interval
    data["structural_error"] = largest if np.isfinite(largest) else None
    if not np.isfinite(largest):
        return say("synthesis.function_gap", lower=lower, upper=upper)
    return say("synthesis.function_error", lower=lower, upper=upper, largest=largest)
