"""A job file as a job: names looked up, frames resolved, loops unrolled, choices as forks; of other robots too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import msgspec

from mafsil.arrays import PoseMatrix
from mafsil.job.language.description import TIP_PATHS, UNNAMED, Goal, Grasp, Head, Job, Move, Pose, Start, Step
from mafsil.job.language.frames import Complaint, Frames, places, pose_of
from mafsil.job.language.move_checks import check_pose
from mafsil.job.language.part import Fork
from mafsil.job.language.statements import JobFile, OtherProgram, OtherStatement, Placed, PlacedGoal, Statement
from mafsil.job.language.surrounding_tables import OtherAction, OtherMove, OtherPlace, OtherRobot
from mafsil.job.language.text import Keys
from mafsil.job.language.units import MILLIMETRE, is_possible
from mafsil.messages.visible import visible

MOST_MOVES = 200_000
"""After all loops are unrolled."""
Body: TypeAlias = tuple[tuple[Statement, ...], Keys]
"""Statements, and where they stand in the file."""
Named = TypeVar("Named")
AnyMove = TypeVar("AnyMove", Move, OtherMove)


def resolve(file: JobFile, others: tuple[OtherRobot, ...], folder: Path, error: Complaint) -> Job:
    """The job that a file asks for.

    1. Frames, each in {s}.
    2. Places of the patterns.
    3. Loops become moves, named after the places; each remembers the statement that it comes from.
    4. Poses go to {s}, names to what they name.

    Args:
        file: checked statement by statement, lengths in metres.
        others: robots beside it, their loops unrolled.
        folder: to which paths of files of places are relative.
        error: makes the complaint about a key.

    Raises:
        JobError: an unknown name, a frame in itself, a pattern or loop that cannot be, too many moves.
    """
    # 1
    reader = _Resolver(file, Frames.of(file, error), folder, error)
    # 3
    made = list(reader.unroll(file.move, ("move",), reader.frames, ""))
    start = Start(
        joints=reader.joints(file.start.joints, ("start", "joints")),
        pose=reader.goal(file.start.pose, ("start", "pose"), reader.frames),
        tool=reader.tool(file.start.tool, ("start", "tool")),
    )
    if start.pose is not None and start.pose.relative is not None:
        raise error("job.relative_start", ("start", "pose", "relative"))
    head: dict[str, Any] = {name: getattr(file, name) for name in Head.__struct_fields__}
    if start.pose is not None and start.pose.carrier is not None:
        raise error("job.frame_moves", ("start", "pose", "frame"), frame=visible(start.pose.carrier))
    head["lying"], head["moving"] = tuple(reader.lying()), reader.frames.moving()
    obstacles = tuple(reader.frames.obstacle(each, ("obstacle", k)) for k, each in enumerate(file.obstacle))
    moves, origins = tuple(move for move, _ in made), tuple(origin for _, origin in made)
    return Job(**head, start=start, obstacle=obstacles, other_robot=others, move=moves, origins=origins)


def move_name(name: str, place: str) -> str:
    """A move as sentences call it: by its name, and the place of the loop."""
    return f"{name} ({place})" if name and place else name or place


def past(moves: list[tuple[AnyMove, Keys]], other: int) -> list[tuple[AnyMove, Keys]]:
    """Moves of one way, those that end it passing over as many of the other.

    Args:
        moves: with where they stand in the file.
        other: moves of the other way, that come after them.
    """
    replaced = msgspec.structs.replace

    def passing(move: AnyMove, left: int) -> AnyMove:
        if move.fork is not None:
            fork = move.fork
            return replaced(move, fork=replaced(fork, skip=fork.skip + other)) if fork.skip == left else move
        return replaced(move, skip=move.skip + other) if move.skip == left else move

    return [(passing(move, len(moves) - 1 - k), place) for k, (move, place) in enumerate(moves)]


class _Resolver:
    """Looks up what a file names.

    Args:
        file: with its tables of names.
        frames: of it.
        folder: to which paths of files of places are relative.
        error: makes the complaint about a key.
    """

    def __init__(self, file: JobFile, frames: Frames, folder: Path, error: Complaint) -> None:
        self.file, self.frames, self.error, self.count = file, frames, error, 0
        self.called: tuple[str, ...] = ()
        # 2
        unit = MILLIMETRE if file.lengths == "millimetres" else 1.0
        self.places = {
            name: places(pattern, name, frames, unit, folder, error) for name, pattern in file.pattern.items()
        }

    def unroll(
        self, statements: tuple[Statement, ...], path: Keys, frames: Frames, place: str
    ) -> Iterator[tuple[Move, Keys]]:
        """Moves of statements, with where they stand in the file."""
        for k, statement in enumerate(statements):
            here = (*path, k)
            if statement.do is not None:
                yield from self.loop(statement, (statement.do, (*here, "do")), here, frames, place)
                continue
            if statement.call is not None:
                yield from self.call(statement, statement.call, here, frames, place)
                continue
            self.count += 1
            if self.count > MOST_MOVES:
                raise self.error("job.too_many_moves", here, most=MOST_MOVES)
            if statement.then is None:
                yield self.move(statement, here, frames, place), here
                continue
            ways = [
                list(self.unroll(inner, (*here, key), frames, place))
                for key, inner in (("then", statement.then), ("else", statement.else_ or ()))
            ]
            fork = Fork(tests=statement.if_, skip=len(ways[0]), other=bool(ways[1]))
            yield Move(name=move_name(statement.name, place), fork=fork), here
            yield from past(ways[0], len(ways[1]))
            yield from ways[1]

    def call(
        self, statement: Statement, name: str, path: Keys, frames: Frames, place: str
    ) -> Iterator[tuple[Move, Keys]]:
        """Moves of a group, once or in rounds."""
        inner = self.looked_up(name, self.file.group, "group", (*path, "call"))
        if name in self.called:
            circle = " -> ".join(map(visible, (*self.called, name)))
            raise self.error("job.group_circle", (*path, "call"), circle=circle)
        before, self.called = self.called, (*self.called, name)
        yield from self.loop(statement, (inner, ("group", name)), path, frames, place)
        self.called = before

    def loop(
        self, statement: Statement, body: Body, path: Keys, frames: Frames, place: str
    ) -> Iterator[tuple[Move, Keys]]:
        """Moves of all rounds of a loop; with `while` each begins with a fork past all that is left."""
        rounds = self.all_rounds(statement, body, path, frames, place)
        if not statement.while_:
            for moves in rounds:
                yield from moves
            return
        whole = list(rounds)
        left = sum(len(moves) + 1 for moves in whole)
        for moves in whole:
            fork = Fork(tests=statement.while_, skip=left - 1, loop=True)
            yield Move(name=move_name(statement.name, place), fork=fork), path
            yield from moves
            left -= len(moves) + 1

    def all_rounds(
        self, statement: Statement, body: Body, path: Keys, frames: Frames, place: str
    ) -> Iterator[list[tuple[Move, Keys]]]:
        """Moves of each round of a loop."""
        for _ in range(statement.repeat or 1):
            for label, poses in self.rounds(statement, path):
                both = " ".join(word for word in (place, label) if word)
                yield list(self.unroll(*body, frames.inside(poses), both))

    def rounds(self, statement: Statement, path: Keys) -> list[tuple[str, dict[str, PoseMatrix]]]:
        """Label and frames of each round of a loop; one without both of a plain one."""
        if statement.each is None:
            return [("", {})]
        names = (statement.each,) if isinstance(statement.each, str) else statement.each
        found = [self.looked_up(name, self.places, "pattern", (*path, "each")) for name in names]
        if len({len(each) for each in found}) != 1:
            counts = ", ".join(f"{visible(name)}: {len(each)}" for name, each in zip(names, found, strict=True))
            raise self.error("job.uneven_patterns", (*path, "each"), counts=counts)
        return [
            (
                " ".join(f"{name} {label}" for name, (label, _) in zip(names, together, strict=True)),
                {name: T for name, (_, T) in zip(names, together, strict=True)},
            )
            for together in zip(*found, strict=True)
        ]

    def move(self, statement: Statement, path: Keys, frames: Frames, place: str) -> Move:
        """One move, its name with the place of the loop."""
        given: dict[str, Any] = {each: getattr(statement, each) for each in Step.__struct_fields__}
        given["name"] = move_name(statement.name, place)
        # 4
        given["joints"] = self.joints(statement.joints, (*path, "joints"))
        given["tool"] = self.tool(statement.tool, (*path, "tool"))
        given["pick"] = self.part(statement.pick, (*path, "pick"))
        given["pose"] = self.goal(statement.pose, (*path, "pose"), frames)
        given["constraints"] = (
            None
            if statement.constraints is None
            else frames.constraints_in_space(statement.constraints, (*path, "constraints"))
        )
        given["via"] = tuple(
            self.via(each, statement, (*path, "via", k), frames) for k, each in enumerate(statement.via)
        )
        if statement.through is not None:
            found = self.looked_up(statement.through, self.places, "pattern", (*path, "through"))
            frames.require_standing(statement.through, (*path, "through"))
            if len(found) < 2:
                raise self.error("job.through", (*path, "through"))
            *between, last = (pose_of(T) for _, T in found)
            given["via"], given["pose"] = tuple(between), Goal(position=last.position, quaternion=last.quaternion)
        return Move(**given)

    def via(
        self, given: tuple[float, ...] | Placed | str, statement: Statement, path: Keys, frames: Frames
    ) -> tuple[float, ...] | Pose:
        """A point on the way: of a path of the tip a pose, else joint coordinates."""
        if isinstance(given, str) and statement.path in TIP_PATHS:
            given = self.looked_up(given, self.file.pose, "pose", path)
            if given.relative is not None:
                raise self.error("job.relative_via", path)
        if isinstance(given, Placed):
            goal = statement.pose if isinstance(statement.pose, PlacedGoal) else None
            if frames.carrier(given.frame) != frames.carrier(None if goal is None else goal.frame):
                raise self.error("job.frame_moves", (*path, "frame"), frame=visible(str(given.frame)))
            return frames.point(given, path)
        found = self.joints(given, path)
        assert found is not None
        return found

    def joints(self, given: tuple[float, ...] | str | None, path: Keys) -> tuple[float, ...] | None:
        """Joint coordinates, of a name those that it names."""
        return (
            self.looked_up(given, self.file.configuration, "configuration", path) if isinstance(given, str) else given
        )

    def tool(self, given: str | None, path: Keys) -> str | None:
        """The name of a tool that there is."""
        if given is not None:
            self.looked_up(given, self.file.tools, "tools", path)
        return given

    def part(self, given: Grasp | str | None, path: Keys) -> Grasp | None:
        """What is picked, of a name the part that it names."""
        if isinstance(given, str):
            named = self.looked_up(given, self.file.part, "part", path)
            plain: dict[str, Any] = {name: getattr(named, name) for name in Grasp.__struct_fields__}
            path = ("part", given)
            given = msgspec.structs.replace(Grasp(**plain), name=given if named.name == UNNAMED else named.name)
        if given is not None and not is_possible(given):
            raise self.error("job.part_inertia", (*path, "inertia"))
        return given

    def lying(self) -> Iterator[tuple[Grasp, Pose, str | None]]:
        """Each part that lies somewhere at the beginning, where, and on which moving frame."""
        for name, given in self.file.part.items():
            part, path = self.part(name, ("part",)), ("part", name, "at")
            assert part is not None
            carrier = self.frames.carrier(given.at.frame if isinstance(given.at, Placed) else given.at)
            if isinstance(given.at, str):
                places = self.looked_up(given.at, self.places, "pattern", path)
                yield from ((part, pose_of(T), carrier) for _, T in places)
            elif given.at is not None:
                yield part, pose_of(self.frames.place(given.at, path)), carrier

    def goal(self, given: PlacedGoal | str | None, path: Keys, frames: Frames) -> Goal | None:
        """A goal, of a name the pose that it names."""
        if isinstance(given, str):
            named = self.looked_up(given, self.file.pose, "pose", path)
            return frames.goal(named, ("pose", given))
        return None if given is None else frames.goal(given, path)

    def looked_up(self, name: str, table: Mapping[str, Named], kind: str, path: Keys) -> Named:
        """What a name means.

        Raises:
            JobError: nothing.
        """
        if name not in table:
            known = ", ".join(map(visible, table)) or "-"
            raise self.error("job.unknown_name", path, table=kind, given=visible(name), known=known)
        return table[name]


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


def _unroll(statements: tuple[OtherStatement, ...], path: Keys) -> Iterator[tuple[OtherMove, Keys]]:
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


def _rounds(each: OtherStatement, inner: tuple[OtherStatement, ...], path: Keys) -> Iterator[tuple[OtherMove, Keys]]:
    """Moves of all rounds of a loop; with `while` each begins with a fork past all that is left."""
    count = each.repeat or 1
    once = list(_unroll(inner, (*path, "do")))
    for turn in range(count):
        if each.while_:
            left = (count - turn) * (len(once) + 1)
            yield OtherMove(fork=Fork(tests=each.while_, skip=left - 1, loop=True), origin=path), path
        yield from once


def _check_moves(statements: tuple[OtherStatement, ...], path: Keys, error: Complaint) -> None:
    for k, each in enumerate(statements):
        here = (*path, k)
        given = [name for name in ACTIONS if getattr(each, name) not in (None, {})]
        branches, turns = each.then is not None or each.else_ is not None, each.repeat is not None or each.while_
        if len(given) != 1 or (branches and not each.if_) or (turns and each.do is None):
            raise error("job.other_move", here)
        if each.pose is not None:
            check_pose(each.pose, (*here, "pose"), {"position": ()}, error)
        if each.do is not None:
            if each.repeat is None or not each.do:
                raise error("job.loop_endless" if each.while_ and each.do else "job.other_loop", here)
            _check_moves(each.do, (*here, "do"), error)
        if each.if_:
            _check_branches(each, here, error)


def _check_branches(choice: OtherStatement, path: Keys, error: Complaint) -> None:
    if not choice.then or choice.else_ == ():
        raise error("job.choice_empty", path)
    _check_moves(choice.then, (*path, "then"), error)
    _check_moves(choice.else_ or (), (*path, "else"), error)
