"""Quantities of a robot as files for elsewhere: C, object files, PTX."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.kernels.export import Export, Legend
from mafsil.kernels.export import export as export_kernel
from mafsil.lazy_module import lazily
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantity import INPUT_TEXTS, Quantity

if TYPE_CHECKING:
    from mafsil.model.loading import RobotLike
    from mafsil.robot.robot import Robot

if TYPE_CHECKING:
    import mafsil.robot.loading as loading
else:
    loading = lazily("mafsil.robot.loading")


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
    """A quantity of a robot as files: `export(robot, "inverse_dynamics").write("folder")`.

    Args:
        robot: its numbers become constants of the code.
        name: a name of the catalogue.
        to: `c` (C99 with test vectors), `object` (an object file with its header) or `ptx` (NVIDIA devices).
        frame: link name for framed quantities; the tip frame if None.
        optional: optional inputs that shall be present, such as ("tip_wrench",).
        target: processor of the object file (`host`, `aarch64`, `cortex-m7`, ...), or oldest generation for PTX
            (`sm_80`); this processor, or `sm_75`, if None.
        real: `double`, or `float` for C.
        function: name of the function; made of the robot's and the quantity's if None.

    Raises:
        InputError: an unknown quantity, frame, form, processor or number type, a name that C refuses.
        KernelError: the compiler refuses.
    """
    arm = loading.as_robot(robot)
    kernel = arm.kernel(name, frame, optional)
    return export_kernel(kernel, legend(arm, quantity(name), frame), to, target=target, real=real, name=function)


def legend(robot: Robot, row: Quantity, frame: str | None) -> Legend:
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
