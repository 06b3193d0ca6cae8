"""`mafsil singularity`: whether a configuration is singular, why, and what is lost and carried there."""

from __future__ import annotations

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.loops import require_open_chain
from mafsil.cli.state import degrees_remarks, joint_values
from mafsil.cli.table import brief, table
from mafsil.messages import say
from mafsil.performance import singularity
from mafsil.robot import load


def find_singularity(robot: str, q: list[str], task: str | None, tip: str | None, degrees: bool) -> Answer:
    """Rank, singular values, causes, lost twists and carried wrenches of one configuration.

    Args:
        robot: name or file.
        q: (n) coordinates as typed.
        task: rows of the Jacobian that count; the arm's natural task if None.
        tip: another tip link.
        degrees: whether bare angles are degrees.

    Raises:
        MafsilError: no such robot or task, not one number per joint.
    """
    arm = load(robot, tip=tip)
    require_open_chain(arm.mechanism, "singularity")
    values = joint_values("q", q, arm.mechanism, degrees=degrees)
    found = singularity(arm, values, task=task)
    product = float(np.prod(found.singular_values)) if found.singular_values.size else 0.0
    data = {**found.to_dict(), "manipulability": product}
    size, length = brief(product), brief(found.length)
    lines = found.explain().splitlines()
    lines.append(say("cli.singularity_rank", rank=found.rank, full=found.full_rank, manipulability=size, length=length))
    head = [say("cli.singularity_values"), *(f"σ{k}" for k in range(1, found.singular_values.size + 1))]
    lines += table(head, [["", *(brief(float(s)) for s in found.singular_values)]])
    return Answer(data, (*lines, *degrees_remarks(q, arm.mechanism, degrees=degrees)))
