"""What became of the doors, holes and guides of a job: how far opened, how deep, how far astray."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mafsil.arrays import Floats
from mafsil.job.door_grips import grips
from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible

PRESSED = 0.05
"""Share of its depth by which a peg in a hole may press into the side."""


def contact_remarks(run: Run) -> list[Remark]:
    """A sentence for each door, hole and guide of a job.

    Args:
        run: what happened.
    """
    job = run.job
    if not (job.door or job.hole or job.guide):
        return []
    T, _ = run.tips()
    return [*_doors(run, T), *_holes(run, T[-1, :3, 3]), *_guides(run, T[:, :3, 3])]


def _doors(run: Run, T: Floats) -> Iterator[Remark]:
    wrench = run.recording.contact_wrench
    for grip in grips(run.job, run.plan):
        one, held = grip.table, (run.recording.t >= grip.start) & (run.recording.t <= grip.end)
        if not held.any():
            continue
        angle = np.unwrap(grip.door.angle(T[held]))
        most = float(angle[np.abs(angle).argmax()])
        force = 0.0 if wrench is None else float(np.linalg.norm(wrench[held, 3:], axis=-1).max())
        details = {"angle": quantity(float(angle[-1]), "rad"), "most": quantity(most, "rad")}
        yield Remark(
            "good", "job.door_opened", {"name": _name("door", one.name), **details, "force": quantity(force, "N")}
        )


def _holes(run: Run, p: Floats) -> Iterator[Remark]:
    for one in run.job.hole:
        u = np.array(one.axis) / np.linalg.norm(one.axis)
        away = p - np.array(one.mouth)
        height = float(away @ u)
        aside = float(np.linalg.norm(away - height * u))
        details = {"name": _name("hole", one.name), "aside": quantity(aside, "m")}
        # Beside the hole it is not in it, however deep it presses into the face.
        if height < 0.0 and aside < one.clearance + one.chamfer - height * PRESSED:
            deep = {"depth": quantity(-height, "m"), "whole": quantity(one.depth, "m")}
            yield Remark("good", "job.hole_reached", details | deep)
        else:
            yield Remark("warning", "job.hole_missed", details | {"height": quantity(height, "m")})


def _guides(run: Run, p: Floats) -> Iterator[Remark]:
    for one in run.job.guide:
        away = p - np.array(one.point)
        if one.direction is not None:
            u = np.array(one.direction) / np.linalg.norm(one.direction)
            off = np.linalg.norm(away - (away @ u)[:, None] * u, axis=-1)
        else:
            u = np.array(one.normal) / np.linalg.norm(np.array(one.normal))
            off = np.abs(away @ u)
        k = int(off.argmax())
        details = {"most": quantity(float(off[k]), "m"), "time": quantity(float(run.recording.t[k]), "s")}
        yield Remark("good", "job.guide_left", {"name": _name("guide", one.name), **details})


def _name(kind: str, name: str) -> str:
    return visible(name) if name else f"@job.unnamed_{kind}"
