"""A function of columns: what a kernel is compiled from."""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.errors import OperandError
from mafsil.expression.graph import cse as shared
from mafsil.expression.graph import rebuilt, symbols_of, topological_order, values
from mafsil.expression.matrix import Convertible, Expression, expression, matrix
from mafsil.expression.node import CONSTANT, SYMBOL, Node, Symbol, constant


class Function:
    """Outputs as expressions of inputs.

    Attributes:
        name: for messages.
        inputs: matrices of symbols.
        outputs: expressions of these symbols and no others.
        input_names, output_names: of the ports.
        order: all nodes of the outputs, operands first.
    """

    def __init__(
        self,
        name: str,
        inputs: Sequence[Expression],
        outputs: Sequence[Expression],
        input_names: Sequence[str] | None = None,
        output_names: Sequence[str] | None = None,
        *,
        cse: bool = False,
    ) -> None:
        """A function.

        Args:
            name: for messages.
            inputs: matrices of symbols.
            outputs: expressions of them.
            input_names, output_names: of the ports; i0, i1, ... and o0, o1, ... if None.
            cse: whether common subexpressions are built once.

        Raises:
            OperandError: an input holds something that is no symbol, or an output depends on a symbol of no input.
        """
        self.name = name
        self.inputs = tuple(inputs)
        self.outputs = tuple(shared(list(outputs)) if cse else outputs)
        self.input_names = tuple(input_names or (f"i{k}" for k in range(len(self.inputs))))
        self.output_names = tuple(output_names or (f"o{k}" for k in range(len(self.outputs))))
        self.order = topological_order(node for output in self.outputs for node in output.entries)
        self.symbols = symbols_of(self.inputs)
        known = set(self.symbols)
        for node in self.order:
            if node.op == SYMBOL and node not in known:
                raise OperandError("expression.free", name=node.name if isinstance(node, Symbol) else node.op)

    def call(self, arguments: Sequence[Convertible]) -> list[Expression]:
        """The outputs for these inputs: numbers for numbers, expressions for expressions.

        Raises:
            OperandError: a size differs from that of its input.
        """
        given: list[Node] = []
        for own, argument in zip(self.inputs, arguments, strict=True):
            other = expression(argument)
            if len(other.entries) != len(own.entries):
                raise OperandError("expression.shapes", sign=self.name, left=own.shape, right=other.shape)
            given += other.entries
        if all(node.op == CONSTANT for node in given):
            pairs = zip(self.symbols, given, strict=True)
            numbers = values(self.order, {symbol: node.value for symbol, node in pairs})
            found = {key: constant(number) for key, number in numbers.items()}
        else:
            found = rebuilt(self.order, dict(zip(self.symbols, given, strict=True)))
        return [matrix(x.rows, x.columns, [found[node] for node in x.entries]) for x in self.outputs]

    def __call__(self, *arguments: Convertible) -> Expression:
        """The output for these inputs, of a function with one.

        Raises:
            OperandError: there are several outputs, or a size differs from that of its input.
        """
        found = self.call(arguments)
        if len(found) != 1:
            raise OperandError("expression.outputs", name=self.name, count=len(found))
        return found[0]
