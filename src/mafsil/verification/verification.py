"""What `verify` hands back: one check per routine and method, with the worst error and what it means."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

from mafsil.answer import Answer, Status
from mafsil.messages import say


class Agreement(Status):
    """How the checks of a robot ended."""

    AGREES = ("verification.all_agree", True)
    DIFFERS = ("verification.some_differ", False)
    INCOMPLETE = ("verification.incomplete", False)


UNCHECKED = "verification.loops_not_found"
"""Reason of what was not compared without which nobody may say that all agrees."""


@dataclass(frozen=True, slots=True)
class Check:
    """One routine, called in one way, compared with one method.

    Attributes:
        routine: such as `inverse_dynamics(tip_wrench)`.
        method: key of the sentence that says how the other number was made.
        error: worst difference, relative to the robot's natural size or the largest entry of the state.
        limit: what rounding may cost.
        state: number of the worst state.
        reason: why there is no number (a refusal of the routine, confirmed by the other method), or empty.
    """

    routine: str
    method: str
    error: float
    limit: float
    state: int = 0
    reason: str = ""

    @property
    def passed(self) -> bool:
        """Both methods agree; NaN agrees with nothing."""
        return isfinite(self.error) and self.error <= self.limit

    def sentence(self, language: str | None = None) -> str:
        """Routine, method, error and verdict in words."""
        key = (
            "verification.refused" if self.reason else "verification.agrees" if self.passed else "verification.differs"
        )
        return say(
            key,
            language=language,
            routine=self.routine,
            method=say(self.method, language=language),
            error=f"{self.error:.1e}",
            limit=f"{self.limit:.0e}",
            state=self.state,
            reason=self.reason,
        )


@dataclass(frozen=True, slots=True)
class Verification(Answer, entries="checks"):
    """All checks of one robot: true if all agree, iterable over the checks, a table when printed.

    Attributes:
        robot: its name.
        checks: in the order of the catalogue.
        states: how many random states.
        seed: of the states.
        left_out: routines that were not compared, with the key of the reason.
        peers: other libraries that could be compared with, with the key of the sentence that says whether this one was.
    """

    robot: str
    checks: tuple[Check, ...]
    states: int
    seed: int
    left_out: tuple[tuple[str, str], ...] = ()
    peers: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        return self.explain()

    @property
    def status(self) -> Agreement:
        """Whether every routine agrees with its independent method."""
        if not (self.checks and all(check.passed for check in self.checks)):
            return Agreement.DIFFERS
        return Agreement.INCOMPLETE if any(key == UNCHECKED for _, key in self.left_out) else Agreement.AGREES

    @property
    def ok(self) -> bool:
        """Every routine agrees with its independent method."""
        return bool(self)

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that do not agree."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def worst(self) -> Check:
        """The check with the largest error in units of its limit."""
        return max(self.checks, key=lambda check: check.error / check.limit if isfinite(check.error) else float("inf"))

    def explain(self, language: str | None = None) -> str:
        """The verdict, every disagreement, and what was left out."""
        lines = [
            self.status.sentence(
                language,
                robot=self.robot,
                checks=len(self.checks),
                failed=len(self.failed),
                states=self.states,
                seed=self.seed,
                worst=f"{self.worst.error:.1e}",
                routine=self.worst.routine,
            )
        ]
        lines += [f"  {check.sentence(language)}" for check in self.checks if not check.passed or check.reason]
        lines += [
            "  " + say("verification.left_out", language=language, routine=routine, reason=say(key, language=language))
            for routine, key in self.left_out
        ]
        lines += ["  " + say(key, language=language, peer=peer) for peer, key in self.peers]
        return "\n".join(lines)

    def table(self, language: str | None = None) -> list[tuple[str, str, str, str, str]]:
        """Rows of text: routine, method, error, limit, verdict."""
        return [
            (
                check.routine,
                say(check.method, language=language),
                "" if check.reason else f"{check.error:.1e}",
                f"{check.limit:.0e}",
                say("verification.yes" if check.passed else "verification.no", language=language),
            )
            for check in self.checks
        ]

    def to_dict(self) -> dict[str, Any]:
        """Plain data, fit for JSON."""
        return {
            "robot": self.robot,
            "ok": self.ok,
            "states": self.states,
            "seed": self.seed,
            "checks": [
                {
                    "routine": check.routine,
                    "method": check.method.removeprefix("verification."),
                    "error": check.error,
                    "limit": check.limit,
                    "passed": check.passed,
                    "state": check.state,
                    "reason": check.reason,
                }
                for check in self.checks
            ],
            "left_out": [{"routine": routine, "reason": say(key, language="en")} for routine, key in self.left_out],
            "peers": {peer: key.removeprefix("verification.peer_") for peer, key in self.peers},
        }
