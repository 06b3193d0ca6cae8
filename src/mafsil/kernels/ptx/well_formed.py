"""What can be said of PTX without a device or NVIDIA's tools: every name declared, nothing missing, no stack."""

from __future__ import annotations

import re
from dataclasses import dataclass

_REGISTERS = re.compile(r"\.reg\s+\.(\w+)\s+%(\w+)<(\d+)>")
_USED = re.compile(r"%([a-z]+)(\d+)\b")
_PARTS = re.compile(r"^(?:\.visible\s+)?\.(entry|func)\b", re.M)
_ROUNDED = re.compile(r"\b(add|sub|mul|fma|div|sqrt)((?:\.\w+)*)\.f64\b")


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
