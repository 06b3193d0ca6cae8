"""Two results of jobs side by side: what changed in the job, the numbers, the joints, the moves and the findings."""

from __future__ import annotations

import json
from dataclasses import dataclass
from difflib import SequenceMatcher, unified_diff
from pathlib import Path
from typing import Any, cast

from mafsil.answer import Answer, Status
from mafsil.errors import FileError
from mafsil.messages import language as current_language
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.regular_file import is_folder, reason, whole_text
from mafsil.report.results import FORMAT

UNITS = {
    "cycle": "s", "duration": "s", "energy": "J", "tip_error": "m", "tip_turn": "rad",
    "joint_error": "rad", "peak_effort": "", "rms_effort": "", "peak_speed": "", "peak_acceleration": "",
}  # fmt: skip
"""Numbers that are compared, and their units where they have one for every kind of joint."""
OF_RUN = ("cycle", "duration", "tip_error", "tip_turn", "energy")
OF_JOINTS = ("joint_error", "peak_effort", "rms_effort", "peak_speed", "peak_acceleration")
SMALL = 1e-6
"""Relative change below which two numbers count as the same: what rounding on another machine leaves."""
LARGEST_FILE = 200_000_000
"""Of results [bytes]."""


class ComparisonStatus(Status):
    """Whether two results say the same."""

    SAME = ("report.results_same", True)
    DIFFERENT = ("report.results_different", False)


@dataclass(frozen=True, slots=True)
class Change:
    """A number in both results.

    Attributes:
        name: `cycle`, `tip_error`, ..., of a move `time`.
        of: the joint or the move it belongs to; empty for the whole run.
        before, after: in SI units; None where one result has none.
    """

    name: str
    of: str
    before: float | None
    after: float | None

    @property
    def share(self) -> float | None:
        """Relative change; None where it has none."""
        if self.before is None or self.after is None or self.before == 0.0:
            return None
        return self.after / self.before - 1.0

    @property
    def changed(self) -> bool:
        """Whether it differs by more than rounding."""
        if self.before is None or self.after is None:
            return self.before is not self.after
        return abs(self.after - self.before) > SMALL * max(abs(self.before), abs(self.after))


@dataclass(frozen=True, eq=False, repr=False)
class ResultsComparison(Answer, data="numbers gone new job versions"):
    """The differences between two results; true if there are none.

    Attributes:
        status: SAME or DIFFERENT.
        numbers: of the run, the joints and the moves, those that changed.
        gone, new: findings of only the first and only the second, by code.
        job: lines of the job that changed, as `diff -u` writes them.
        versions: packages whose versions differ, with both.
    """

    status: ComparisonStatus
    numbers: tuple[Change, ...]
    gone: tuple[dict[str, Any], ...]
    new: tuple[dict[str, Any], ...]
    job: tuple[str, ...]
    versions: dict[str, tuple[str, str]]

    def explain(self, language: str | None = None) -> str:
        """The status and a line for each change."""
        lines = [self.status.sentence(language)]
        lines += [_line(change, language) for change in self.numbers]
        code = language or current_language()
        for key, findings in (("finding_gone", self.gone), ("finding_new", self.new)):
            lines += [say(f"report.{key}", language=language, finding=_say(each, code)) for each in findings]
        lines += [visible(line) for line in self.job]
        lines += [f"{name}: {before} -> {after}" for name, (before, after) in self.versions.items()]
        return "\n".join(lines)


def compare_results(before: str | Path, after: str | Path) -> ResultsComparison:
    """The differences between the results of two runs.

    Moves are matched by name and kind in their order, joints by name.

    Args:
        before, after: folders that `mafsil run` left, or their `results.json`.

    Raises:
        FileError: missing, unreadable, or no results of a run.
    """
    (first, first_job), (second, second_job) = _read(Path(before)), _read(Path(after))
    numbers = [Change(name, "", _number(first["numbers"], name), _number(second["numbers"], name)) for name in OF_RUN]
    numbers += _joints(first["joints"], second["joints"]) + _moves(first["steps"], second["steps"])
    changed = tuple(each for each in numbers if each.changed)
    said = [{_key(each) for each in data["findings"]} for data in (first, second)]
    gone = tuple(each for each in first["findings"] if _key(each) not in said[1])
    new = tuple(each for each in second["findings"] if _key(each) not in said[0])
    job = tuple(unified_diff(first_job, second_job, "job.toml", "job.toml", lineterm="", n=0))
    versions = {
        name: (str(first["versions"].get(name, "-")), str(second["versions"].get(name, "-")))
        for name in {**first["versions"], **second["versions"]}
        if first["versions"].get(name) != second["versions"].get(name)
    }
    same = not (changed or gone or new or job or first["status"] != second["status"])
    status = ComparisonStatus.SAME if same else ComparisonStatus.DIFFERENT
    return ResultsComparison(status, changed, gone, new, job, versions)


def _read(path: Path) -> tuple[dict[str, Any], list[str]]:
    """Results and lines of the job of one run."""
    file = path / "results.json" if is_folder(path) else path
    shown = visible(str(file))
    try:
        data = cast("dict[str, Any]", json.loads(whole_text(file, LARGEST_FILE), parse_int=float))
        job = file.with_name("job.toml")
        text = whole_text(job, LARGEST_FILE).splitlines() if job.exists() else []
    except OSError as fault:
        raise FileError("report.results_unreadable", path=shown, reason=reason(fault)) from None
    except (ValueError, RecursionError):
        raise FileError("report.no_results", path=shown) from None
    if not _is_results(data):
        raise FileError("report.no_results", path=shown)
    return data, text


def _is_results(data: object) -> bool:
    """Whether it has what is compared, of the kinds that are expected."""
    if not isinstance(data, dict):
        return False
    given = cast("dict[str, Any]", data)
    kinds = {"numbers": dict, "joints": list, "steps": list, "findings": list, "versions": dict, "status": str}
    if given.get("format") != FORMAT or not all(isinstance(given.get(name), kind) for name, kind in kinds.items()):
        return False
    rows = all(isinstance(each, dict) for name in ("joints", "steps", "findings") for each in given[name])
    return rows and all(isinstance(each.get("name"), str) for each in given["joints"])


def _joints(first: list[dict[str, Any]], second: list[dict[str, Any]]) -> list[Change]:
    """Numbers of joints that both results have by name."""
    later = {each["name"]: each for each in second}
    pairs = [(each, later[each["name"]]) for each in first if each["name"] in later]
    return [
        Change(name, one["name"], _number(one, name), _number(other, name))
        for one, other in pairs
        for name in OF_JOINTS
    ]


def _moves(first: list[dict[str, Any]], second: list[dict[str, Any]]) -> list[Change]:
    """Times of moves, those of one name and kind in one order together; others are in one run alone."""
    keys = [[(str(each.get("name")), str(each.get("kind"))) for each in steps] for steps in (first, second)]
    found: list[Change] = []
    for kind, i, j, k, m in SequenceMatcher(None, *keys, autojunk=False).get_opcodes():
        if kind == "equal":
            pairs = zip(first[i:j], second[k:m], strict=True)
            found += [Change("time", _move_name(one), _time(one), _time(other)) for one, other in pairs]
            continue
        found += [Change("time", _move_name(one), _time(one), None) for one in first[i:j]]
        found += [Change("time", _move_name(other), None, _time(other)) for other in second[k:m]]
    return found


def _move_name(step: dict[str, Any]) -> str:
    return str(step.get("name") or step.get("kind") or "")


def _time(step: dict[str, Any]) -> float | None:
    begin, end = _number(step, "start"), _number(step, "end")
    return None if begin is None or end is None else end - begin


def _number(data: dict[str, Any], name: str) -> float | None:
    value = data.get(name)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _key(finding: dict[str, Any]) -> str:
    """By what it says, in English: the same code with another number is another finding."""
    return _say(finding, "en")


def _say(finding: dict[str, Any], language: str) -> str:
    sentence = finding.get("sentence")
    if not isinstance(sentence, dict):
        return visible(str(finding.get("code")))
    texts = cast("dict[str, Any]", sentence)
    return visible(str(texts.get(language, texts.get("en", ""))))


def _line(change: Change, language: str | None) -> str:
    """`cycle time: 6.04 s -> 5.2 s (-14 %)`."""
    unit = "s" if change.name == "time" else UNITS[change.name]
    none = say("report.none_there", language=language)
    before, after = (none if each is None else quantity(each, unit) for each in (change.before, change.after))
    share = "" if change.share is None else f" ({100 * change.share:+.3g} %)"
    name = say(f"report.changed_{change.name}", language=language)
    return f"{name}{f' ({visible(change.of)})' if change.of else ''}: {before} -> {after}{share}"
