"""A quantity as a kernel for graphics processors: its PTX text, how it is launched, and what can be said of the text.

Without a device or NVIDIA's tools that is: every name declared, nothing missing, no stack (`inspect`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from mafsil.errors import InputError
from mafsil.expression import Function
from mafsil.kernels.layout import Signature, identifier
from mafsil.kernels.ptx.grid import Plan, device_module, plan
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import Tape, read
from mafsil.kernels.target import Target, translate

_REGISTERS = re.compile(r"\.reg\s+\.(\w+)\s+%(\w+)<(\d+)>")
_USED = re.compile(r"%([a-z]+)(\d+)\b")
_PARTS = re.compile(r"^(?:\.visible\s+)?\.(entry|func)\b", re.M)
_ROUNDED = re.compile(r"\b(add|sub|mul|fma|div|sqrt)((?:\.\w+)*)\.f64\b")
TRIPLE = "nvptx64-nvidia-cuda"
OLDEST = "sm_75"
"""PTX for this generation (Turing) runs on it and on every later one: the driver finishes the compilation."""
KNOWN = ("sm_60", "sm_70", "sm_75", "sm_80", "sm_86", "sm_89", "sm_90", "sm_100", "sm_120")


@dataclass(frozen=True)
class GridProgram:
    """PTX and what its launch needs.

    Attributes:
        name: symbol of the kernel.
        signature: ports.
        plan: threads of a block, and how rows are carried.
        text: PTX.
    """

    name: str
    signature: Signature
    plan: Plan
    text: str


def grid_program(tape: Tape, signature: Signature, name: str, processor: str = OLDEST) -> GridProgram:
    """The kernel of a tape.

    Args:
        tape: the program.
        signature: its ports.
        name: symbol of the kernel.
        processor: oldest generation that it shall run on.

    Raises:
        InputError: no such generation.
        KernelError: LLVM refuses the module.
    """
    target = nvptx(processor)
    found = plan(signature)
    text = translate(device_module(tape, signature, target, found, name), target, "assembly").decode()
    return GridProgram(name, signature, found, text)


def device_program(signature: Signature, build: Callable[[], Function]) -> GridProgram:
    """A kernel as it is launched over arrays on a device.

    Args:
        signature: its ports.
        build: makes its expression.
    """
    return grid_program(reduce(read(build())), signature, f"mafsil_{identifier(signature.name)}")


def nvptx(processor: str) -> Target:
    """A generation of graphics processors; each fuses products and sums and rounds to integers.

    Raises:
        InputError: no such generation.
    """
    if processor not in KNOWN:
        raise InputError("export.machine", name=processor, known=", ".join(KNOWN))
    return Target(TRIPLE, processor, "", 1, fma=True, rounding=True)


@dataclass(frozen=True)
class PtxSummary:
    """What a PTX text is made of.

    Attributes:
        version: of the language, such as `6.3`.
        processor: oldest generation.
        entries: kernels.
        functions: other functions.
        undeclared: registers used but not declared, or labels or functions that do not exist.
        local: the text reserves stack space.
        outside: functions that others must bring.
        fused: fused products and sums.
        arithmetic: instructions on doubles that compute something.
        unrounded: of them, those whose rounding the driver's compiler may change.
        barriers: meetings of a block.
    """

    version: str
    processor: str
    entries: tuple[str, ...]
    functions: tuple[str, ...]
    undeclared: tuple[str, ...]
    local: bool
    outside: tuple[str, ...]
    fused: int
    arithmetic: int
    unrounded: tuple[str, ...]
    barriers: int


def inspect(text: str) -> PtxSummary:
    """Read a PTX text as LLVM writes it."""
    code = re.sub(r"//[^\n]*", "", text)
    starts = [found.start() for found in _PARTS.finditer(code)]
    parts = [code[a:b] for a, b in zip(starts, [*starts[1:], len(code)], strict=True)]
    names = [(_PARTS.match(part), _name(part)) for part in parts]
    entries = tuple(name for found, name in names if found and found.group(1) == "entry")
    functions = tuple(name for found, name in names if found and found.group(1) == "func")
    rounded = _ROUNDED.findall(code)
    plain = tuple(f"{op}{how}.f64" for op, how in rounded if ".rn" not in how)
    return PtxSummary(
        version=_after(code, ".version"),
        processor=_after(code, ".target"),
        entries=entries,
        functions=functions,
        undeclared=tuple(sorted({bad for part in parts for bad in _undeclared_names(part, {*entries, *functions})})),
        local=".local" in code,
        outside=tuple(re.findall(r"\.extern\s+\.func[^;]*?(\w+)\s*[(;]", code)),
        fused=sum(op == "fma" for op, _ in rounded),
        arithmetic=len(rounded),
        unrounded=plain,
        barriers=len(re.findall(r"\b(?:bar\.sync|barrier\.sync|barrier\.cta\.sync)", code)),
    )


def _after(code: str, directive: str) -> str:
    found = re.search(re.escape(directive) + r"\s+([^\s,]+)", code)
    return found.group(1) if found else ""


def _name(part: str) -> str:
    """The function's name: behind the results in parentheses, before the parameters."""
    head = re.sub(r"^\S*\s*(?:\.\w+\s+)*\.(?:entry|func)\s*", "", part.partition("{")[0], count=1)
    head = re.sub(r"^\([^)]*\)\s*", "", head.strip())
    found = re.match(r"[\w$]+", head)
    return found.group() if found else ""


def _undeclared_names(part: str, known: set[str]) -> set[str]:
    body = part.partition("{")[2]
    declared = {prefix: int(count) for _, prefix, count in _REGISTERS.findall(body)}
    bad = {
        f"%{prefix}{number}"
        for prefix, number in _USED.findall(re.sub(r"%(?:tid|ctaid|ntid|nctaid)\.\w", "", body))
        if int(number) >= declared.get(prefix, 0)
    }
    labels = set(re.findall(r"^(\$\w+):", body, flags=re.M))
    bad |= {label for label in re.findall(r"\bbra(?:\.uni)?\s+(\$\w+)", body) if label not in labels}
    called = re.findall(r"\bcall(?:\.uni)?\s+(?:\([^)]*\)\s*,\s*)?([A-Za-z_$][\w$]*)", body)
    return bad | {name for name in called if name not in known}
