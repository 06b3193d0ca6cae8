"""From an expression to LLVM IR: entries for batches, for one row, and for rows in lanes, alone or in one module.

The batch entry takes W rows at once, the single entry one row by the shortest way. A tape is a list of operations on
numbers, each needing earlier ones. In C the single entry would be
`void single(const double *x0, ..., double *y0, ...) { double t5 = x0[1] * x0[2]; ... y0[0] = t9; }`; the batch entry
does the same with W numbers in place of one (`<W x double>`), element e of W rows of the batch in the W lanes. Steps:

1. The function is read into a tape and reduced (`trace_function`); ports and tape must fit each other, and one tile of
   rows the stack.
2. The tape is cut into pieces of some thousand operations (`segments`): LLVM's time grows faster than the length.
3. Every piece is printed, operation by operation (`program.Program`), into the text of a function.
4. One piece is the body itself; several become functions that the body calls one after another, values for later
   pieces in memory at `%far`.
5. The batch entry is wrapped in what brings rows into lanes (`staging`); the single entry takes pointers as they are.
6. What all need once: declarations of intrinsics, attributes. What moves rows and reduces huge angles is the same for
   all kernels of a processor: a part of a module that stands alone, else compiled once and called (`shared_module`).

Compiled apart, each entry is there as soon as it is needed, and a kernel that is only ever called in one way has only
that. Comments are kept out of the IR itself: its length decides how hard LLVM tries (`target`). Kernels from the cache
need none of this, and `compiler` imports this module when it must: with the expressions, the rules of reduction and
the printers of IR it takes 30 ms, more than all the rest of a start.
"""

from __future__ import annotations

from mafsil.errors import KernelError
from mafsil.expression import Function
from mafsil.kernels import call
from mafsil.kernels.argument import huge_function, huge_value_function
from mafsil.kernels.call import CALL
from mafsil.kernels.emitter import Text, prototypes
from mafsil.kernels.gathering import GATHERING
from mafsil.kernels.layout import ALONE, BATCH, LANE_COUNT, LANES, SINGLE, Signature
from mafsil.kernels.program import Program
from mafsil.kernels.reduce import reduce
from mafsil.kernels.rows import blocks
from mafsil.kernels.schedule import Segment, segments
from mafsil.kernels.staging import BODY, movers, staging
from mafsil.kernels.tape import Tape, from_text, read
from mafsil.kernels.target import Target

TILE_BYTES = 1 << 22
"""Bytes of stack that the rows of one tile may take: half of what a thread has on most systems."""
Places = dict[int, list[tuple[int, int]]]


def lower(
    tape: Tape, signature: Signature, target: Target, entries: tuple[str, ...] = (BATCH, SINGLE), alone: bool = True
) -> str:
    """Text of one module with the entries.

    Args:
        tape: the program, reduced or not.
        signature: its ports; sizes must be those of the tape.
        target: lanes, and whether products and sums may be fused.
        entries: which of `mafsil_batch`, `mafsil_single` and `mafsil_lanes`.
        alone: without calls to anything outside; else it calls the functions of `shared_module`.

    Raises:
        KernelError: the ports do not fit the tape, or a tile not the stack.
    """
    # 1. (The stack is checked with the batch entry.)
    _check(tape, signature)
    # 2. to 5. for each entry.
    declared, lines = {"declare i64 @llvm.ctlz.i64(i64, i1)"}, list[str]()
    for name, body in ((BATCH, _batch), (SINGLE, _single), (LANES, _lanes)):
        if name in entries:
            found, text = body(tape, signature, target)
            declared |= found
            lines += text
    # The batch entry looks up the single one at ALONE, to leave a lone row to it: in the same module that is a
    # constant, else a variable, null until `image` stores the address.
    if BATCH in entries:
        known = f"internal constant ptr @{SINGLE}" if SINGLE in entries else "dso_local global ptr null"
        lines.append(f"@{ALONE} = {known}, align 8")
    # 6.
    operations = {node.op for node in tape.nodes}
    found, text = _callees(target, moves=BATCH in entries, turns=bool(operations & {"sin", "cos", "tan"}))
    if alone:
        declared |= found
        lines.append(text)
    else:
        declared |= set(prototypes(text))
    return _module(target, declared, lines)


def shared_module(target: Target) -> tuple[str, list[str]]:
    """Text of the module with what all kernels of a processor call, and its symbols.

    That is what moves rows, reduces huge angles, and reads the arguments of unusual calls.

    Args:
        target: lanes, and whether products and sums may be fused.
    """
    declared, text = _callees(target)
    text += GATHERING
    symbols = [head.split("@")[1].split("(")[0] for head in prototypes(text)]
    return _module(target, declared, [text.replace("define internal", "define dso_local")]), symbols


def _callees(target: Target, moves: bool = True, turns: bool = True) -> tuple[set[str], str]:
    """Declarations and text of what moves rows, and of what reduces huge angles."""
    huge, declared = huge_function(target.fma, "#0") if turns else ("", set[str]())
    return declared, (movers(target.lanes, "#0", target.triple) if moves else "") + huge


def _module(target: Target, declared: set[str], lines: list[str]) -> str:
    # LLVM would split vectors of 512 bits on processors where it thinks them slow; "no-builtins" keeps it from turning
    # loops into calls of memcpy, which nobody would link. The weights are those of `argument`: one in a million.
    bits = 64 * target.lanes  # The lanes of LANES are split where vectors are narrower.
    attributes = f'"min-legal-vector-width"="{bits}" "prefer-vector-width"="{bits}" "no-builtins" nounwind'
    weights = '!0 = !{!"branch_weights", i32 1, i32 1000000}'
    triple = f'target triple = "{target.triple}"'
    return "\n".join([triple, *sorted(declared), *lines, f"attributes #0 = {{ {attributes} }}", weights, ""])


def _batch(tape: Tape, signature: Signature, target: Target) -> tuple[set[str], list[str]]:
    """Declarations and text of the batch entry and all that it calls."""
    _check_tile(signature, target.lanes)
    # The body takes a tile of inputs and, for every output, the address of its first row and the bytes between rows.
    rows = ", ".join(["ptr noalias %in", *(f"ptr noalias %rows{k}, i64 %step{k}" for k in range(len(tape.outputs)))])
    entry = _Entry(tape, segments(tape, blocks=blocks(tape, target.lanes)), target, target.lanes, rows)
    head = f"define internal void @{BODY}({rows}) noinline #0 {{"
    body = [*entry.functions, head, "entry:", *entry.lines, "}", staging(signature, target.lanes, "#0", target.triple)]
    return entry.declared, body


def _single(tape: Tape, signature: Signature, target: Target) -> tuple[set[str], list[str]]:
    """Declarations and text of the single entry and all that it calls."""
    ports = ", ".join(["ptr noalias %in", *_pointers("noalias %y", len(signature.outputs))])
    entry = _Entry(tape, segments(tape), target, 1, ports)
    # One piece reads all inputs before it writes; several pieces would read inputs that an earlier one has overwritten
    # where the caller's `out` lies over them, so they get a copy.
    gathered = _gather(signature) if entry.functions else []
    head = f"define dso_local void @{SINGLE}({', '.join(_single_ports(signature))}) #0 {{"
    return entry.declared, [*entry.functions, head, "entry:", *gathered, *entry.lines, "}"]


def _lanes(tape: Tape, signature: Signature, target: Target) -> tuple[set[str], list[str]]:
    """Declarations and text of the entry for rows in lanes, and all it calls: nothing is transposed."""
    ports = ", ".join(["ptr noalias %in", *_pointers("noalias %y", len(signature.outputs))])
    entry = _Entry(tape, segments(tape), target, LANE_COUNT, ports, in_rows=False)
    head = f"define dso_local void @{LANES}({ports}) #0 {{"
    return entry.declared, [*entry.functions, head, "entry:", *entry.lines, "}"]


def point(
    tape: Tape, signature: Signature, target: Target, name: str, *, inline: bool = False, cut: bool = False
) -> str:
    """Text of one evaluation without vectors, and all it calls: void name(double *in0, ..., double *out0, ...).

    Args:
        tape: the program, reduced or not.
        signature: its ports; sizes must be those of the tape.
        target: whether products and sums may be fused; its lanes do not matter.
        name: symbol of the function.
        inline: the function is a part of others in the same module, else it is an entry of the module.
        cut: into functions that it calls, as for this machine; a copy of the inputs and values between them take
            stack space. Otherwise never: compilers of other machines have their own ways with long functions.

    Raises:
        KernelError: the ports do not fit the tape.
    """
    _check(tape, signature)
    pieces = segments(tape) if cut else segments(tape, 1 << 60)
    ports = ", ".join(["ptr noalias %in", *_pointers("noalias %y", len(signature.outputs))])
    entry = _Entry(tape, pieces, target, 1, ports, scalar=True)
    gathered = _gather(signature) if entry.functions else []
    huge, declared = huge_value_function(target.fma, "#1")
    head = "define internal" if inline else "define dso_local"
    operations = {node.op for node in tape.nodes}
    return "\n".join(
        [
            *sorted(entry.declared | declared | {"declare i64 @llvm.ctlz.i64(i64, i1)"}),
            huge if operations & {"sin", "cos", "tan"} else "",
            *entry.functions,
            f"{head} void @{name}({', '.join(_single_ports(signature))}) {'alwaysinline ' * inline}#1 {{",
            "entry:",
            *gathered,
            *entry.lines,
            "}",
            'attributes #1 = { "no-builtins" nounwind }',
            '!0 = !{!"branch_weights", i32 1, i32 1000000}',
            "",
        ]
    )


def _check(tape: Tape, signature: Signature) -> None:
    sizes = tuple(port.size for port in signature.inputs), tuple(port.size for port in signature.outputs)
    if sizes != (tape.input_sizes, tape.output_sizes):
        raise KernelError(
            "kernels.ports", kernel=signature.name, expected=sizes, got=(tape.input_sizes, tape.output_sizes)
        )


def _check_tile(signature: Signature, lanes: int) -> None:
    count, most = sum(port.size for port in signature.ports), TILE_BYTES // (8 * lanes)
    if count > most:
        raise KernelError("kernels.stack_size", kernel=signature.name, count=count, most=most)


class _Entry:
    """The lines of one entry's body; a long tape becomes functions that the body calls.

    Attributes:
        functions: IR of these functions.
        lines: the body.
        declared: declarations of the intrinsics in use.
    """

    def __init__(
        self,
        tape: Tape,
        pieces: tuple[list[Segment], int],
        target: Target,
        width: int,
        ports: str,
        in_rows: bool = True,
        scalar: bool = False,
    ) -> None:
        self.functions: list[str] = []
        self.lines: list[str] = []
        self.declared: set[str] = set()
        self.group = "#1" if scalar else "#0"
        # 3.
        found, cells = pieces
        places = _places(tape)
        texts = [
            _emit(tape, found, k, Text(target.fma, target.rounding, scalar=scalar), width, places, in_rows)
            for k in range(len(found))
        ]
        for text in texts:
            self.declared |= text.declared
        # 4.
        if len(texts) == 1:
            self.lines = [*texts[0].entry, *texts[0].lines, "  ret void"]
        else:
            self.call(texts, cells, width, ports)

    def call(self, texts: list[Text], cells: int, width: int, ports: str) -> None:
        """The pieces as functions, called one after another."""
        # `noinline` holds the pieces apart: inlined they would be one long function again. `noalias` is for parameters
        # only, so it is taken out of the arguments of the calls.
        real = "double" if width == 1 else f"<{width} x double>"
        self.lines.append(f"  %far = alloca [{max(cells, 1)} x {real}], align 64")
        arguments = ports.replace("noalias ", "")
        for k, text in enumerate(texts):
            name = f"{BODY}.{width}.{k}"
            head = f"define internal void @{name}({ports}, ptr noalias %far) noinline {self.group} {{"
            self.functions.append("\n".join([head, "entry:", *text.entry, *text.lines, "  ret void", "}", ""]))
            self.lines.append(f"  call void @{name}({arguments}, ptr %far)")
        self.lines.append("  ret void")


def _emit(
    tape: Tape, pieces: list[Segment], k: int, text: Text, width: int, places: Places, in_rows: bool
) -> Text:  # fmt: skip
    """The text of piece k; the first also stores the outputs that are inputs or constants."""
    # Stack space is reserved in the entry block, whose lines are known last; the arithmetic begins in another one.
    text.do("br label %body")
    text.label("body")
    program = Program(tape, pieces[k], text, width, in_rows)
    # Outputs may overwrite inputs: a single piece on one row reads all of them first.
    if width == 1 and len(pieces) == 1:
        program.preload()
    # Outputs that are inputs or constants belong to no piece; the first one writes them. (With several lanes they are
    # part of the blocks.)
    if k == 0:
        for i, where in places.items():
            if tape.nodes[i].op in ("input", "const"):
                program.store(i, where)
    program.emit(places)
    return text


def _places(tape: Tape) -> Places:
    """For every node, the (port, element) of the outputs that it is."""
    places: Places = {}
    for k, port in enumerate(tape.outputs):
        for element, i in enumerate(port):
            places.setdefault(i, []).append((k, element))
    return places


def _pointers(name: str, count: int) -> list[str]:
    return [f"ptr {name}{k}" for k in range(count)]


def _single_ports(signature: Signature) -> list[str]:
    return _pointers("%x", len(signature.inputs)) + _pointers("%y", len(signature.outputs))


def _gather(signature: Signature) -> list[str]:
    """Copies all inputs to one place on the stack: outputs may overwrite inputs, so all are read first."""
    text = Text(fma=False, rounding=False)
    total = sum(port.size for port in signature.inputs)
    text.do(f"%in = alloca [{max(total, 1)} x double], align 64")
    place = 0
    for k, port in enumerate(signature.inputs):
        for element in range(port.size):
            text.do(f"%from{place} = getelementptr double, ptr %x{k}, i64 {element}")
            text.do(f"%number{place} = load double, ptr %from{place}, align 8")
            text.do(f"%to{place} = getelementptr double, ptr %in, i64 {place}")
            text.do(f"store double %number{place}, ptr %to{place}, align 8")
            place += 1
    return text.lines


def trace_function(function: Function) -> Tape:
    """The reduced tape of a function.

    Args:
        function: whose ports are columns.

    Raises:
        KernelError: an operation has no compiled form.
    """
    return reduce(read(function))


def translate(part: str, program: str | None, signature: Signature, machine: Target) -> str:
    """LLVM IR of the module of a part.

    Args:
        part: BATCH, SINGLE, LANES or CALL.
        program: text of the reduced tape; None for CALL, which does no arithmetic.
        signature: ports.
        machine: to compile for.
    """
    if program is None or part == CALL:
        return call.wrapper(signature, machine.triple)
    ir = lower(from_text(program), signature, machine, (part,), alone=False)
    return ir + call.loop(machine.triple) if part == BATCH else ir
