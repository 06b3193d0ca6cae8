"""What other robots of a job file do, as moves one after the other: loops unrolled, choices as forks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mafsil.job.language.frames import Complaint
from mafsil.job.language.pose_checks import check_pose
from mafsil.job.language.resolving import MOST_MOVES, past
from mafsil.job.language.statements import OtherProgram, OtherStatement
from mafsil.job.lines import Path
from mafsil.job.other_robot import OtherAction, OtherMove, OtherPlace, OtherRobot
from mafsil.job.signals import Fork

ACTIONS = ("joints", "pose", "pause", "set", "wait", "do", "if_")


def other_robots(programs: tuple[OtherProgram, ...], error: Complaint) -> tuple[OtherRobot, ...]:
    """The robots beside that of a job.

    Args:
        programs: as the file has them, checked.
        error: makes the complaint about a key.

    Raises:
        JobError: too many moves.
    """
    found: list[OtherRobot] = []
    for k, program in enumerate(programs):
        moves: list[OtherMove] = []
        for move, _ in _unroll(program.move, ()):
            moves.append(move)
            if len(moves) > MOST_MOVES:
                raise error("job.too_many_moves", ("other_robot", k, "move"), most=MOST_MOVES)
        place: dict[str, Any] = {name: getattr(program, name) for name in OtherPlace.__struct_fields__}
        found.append(OtherRobot(**place, move=tuple(moves)))
    return tuple(found)


def check_programs(programs: tuple[OtherProgram, ...], error: Complaint) -> None:
    """Refuse steps that are not exactly one thing, loops and choices without moves.

    Args:
        programs: as the file has them.
        error: makes the complaint about a key.

    Raises:
        JobError: naming the key.
    """
    for k, program in enumerate(programs):
        _check_moves(program.move, ("other_robot", k, "move"), error)


def _unroll(statements: tuple[OtherStatement, ...], path: Path) -> Iterator[tuple[OtherMove, Path]]:
    """Moves of statements, with where they stand under the moves of their robot."""
    for k, each in enumerate(statements):
        here = (*path, k)
        if each.do is not None:
            yield from _rounds(each, each.do, here)
        elif each.then is not None:
            ways = [
                list(_unroll(inner, (*here, key))) for key, inner in (("then", each.then), ("else", each.else_ or ()))
            ]
            yield OtherMove(fork=Fork(tests=each.if_, skip=len(ways[0]), other=bool(ways[1])), origin=here), here
            yield from past(ways[0], len(ways[1]))
            yield from ways[1]
        else:
            plain: dict[str, Any] = {name: getattr(each, name) for name in OtherAction.__struct_fields__}
            yield OtherMove(**plain, origin=here), here


def _rounds(each: OtherStatement, inner: tuple[OtherStatement, ...], path: Path) -> Iterator[tuple[OtherMove, Path]]:
    """Moves of all rounds of a loop; with `while` each begins with a fork past all that is left."""
    count = each.repeat or 1
    once = list(_unroll(inner, (*path, "do")))
    for turn in range(count):
        if each.while_:
            left = (count - turn) * (len(once) + 1)
            yield OtherMove(fork=Fork(tests=each.while_, skip=left - 1, loop=True), origin=path), path
        yield from once


def _check_moves(statements: tuple[OtherStatement, ...], path: Path, error: Complaint) -> None:
    for k, each in enumerate(statements):
        here = (*path, k)
        given = [name for name in ACTIONS if getattr(each, name) not in (None, {})]
        if len(given) != 1:
            raise error("job.other_move", here)
        if (each.then is not None or each.else_ is not None) and not each.if_:
            raise error("job.other_move", here)
        if (each.repeat is not None or each.while_) and each.do is None:
            raise error("job.other_move", here)
        if each.pose is not None:
            check_pose(each.pose, (*here, "pose"), {"position": ()}, error)
        if each.do is not None:
            if each.repeat is None or not each.do:
                raise error("job.loop_endless" if each.while_ and each.do else "job.other_loop", here)
            _check_moves(each.do, (*here, "do"), error)
        if each.if_:
            if not each.then or each.else_ == ():
                raise error("job.choice_empty", here)
            _check_moves(each.then, (*here, "then"), error)
            _check_moves(each.else_ or (), (*here, "else"), error)
