"""Rows in, lanes out: IR that carries W rows of an input to a tile, where equal elements lie side by side.

A tile holds element e of row l at index e W + l. The arithmetic reads tiles and writes W rows; tails and outputs whose
cores are not contiguous are written to spare rows and copied from there. So the arithmetic is compiled once, and full
tiles, tails, broadcasts and any strides give the same bits.

One call of the batch entry:

1. Base, strides and contiguity of every port; one contiguous row goes to the single entry.
2. Inputs that are broadcast fill their tiles once.
3. For every full tile: the other inputs are brought in, those of the next tile are asked for, and the arithmetic
   writes its rows to the result, or to spare rows where their cores are not contiguous, or to the stage of `streaming`
   where the caller asks for that and the rows of the batch are contiguous.
4. The last rows, fewer than W, go by the spare rows.

`args`, `dims` and `steps` are those of a NumPy gufunc loop: addresses of all ports; the number of rows; bytes from row
to row of every port, then bytes along every core axis.
"""

from __future__ import annotations

from mafsil.kernels.emitter import Text
from mafsil.kernels.layout import ALONE, BATCH, Port, Signature, contiguous_steps
from mafsil.kernels.rows import block_length, columns_of
from mafsil.kernels.streaming import LINE, REST, STREAM, functions, pitch, stage_size, streams

BODY = "mafsil_tile"
"""Symbol of the arithmetic on one tile: void (double *in, char *rows0, int64 step0, char *rows1, ...)."""
_FAR = 1024
"""Bytes of the rows of a tile from which on the processor does not fetch them by itself before they are needed."""


def staging(signature: Signature, width: int, attributes: str, triple: str) -> str:
    """IR of the batch entry, which calls the functions of `movers`.

    Args:
        signature: ports of the kernel.
        width: rows of a tile.
        attributes: of every function.
        triple: LLVM triple of the target, which decides whether there are stores past the caches.
    """
    streaming = streams(triple) and any(port.size for port in signature.outputs)
    parts = [_shapes(signature), _Batch(signature, width, streaming).text()]
    return "\n".join(parts).replace("#ATTRIBUTES", attributes)


def movers(width: int, attributes: str, triple: str) -> str:
    """IR of the functions that move rows, the same for all kernels of a processor; arguments as for `staging`."""
    parts = [mover(width, block) for block in (4, 2) if block <= width]
    parts += [_walker(width, inward=True), _walker(width, inward=False), _AHEAD]
    if streams(triple):
        parts.append(functions())
    return "\n".join(parts).replace("#ATTRIBUTES", attributes)


def mover(width: int, block: int) -> str:
    """IR of a function that transposes `width` contiguous rows, `block` columns at a time; the last block may overlap.

    void (double *rows, int64 step in bytes, int64 columns >= block, double *tile).
    """
    # do { load `block` columns of W rows; transpose in registers; store them as columns of the tile; } until the last.
    text = Text(fma=False, rounding=False)
    for row in range(1, width):
        text.do(f"%step{row} = mul i64 %step, {row}")
    text.do(f"%last = sub i64 %columns, {block}")
    text.do("br label %next")
    text.label("next")
    text.do("%column = phi i64 [ 0, %entry ], [ %following, %next ]")
    text.do("%row0 = getelementptr double, ptr %rows, i64 %column")
    text.do(f"%skip = mul i64 %column, {width}")
    text.do("%place = getelementptr double, ptr %tile, i64 %skip")
    rows = ["%row0"] + [text.let(f"getelementptr i8, ptr %row0, i64 %step{row}") for row in range(1, width)]
    columns = [text.let(f"getelementptr double, ptr %place, i64 {k * width}") for k in range(block)]
    values = [text.let(f"load <{block} x double>, ptr {row}, align 8") for row in rows]
    for place, value in zip(columns, columns_of(text, values, width, block), strict=True):
        text.do(f"store <{width} x double> {value}, ptr {place}, align {8 * width}")
    text.do("%done = icmp sge i64 %column, %last")
    # The last step goes back to columns - block: the overlap is written twice, with the same numbers.
    text.do(f"%ahead = add i64 %column, {block}")
    text.do("%over = icmp sgt i64 %ahead, %last")
    text.do("%following = select i1 %over, i64 %last, i64 %ahead")
    text.do("br i1 %done, label %leave, label %next")
    text.label("leave")
    text.do("ret void")
    head = f"define internal void @{_mover(block)}(ptr %rows, i64 %step, i64 %columns, ptr %tile) #ATTRIBUTES {{"
    return "\n".join([head, "entry:", *text.lines, "}", ""])


_AHEAD = f"""
declare void @llvm.prefetch.p0(ptr, i32, i32, i32)

define internal void @mafsil_ahead(ptr %start, i64 %bytes) #ATTRIBUTES {{
entry:
  br label %next
next:
  %at = phi i64 [ 0, %entry ], [ %at.next, %next ]
  %place = getelementptr i8, ptr %start, i64 %at
  call void @llvm.prefetch.p0(ptr %place, i32 0, i32 3, i32 1)
  %at.next = add i64 %at, {LINE}
  %more = icmp slt i64 %at.next, %bytes
  br i1 %more, label %next, label %leave
leave:
  ret void
}}
"""
"""Asks for memory that will be read soon; beyond the end of an array nothing happens."""


def _mover(block: int) -> str:
    return f"mafsil_in{block}"


def _walker(width: int, inward: bool) -> str:
    """IR of a function that moves any rows element by element: tails, broadcasts, any strides.

    void (char *rows, int64 step, count of rows, elements, rank, int64 *shape, *steps, double *cells).
    Inward, the cells are a tile, and lanes beyond the count repeat the last row; outward, they are contiguous rows, of
    which `count` are copied.

    1. For every element e of the core:
    2. its offset from the quotients and remainders of e by the core's sizes, innermost axis first (mixed radix);
    3. for every lane l: the copy between rows + min(l, count - 1) step + offset and the cell.
    """
    copy = (
        "%number = load double, ptr %source, align 8\n  store double %number, ptr %cell, align 8"
        if inward
        else "%number = load double, ptr %cell, align 8\n  store double %number, ptr %source, align 8"
    )
    lanes = str(width) if inward else "%count"
    element, lane = ("%e", "%l") if inward else ("%l", "%e")
    across = str(width) if inward else "%elements"
    arguments = "ptr %rows, i64 %step, i64 %count, i64 %elements, i64 %rank, ptr %shape, ptr %steps, ptr %tile"
    return f"""define internal void @{_walk(inward)}({arguments}) #ATTRIBUTES {{
entry:
  %lastrow = sub i64 %count, 1
  %innermost = sub i64 %rank, 1
  br label %element
element:                                                     ; 1.
  %e = phi i64 [ 0, %entry ], [ %e.next, %element.end ]
  br label %axis
axis:                                                        ; 2.
  %d = phi i64 [ %innermost, %element ], [ %d.next, %axis.body ]
  %rest = phi i64 [ %e, %element ], [ %rest.next, %axis.body ]
  %offset = phi i64 [ 0, %element ], [ %offset.next, %axis.body ]
  %axis.done = icmp slt i64 %d, 0
  br i1 %axis.done, label %lane, label %axis.body
axis.body:
  %size.place = getelementptr i64, ptr %shape, i64 %d
  %size = load i64, ptr %size.place, align 8
  %axis.step.place = getelementptr i64, ptr %steps, i64 %d
  %axis.step = load i64, ptr %axis.step.place, align 8
  %rest.next = udiv i64 %rest, %size
  %whole = mul i64 %rest.next, %size
  %along = sub i64 %rest, %whole
  %shift = mul i64 %along, %axis.step
  %offset.next = add i64 %offset, %shift
  %d.next = sub i64 %d, 1
  br label %axis
lane:                                                        ; 3.
  %l = phi i64 [ 0, %axis ], [ %l.next, %lane ]
  %beyond = icmp sgt i64 %l, %lastrow
  %row = select i1 %beyond, i64 %lastrow, i64 %l
  %row.shift = mul i64 %row, %step
  %place = add i64 %row.shift, %offset
  %source = getelementptr i8, ptr %rows, i64 %place
  %cell.row = mul i64 {element}, {across}
  %cell.index = add i64 %cell.row, {lane}
  %cell = getelementptr double, ptr %tile, i64 %cell.index
  {copy}
  %l.next = add i64 %l, 1
  %l.more = icmp slt i64 %l.next, {lanes}
  br i1 %l.more, label %lane, label %element.end
element.end:
  %e.next = add i64 %e, 1
  %e.more = icmp slt i64 %e.next, %elements
  br i1 %e.more, label %element, label %leave
leave:
  ret void
}}
"""


def _walk(inward: bool) -> str:
    return f"mafsil_{'in' if inward else 'out'}_any"


def _shapes(signature: Signature) -> str:
    """Constant tables of the core shapes; a contiguous core is walked as one axis with steps of 8 bytes."""
    lines: list[str] = []
    for k, port in enumerate(signature.ports):
        values = ", ".join(f"i64 {n}" for n in port.shape or (1,))
        lines.append(f"@shape{k} = private unnamed_addr constant [{len(port.shape) or 1} x i64] [{values}]")
        lines.append(f"@size{k} = private unnamed_addr constant i64 {port.size}")
    return "\n".join([*lines, "@eight = private unnamed_addr constant i64 8", ""])


class _Batch:
    """Writes the batch entry."""

    def __init__(self, signature: Signature, width: int, streaming: bool) -> None:
        self.signature = signature
        self.width = width
        self.streaming = streaming
        self.out = Text(fma=False, rounding=False)
        self.inputs = len(signature.inputs)

    def text(self) -> str:
        """The four steps."""
        # 1.
        out, width = self.out, self.width
        out.do("%rows = load i64, ptr %dims, align 8")
        self._tiles()
        out.do("%some = icmp sgt i64 %rows, 0")
        out.do("br i1 %some, label %ports, label %leave")
        out.label("ports")
        for k, port in enumerate(self.signature.ports):
            self._port(k, port)
        self._only_row()
        # 2.
        for k, port in enumerate(self.signature.inputs):
            self._broadcast(k, port)
        # 3. for (row = 0; row <= rows - W; row += W)
        out.do(f"%tiles = sub i64 %rows, {width}")
        out.do("%first = icmp sge i64 %tiles, 0")
        before = out.block
        out.do("br i1 %first, label %tile, label %rest")
        out.label("tile")
        out.do(f"%row = phi i64 [ 0, %{before} ], [ %row.next, %tile.end ]")
        for k, port in enumerate(self.signature.ports):
            if k < self.inputs:
                self._full(k, port)
        self._compute()
        out.do("br label %tile.end")
        out.label("tile.end")
        out.do(f"%row.next = add i64 %row, {width}")
        out.do("%more = icmp sle i64 %row.next, %tiles")
        out.do("br i1 %more, label %tile, label %rest")
        # 4.
        out.label("rest")
        out.do(f"%from = phi i64 [ 0, %{before} ], [ %row.next, %tile.end ]")
        self._stream_rest()
        out.do("%left = sub i64 %rows, %from")
        out.do("%tail = icmp sgt i64 %left, 0")
        out.do("br i1 %tail, label %partial, label %leave")
        out.label("partial")
        for k, port in enumerate(self.signature.ports):
            if k == self.inputs:
                self._call_body([(f"%tile{o}", str(8 * p.size)) for o, p in self._outputs()])
            self._walk(k, port, "%from", "%left")
        out.do("br label %leave")
        out.label("leave")
        out.do("ret void")
        head = f"define dso_local void @{BATCH}(ptr %args, ptr %dims, ptr %steps, ptr %data) #ATTRIBUTES {{"
        return "\n".join([head, "entry:", *out.entry, *out.lines, "}", ""])

    def _tiles(self) -> None:
        """Stack space of the tiles, and where every port begins in them."""
        places = self._places()
        for name, size in (("in", self._size(self.signature.inputs)), ("out", places[-1])):
            self.out.entry.append(f"  %{name} = alloca [{max(1, size)} x double], align 64")
        for k in range(len(self.signature.ports)):
            base = "in" if k < self.inputs else "out"
            self.out.do(f"%tile{k} = getelementptr double, ptr %{base}, i64 {places[k]}")

    def _size(self, ports: tuple[Port, ...]) -> int:
        return self.width * sum(port.size for port in ports)

    def _places(self) -> list[int]:
        """Where in its stack space each port begins, in doubles; the last number is the size of the outputs' space."""
        places = [self._size(self.signature.inputs[:k]) for k in range(self.inputs)]
        end = 0
        for port in self.signature.outputs:
            front = LINE // 8 if self.streaming else 0
            places.append(end + front)
            end += stage_size(port, self.width) if self.streaming else self.width * port.size
        return [*places, end]

    def _port(self, k: int, port: Port) -> None:
        """Base, outer stride, whether the core is contiguous, and the table of core strides in force."""
        out, rank = self.out, len(port.shape)
        out.do(f"%base{k}.place = getelementptr ptr, ptr %args, i64 {k}")
        out.do(f"%base{k} = load ptr, ptr %base{k}.place, align 8")
        out.do(f"%step{k}.place = getelementptr i64, ptr %steps, i64 {k}")
        out.do(f"%step{k} = load i64, ptr %step{k}.place, align 8")
        out.do(f"%core{k} = getelementptr i64, ptr %steps, i64 {self.signature.core_steps[k]}")
        # Contiguous: every core stride is that of C order; axes of length 1 are never stepped along.
        dense = "true"
        for axis, (size, step) in enumerate(zip(port.shape, contiguous_steps(port), strict=True)):
            if size > 1:
                place = out.let(f"getelementptr i64, ptr %core{k}, i64 {axis}")
                same = out.let(f"icmp eq i64 {out.let(f'load i64, ptr {place}, align 8')}, {step}")
                dense = out.let(f"and i1 {dense}, {same}")
        out.do(f"%dense{k} = and i1 {dense}, true")
        out.do(f"%walk.rank{k} = select i1 %dense{k}, i64 {min(rank, 1)}, i64 {rank}")
        out.do(f"%walk.shape{k} = select i1 %dense{k}, ptr @size{k}, ptr @shape{k}")
        out.do(f"%walk.steps{k} = select i1 %dense{k}, ptr @eight, ptr %core{k}")
        if k < self.inputs:
            out.do(f"%fixed{k} = icmp eq i64 %step{k}, 0")
        elif self.streaming:
            # Staged: the caller asks for it by `data`, and the rows of the whole batch lie one after another.
            asked = out.let("icmp ne ptr %data, null")
            rows = out.let(f"icmp eq i64 %step{k}, {8 * port.size}")
            out.do(f"%staged{k} = and i1 %dense{k}, {out.let(f'and i1 {asked}, {rows}')}")
            out.entry.append(f"  %cursor{k} = alloca ptr, align 8")
            out.do(f"store ptr %base{k}, ptr %cursor{k}, align 8")

    def _only_row(self) -> None:
        """One contiguous row goes to the single entry, which has the shorter way, if that is there."""
        out = self.out
        single = out.let(f"load ptr, ptr @{ALONE}, align 8")
        alone = out.let("icmp eq i64 %rows, 1")
        alone = out.let(f"and i1 {alone}, {out.let(f'icmp ne ptr {single}, null')}")
        for k in range(len(self.signature.ports)):
            alone = out.let(f"and i1 {alone}, %dense{k}")
        out.do(f"br i1 {alone}, label %single, label %many")
        out.label("single")
        arguments = ", ".join(f"ptr %base{k}" for k in range(len(self.signature.ports)))
        out.do(f"call void {single}({arguments})")
        out.do("ret void")
        out.label("many")

    def _broadcast(self, k: int, port: Port) -> None:
        """An input with outer stride 0 fills its tile once."""
        if port.size == 0:
            return
        self.out.do(f"br i1 %fixed{k}, label %fill{k}, label %filled{k}")
        self.out.label(f"fill{k}")
        self._call_walk(k, port, f"%base{k}", str(self.width))
        self.out.do(f"br label %filled{k}")
        self.out.label(f"filled{k}")

    def _full(self, k: int, port: Port) -> None:
        """Fill a tile with full lanes of one input by the shortest way."""
        out = self.out
        if port.size == 0:
            return
        out.do(f"br i1 %fixed{k}, label %full.end{k}, label %full{k}")
        out.label(f"full{k}")
        shift = out.let(f"mul i64 %row, %step{k}")
        place = out.let(f"getelementptr i8, ptr %base{k}, i64 {shift}")
        block = block_length(port.size, self.width)
        if block > 1:
            out.do(f"br i1 %dense{k}, label %fast{k}, label %slow{k}")
            out.label(f"fast{k}")
            out.do(f"call void @{_mover(block)}(ptr {place}, i64 %step{k}, i64 {port.size}, ptr %tile{k})")
            self._ask_ahead(k, port, place)
            out.do(f"br label %full.end{k}")
            out.label(f"slow{k}")
        self._call_walk(k, port, place, str(self.width))
        out.do(f"br label %full.end{k}")
        out.label(f"full.end{k}")

    def _ask_ahead(self, k: int, port: Port, place: str) -> None:
        """The rows of the next tile are on their way while this one is computed, if they follow and are long."""
        out, size = self.out, 8 * port.size * self.width
        if size < _FAR:
            return
        follow = out.let(f"icmp eq i64 %step{k}, {8 * port.size}")
        out.do(f"br i1 {follow}, label %ahead{k}, label %full.end{k}")
        out.label(f"ahead{k}")
        next_tile = out.let(f"getelementptr i8, ptr {place}, i64 {size}")
        out.do(f"call void @mafsil_ahead(ptr {next_tile}, i64 {size})")

    def _compute(self) -> None:
        """The arithmetic on a full tile, straight to the caller's rows where their cores are contiguous."""
        out = self.out
        # Where each output goes: the caller's rows, spare rows (the tile) with a scatter afterwards, or the stage.
        targets: list[tuple[str, str]] = []
        places: dict[int, str] = {}
        for k, port in self._outputs():
            shift = out.let(f"mul i64 %row, %step{k}")
            places[k] = out.let(f"getelementptr i8, ptr %base{k}, i64 {shift}")
            rows = out.let(f"select i1 %dense{k}, ptr {places[k]}, ptr %tile{k}")
            step = out.let(f"select i1 %dense{k}, i64 %step{k}, i64 {8 * port.size}")
            if self.streaming:
                rows = out.let(f"select i1 %staged{k}, ptr %tile{k}, ptr {rows}")
                step = out.let(f"select i1 %staged{k}, i64 {pitch(port, self.width)}, i64 {step}")
            targets.append((rows, step))
        self._call_body(targets)
        for k, port in self._outputs():
            if port.size:
                out.do(f"br i1 %dense{k}, label %dense.rows{k}, label %scatter{k}")
                out.label(f"scatter{k}")
                self._call_walk(k, port, places[k], str(self.width))
                out.do(f"br label %written{k}")
                out.label(f"dense.rows{k}")
                self._stream(k, port, places[k])
                out.do(f"br label %written{k}")
                out.label(f"written{k}")

    def _stream(self, k: int, port: Port, place: str) -> None:
        """The staged rows of one output go to memory: as one run, or row after row where there is room between them."""
        if not self.streaming:
            return
        out, size, apart = self.out, 8 * port.size, pitch(port, self.width)
        out.do(f"br i1 %staged{k}, label %stream{k}, label %written{k}")
        out.label(f"stream{k}")
        cursor = out.let(f"load ptr, ptr %cursor{k}, align 8")
        runs, length = (1, self.width * size) if apart == size else (self.width, size)
        run = f"%tile{k}"
        for number in range(runs):
            to = out.let(f"getelementptr i8, ptr {place}, i64 {number * length}")
            after = f"%tile{k}" if number + 1 == runs else out.let(f"getelementptr i8, ptr {run}, i64 {apart}")
            cursor = out.let(f"call ptr @{STREAM}(ptr {run}, i64 {length}, ptr {to}, ptr {cursor}, ptr {after})")
            run = after
        out.do(f"store ptr {cursor}, ptr %cursor{k}, align 8")

    def _stream_rest(self) -> None:
        """What the last full tile began of a line is written before the stage is used for the tail."""
        if not self.streaming:
            return
        out = self.out
        out.do("%tiles.done = icmp sgt i64 %from, 0")
        for k, port in self._outputs():
            if port.size:
                out.do(f"%rest.open{k} = and i1 %tiles.done, %staged{k}")
                out.do(f"br i1 %rest.open{k}, label %close{k}, label %closed{k}")
                out.label(f"close{k}")
                place = out.let(f"getelementptr i8, ptr %base{k}, i64 {out.let(f'mul i64 %from, %step{k}')}")
                cursor = out.let(f"load ptr, ptr %cursor{k}, align 8")
                out.do(f"call void @{REST}(ptr %tile{k}, ptr {place}, ptr {cursor})")
                out.do(f"br label %closed{k}")
                out.label(f"closed{k}")

    def _outputs(self) -> list[tuple[int, Port]]:
        return list(enumerate(self.signature.outputs, self.inputs))

    def _call_body(self, targets: list[tuple[str, str]]) -> None:
        arguments = "".join(f", ptr {rows}, i64 {step}" for rows, step in targets)
        self.out.do(f"call void @{BODY}(ptr %in{arguments})")

    def _walk(self, k: int, port: Port, row: str, count: str) -> None:
        """Move `count` rows of one port from `row` on."""
        out = self.out
        if port.size == 0:
            return
        if k < self.inputs:
            out.do(f"br i1 %fixed{k}, label %part.end{k}, label %part{k}")
            out.label(f"part{k}")
        shift = out.let(f"mul i64 {row}, %step{k}")
        self._call_walk(k, port, out.let(f"getelementptr i8, ptr %base{k}, i64 {shift}"), count)
        if k < self.inputs:
            out.do(f"br label %part.end{k}")
            out.label(f"part.end{k}")

    def _call_walk(self, k: int, port: Port, place: str, count: str) -> None:
        walk = _walk(k < self.inputs)
        self.out.do(
            f"call void @{walk}(ptr {place}, i64 %step{k}, i64 {count}, i64 {port.size}, i64 %walk.rank{k}, "
            f"ptr %walk.shape{k}, ptr %walk.steps{k}, ptr %tile{k})"
        )
