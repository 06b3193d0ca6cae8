"""What of a robot goes elsewhere: quantities of the catalogue, inverse kinematics, the closed loop, all at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mafsil.control.laws.law_export import PORTS, law_kernel
from mafsil.errors import InputError
from mafsil.kernels.export import Export, Legend, bundle
from mafsil.kernels.export import export as export_kernel
from mafsil.kernels.export.legend import symbol
from mafsil.kernels.export.object_file import layout_text
from mafsil.mechanics.loop_terms import Term
from mafsil.model.loading import RobotLike
from mafsil.page.arm import Arm
from mafsil.page.assemble import assemble
from mafsil.page.content import content
from mafsil.robot import as_open_tree, as_robot
from mafsil.robot.exporting import export as export_quantity

if TYPE_CHECKING:
    from mafsil.kernels import Kernel

_POSE = "pose of the tip in {s}"
_TASK = "weights (6) of rotations and positions, axis (3), lower and upper bounds [rad | m]"


@dataclass(frozen=True)
class _Row:
    """A kernel that is no quantity of the catalogue.

    Attributes:
        title: what it computes.
        kernel: of an arm; None where the arm has none.
        why: key of the sentence that says why.
        ports: their meaning.
    """

    title: str
    kernel: Callable[[Arm], Kernel | None]
    why: str
    ports: Mapping[str, str] = field(default_factory=dict[str, str])


BEYOND: dict[str, _Row] = {
    "closed_form": _Row(
        "Inverse kinematics: all branches of a pose.",
        lambda arm: arm.form and arm.form.kernel,
        "session.no_branches",
        {"T_sd": _POSE, "table": "rows (q, residual, subproblem residual, free) [rad | m]; locked joints at zero"},
    ),
    "labelled_closed_form": _Row(
        "Inverse kinematics: all branches of a pose with names and limits.",
        lambda arm: arm.form and arm.form.labelled,
        "session.no_branches",
        {
            "T_sd": _POSE,
            "q0": "coordinates to which angles are wound and that free and locked joints take [rad | m]",
            "turns": "cosines and sines of q0",
            "lower": "limits [rad | m]",
            "upper": "limits [rad | m]",
            "q": "coordinates of each branch [rad | m]",
            "details": "residual, subproblem residual, free coordinates, code, branch margin, excess over the limits",
            "defect": "how far T_sd is from a pose",
        },
    ),
    "pose_step": _Row(
        "Inverse kinematics: one bounded damped step towards a pose.",
        lambda arm: arm.problem.step(False),
        "",
        {"q": "coordinates [rad | m]", "T_sd": _POSE, "task": _TASK, "out": "next coordinates, twist left at q"},
    ),
    "pose_check": _Row(
        "Inverse kinematics: the pose of the tip and the twist that is left.",
        lambda arm: arm.problem.check(False),
        "",
        {"q": "coordinates [rad | m]", "T_sd": _POSE, "task": _TASK, "out": "pose (16), twist left (6)"},
    ),
    "closed_loop": _Row(
        "One step of computed torque and of the robot under it, pushed at the tip.",
        lambda arm: arm.kernels.get("closed_loop"),
        "session.no_closed_loop",
        {
            "state": "coordinates and rates [rad | m, per s]",
            "reference": "desired positions, rates, accelerations",
            "gains": "of position, rate, integral",
            "step": "[s]",
            "T_desired": "desired pose of the tip",
            "limit": "of the efforts [N m | N]",
            "push": "wrench on the tip in its frame (m, f) [N m, N]",
            "next_state": "coordinates and rates after the step",
            "command": "efforts asked for [N m | N]",
            "effort": "efforts after clipping [N m | N]",
            "acceleration": "at the beginning of the step",
            "tip_errors": "distance [m] and angle [rad] of the tip from the reference",
        },
    ),
    "computed_torque": _Row(
        "Control law: computed torque, one call of it.",
        lambda arm: _law(arm, "computed_torque"),
        "session.no_closed_loop",
        PORTS,
    ),
    "pid": _Row("Control law: PID of every joint, one call of it.", lambda arm: _law(arm, "feedback"), "", PORTS),
    "pd_gravity": _Row(
        "Control law: PD of every joint and the arm's gravity, one call of it.",
        lambda arm: _law(arm, "feedback", "gravity"),
        "session.no_closed_loop",
        PORTS,
    ),
}
"""By the name under which they are exported."""


def export(
    robot: RobotLike,
    name: str,
    to: str = "c",
    *,
    frame: str | None = None,
    optional: tuple[str, ...] = (),
    target: str | None = None,
    real: str = "double",
    function: str | None = None,
) -> Export:
    """A quantity of a robot, or a step of its inverse kinematics or closed loop, as files.

    Args:
        robot: its numbers become constants of the code.
        name: a name of the catalogue, or `closed_form`, `labelled_closed_form`, `pose_step`, `pose_check`,
            `closed_loop`, or the control laws `computed_torque`, `pid`, `pd_gravity` with their gains as inputs.
        to: `c` (C99 with test vectors), `object`, `ptx`, or `wasm` (a module with its ports as JSON).
        frame: link name for framed quantities; the tip frame if None.
        optional: optional inputs of quantities that shall be present, such as ("tip_wrench",).
        target: processor of the object file, or oldest generation for PTX; see `mafsil.robot.exporting.export`.
        real: `double`, or `float` for C.
        function: name of the function; made of the robot's and the quantity's if None.

    Raises:
        InputError: an unknown name, frame, form, processor or number type, a name that C refuses, an arm without the
            closed form or the masses that are needed.
        KernelError: the compiler refuses.
    """
    if name not in BEYOND:
        return export_quantity(
            robot, name, to, frame=frame, optional=optional, target=target, real=real, function=function
        )
    row, arm = BEYOND[name], Arm(as_robot(robot))
    kernel = row.kernel(arm)
    if kernel is None:
        raise InputError(row.why, robot=arm.robot.name)
    if frame is not None or optional:
        raise InputError("session.no_options", name=name)
    joints = ", ".join(arm.robot.joint_names)
    words = Legend(arm.robot.name, f"{row.title} Joints: {joints}.", row.ports)
    return export_kernel(kernel, words, to, target=target, real=real, name=function)


def _law(arm: Arm, *kinds: str) -> Kernel | None:
    """A law whose gains are inputs; None for an arm without masses where the law needs them."""
    mechanism = arm.robot.mechanism
    if kinds != ("feedback",) and arm.kernels.get("closed_loop") is None:
        return None
    terms = tuple(Term(kind, None if kind == "feedback" else mechanism) for kind in kinds)
    return law_kernel(arm.robot, terms, None, integrates=kinds == ("feedback",))


def export_all(robot: RobotLike, to: str, *, language: str = "en", python: str = "robot") -> Export:
    """Everything that a page computes with: one module with its ports, or the page itself.

    Args:
        robot: its numbers become constants of the code.
        to: `wasm` or `page`.
        language: in which the page opens.
        python: expression that makes the robot in the scripts that the page writes.

    Raises:
        InputError: another form.
        KernelError: the compiler refuses.
    """
    arm = Arm(as_open_tree(robot))
    name = symbol(arm.robot.name, "page")
    match to:
        case "wasm":
            module = bundle(arm.kernels)
            files = {f"{name}.wasm": module.code, f"{name}.json": layout_text(module).encode()}
            return Export(name, files, {"kernels": tuple(arm.kernels), "bytes": len(module.code)})
        case "page":
            html = assemble(content(arm, language, python)).encode()
            return Export(name, {f"{name}.html": html}, {"bytes": len(html)})
        case _:
            raise InputError("export.form", form=to, known="wasm, page")
