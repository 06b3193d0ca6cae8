"""Compiled functions of arrays, declared in one line each: an expression of `mafsil.algebra`, compiled at first use."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from mafsil import kernels
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.algebra.membership as expression
else:
    expression = lazily("mafsil.algebra.membership")

Ports = tuple[tuple[str, tuple[int, ...]], ...]
"""(name, shape) of every input or output."""


class Declared:
    """A batched array function of an algebra expression; `at` evaluates it, and once compiled is the builtin itself.

    Args:
        source: `module.function` of `mafsil.algebra`.
        inputs: ports, or ports as text: `"R:3,3 t"` is a (3, 3) matrix R and a number t.
        outputs: likewise.
        constants: further arguments of the expression, such as the name of an Euler sequence.
    """

    conditions: dict[str, str]
    """Argument -> name of the condition that the expression may take as met (`conditioned.Conditioned`)."""

    def __init__(self, source: str, inputs: str | Ports, outputs: str | Ports, *constants: object) -> None:
        self.source = source
        self.inputs, self.outputs = _ports(inputs), _ports(outputs)
        self.conditions = {}
        self.constants = constants
        self.at: Callable[..., Any] = self._first

    def __call__(self, *args: Any) -> Any:
        """Evaluate at one point or over a broadcast batch.

        Raises:
            InputError: wrong shape, not numbers, NaN in a call without batch, or a condition that is not met.
        """
        return self.at(*args)

    def _first(self, *args: Any) -> Any:
        """The first evaluation compiles, or loads, the kernel and takes this method's place."""
        self.at = self.evaluation()
        return self.at(*args)

    def evaluation(self) -> Callable[..., Any]:
        """What evaluates from the second call on: the kernel's own."""
        return self.kernel.call

    @cached_property
    def kernel(self) -> kernels.Kernel:
        """The compiled expression."""
        signature = kernels.Signature(_name(self), _signature_ports(self.inputs), _signature_ports(self.outputs))
        given = (self.source, self.inputs, self.outputs, tuple(self.conditions.items()), self.constants)
        return kernels.compile(
            signature,
            partial(_build, *given),
            key=repr(given),
            fingerprints=(kernels.fingerprint("mafsil.algebra"),),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, self.inputs, self.outputs, *self.constants)


def _build(
    source: str, inputs: Ports, outputs: Ports, conditions: tuple[tuple[str, str], ...], constants: tuple[object, ...]
) -> Any:
    return expression.function(source, inputs, outputs, dict(conditions), constants)


def _name(declared: Declared) -> str:
    return "_".join([declared.source.replace(".", "_"), *map(str, declared.constants)])


def _ports(given: str | Ports) -> Ports:
    if not isinstance(given, str):
        return given
    parts = (entry.partition(":") for entry in given.split())
    return tuple((name, tuple(map(int, shape.split(","))) if shape else ()) for name, _, shape in parts)


def _signature_ports(ports: Ports) -> tuple[kernels.Port, ...]:
    return tuple(kernels.Port(name, shape) for name, shape in ports)
