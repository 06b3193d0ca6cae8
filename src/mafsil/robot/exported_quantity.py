"""A quantity of one robot as files for elsewhere, with the words at their head."""

from __future__ import annotations

from mafsil.kernels.export import Export, Legend
from mafsil.kernels.export import export as export_kernel
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantity import INPUT_TEXTS, Quantity
from mafsil.robot.compiled_robot import CompiledRobot


def export_files(
    robot: CompiledRobot,
    name: str,
    to: str,
    *,
    frame: str | None,
    optional: tuple[str, ...],
    target: str | None,
    real: str,
    function: str | None,
) -> Export:
    """The files, not yet written; arguments as `mafsil.robot.exporting.export`."""
    kernel = robot.kernel(name, frame, optional)
    return export_kernel(kernel, legend(robot, quantity(name), frame), to, target=target, real=real, name=function)


def legend(robot: CompiledRobot, row: Quantity, frame: str | None) -> Legend:
    """The words at the head of exported files: the robot, its joints, what every number means.

    Args:
        robot: whose quantity it is.
        row: the quantity.
        frame: link name for framed quantities; the tip frame if None.
    """
    ports = {name: text.partition(") ")[2].removesuffix("; optional.") for name, text in INPUT_TEXTS.items()}
    of = f" of frame {frame or robot.mechanism.tip}" if row.framed else ""
    expressed = f", expressed in {row.expressed_in}" if row.expressed_in else ""
    ports[row.name] = f"{row.symbol}{of} [{row.unit}]{expressed}"
    joints = ", ".join(robot.joint_names)
    return Legend(robot.name, f"{row.title} Joints: {joints}.", ports)
