"""What an identification hands back: a better robot, its parameters with their errors, and what stays unknown."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.identification.knowledge import Unidentifiable
from mafsil.identification.remark import Remark
from mafsil.identification.saving import save
from mafsil.mechanics.inertial_parameters import BaseParameters
from mafsil.messages import say
from mafsil.robot import Robot


@dataclass(frozen=True, slots=True)
class Parameter:
    """A base parameter: it stands for itself plus what it absorbs.

    Attributes:
        label: such as `link3.Ixx` or `joint2.coulomb`; SI units.
        value: what the data alone ask for.
        standard_error: of the value; that of before where the data do not tell.
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
        unseen: whether they were taken on motion that was kept back; else on the motion learnt from.
        effort: (n,) root mean square of the efforts [N m | N].
        before: (n,) error of the description [%].
        after: (n,) error of the new robot [%].
        learnt: (n,) error of the new robot on the motion it was learnt from [%]; much smaller than `after` means that
            noise was learnt.
    """

    joints: tuple[str, ...]
    unseen: bool
    effort: Floats
    before: Floats
    after: Floats
    learnt: Floats


@dataclass(frozen=True, eq=False)
class Identification:
    """The outcome of `identify`.

    Attributes:
        robot: the robot with new masses, inertias, friction and rotors; all bodies are possible ones.
        before: the robot that was given.
        parameters: base parameters with standard errors.
        covariance: (k, k) of their values.
        base: which combination of all parameters each of them is.
        told: how many independent combinations this log tells better than was known before.
        condition: condition number of the weighted columns scaled to length one: below 100 the motion is exciting.
        noise: (n,) standard deviation of the filtered efforts [N m | N].
        bandwidth: highest frequency of the motion that was used [Hz].
        rows: how many independent samples each joint gave.
        unidentifiable: what the data cannot tell.
        validation: torque errors before and after.
        remarks: what was irregular in the log or in the description.
    """

    robot: Robot
    before: Robot
    parameters: tuple[Parameter, ...]
    covariance: Floats
    base: BaseParameters
    told: int
    condition: float
    noise: Floats
    bandwidth: float
    rows: int
    unidentifiable: tuple[Unidentifiable, ...]
    validation: Validation
    remarks: tuple[Remark, ...]

    def parameter(self, label: str) -> Parameter:
        """The base parameter of that name.

        Raises:
            KeyError: there is none.
        """
        return {parameter.label: parameter for parameter in self.parameters}[label]

    def explain(self, language: str | None = None) -> str:
        """What was found, how well it predicts, and what the data cannot tell, in sentences."""
        details = {"told": self.told, "count": len(self.parameters), "rows": self.rows, "band": self.bandwidth}
        lines = [say("identification.summary", language=language, robot=self.robot.name, **details)]
        key = "identification.unseen" if self.validation.unseen else "identification.seen"
        lines += [
            say(key, language=language, joint=joint, before=before, after=after)
            for joint, before, after in zip(
                self.validation.joints, self.validation.before, self.validation.after, strict=True
            )
        ]
        lines.append(say("identification.condition", language=language, condition=self.condition))
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
            "parameters": [
                {
                    "label": p.label, "value": p.value, "standard_error": p.standard_error,
                    "before": p.before, "after": p.after,
                }
                for p in self.parameters
            ],
            "told": self.told,
            "condition": self.condition,
            "noise": self.noise,
            "bandwidth": self.bandwidth,
            "rows": self.rows,
            "validation": {
                "joints": list(v.joints), "unseen": v.unseen, "effort": v.effort,
                "before_percent": v.before, "after_percent": v.after, "learnt_percent": v.learnt,
            },
            "unidentifiable": [
                {"labels": list(u.labels), "reason": u.reason, "sentence": u.sentence()} for u in self.unidentifiable
            ],
            "remarks": [remark.sentence() for remark in self.remarks],
        }  # fmt: skip
