"""Quantities of a robot as files for elsewhere: C, object files, PTX."""

from __future__ import annotations

from mafsil.kernels.export import Export
from mafsil.model.loading import RobotLike
from mafsil.robot.loading import as_robot


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
    arm = as_robot(robot)
    return arm.export(name, to, frame=frame, optional=optional, target=target, real=real, function=function)
