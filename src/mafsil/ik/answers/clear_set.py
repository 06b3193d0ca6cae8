"""Answers as the compiled closed form gives them: nothing else is computed before it is read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.setting import Setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.tolerances import REACHED

_new = object.__new__


def clear_set(setting: Setting, q: JointVector, details: Floats, chosen: slice | NDArray[np.intp]) -> SolutionSet:
    """The solutions of a pose whose list is clear: distinct, isolated, exact rows of the closed form.

    Args:
        setting: the arm.
        q: (k, m) their coordinates.
        details: (rows, 6) of all rows of the closed form.
        chosen: which rows they are.
    """
    answer = _new(SolutionSet)
    answer.own = answer.q = q
    answer._ask, answer._setting, answer._details, answer._chosen = _question, setting, details, chosen  # pyright: ignore[reportPrivateUsage]
    if setting.part.places is not None:
        answer.q = setting.part.lifted(q, setting.part.middle)
    return answer


def exact_set(question: Question, q: JointVector, details: Floats, rows: list[int]) -> SolutionSet:
    """The solutions of a pose whose list is exact, but where branches may meet and joints be free; or there are none.

    Args:
        question: about the pose.
        q: (rows, m) coordinates of all rows of the closed form.
        details: (rows, 6) of them.
        rows: which of them are solutions, each of them once.
    """
    chosen = np.array(rows, dtype=np.intp)
    answer = clear_set(question.setting, q[chosen], details, chosen)
    if question.setting.part.places is not None:
        answer.q = question.setting.part.lifted(answer.own, question.others)
    answer._isolated = False  # pyright: ignore[reportPrivateUsage]
    vars(answer)["_question"] = question
    return answer


def _question(answer: SolutionSet) -> Question:
    """The question that a clear list answers: its pose is that of its solutions."""
    setting = answer._setting  # pyright: ignore[reportPrivateUsage]
    return Question(setting, setting.robot.forward_kinematics(answer.own[0]), setting.middle, REACHED)
