"""`mafsil lint`: what looks wrong in a robot description; `mafsil verify`: its routines against independent methods."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from mafsil.cli.answer import Answer, Tone, Toned
from mafsil.cli.state import count
from mafsil.cli.table import table
from mafsil.messages import say
from mafsil.model.diagnostics import Diagnostic, Report, Severity
from mafsil.model.file_reader import Change
from mafsil.model.lint import lint as linted
from mafsil.model.lint import repair
from mafsil.robot import load
from mafsil.verification import verify as verified
from mafsil.verification.verify import Peer
from mafsil.whole_file import write_whole

STATES = 8


def lint(robot: str, fix: str | None, only: list[str] | None = None) -> Answer:
    """The remarks about a description; with `fix` a corrected copy and the list of what was changed.

    The answer is a refusal where errors remain in the corrected copy, or where a change is a guess.

    Args:
        robot: name or file.
        fix: the file to write the corrected URDF to, or None.
        only: codes of the repairs to carry out, instead of those of all errors.

    Raises:
        MafsilError: no such robot, file or code, `fix` for another format than URDF, a file that cannot be written.
    """
    report = linted(robot)
    data: dict[str, object] = {
        "source": report.source,
        "ok": not report.errors,
        "diagnostics": [item.to_dict() for item in report],
    }
    lines = [*(_line(item) for item in report), *([""] if len(report.codes) else []), _summary(report)]
    if fix is None:
        refusal = say("lint.refused", robot=report.source, errors=len(report.errors)) if report.errors else None
        return Answer(data, tuple(lines), refusal)
    text, changes = repair(robot, only=only or ())
    write_whole(Path(fix), text.encode())
    data["fixed"] = fix
    data["changes"] = [{code: change.sentence(code) for code in ("en", "ar")} for change in changes]
    remaining, guesses = len(linted(Path(fix)).errors), sum(change.repair.guess for change in changes)
    data["remaining_errors"] = remaining
    refusal = say("lint.guessed", path=fix, count=guesses) if guesses else None
    refusal = say("lint.remain", path=fix, errors=remaining) if remaining else refusal
    return Answer(data, (*lines, "", *_change(fix, changes)), refusal)


_TONES: dict[Severity, Tone] = {Severity.ERROR: "bad", Severity.WARNING: "warning", Severity.INFO: "plain"}


def _line(item: Diagnostic) -> str:
    line = f"  {say(f'lint.severity_{item.severity.value}')}: {item.line_of_text()}"
    return Toned(line, _TONES[item.severity])


def _summary(report: Report) -> str:
    if not report.diagnostics:
        return Toned(say("lint.clean", robot=report.source), "good")
    notes = sum(item.severity is Severity.INFO for item in report)
    return say(
        "lint.summary", robot=report.source, errors=len(report.errors), warnings=len(report.warnings), notes=notes
    )


def _change(path: str, changes: tuple[Change, ...]) -> list[str]:
    if not changes:
        return [say("lint.nothing_fixed", path=path)]
    return [say("lint.fixed", path=path, count=len(changes)), *(f"  {change.sentence()}" for change in changes)]


def verify(robot: str, tip: str | None, against: list[str] | None, states: str | None, seed: str | None) -> Answer:
    """A table of routines, methods and errors.

    Args:
        robot: name or file.
        tip: another tip link.
        against: peers that are installed, `pinocchio`, `mujoco` or both.
        states: how many random states, as typed; 8 if None.
        seed: of the states, as typed; 0 if None.

    Raises:
        MafsilError: no such robot, no such peer.
    """
    peers = cast("list[Peer]", against or [])
    report = verified(
        load(robot, tip=tip),
        peers,
        states=STATES if states is None else count("states", states),
        seed=0 if seed is None else count("seed", seed),
    )
    head = [say(f"verification.{name}") for name in ("routine", "method", "error", "limit", "verdict")]
    first, *rest = report.explain().split("\n")
    lines = [*table(head, report.table()), "", Toned(first, "good" if report else "bad"), *rest]
    return Answer(report.to_dict(), tuple(lines), None if report else first)
