"""What a page carries: robot, kernels, solids, table and sentences as plain data."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mafsil.errors import ModelError
from mafsil.ik.answers.branch import SIDES, Branch
from mafsil.kernels.export import bundle
from mafsil.messages import LANGUAGES, direction, say
from mafsil.messages.catalogue import keys, template
from mafsil.messages.isolates import runs
from mafsil.messages.visible import visible
from mafsil.model import Joint, JointKind, Mechanism
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.page.arm import Arm
from mafsil.page.session import action_arguments
from mafsil.scene import Drawing, as_data


def content(
    arm: Arm,
    language: str,
    python: str,
    areas: Sequence[str] = ("page",),
    scene: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The data of a page.

    Args:
        arm: what it computes with.
        language: in which it opens.
        python: expression of the robot, for the journal's script.
        areas: of the catalogue whose sentences it carries; no key stands in two of them.
        scene: what is drawn, as `mafsil.scene.as_data` with centre, size and floor; made of the arm if None.

    Raises:
        KernelError: LLVM refuses a kernel.
    """
    robot = arm.robot
    module = bundle(arm.kernels)
    joints = robot.mechanism.coordinates
    return {
        "language": language,
        "languages": {
            code: {"direction": direction(code), "sentences": dict(_sentences(code, areas))} for code in LANGUAGES
        },
        "robot": {
            "name": visible(robot.name),
            "python": python,
            "tip": visible(robot.mechanism.tip),
            "masses": [float(link.inertial.mass) if link.inertial else 0.0 for link in robot.mechanism.links],
            "loops": [visible(loop.name) for loop in robot.mechanism.loops],
            "gravity": np.asarray(robot.mechanism.gravity).tolist(),
            "joints": [_joint(robot.mechanism, joint) for joint in joints],
        },
        "postures": list(_postures(arm)),
        "actions": action_arguments(),
        "settings": arm.settings,
        "kernels": {"layout": dict(module.layout), "code": _compress(module.code)},
        "branches": _branches(arm),
        "dh": dh_table(arm),
        "scene": _scene(arm) if scene is None else dict(scene),
    }


def _joint(mechanism: Mechanism, joint: Joint) -> dict[str, Any]:
    """A joint for the scripts: the place of its link in the list, and its axis in the frame of that link."""
    moves = {"name": visible(joint.name), "prismatic": joint.kind is JointKind.PRISMATIC}
    return moves | {"link": mechanism.joints.index(joint) + 1, "axis": np.asarray(joint.axis).tolist()}


def _postures(arm: Arm) -> Iterator[dict[str, Any]]:
    """Postures that the description names, where they say where every joint is."""
    names = [joint.name for joint in arm.robot.mechanism.coordinates]
    for name, values in arm.robot.mechanism.provenance.postures:
        if values.keys() >= set(names):
            yield {"name": visible(name), "q": [values[one] for one in names]}


def _compress(code: bytes) -> str:
    return base64.b64encode(gzip.compress(code, 9, mtime=0)).decode("ascii")


def _sentences(code: str, areas: Sequence[str]) -> Iterator[tuple[str, list[str | list[str]]]]:
    for area, name in sorted((one, name) for one in areas for name in keys(code, one)):
        yield name, sentence(code, f"{area}.{name}")


def sentence(code: str, key: str) -> list[str | list[str]]:
    """A sentence as scripts say it, cut by the package's one function: what keeps its own direction stands in lists.

    Args:
        code: of the language.
        key: of the catalogue.
    """
    text = template(key, code)
    pieces = runs(text) if direction(code) == "rtl" else [(text, False)]
    return [[words] if foreign else words for words, foreign in pieces]


def _branches(arm: Arm) -> dict[str, Any] | None:
    """Names of the branches in every language: of their sides by code, of roots by row where they tell some apart."""
    if arm.form is None or arm.branch_names is None:
        return None
    rows = arm.form.pattern.branches
    branches = [arm.branch_names.branch(number) for number in range(SIDES)]
    roots = [Branch(root=arm.branch_names.branch(0, row).root) for row in range(rows)]
    names = {
        code: {
            "sides": [one.label(code) if any(one) or not any(roots[0]) else "" for one in branches],
            "roots": [one.label(code) if any(one) else "" for one in roots],
            "joint": say("ik.branch_joint", language=code),
        }
        for code in LANGUAGES
    }
    return {"rows": rows, **names}


def dh_table(arm: Arm) -> dict[str, Any] | None:
    """The table of an arm in the modified convention; None for chains that have none, and with loops."""
    mechanism = arm.robot.mechanism
    if mechanism.loops:
        return None
    try:
        found = dh_from_mechanism(mechanism)
    except ModelError:
        return None
    if len(found.rows) != len(arm.places):
        return None
    rows = [
        {
            "a": row.a,
            "alpha": row.alpha,
            "d": row.d + (row.offset if row.kind == "P" else 0.0),
            "theta": row.theta + (row.offset if row.kind == "R" else 0.0),
            "prismatic": row.kind == "P",
            "place": place,
        }
        for row, place in zip(found.rows, arm.places, strict=True)
    ]
    return {"base": found.base.ravel().tolist(), "tool": found.tool.ravel().tolist(), "rows": rows}


def _scene(arm: Arm) -> dict[str, Any]:
    mechanism = arm.robot.mechanism
    poses = np.asarray(arm.robot.link_poses(arm.start))
    tip = poses[mechanism.link_names.index(mechanism.tip)] @ mechanism.T_lt
    drawing = Drawing(mechanism)
    centre, size, floor = drawing.extent(np.vstack([poses[:, :3, 3], tip[:3, 3]]), poses)
    return as_data(drawing.bodies(floor, poses)) | {"centre": centre, "size": size, "floor": floor}
