"""`mafsil export`: a quantity of a robot as C, as an object file or as PTX; and its self-test."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from mafsil.cli.answer import Answer
from mafsil.cli.table import details
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import language, say
from mafsil.robot import load
from mafsil.robot.exporting import export as exported

if TYPE_CHECKING:
    import mafsil.page.exporting as exporting
else:
    exporting = lazily("mafsil.page.exporting")

CHECKED = (("planar2r", "forward_kinematics"), ("puma560", "mass_matrix"), ("panda", "inverse_dynamics"))
"""What `mafsil info --export-check` compiles: robots and quantities."""


def export(
    robot: str,
    quantity: str | None,
    to: str | None,
    target: str | None,
    real: str | None,
    frame: str | None,
    function: str | None,
    out: str | None,
    tip: str | None,
) -> Answer:
    """Files in a folder.

    Args:
        robot: name or file.
        quantity: a name of the catalogue or of inverse kinematics and closed loop; None for all that a page needs.
        to: `c`, `object`, `ptx`, `wasm` or `page`; C if None.
        target: processor; see `mafsil.robot.exporting.export`.
        real: `double` or `float`.
        frame: link name for framed quantities.
        function: name of the function.
        out: folder; the current one if None.
        tip: another tip link.

    Raises:
        MafsilError: no such robot, quantity, frame, form or processor, a folder that cannot be written.
    """
    arm = load(robot, tip=tip)
    if quantity is None or to == "page":
        if to not in ("wasm", "page"):
            raise InputError("session.no_quantity")
        found = exporting.export_all(arm, to, language=language(), python=repr(robot))
    else:
        found = exporting.export(
            arm, quantity, to or "c", frame=frame, target=target, real=real or "double", function=function
        )
    paths = [str(path) for path in found.write(out or ".")]
    known: dict[str, Any] = {
        key: list(cast("tuple[Any, ...]", value)) if isinstance(value, tuple) else value
        for key, value in found.details.items()
    }
    lines = [say("cli.export_written", name=found.name), *(f"  {path}" for path in paths)]
    return Answer({"name": found.name, "files": paths, **known}, (*lines, *details(known)))


def checks() -> list[dict[str, Any]]:
    """Exports compiled and run by the C compiler of this computer: one row each, or one that says there is none."""
    from mafsil.kernels.export.exported import compiler, trial

    path = compiler()
    if path is None:
        return [{"name": say("cli.check_export_c"), "ok": True, "detail": say("cli.check_no_compiler")}]
    rows: list[dict[str, Any]] = []
    for robot, quantity in CHECKED:
        arm = load(robot)
        for to, real in (("c", "double"), ("c", "float"), ("object", "double")):
            name = say("cli.check_export", robot=robot, quantity=quantity, form=to, real=real)
            try:
                found = trial(exported(arm, quantity, to, real=real), path)
            except Exception as failure:
                rows.append({"name": name, "ok": False, "detail": f"{type(failure).__name__}: {failure}"})
            else:
                rows.append({"name": name, "ok": found.ok, "detail": found.said})
    return rows
