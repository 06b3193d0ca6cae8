"""Rows that leave the caches: staged in the nearest one and written to memory in whole lines that nobody reads first.

A tile of the batch writes W rows side by side in small pieces. Into memory that no cache holds, every piece makes the
processor read its line first, and W rows are W lines at once. Here the rows are written to a stage on the stack, and
from there in order, 64 bytes at a time, by stores that bypass the caches.

1. The stage holds W rows, `pitch` bytes apart. Rows whose starts would fall into the same sets of the nearest cache
   are kept one line further apart.
2. A cursor in the result says up to where it is written. Numbers before the first whole line go one by one.
3. Then whole lines go, as long as the staged run reaches; the stage is read unaligned, memory is written aligned.
4. The last line's worth of the run is copied before the place of the next run, which thereby continues the line that
   is begun: between two runs no line is written in parts.
5. After the last run the numbers behind the cursor go one by one; then a fence orders the stores before whatever
   other threads are told.

Every number is moved as it is, so the result has the bits of plain stores.
"""

from __future__ import annotations

from mafsil.kernels.layout import Port

LINE = 64
"""Bytes of a cache line."""
STREAM = "mafsil_stream"
"""Symbol: ptr (double *run, int64 bytes, char *result, char *cursor, char *next) -> cursor; steps 2 to 4."""
REST = "mafsil_stream_rest"
"""Symbol: void (char *next, char *result_end, char *cursor); step 5."""
STREAMED = 1
"""Value of the batch entry's `data` that asks for whole lines past the caches; null writes straight to the result."""
_SETS = 64
"""Sets of the nearest cache on every x86-64 processor so far: as many lines as a page has."""
_WAYS = 2
"""Rows that may start in one set: their lines are held at once, beside those of inputs and intermediate values."""
_X86 = ("x86_64", "amd64")


def streams(triple: str) -> bool:
    """Whether kernels for this processor have the staged way; elsewhere all stores are plain.

    Args:
        triple: LLVM triple.
    """
    return triple.startswith(_X86)


def pitch(port: Port, width: int) -> int:
    """Step 1: bytes from one staged row to the next.

    Args:
        port: an output.
        width: rows of a tile.
    """
    size = 8 * port.size
    places = [row * size // LINE % _SETS for row in range(width)]
    crowded = max(places.count(place) for place in places) > _WAYS and size >= LINE
    return size + LINE if crowded else size


def stage_size(port: Port, width: int) -> int:
    """Doubles of the stage of one output: a line in front of the rows, the rows, filled up to whole lines."""
    return (LINE + width * pitch(port, width) + LINE - 1) // LINE * LINE // 8


def functions() -> str:
    """LLVM IR of STREAM (steps 2 to 4 of this module) and REST (step 5)."""
    return f"""
declare void @llvm.x86.sse.sfence()
!1 = !{{i32 1}}

define internal ptr @{STREAM}(ptr %run, i64 %bytes, ptr %result, ptr %cursor, ptr %next) #ATTRIBUTES {{
entry:
  %result.at = ptrtoint ptr %result to i64
  %start = ptrtoint ptr %cursor to i64
  %end = add i64 %result.at, %bytes
  br label %head
head:                                                        ; step 2
  %at = phi i64 [ %start, %entry ], [ %at.next, %head.number ]
  %within = and i64 %at, {LINE - 1}
  %begun = icmp ne i64 %within, 0
  %inside = icmp ult i64 %at, %end
  %number.first = and i1 %begun, %inside
  br i1 %number.first, label %head.number, label %lines
head.number:
  %head.shift = sub i64 %at, %result.at
  %head.from = getelementptr i8, ptr %run, i64 %head.shift
  %head.to = inttoptr i64 %at to ptr
  %number = load double, ptr %head.from, align 8
  store double %number, ptr %head.to, align 8
  %at.next = add i64 %at, 8
  br label %head
lines:                                                       ; step 3
  %to = phi i64 [ %at, %head ], [ %to.next, %line ]
  %to.next = add i64 %to, {LINE}
  %fits = icmp ule i64 %to.next, %end
  br i1 %fits, label %line, label %keep
line:
  %shift = sub i64 %to, %result.at
  %from = getelementptr i8, ptr %run, i64 %shift
  %place = inttoptr i64 %to to ptr
  %eight = load <8 x double>, ptr %from, align 8
  store <8 x double> %eight, ptr %place, align {LINE}, !nontemporal !1
  br label %lines
keep:                                                        ; step 4
  %last.shift = sub i64 %bytes, {LINE}
  %last.from = getelementptr i8, ptr %run, i64 %last.shift
  %before = getelementptr i8, ptr %next, i64 -{LINE}
  %last = load <8 x double>, ptr %last.from, align 8
  store <8 x double> %last, ptr %before, align 8
  %reached = inttoptr i64 %to to ptr
  ret ptr %reached
}}

define internal void @{REST}(ptr %next, ptr %end.place, ptr %cursor) #ATTRIBUTES {{
entry:
  %end = ptrtoint ptr %end.place to i64
  %start = ptrtoint ptr %cursor to i64
  br label %more
more:                                                        ; step 5
  %at = phi i64 [ %start, %entry ], [ %at.next, %number ]
  %inside = icmp ult i64 %at, %end
  br i1 %inside, label %number, label %fence
number:
  %shift = sub i64 %at, %end
  %from = getelementptr i8, ptr %next, i64 %shift
  %to = inttoptr i64 %at to ptr
  %value = load double, ptr %from, align 8
  store double %value, ptr %to, align 8
  %at.next = add i64 %at, 8
  br label %more
fence:
  call void @llvm.x86.sse.sfence()
  ret void
}}
"""
