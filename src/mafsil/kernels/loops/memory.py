"""Memory of running loops, as LLVM IR that is part of each module that needs it: blocks in a list, freed together.

A function that makes arrays has a list of their blocks, and frees them when it ends. Arrays can leave a function only
in its result; one with arrays in its result adds to the list of its caller.
"""

from __future__ import annotations

from mafsil.kernels import target
from mafsil.kernels.loops.arrays import ALIGNMENT, ALLOCATE, RELEASE, TIMES
from mafsil.kernels.loops.block import METADATA

HEAD = 32
"""Bytes that begin a block: the next one, its size, where its numbers begin, and the object that keeps it, if any."""

FREE = "declare void @free(ptr)"
_DECLARED = {FREE, "declare ptr @malloc(i64)", "declare { i64, i1 } @llvm.smul.with.overflow.i64(i64, i64)"}
_TEXT = f"""
define internal i64 @{TIMES}(i64 %a, i64 %b) alwaysinline nounwind {{
  %both = call {{ i64, i1 }} @llvm.smul.with.overflow.i64(i64 %a, i64 %b)
  %product = extractvalue {{ i64, i1 }} %both, 0
  %over = extractvalue {{ i64, i1 }} %both, 1
  %low = icmp slt i64 %a, 0
  %under = icmp slt i64 %b, 0
  %below = or i1 %low, %under
  %wrong = or i1 %over, %below
  %found = select i1 %wrong, i64 -1, i64 %product
  ret i64 %found
}}
define internal noalias ptr @{ALLOCATE}(i64 %size, ptr %list) noinline nounwind {{
entry:
  %sane = icmp ult i64 %size, {1 << 62}
  br i1 %sane, label %try, label %none
try:
  %whole = add i64 %size, {ALIGNMENT + 64}
  %raw = call ptr @malloc(i64 %whole)
  %got = icmp ne ptr %raw, null
  br i1 %got, label %made, label %none
made:
  %number = ptrtoint ptr %raw to i64
  %above = add i64 %number, {HEAD + ALIGNMENT - 1}
  %begin = and i64 %above, {-ALIGNMENT}
  %data = inttoptr i64 %begin to ptr
  %next = load ptr, ptr %list
  store ptr %next, ptr %raw
  %size_at = getelementptr i8, ptr %raw, i64 8
  store i64 %size, ptr %size_at
  %data_at = getelementptr i8, ptr %raw, i64 16
  store ptr %data, ptr %data_at
  %keeper_at = getelementptr i8, ptr %raw, i64 24
  store ptr null, ptr %keeper_at
  store ptr %raw, ptr %list
  ret ptr %data
none:
  ret ptr null
}}
define internal void @{RELEASE}(ptr %list) nounwind {{
entry:
  %first = load ptr, ptr %list
  br label %look
look:
  %block = phi ptr [ %first, %entry ], [ %next, %free ]
  %end = icmp eq ptr %block, null
  br i1 %end, label %done, label %free
free:
  %next = load ptr, ptr %block
  call void @free(ptr %block)
  br label %look
done:
  ret void
}}
"""


def module_text(texts: list[str], declared: set[str]) -> str:
    """A module of these functions and declarations, with what it needs of this file."""
    own = {line for line in declared if any(f"@{name}(" in line for name in (TIMES, ALLOCATE, RELEASE))}
    outside = (declared - own) | (_DECLARED if own else set[str]())
    head = [f'target triple = "{target.host().triple}"', *sorted(outside), *([_TEXT] if own else [])]
    return "\n".join([*head, *texts, METADATA])
