"""Whether the signals of a job file fit each other: names, kinds of values, tables in order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches

from mafsil.job.description import Variable
from mafsil.job.language.frames import Complaint
from mafsil.job.language.statements import JobFile, OtherStatement, Statement
from mafsil.job.lines import Path
from mafsil.job.signals import Between, Condition, Input, SignalValue, Test
from mafsil.messages.visible import visible

TESTS = ("if", "while")
"""Keys that look at variables, too."""


def require_signals(file: JobFile, error: Complaint) -> None:
    """Refuse what cannot be set, waited for or answered.

    Args:
        file: checked key by key.
        error: makes the complaint about a key.

    Raises:
        JobError: a name that is output and input, or neither; a value of another kind; a table out of order.
    """
    for name, source in file.input.items():
        if name in file.output:
            raise error("job.signal_twice", ("input", name), signal=visible(name))
        _require_source(source, ("input", name), file, error)
    digital = {name: isinstance(value, bool) for name, value in file.output.items()}
    for name, source in file.input.items():
        digital[name] = isinstance(source.start, bool) if source.follows is None else digital[source.follows]
    for statement, path in _statements(file.move, ("move",)):
        for values, here in outputs_of(statement, path):
            _require_values(values, file, digital, here, error)
        until = statement.until if isinstance(statement, Statement) else {}
        for key, conditions in (("wait", statement.wait), ("until", until)):
            for name, wanted in conditions.items():
                _require_kind(wanted, digital, name, (*path, key, name), error)
        for key, tests in (("if", statement.if_), ("while", statement.while_)):
            for name, test in tests.items():
                _require_test(test, digital, file.variables, name, (*path, key, name), error)
    touched = file.surface or file.hole or file.door or file.guide
    for statement, path in _statements(file.move, ("move",)):
        if isinstance(statement, Statement) and statement.until_force is not None and not touched:
            raise error("job.search_surface", (*path, "until_force"))
    for name, frame in file.frame.items():
        if frame.since is not None and not (frame.since in file.input and digital[frame.since]):
            known = ", ".join(visible(one) for one in file.input if digital[one]) or "-"
            raise error("job.frame_since", ("frame", name, "since"), given=visible(frame.since), known=known)
    _require_others(file, digital, error)


def _require_others(file: JobFile, digital: Mapping[str, bool], error: Complaint) -> None:
    """Signals of other robots, each output set by one robot alone."""
    statements = _statements(file.move, ("move",))
    main = (name for one, path in statements for values, _ in outputs_of(one, path) for name in values)
    owners = dict.fromkeys(main, "@job.owner_main")
    for k, robot in enumerate(file.other_robot):
        for move, path in _statements(robot.move, ("other_robot", k, "move")):
            _require_values(move.set, file, digital, path, error)
            for name, wanted in move.wait.items():
                _require_kind(wanted, digital, name, (*path, "wait", name), error)
            for key, tests in (("if", move.if_), ("while", move.while_)):
                for name, test in tests.items():
                    _require_test(test, digital, file.variables, name, (*path, key, name), error)
            for name in move.set:
                first = owners.setdefault(name, visible(robot.name))
                if first != visible(robot.name):
                    details = {"signal": visible(name), "first": first, "second": visible(robot.name)}
                    raise error("job.signal_owner", (*path, "set", name), **details)


def outputs_of(statement: Statement | OtherStatement, path: Path) -> Iterator[tuple[Mapping[str, SignalValue], Path]]:
    """What a statement sets, at rest and on the way, and where that stands."""
    yield statement.set, path
    if isinstance(statement, Statement):
        yield from ((one.set, (*path, "outputs", k)) for k, one in enumerate(statement.outputs))


def _require_values(
    values: Mapping[str, SignalValue], file: JobFile, digital: Mapping[str, bool], path: Path, error: Complaint
) -> None:
    """Outputs, and values of their kind."""
    for name, value in values.items():
        here = (*path, "set", name)
        if name in file.input:
            raise error("job.signal_input", here, signal=visible(name))
        _require_kind(value, digital, name, here, error)


def _require_source(source: Input, path: Path, file: JobFile, error: Complaint) -> None:
    """A table in order, or the answer to an output."""
    if source.follows is not None:
        given = {"start": source.start is not False, "changes": bool(source.changes), "every": source.every is not None}
        for key in (key for key, there in given.items() if there):
            raise error("job.signal_answer", (*path, key))
        if source.follows not in file.output:
            known = ", ".join(map(visible, file.output)) or "-"
            raise error("job.signal_follows", (*path, "follows"), given=visible(source.follows), known=known)
        return
    if source.after > 0.0:
        raise error("job.signal_after", (*path, "after"))
    if source.every is not None and not source.changes:
        raise error("job.signal_every", (*path, "every"))
    last = -1.0
    for k, (time, value) in enumerate(source.changes):
        if time <= last or (source.every is not None and time >= source.every):
            raise error("job.signal_order", (*path, "changes", k), time=f"{time:g}")
        if isinstance(value, bool) is not isinstance(source.start, bool):
            raise error("job.signal_start", (*path, "changes", k))
        last = time


def _require_kind(
    given: SignalValue | Condition,
    digital: Mapping[str, bool],
    name: str,
    path: Path,
    error: Complaint,
    variables: Iterable[str] = (),
) -> None:
    """The name of a signal, and a value, or condition, of its kind."""
    if name not in digital:
        there = [*digital, *variables]
        known = ", ".join(map(visible, get_close_matches(name, there, n=1, cutoff=0.55) or there)) or "-"
        key = "job.test_unknown" if path[-2] in TESTS else "job.signal_unknown"
        raise error(key, path, signal=visible(name), known=known)
    if isinstance(given, Between):
        if given.above is None and given.below is None:
            raise error("job.signal_bounds", path)
        if given.above is not None and given.below is not None and not given.above < given.below:
            raise error("job.signal_bounds", path)
    if isinstance(given, bool) is not digital[name]:
        raise error("job.signal_digital" if digital[name] else "job.signal_number", path, signal=visible(name))


def _require_test(
    test: Test, digital: Mapping[str, bool], variables: Mapping[str, Variable], name: str, path: Path, error: Complaint
) -> None:
    """The name of a signal or of a variable, not of both, and what its values can be compared with."""
    if name not in variables:
        if isinstance(test, str):
            raise error("job.test_text", path, signal=visible(name))
        _require_kind(test, digital, name, path, error, variables)
        return
    value = variables[name]
    if name in digital:
        raise error("job.test_both", path, signal=visible(name))
    if isinstance(value, tuple):
        raise error("job.test_list", path, variable=visible(name))
    if isinstance(test, str) is not isinstance(value, str):
        raise error("job.test_kind", path, variable=visible(name), value=visible(str(value)))
    if not isinstance(test, str):
        _require_kind(test, {name: isinstance(value, bool)}, name, path, error)


def _statements(
    statements: Sequence[Statement | OtherStatement], path: Path
) -> Iterator[tuple[Statement | OtherStatement, Path]]:
    """All statements, those in loops and choices too, each with its place."""
    for k, statement in enumerate(statements):
        yield statement, (*path, k)
        for key, inner in (("do", statement.do), ("then", statement.then), ("else", statement.else_)):
            yield from _statements(inner or (), (*path, k, key))
