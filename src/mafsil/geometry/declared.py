"""Functions of arrays, declared in one line each: an expression of `mafsil.algebra`, compiled at its first use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import Any

import numpy as np

from mafsil import kernels
from mafsil.geometry import membership
from mafsil.kernels import Kernel, Port, Signature

Ports = tuple[tuple[str, tuple[int, ...]], ...]


class Declared:
    """A batched array function of an algebra expression; `at` evaluates it, and once compiled is the builtin itself.

    Args:
        source: `module.function` of `mafsil.algebra`.
        inputs: ports as text: `"R:3,3 t"` is a (3, 3) matrix R and a number t.
        outputs: likewise.
        conditions: argument -> name of the condition it must meet (`membership`): an argument that does not is refused.
        constants: further arguments of the expression, such as the name of an Euler sequence.
    """

    def __init__(
        self, source: str, inputs: str, outputs: str, conditions: Mapping[str, str] | None = None, *constants: object
    ) -> None:
        self.source = source
        self.inputs, self.outputs = _ports(inputs), _ports(outputs)
        self.conditions = dict(conditions or {})
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
        self.at = self._checked() if self.conditions else self.kernel.call
        return self.at(*args)

    def _checked(self) -> Callable[..., Any]:
        """The kernel's call, followed by a look for NaN: the mark of a condition that is not met, or of a NaN given."""
        call, single_output, shape = self.kernel.call, len(self.outputs) == 1, self.outputs[0][1]
        core_dimensions, first_number = len(shape), (..., *(0,) * len(shape))

        def evaluate(*args: Any) -> Any:
            result = call(*args)
            first = result if single_output else result[0]
            if first.ndim == core_dimensions:
                number = first.item(0)
                marked = number != number
            else:
                marked = np.isnan(first[first_number]).any()
            if marked:
                self._refuse(args)
            return result

        return evaluate

    @cached_property
    def kernel(self) -> Kernel:
        """The compiled expression."""
        signature = Signature(_name(self), _signature_ports(self.inputs), _signature_ports(self.outputs))
        given = (self.source, self.inputs, self.outputs, tuple(self.conditions.items()), self.constants)
        return kernels.compile(
            signature,
            partial(_build, *given),
            key=repr(given),
            fingerprints=(kernels.fingerprint("mafsil.algebra"),),
        )

    def _refuse(self, args: tuple[Any, ...]) -> None:
        for (name, _), value in zip(self.inputs, args, strict=True):
            if name in self.conditions:
                membership.require(self.conditions[name], name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return _declare, (self.source, self.inputs, self.outputs, self.conditions, self.constants)


def _declare(
    source: str, inputs: Ports, outputs: Ports, conditions: Mapping[str, str], constants: tuple[object, ...]
) -> Declared:
    declared = Declared(source, "", "", conditions, *constants)
    declared.inputs, declared.outputs = inputs, outputs
    return declared


def _build(
    source: str, inputs: Ports, outputs: Ports, conditions: tuple[tuple[str, str], ...], constants: tuple[object, ...]
) -> Any:
    from mafsil.algebra.expression import function  # expressions are loaded only when a kernel has to be made

    return function(source, inputs, outputs, dict(conditions), constants)


def _name(declared: Declared) -> str:
    return "_".join([declared.source.replace(".", "_"), *map(str, declared.constants)])


def _ports(text: str) -> Ports:
    parts = (entry.partition(":") for entry in text.split())
    return tuple((name, tuple(map(int, shape.split(","))) if shape else ()) for name, _, shape in parts)


def _signature_ports(ports: Ports) -> tuple[Port, ...]:
    return tuple(Port(name, shape) for name, shape in ports)
