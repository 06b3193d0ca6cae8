"""`mafsil linkage`: the links of a linkage with their lengths, as plates to cut, and one turn of its crank."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.numerals import count
from mafsil.cli.numerals import number as typed
from mafsil.cli.table import number, table
from mafsil.csv_table import csv_text
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.mobility import Linkage
from mafsil.mobility.linkages import CrankTurn, turn_crank
from mafsil.mobility.linkages.mechanism_linkage import as_linkage
from mafsil.mobility.linkages.plates import plates, write_plates
from mafsil.whole_file import write_whole

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

        plot_crank_turn(found, picture)
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    return Answer(data, tuple(lines), None if found is None or found else found.explain().split("\n")[0])


def _links(linkage: Linkage) -> tuple[dict[str, Any], list[str]]:
    """Distances of the pins of each link, as drawn."""
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
