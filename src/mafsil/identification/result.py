"""What an identification hands back: a better robot, parameters with standard errors, what is unidentifiable.

Identifiability: parameters that no motion excites, that act only in combinations, that a log does not excite.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.identification.log import Remark
from mafsil.identification.regression import Fit, Parameterisation
from mafsil.identification.tolerances import ALONE
from mafsil.identification.torque_model import TorqueModel, save
from mafsil.mechanics.inertial_parameters import BaseParameters
from mafsil.messages import say
from mafsil.robot import Robot

LONGEST = 20
"""Sentences that are printed; `explain` gives all."""


class IdentificationStatus(Status):
    """Whether the new robot predicts efforts better than the description."""

    IDENTIFIED = ("identification.identified", True)
    WORSE = ("identification.worse", False)
    SUSPECT = ("identification.suspect", False)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A base parameter: it stands for itself plus what it absorbs.

    Attributes:
        label: such as `link3.Ixx` or `joint2.coulomb`; SI units.
        value: what the data alone ask for.
        standard_error: of the value; the prior's where the data do not identify it.
        before: in the description.
        after: in the new robot, whose masses bodies can have.
    """

    label: str
    value: float
    standard_error: float
    before: float
    after: float


@dataclass(frozen=True, eq=False, slots=True)
class Validation:
    """Torque errors, root mean square, in percent of each joint's torque.

    Attributes:
        joints: names.
        held_out: whether they were taken on held-out motion; else on the training motion.
        effort: (n,) root mean square of the efforts [N m | N].
        before: (n,) error of the description [%].
        after: (n,) error of the new robot [%].
        training: (n,) error of the new robot on the training motion [%]; much smaller than `after` means that
            noise was fitted.
    """

    joints: tuple[str, ...]
    held_out: bool
    effort: Floats
    before: Floats
    after: Floats
    training: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Answer):
    """The answer of `identify`: true if the new robot predicts efforts better than the description did.

    Attributes:
        robot: the robot with new masses, inertias, friction and rotors; all bodies are possible ones.
        before: the robot that was given.
        parameters: base parameters with standard errors.
        covariance: (k, k) of their values.
        base: which combination of all parameters each of them is.
        identifiable_count: how many independent combinations this log identifies better than the prior.
        condition_number: of the weighted columns scaled to length one: below 100 the motion is exciting.
        noise: (n,) standard deviation of the filtered efforts [N m | N].
        bandwidth: highest frequency of the motion that was used [Hz].
        rows: how many independent samples each joint gave.
        unidentifiable: what the data cannot identify.
        validation: torque errors before and after.
        remarks: what was irregular in the log or in the description.
        faults: what is probably wrong with the log: reversed signs, other units, swapped columns; see `examination`.
    """

    robot: Robot
    before: Robot
    parameters: tuple[Parameter, ...]
    covariance: Floats
    base: BaseParameters
    identifiable_count: int
    condition_number: float
    noise: Floats
    bandwidth: float
    rows: int
    unidentifiable: tuple[Unidentifiable, ...]
    validation: Validation
    remarks: tuple[Remark, ...]
    faults: tuple[Remark, ...] = ()

    def __repr__(self) -> str:
        shown = self.explain().split("\n")
        more = [] if len(shown) <= LONGEST else [say("messages.more_rows", count=len(shown) - LONGEST)]
        return "\n".join([*shown[:LONGEST], *more])

    @property
    def status(self) -> IdentificationStatus:
        """SUSPECT if the log has faults; WORSE if nothing was identifiable, or torque errors became no smaller."""
        if self.faults:
            return IdentificationStatus.SUSPECT
        better = float(np.mean(self.validation.after)) < float(np.mean(self.validation.before))
        return IdentificationStatus.IDENTIFIED if self.identifiable_count and better else IdentificationStatus.WORSE

    def parameter(self, label: str) -> Parameter:
        """The base parameter of that name.

        Raises:
            KeyError: there is none.
        """
        return {parameter.label: parameter for parameter in self.parameters}[label]

    def explain(self, language: str | None = None) -> str:
        """What was found, how well it predicts, and what the data cannot identify, in sentences."""
        details = {
            "identifiable": self.identifiable_count,
            "count": len(self.parameters),
            "rows": self.rows,
            "band": self.bandwidth,
        }
        lines = [say("identification.summary", language=language, robot=self.robot.name, **details)]
        lines += [self.status.sentence(language)] * bool(self.faults)
        lines += [fault.sentence(language) for fault in self.faults]
        key = "identification.held_out" if self.validation.held_out else "identification.training"
        lines += [
            say(key, language=language, joint=joint, before=before, after=after)
            for joint, before, after in zip(
                self.validation.joints, self.validation.before, self.validation.after, strict=True
            )
        ]
        lines.append(say("identification.condition", language=language, condition_number=self.condition_number))
        lines += [item.sentence(language) for item in self.unidentifiable]
        lines += [remark.sentence(language) for remark in self.remarks]
        return "\n".join(lines)

    def save(self, path: str | PathLike[str]) -> tuple[Remark, ...]:
        """Write the new robot as .urdf, or as .toml, which holds rotors and offsets too.

        Args:
            path: an existing file is replaced.

        Returns:
            What the file could not hold.

        Raises:
            FileError: another suffix, or a place that cannot be written.
            ModelError: a robot that the format cannot hold at all, such as one with loops.
        """
        target = Path(path)
        if target.suffix.lower() not in (".urdf", ".toml"):
            raise FileError("identification.suffix", path=str(target))
        return save(self.robot.mechanism, target)

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, for machines."""
        v = self.validation
        return {
            "robot": self.robot.name,
            "status": self.status.name.lower(),
            "parameters": [
                {
                    "label": p.label, "value": p.value, "standard_error": p.standard_error,
                    "before": p.before, "after": p.after,
                }
                for p in self.parameters
            ],
            "identifiable_count": self.identifiable_count,
            "condition_number": self.condition_number,
            "noise": self.noise,
            "bandwidth": self.bandwidth,
            "rows": self.rows,
            "validation": {
                "joints": list(v.joints), "held_out": v.held_out, "effort": v.effort,
                "before_percent": v.before, "after_percent": v.after, "training_percent": v.training,
            },
            "unidentifiable": [
                {"labels": list(u.labels), "reason": u.reason, "sentence": u.sentence()} for u in self.unidentifiable
            ],
            "remarks": [remark.sentence() for remark in self.remarks],
            "faults": [fault.sentence() for fault in self.faults],
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Unidentifiable:
    """Parameters that the data cannot identify.

    Attributes:
        labels: their names, such as `link1.m`.
        reason: `never` (no motion of this robot excites them), `combination` (they act only in linear combinations
            with others) or `log` (this log does not excite them).
        remark: the sentence.
    """

    labels: tuple[str, ...]
    reason: str
    remark: Remark

    def sentence(self, language: str | None = None) -> str:
        """What cannot be identified, and why."""
        return self.remark.sentence(language)


def unidentifiable(
    model: TorqueModel, base: BaseParameters, fit: Fit, b0: Floats, parameterisation: Parameterisation
) -> tuple[Unidentifiable, ...]:
    """All that cannot be identified, link by link and joint by joint.

    Args:
        model: names of all parameters.
        base: the base parameters.
        fit: of this log.
        b0: (k,) base parameters of before.
        parameterisation: the prior.
    """
    return (*_structural(model, base, parameterisation), *_by_this_log(base, fit, parameterisation))


def _structural(model: TorqueModel, base: BaseParameters, parameterisation: Parameterisation) -> list[Unidentifiable]:
    """What no motion shows at all, and what shows only in sums."""
    K = base.combination
    basis = np.linalg.svd(K, full_matrices=False)[2]
    alone = 1.0 - (basis**2).sum(axis=0) < ALONE
    shows = np.abs(K).max(axis=0, initial=0.0) > 0.0
    rotors_known = not parameterisation.scale[-model.rotor_count :].any()
    never, combined = dict[str, list[str]](), dict[str, list[str]]()
    for k, label in enumerate(model.labels):
        if rotors_known and k >= len(model.labels) - model.rotor_count:
            continue
        part = label.rpartition(".")[0]
        if not shows[k]:
            never.setdefault(part, []).append(label)
        elif not alone[k]:
            combined.setdefault(part, []).append(label)
    return [
        *(_group("never", part, tuple(labels)) for part, labels in never.items()),
        *(_group("combination", part, tuple(labels)) for part, labels in combined.items()),
    ]


def _group(reason: str, part: str, labels: tuple[str, ...]) -> Unidentifiable:
    key = f"identification.{reason}_all" if len(labels) == 10 else f"identification.{reason}"
    words = [Remark(f"identification.word_{label.rpartition('.')[2].lower()}") for label in labels]
    details: dict[str, object] = {"part": part, "names": _list(words)}
    return Unidentifiable(labels, reason, Remark(key, details))


def _by_this_log(base: BaseParameters, fit: Fit, parameterisation: Parameterisation) -> list[Unidentifiable]:
    """Base parameters whose standard error is no smaller than that of the prior."""
    spread = base.combination @ parameterisation.at(np.zeros(parameterisation.size))[1]
    before = np.sqrt((spread**2).sum(axis=1))
    found: dict[str, list[str]] = {}
    for label, error, size in zip(base.labels, fit.standard_errors, before, strict=True):
        if error > 0.7 * size:
            part = label.rpartition(".")[0]
            found.setdefault(part, []).append(label)
    return [_group("log", part, tuple(labels)) for part, labels in found.items()]


def _list(words: list[Remark]) -> Remark:
    """Words one after the other, as one remark."""
    first, *rest = words
    for word in rest:
        first = Remark("identification.and", {"first": first, "second": word})
    return first
