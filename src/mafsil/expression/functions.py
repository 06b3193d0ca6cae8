"""Functions of expressions: element by element, of vectors, and how matrices are put together."""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.errors import OperandError
from mafsil.expression import arithmetic, elementary
from mafsil.expression.matrix import Convertible, Expression, combine, elementwise, expression, matrix
from mafsil.expression.node import MINUS_ONE, ONE, ZERO, Node


def sqrt(x: Convertible) -> Expression:
    """Square root."""
    return elementwise(elementary.sqrt, x)


def exp(x: Convertible) -> Expression:
    """Exponential."""
    return elementwise(elementary.UNARY["exp"], x)


def log(x: Convertible) -> Expression:
    """Natural logarithm."""
    return elementwise(elementary.log, x)


def sin(x: Convertible) -> Expression:
    """Sine of an angle [rad]."""
    return elementwise(elementary.UNARY["sin"], x)


def cos(x: Convertible) -> Expression:
    """Cosine of an angle [rad]."""
    return elementwise(elementary.cos, x)


def tan(x: Convertible) -> Expression:
    """Tangent of an angle [rad]."""
    return elementwise(elementary.UNARY["tan"], x)


def asin(x: Convertible) -> Expression:
    """Angle in [-pi/2, pi/2] of a sine."""
    return elementwise(elementary.UNARY["asin"], x)


def acos(x: Convertible) -> Expression:
    """Angle in [0, pi] of a cosine."""
    return elementwise(elementary.UNARY["acos"], x)


def atan(x: Convertible) -> Expression:
    """Angle in (-pi/2, pi/2) of a tangent."""
    return elementwise(elementary.UNARY["atan"], x)


def tanh(x: Convertible) -> Expression:
    """Hyperbolic tangent."""
    return elementwise(elementary.UNARY["tanh"], x)


def fabs(x: Convertible) -> Expression:
    """Magnitude."""
    return elementwise(elementary.fabs, x)


def sign(x: Convertible) -> Expression:
    """-1, 0 or 1."""
    return elementwise(elementary.UNARY["sign"], x)


def floor(x: Convertible) -> Expression:
    """Greatest whole number not above x."""
    return elementwise(elementary.UNARY["floor"], x)


def ceil(x: Convertible) -> Expression:
    """Least whole number not below x."""
    return elementwise(elementary.UNARY["ceil"], x)


def logic_not(x: Convertible) -> Expression:
    """1 where x is zero, else 0."""
    return elementwise(elementary.not_, x)


def logic_and(x: Convertible, y: Convertible) -> Expression:
    """1 where neither is zero, else 0."""
    return combine(elementary.BINARY["and"], x, y, "and")


def logic_or(x: Convertible, y: Convertible) -> Expression:
    """0 where both are zero, else 1."""
    return combine(elementary.BINARY["or"], x, y, "or")


def equal(x: Convertible, y: Convertible) -> Expression:
    """1 where x = y, else 0."""
    return combine(elementary.eq, x, y, "=")


def unequal(x: Convertible, y: Convertible) -> Expression:
    """0 where x = y, else 1."""
    return combine(elementary.ne, x, y, "=")


def fmin(x: Convertible, y: Convertible) -> Expression:
    """The lesser of both; the other one where one is NaN."""
    return combine(elementary.fmin, x, y, "fmin")


def fmax(x: Convertible, y: Convertible) -> Expression:
    """The greater of both; the other one where one is NaN."""
    return combine(elementary.fmax, x, y, "fmax")


def atan2(y: Convertible, x: Convertible) -> Expression:
    """Angle of the point (x, y) in [-pi, pi]."""
    return combine(elementary.BINARY["atan2"], y, x, "atan2")


def copysign(x: Convertible, y: Convertible) -> Expression:
    """Magnitude of x with the sign of y."""
    return combine(elementary.BINARY["copysign"], x, y, "copysign")


def power(x: Convertible, y: Convertible) -> Expression:
    """x to the power of y; whole powers up to 100 as products."""
    return combine(elementary.power, x, y, "**")


def if_else(condition: Convertible, x: Convertible, y: Convertible) -> Expression:
    """x where the condition is not zero, else y; NaN of the side not taken does not pass."""
    taken = combine(arithmetic.if_else_zero, condition, x, "if")
    return taken + combine(arithmetic.if_else_zero, logic_not(condition), y, "else")


def zeros(rows: int, columns: int = 1) -> Expression:
    """Zeros."""
    return matrix(rows, columns, [ZERO] * (rows * columns))


def ones(rows: int, columns: int = 1) -> Expression:
    """Ones."""
    return matrix(rows, columns, [ONE] * (rows * columns))


def eye(n: int) -> Expression:
    """Identity matrix (n, n)."""
    return matrix(n, n, [ONE if i == j else ZERO for j in range(n) for i in range(n)])


def vertcat(*parts: Convertible) -> Expression:
    """One matrix below the other; parts without elements are skipped."""
    blocks = [expression(part) for part in parts]
    filled = [block for block in blocks if block.entries] or blocks[:1]
    if all(block.columns == 1 for block in filled):
        return matrix(sum(block.rows for block in filled), 1, [x for block in filled for x in block.entries])
    columns = filled[0].columns
    if any(block.columns != columns for block in filled):
        raise OperandError("expression.joined", shapes=", ".join(f"{b.rows} x {b.columns}" for b in filled))
    entries = [
        x for j in range(columns) for block in filled for x in block.entries[block.rows * j : block.rows * (j + 1)]
    ]
    return matrix(sum(block.rows for block in filled), columns, entries)


def horzcat(*parts: Convertible) -> Expression:
    """One matrix beside the other; parts without elements are skipped."""
    blocks = [expression(part) for part in parts]
    filled = [block for block in blocks if block.entries] or blocks[:1]
    rows = filled[0].rows if filled else 0
    if any(block.rows != rows for block in filled):
        raise OperandError("expression.joined", shapes=", ".join(f"{b.rows} x {b.columns}" for b in filled))
    return matrix(rows, sum(block.columns for block in filled), [x for block in filled for x in block.entries])


def blockcat(rows: Sequence[Sequence[Convertible]]) -> Expression:
    """Matrix of blocks, row by row."""
    return vertcat(*(horzcat(*row) for row in rows))


def diagcat(*parts: Convertible) -> Expression:
    """Blocks along the diagonal, zeros elsewhere."""
    blocks = [expression(part) for part in parts]
    whole = zeros(sum(block.rows for block in blocks), sum(block.columns for block in blocks))
    row = column = 0
    for block in blocks:
        whole[row : row + block.rows, column : column + block.columns] = block
        row, column = row + block.rows, column + block.columns
    return whole


def vertsplit(x: Expression) -> list[Expression]:
    """The rows."""
    return [x[i, :] for i in range(x.rows)]


def vec(x: Expression) -> Expression:
    """The columns one below the other."""
    return matrix(x.rows * x.columns, 1, x.entries.copy())


def reshape(x: Expression, rows: int, columns: int) -> Expression:
    """The elements, column by column, in another shape."""
    if rows * columns != len(x.entries):
        raise OperandError("expression.shapes", sign="reshape", left=x.shape, right=(rows, columns))
    return matrix(rows, columns, x.entries.copy())


def repmat(x: Expression, rows: int, columns: int = 1) -> Expression:
    """The matrix repeated, rows times downwards and columns times sideways."""
    return horzcat(*[vertcat(*[x] * rows)] * columns)


def diag(x: Convertible) -> Expression:
    """Diagonal matrix of a column, or the diagonal of a matrix as a column."""
    given = expression(x)
    if given.columns == 1:
        n = given.rows
        return matrix(n, n, [given.entries[i] if i == j else ZERO for j in range(n) for i in range(n)])
    return matrix(given.rows, 1, [given.entries[i + given.rows * i] for i in range(given.rows)])


def trace(x: Expression) -> Expression:
    """Sum of the diagonal."""
    return matrix(1, 1, [_sum([x.entries[i + x.rows * i] for i in range(x.rows)])])


def dot(x: Convertible, y: Convertible) -> Expression:
    """Sum of the products of equal places."""
    a, b = expression(x), expression(y)
    if len(a.entries) != len(b.entries):
        raise OperandError("expression.shapes", sign="dot", left=a.shape, right=b.shape)
    return matrix(1, 1, [_sum([arithmetic.mul(p, q) for p, q in zip(a.entries, b.entries, strict=True)])])


def sumsqr(x: Convertible) -> Expression:
    """Sum of the squares."""
    return dot(x, x)


def norm_2(x: Convertible) -> Expression:
    """Length of a vector."""
    return sqrt(dot(x, x))


def cross(x: Convertible, y: Convertible) -> Expression:
    """Vector product (3,)."""
    a, b = expression(x), expression(y)
    if len(a.entries) != 3 or len(b.entries) != 3:
        raise OperandError("expression.shapes", sign="cross", left=a.shape, right=b.shape)
    (a1, a2, a3), (b1, b2, b3) = a.entries, b.entries
    entries = [_minor(a2, b3, a3, b2), _minor(a3, b1, a1, b3), _minor(a1, b2, a2, b1)]
    return matrix(a.rows, a.columns, entries)


def skew(x: Convertible) -> Expression:
    """[x] (3, 3), the matrix with [x] y = x cross y."""
    x1, x2, x3 = expression(x).entries
    n1, n2, n3 = arithmetic.neg(x1), arithmetic.neg(x2), arithmetic.neg(x3)
    return matrix(3, 3, [ZERO, x3, n2, n3, ZERO, x1, x2, n1, ZERO])


def det(x: Expression) -> Expression:
    """Determinant, by minors along the row or column with the fewest entries."""
    if x.rows != x.columns:
        raise OperandError("expression.shapes", sign="det", left=x.shape, right=(x.rows, x.rows))
    return matrix(1, 1, [_determinant(_rows_of(x))])


def solve(A: Expression, b: Expression) -> Expression:
    """x with A x = b, by cofactors, for sizes up to three.

    Raises:
        OperandError: A is not square, larger than (3, 3), or b does not fit.
    """
    n = A.rows
    if n != A.columns or n > 3 or n != b.rows:
        raise OperandError("expression.shapes", sign="solve", left=A.shape, right=b.shape)
    rows = _rows_of(A)
    cofactors = [_cofactor(rows, i, j) for i in range(n) for j in range(n)]
    whole = _determinant(rows)
    return matrix(n, n, [arithmetic.div(x, whole) for x in cofactors]) @ b


def _minor(a: Node, b: Node, c: Node, d: Node) -> Node:
    """a b - c d."""
    return arithmetic.sub(arithmetic.mul(a, b), arithmetic.mul(c, d))


def _sum(terms: list[Node]) -> Node:
    total = ZERO
    for term in terms:
        total = arithmetic.add(total, term)
    return total


def _rows_of(x: Expression) -> list[list[Node]]:
    return [[x.entries[i + x.rows * j] for j in range(x.columns)] for i in range(x.rows)]


def _determinant(rows: list[list[Node]]) -> Node:
    n = len(rows)
    if n == 0:
        return ONE
    if n == 1:
        return rows[0][0]
    if n == 2:
        return _minor(rows[0][0], rows[1][1], rows[0][1], rows[1][0])
    in_rows = [sum(x is not ZERO for x in row) for row in rows]
    in_columns = [sum(row[j] is not ZERO for row in rows) for j in range(n)]
    i, j = in_rows.index(min(in_rows)), in_columns.index(min(in_columns))
    if i <= j:
        terms = [arithmetic.mul(x, _cofactor(rows, i, k)) for k, x in enumerate(rows[i]) if x is not ZERO]
    else:
        terms = [arithmetic.mul(row[j], _cofactor(rows, k, j)) for k, row in enumerate(rows) if row[j] is not ZERO]
    return _sum(terms)


def _cofactor(rows: list[list[Node]], i: int, j: int) -> Node:
    """The determinant without row i and column j, with its sign."""
    rest = [[x for c, x in enumerate(row) if c != j] for r, row in enumerate(rows) if r != i]
    return arithmetic.mul(MINUS_ONE if (i + j) % 2 else ONE, _determinant(rest))
