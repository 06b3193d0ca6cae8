"""A run as tables and plots: what limits its cycle, when, what more of it would save; and what fails in many runs."""

from __future__ import annotations

from mafsil.arrays import Floats
from mafsil.job.driving.run import SHARES, Run
from mafsil.job.planning.limiting import MORE, CycleLimit, most_used, name_limit
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.report.content import Finding, Plot, Table


def variation_table(run: Run, language: str) -> Table | None:
    """A row for each quantity: what so many runs do not exceed; None where nothing was varied.

    Args:
        run: what happened.
        language: of all texts.
    """
    if run.variation is None:
        return None
    head = (say("report.variation_quantity", language=language), *(f"{digits(100.0 * share)} %" for share in SHARES))
    rows = tuple((say(f"report.variation_{name}", language=language), *cells) for name, *cells in run.variation.rows())
    return Table(head, rows)


def variation_findings(run: Run, language: str) -> tuple[Finding, ...]:
    """How many runs did the job, and what the others failed by.

    Args:
        run: what happened.
        language: of all texts.
    """
    if run.variation is None:
        return ()
    sentences = run.variation.explain(language).split("\n")
    level = "good" if run.variation else "warning"
    return (Finding(level, sentences[0]), *(Finding("good", sentence) for sentence in sentences[1:]))


def limit_table(run: Run, cycle: float, language: str) -> Table:
    """A row for each limit that decides or would save time, the most precious first.

    Args:
        run: what happened.
        cycle: time of the cycle [s].
        language: of all texts.
    """
    more = digits(100.0 * MORE)
    head = tuple(say(f"report.{key}", language=language, more=more) for key in ("limit", "deciding", "saved"))
    rows = tuple(_row(run, one, cycle, language) for one in run.limits)
    return Table(head, rows or ((say("report.no_limit", language=language), "–", "–"),))


def limit_plot(run: Run, t: Floats, language: str) -> tuple[Plot, ...]:
    """How much of the limit that is used most is used, a curve for each limit that decides somewhere.

    Args:
        run: what happened.
        t: (rows,) times [s].
        language: of all texts.
    """
    values, labels = most_used(run.plan, t)
    if len(labels) < 2:
        return ()
    names = tuple(limit_name(run, *label, language) for label in labels)
    keys = tuple(quantity if joint < 0 else f"{quantity} {run.robot.joint_names[joint]}" for quantity, joint in labels)
    title = say("report.most_used", language=language)
    return (Plot("limit_used", title, "%", 100.0 * values, names=names, keys=keys),)


def limit_name(run: Run, quantity: str, joint: int, language: str) -> str:
    """`the velocity of joint2`, `the speed of the tip`, or all the others.

    Args:
        run: gives the names of the joints.
        quantity, joint: as in `CycleLimit`.
        language: of the text.
    """
    if quantity == "others":
        return say("report.other_limits", language=language)
    return name_limit(run.robot, quantity, joint).explain(language=language)


def _row(run: Run, one: CycleLimit, cycle: float, language: str) -> tuple[str, ...]:
    """Name, time decided and time saved, each with its share of the cycle."""
    times = (_share(seconds, cycle) if seconds == seconds else "–" for seconds in (one.deciding, one.saved))
    return (limit_name(run, one.quantity, one.joint, language), *times)


def _share(seconds: float, cycle: float) -> str:
    return f"{quantity(seconds, 's')} ({digits(100 * seconds / cycle)} %)" if cycle > 0.0 else quantity(seconds, "s")
