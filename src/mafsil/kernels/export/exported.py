"""A kernel's quantity as files for elsewhere, and exported C compiled and run where a compiler is.

The stored numbers must come out of the trial.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias

from mafsil.errors import FileError, InputError
from mafsil.kernels.export import c_source
from mafsil.kernels.export.legend import Legend, symbol, tapes, vectors, wrap_text
from mafsil.kernels.export.object_file import bundle, layout_text, object_file, rows_prototype, symbols
from mafsil.kernels.export.wasm import loadable, machine
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.ptx.program import OLDEST, GridProgram, grid_program
from mafsil.kernels.tape import Tape

Form: TypeAlias = Literal["c", "object", "ptx", "wasm"]
FORMS: tuple[Form, ...] = ("c", "object", "ptx", "wasm")


@dataclass(frozen=True)
class Export:
    """Files, not yet written.

    Attributes:
        name: of the function or kernel.
        files: contents by file name.
        details: what stands in them: operations, number type, processor, names that a linker must find.
    """

    name: str
    files: Mapping[str, bytes]
    details: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def write(self, folder: str | os.PathLike[str] = ".") -> tuple[Path, ...]:
        """Write the files; each appears whole or not at all.

        Args:
            folder: made if it is missing.

        Raises:
            FileError: the folder or a file cannot be written.
        """
        place = Path(folder)
        written: list[Path] = []
        try:
            place.mkdir(parents=True, exist_ok=True)
            for name, contents in self.files.items():
                path, fresh = place / name, place / f".{name}.{os.getpid()}"
                fresh.write_bytes(contents)
                fresh.replace(path)
                written.append(path)
        except OSError as error:
            raise FileError("export.unwritable", path=str(place), reason=error.strerror or str(error)) from None
        return tuple(written)


def export(
    kernel: Kernel, legend: Legend, to: str, *, target: str | None = None, real: str = "double", name: str | None = None
) -> Export:
    """Files of a kernel's quantity.

    Args:
        kernel: the quantity, compiled for this processor.
        legend: words for the files' comments.
        to: `c`, `object`, `ptx` or `wasm`.
        target: processor of an object file, or the oldest generation for PTX.
        real: `double`, or `float` for C.
        name: of the function; made from the legend's owner and the kernel's name if None.

    Raises:
        InputError: an unknown form, number type or processor, a name that C refuses.
        KernelError: LLVM refuses the module.
    """
    if to not in FORMS:
        raise InputError("export.form", form=to, known=", ".join(FORMS))
    if real not in ("double", "float") or (real == "float" and to != "c"):
        raise InputError("export.real", real=real, form=to)
    if to in ("c", "wasm") and target is not None:
        raise InputError("export.no_target", target=target, form=to)
    function = symbol(legend.owner, kernel.signature.name, name)
    if to == "wasm":
        return _wasm(kernel, legend, function)
    tape, reduced = tapes(kernel)
    match to:
        case "c":
            return _c(kernel, tape, reduced, legend, function, "float" if real == "float" else "double")
        case "object":
            return _object(kernel, tape, reduced, legend, function, target or "host")
        case _:
            return _ptx(kernel, reduced, legend, function, target or OLDEST)


def _c(kernel: Kernel, tape: Tape, reduced: Tape, legend: Legend, name: str, real: c_source.Real) -> Export:
    signature = kernel.signature
    stored = vectors(kernel.evaluate, tape, signature, single=real == "float")
    build = f"cc -std=c99 -O2 {name}.c {name}_test.c -o {name}_test -lm"
    notes = (f"{reduced.operations} operations, {real}. Proof: {build} && ./{name}_test",)
    files = {
        f"{name}.h": c_source.header(signature, legend, name, real, notes=notes),
        f"{name}.c": c_source.source(reduced, signature, name, real),
        f"{name}_test.c": c_source.program(signature, name, real, stored),
    }
    details = {"operations": reduced.operations, "real": real, "vectors": stored.rows, "build": build}
    return Export(name, _bytes(files), details)


def _object(kernel: Kernel, tape: Tape, reduced: Tape, legend: Legend, name: str, target: str) -> Export:
    signature, chosen = kernel.signature, machine(target)
    code = object_file(reduced, signature, chosen, name)
    found = symbols(code)
    needs = ", ".join(found.needed) or "nothing"
    notes = (f"Object file for {chosen.name} ({chosen.target.triple}); it needs {needs} from outside.",)
    more = rows_prototype(c_source.prototype(signature, name, "double"), name)
    files = {
        f"{name}.h": c_source.header(signature, legend, name, "double", more, notes),
        f"{name}_test.c": c_source.program(signature, name, "double", vectors(kernel.evaluate, tape, signature)),
    }
    contents = {f"{name}.o": code, **_bytes(files)}
    if code[:4] == b"\0asm":
        contents[f"{name}.wasm"] = loadable(code, [name, f"{name}_rows"])
    details = {"target": chosen.name, "triple": chosen.target.triple, "machine": found.machine, "bits": found.bits}
    return Export(name, contents, details | {"defined": found.defined, "needed": found.needed})


def _wasm(kernel: Kernel, legend: Legend, name: str) -> Export:
    found = bundle({name: kernel})
    about = "\n".join(legend.lines(kernel.signature)) + "\n"
    files = {f"{name}.wasm": found.code, **_bytes({f"{name}.json": layout_text(found), f"{name}.txt": about})}
    return Export(name, files, {"target": "wasm32", "bytes": len(found.code)})


def _ptx(kernel: Kernel, reduced: Tape, legend: Legend, name: str, target: str) -> Export:
    program = grid_program(reduced, kernel.signature, name, target)
    head = [*legend.lines(kernel.signature), *_launch_notes(program)]
    comment = "".join(f"// {line}".encode("ascii", "replace").decode().rstrip() + "\n" for line in head)
    details = {"target": target, "threads": program.plan.threads, "shared_bytes": 8 * program.plan.size}
    return Export(name, _bytes({f"{name}.ptx": comment + program.text}), details)


def _launch_notes(program: GridProgram) -> tuple[str, ...]:
    """How others launch it, for the comment at the head of the file."""
    inputs = [f"{p.name} pointer, divisor, modulus (64 bits each)" for p in program.signature.inputs]
    outputs = [f"{p.name} pointer" for p in program.signature.outputs]
    return (
        f"Kernel {program.name}: {program.plan.threads} threads in a block, (rows + {program.plan.threads - 1}) / "
        f"{program.plan.threads} blocks, no dynamic shared memory.",
        *wrap_text(f"Parameters: {'; '.join([*inputs, *outputs, 'rows (64 bits)'])}.", "  "),
        "Rows lie one after another without gaps. Row r of the batch takes row r of an input whose modulus is 0,",
        "and row (r / divisor) mod modulus of one that is broadcast; the divisor is 1 or more.",
    )


def _bytes(files: Mapping[str, str]) -> dict[str, bytes]:
    return {name: contents.encode() for name, contents in files.items()}


COMPILERS = ("cc", "gcc", "clang")
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
"""No warning is forgiven."""
_SECONDS = 120.0


@dataclass(frozen=True)
class Trial:
    """What became of it.

    Attributes:
        ok: compiled without a warning, and every number within its limit.
        said: what the program printed, or the compiler's first complaint.
    """

    ok: bool
    said: str


def compiler() -> str | None:
    """Path of a C compiler: the one that the environment variable CC names, else the first that is installed."""
    chosen = os.environ.get("CC")
    for name in (chosen,) if chosen else COMPILERS:
        path = shutil.which(name)
        if path:
            return path
    return None


def trial(exported: Export, path: str, flags: Sequence[str] = STRICT) -> Trial:
    """Compile an export's sources, or link its object file, with its test program, and run that.

    Args:
        exported: from C, or an object file for this processor.
        path: of the compiler.
        flags: for the compiler.
    """
    with tempfile.TemporaryDirectory(prefix="mafsil-") as folder:
        exported.write(folder)
        parts = sorted(name for name in exported.files if name.endswith((".c", ".o")))
        program = str(Path(folder) / "trial")
        try:
            built = _run([path, *flags, *parts, "-o", program, "-lm"], folder)
            if built.returncode or built.stderr.strip():
                return Trial(False, _first_line(built.stderr))
            found = _run([program], folder)
        except (OSError, subprocess.TimeoutExpired) as error:
            return Trial(False, f"{type(error).__name__}: {error}")
    return Trial(found.returncode == 0, _first_line(found.stdout or found.stderr))


def _run(words: list[str], folder: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words, cwd=folder, capture_output=True, check=False, timeout=_SECONDS, encoding="utf-8", errors="replace"
    )


def _first_line(text: str) -> str:
    return (text.strip().splitlines() or ["-"])[0]
