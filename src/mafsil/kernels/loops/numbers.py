"""Numbers of compiled loops: conversions, arithmetic, comparisons and functions, as Python and NumPy mean them."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from mafsil.kernels.loops.block import Block, Value, constant, real_text
from mafsil.kernels.loops.kinds import (
    BITS,
    BOOL,
    COMPLEX,
    INTEGER,
    LANES,
    MASK,
    NARROW,
    REAL,
    SINGLE,
    UNSIGNED,
    VECTOR,
    WIDTH,
    Kind,
    Narrow,
    Number,
    refusal,
)

OPERATIONS: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**",
    ast.LShift: "<<", ast.RShift: ">>", ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^",
}  # fmt: skip
ORDERS: dict[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_REAL = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_WHOLE = {"+": "add nsw", "-": "sub nsw", "*": "mul nsw", "<<": "shl", ">>": "ashr", "&": "and", "|": "or", "^": "xor"}
_UNSIGNED = {"+": "add", "-": "sub", "*": "mul", ">>": "lshr", "//": "udiv", "%": "urem"}
_SIGNED_ORDER = {"<": "slt", "<=": "sle", ">": "sgt", ">=": "sge", "==": "eq", "!=": "ne"}
_REAL_ORDER = {"<": "olt", "<=": "ole", ">": "ogt", ">=": "oge", "==": "oeq", "!=": "une"}
_FOLDED: dict[str, Callable[[Any, Any], Any]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
    "//": lambda a, b: a // b, "%": lambda a, b: a % b, "**": lambda a, b: a**b, "<<": lambda a, b: a << b,
    ">>": lambda a, b: a >> b, "&": lambda a, b: a & b, "|": lambda a, b: a | b, "^": lambda a, b: a ^ b,
}  # fmt: skip
_LANE_FLAGS = "nsz contract "
_MOST_SQUARINGS = 1 << 16


def convert(block: Block, value: Value, kind: Kind) -> Value:
    """The value as another kind; none loses its fraction unasked.

    Raises:
        KernelError: no such conversion.
    """
    have = value.kind
    if have is kind or (isinstance(kind, Narrow) and have is INTEGER):
        return value
    if kind is LANES and isinstance(have, Number):
        return broadcast(block, value)
    if not isinstance(have, Number) or not isinstance(kind, Number) or (have.rank > kind.rank and kind is not INTEGER):
        raise refusal(f"{have} where {kind} is needed")
    if value.constant is not None and kind in (REAL, INTEGER):
        return constant(float(value.constant) if kind is REAL else int(value.constant))
    return _converted_number(block, value, have, kind)


def _converted_number(block: Block, value: Value, have: Number, kind: Number) -> Value:
    """The instruction that makes a number another kind of number."""
    if kind is COMPLEX:
        return Value(COMPLEX, (convert(block, value, REAL).name, real_text(0.0)))
    if kind in (INTEGER, UNSIGNED):
        if have not in (BOOL, INTEGER, UNSIGNED):
            raise refusal(f"{have} where {kind} is needed")
        return Value(
            kind, (block.let(f"zext i1 {value.name} to i64") if have is BOOL else value.name,), None, have is BOOL
        )
    if isinstance(kind, Narrow) or kind is BOOL:
        raise refusal(f"{have} where {kind} is needed")
    if have is SINGLE:
        return block.number(kind, f"fpext float {value.name} to double")
    word = "uitofp" if have in (BOOL, UNSIGNED) else "sitofp"
    return block.number(kind, f"{word} {have.parts[0]} {value.name} to {kind.parts[0]}")


def broadcast(block: Block, value: Value) -> Value:
    """A number in all lanes."""
    part = convert(block, value, REAL)
    if part.constant is not None:
        return Value(LANES, (f"<{', '.join([f'double {part.name}'] * WIDTH)}>",))
    first = block.let(f"insertelement {VECTOR} poison, double {part.name}, i32 0")
    return block.number(LANES, f"shufflevector {VECTOR} {first}, {VECTOR} poison, <{WIDTH} x i32> zeroinitializer")


def alike(block: Block, a: Value, b: Value) -> tuple[Value, Value]:
    """Both in the wider of their kinds."""
    if a.kind is b.kind and not isinstance(a.kind, Narrow):
        return a, b
    if LANES in (a.kind, b.kind):
        return convert(block, a, LANES), convert(block, b, LANES)
    if not isinstance(a.kind, Number) or not isinstance(b.kind, Number):
        raise refusal(f"arithmetic of {a.kind} and {b.kind}")
    kind = max(a.kind, b.kind, key=lambda each: each.rank)
    return convert(block, a, kind), convert(block, b, kind)


def arithmetic(block: Block, operation: str, a: Value, b: Value) -> Value | None:
    """The result of an operation as Python means it; None where it takes a function of the language (`library`)."""
    if a.constant is not None and b.constant is not None:
        folded = _fold(operation, a.constant, b.constant)
        if folded is not None:
            return constant(folded)
    if operation == "**":
        return _power(block, a, b)
    if a.kind is MASK and b.kind is MASK:
        return block.number(MASK, f"{_WHOLE[operation]} {BITS} {a.name}, {b.name}")
    if operation == "/":
        a, b = (convert(block, x, REAL) if x.kind in (INTEGER, BOOL, UNSIGNED) else x for x in (a, b))
    a, b = alike(block, a, b)
    if a.kind is LANES:
        return block.number(LANES, f"{_REAL[operation]} {_LANE_FLAGS}{VECTOR} {a.name}, {b.name}")
    if a.kind in (REAL, SINGLE):
        if operation not in _REAL:
            return None
        return block.number(a.kind, f"{_REAL[operation]} {block.fast}{a.kind.parts[0]} {a.name}, {b.name}")
    if a.kind is COMPLEX:
        return _complex(block, operation, a, b)
    if a.kind is BOOL and operation in ("&", "|", "^"):
        return block.number(BOOL, f"{_WHOLE[operation]} i1 {a.name}, {b.name}")
    if a.kind is UNSIGNED:
        return block.number(UNSIGNED, f"{_UNSIGNED.get(operation) or _WHOLE[operation]} i64 {a.name}, {b.name}")
    return _whole(block, operation, convert(block, a, INTEGER), convert(block, b, INTEGER))


def _fold(operation: str, a: float, b: float) -> float | None:
    """The result for constants; None where Python has none, or a wider one."""
    try:
        made = _FOLDED[operation](a, b)
    except (ArithmeticError, TypeError, ValueError):
        return None
    narrow = isinstance(made, float) or (isinstance(made, int) and -(1 << 63) <= made < 1 << 63)
    return made if narrow else None


def _whole(block: Block, operation: str, a: Value, b: Value) -> Value | None:
    natural = a.natural and b.natural and operation in "+*&|>><<^"
    if operation in ("//", "%"):
        positive = b.constant is not None and b.constant > 0
        return _by_constant(block, operation, a, b) if positive else _floor(block, operation, a, b)
    if operation == "&" and (a.natural or b.natural):
        natural = True
    if operation == ">>":
        natural = a.natural
    if operation not in _WHOLE:
        raise refusal(f"{operation} of whole numbers")
    return Value(INTEGER, (block.let(f"{_WHOLE[operation]} i64 {a.name}, {b.name}"),), None, natural)


def _by_constant(block: Block, operation: str, a: Value, b: Value) -> Value:
    """Quotient or remainder by a positive constant, rounded towards minus infinity."""
    if a.natural:
        return Value(
            INTEGER, (block.let(f"{'udiv' if operation == '//' else 'urem'} i64 {a.name}, {b.name}"),), None, True
        )
    rest = block.let(f"srem i64 {a.name}, {b.name}")
    below = block.let(f"icmp slt i64 {rest}, 0")
    if operation == "%":
        moved = block.let(f"add i64 {rest}, {b.name}")
        return Value(INTEGER, (block.let(f"select i1 {below}, i64 {moved}, i64 {rest}"),), None, True)
    quotient = block.let(f"sdiv i64 {a.name}, {b.name}")
    less = block.let(f"sub i64 {quotient}, 1")
    return block.number(INTEGER, f"select i1 {below}, i64 {less}, i64 {quotient}")


def _floor(block: Block, operation: str, a: Value, b: Value) -> Value:
    """Quotient or remainder, rounded towards minus infinity; 0 where the divisor is."""
    none = block.let(f"icmp eq i64 {b.name}, 0")
    divisor = block.let(f"select i1 {none}, i64 1, i64 {b.name}")
    rest = block.let(f"srem i64 {a.name}, {divisor}")
    signs = block.let(f"xor i64 {rest}, {divisor}")
    apart, some = block.let(f"icmp slt i64 {signs}, 0"), block.let(f"icmp ne i64 {rest}, 0")
    wrong = block.let(f"and i1 {apart}, {some}")
    if operation == "%":
        other = block.let(f"add i64 {rest}, {divisor}")
    else:
        rest = block.let(f"sdiv i64 {a.name}, {divisor}")
        other = block.let(f"sub i64 {rest}, 1")
    found = block.let(f"select i1 {wrong}, i64 {other}, i64 {rest}")
    return Value(INTEGER, (block.let(f"select i1 {none}, i64 0, i64 {found}"),), None, a.natural and b.natural)


def _power(block: Block, a: Value, b: Value) -> Value | None:
    """A constant whole power by squaring; of real exponents by the system's library."""
    if isinstance(b.constant, int) and not isinstance(b.constant, bool) and abs(b.constant) < _MOST_SQUARINGS:
        made, exponent = constant(1), abs(b.constant)
        while exponent:
            if exponent & 1:
                made = a if made.constant == 1 else _sure(arithmetic(block, "*", made, a))
            exponent >>= 1
            a = _sure(arithmetic(block, "*", a, a)) if exponent else a
        return made if b.constant >= 0 else arithmetic(block, "/", constant(1.0), made)
    if b.kind is not REAL:
        return None
    x = convert(block, a, REAL)
    return Value(REAL, (block.call("llvm.pow.f64", "double", f"double {x.name}", f"double {b.name}"),))


def _sure(value: Value | None) -> Value:
    assert value is not None
    return value


def _complex(block: Block, operation: str, a: Value, b: Value) -> Value | None:
    def of(word: str, x: str, y: str) -> str:
        return block.let(f"{word} {block.fast}double {x}, {y}")

    (ar, ai), (br, bi) = a.parts, b.parts
    if operation in "+-":
        return Value(COMPLEX, (of(_REAL[operation], ar, br), of(_REAL[operation], ai, bi)))
    if operation != "*":
        return None
    real = of("fsub", of("fmul", ar, br), of("fmul", ai, bi))
    return Value(COMPLEX, (real, of("fadd", of("fmul", ar, bi), of("fmul", ai, br))))


def compare(block: Block, order: str, a: Value, b: Value) -> Value:
    """One of < <= > >= == != of two numbers or lanes."""
    a, b = alike(block, a, b)
    if a.kind is LANES:
        return block.number(MASK, f"fcmp {_REAL_ORDER[order]} {VECTOR} {a.name}, {b.name}")
    if a.kind is COMPLEX:
        each = [block.let(f"fcmp {_REAL_ORDER[order]} double {x}, {y}") for x, y in zip(a.parts, b.parts, strict=True)]
        return block.number(BOOL, f"{'and' if order == '==' else 'or'} i1 {each[0]}, {each[1]}")
    if a.kind in (REAL, SINGLE):
        return block.number(BOOL, f"fcmp {block.fast}{_REAL_ORDER[order]} {a.kind.parts[0]} {a.name}, {b.name}")
    word = _SIGNED_ORDER[order]
    if a.kind in (UNSIGNED, BOOL):
        word = word.replace("s", "u", 1) if word[0] == "s" else word
    return block.number(BOOL, f"icmp {word} {a.kind.parts[0]} {a.name}, {b.name}")


def select_value(block: Block, condition: str, yes: Value, no: Value) -> Value:
    """One of two numbers."""
    yes, no = alike(block, yes, no)
    parts = zip(yes.kind.parts, yes.parts, no.parts, strict=True)
    made = tuple(block.let(f"select i1 {condition}, {kind} {a}, {kind} {b}") for kind, a, b in parts)
    return Value(yes.kind, made, None, yes.natural and no.natural)


def truth(block: Block, value: Value) -> Value:
    """Whether a number is not zero."""
    if value.kind is BOOL:
        return value
    if not isinstance(value.kind, Number):
        raise refusal(f"{value.kind} as a condition")
    return compare(block, "!=", value, constant(0))


def negate(block: Block, value: Value) -> Value:
    """The other sign."""
    if value.constant is not None and value.kind is not BOOL:
        return constant(-value.constant)
    if value.kind in (INTEGER, BOOL) or value.kind in NARROW.values():
        return block.number(INTEGER, f"sub nsw i64 0, {convert(block, value, INTEGER).name}")
    flags = _LANE_FLAGS if value.kind is LANES else block.fast
    parts = zip(value.kind.parts, value.parts, strict=True)
    return Value(value.kind, tuple(block.let(f"fneg {flags}{kind} {part}") for kind, part in parts))


def absolute(block: Block, value: Value) -> Value | None:
    """The magnitude; None where it takes a function of the language."""
    if value.kind is COMPLEX:
        return None
    if value.kind not in (INTEGER, BOOL, REAL, SINGLE, LANES):
        raise refusal(f"the magnitude of {value.kind}")
    if value.kind in (INTEGER, BOOL):
        x = convert(block, value, INTEGER)
        below = compare(block, "<", x, constant(0))
        made = select_value(block, below.name, negate(block, x), x)
        return Value(INTEGER, made.parts, None, True)
    part, suffix = value.kind.parts[0], {REAL: "f64", SINGLE: "f32", LANES: f"v{WIDTH}f64"}[value.kind]
    return Value(value.kind, (block.call(f"llvm.fabs.{suffix}", part, f"{part} {value.name}"),))


def whole(block: Block, value: Value) -> Value:
    """The number without its fraction, as `int` makes it."""
    if isinstance(value.constant, int | float):
        return constant(int(value.constant))
    if value.kind in (REAL, SINGLE):
        return block.number(INTEGER, f"fptosi {value.kind.parts[0]} {value.name} to i64")
    return Value(INTEGER, convert(block, value, INTEGER).parts, None, value.natural)
