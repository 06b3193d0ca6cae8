"""One call of a control law as an expression: measured state, reference and integrals in, efforts and integrals out."""

from __future__ import annotations

from dataclasses import replace

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.closed_loop import Commands, Trees, clip_command, symbol_of
from mafsil.mechanics.loop_terms import Loop, input_sizes, output_sizes


def law_inputs(loop: Loop, gains: Floats | None) -> dict[str, tuple[int, ...]]:
    """Names and core shapes of the inputs; limits at which integrals wait are constants.

    Args:
        loop: whose law it is.
        gains: (terms, 3, n) where they are constants.
    """
    sizes, n = input_sizes(loop), loop.plant.n
    chosen = [name for name in ("reference", "gains", "integral") if name in sizes]
    if gains is not None and "gains" in chosen:
        chosen.remove("gains")
    return {"q": (n,), "qd": (n,), **{name: sizes[name] for name in chosen}}


def law_outputs(loop: Loop) -> dict[str, tuple[int, ...]]:
    """Names and core shapes of the outputs."""
    sizes = output_sizes(loop)
    return {name: sizes[name] for name in ("effort", "next_integral") if name in sizes}


def law_step(
    loop: Loop, gains: Floats | None, limit: Floats | None, integral_limit: Floats | None = None
) -> ex.Function:
    """The call as a function, inputs and outputs as `law_inputs` and `law_outputs` say, columns in C order.

    Args:
        loop: whose law it is; its plant only says how many coordinates there are.
        gains: (terms, 3, n) proportional, rate, and integral times the period; None makes them an input.
        limit: (n,) at which efforts are clipped [N m | N]; None for no clipping.
        integral_limit: (terms, n) at which the integrals of terms that wait do so [N m | N].
    """
    symbols = {name: symbol_of(name, shape) for name, shape in law_inputs(loop, gains).items()}
    x = dict(symbols)
    if gains is not None:
        x["gains"] = ex.Expression(gains.reshape(-1))
    if integral_limit is not None:
        x["integral_limit"] = ex.Expression(integral_limit.reshape(-1))
    law = replace(loop, noisy=True)  # The state is measured: nothing is shared with the plant's own step.
    commands = Commands(law, Trees(), x["q"], x["qd"], x)
    effort = commands.effort if limit is None else clip_command(commands.effort, ex.Expression(limit))
    results = {"effort": effort, "next_integral": commands.integral}
    return ex.Function("law", list(symbols.values()), ex.cse([results[name] for name in law_outputs(loop)]))


def closed_law(loop: Loop) -> ex.Function:
    """The efforts of a law of a closed chain: q, qd, u, v, a (n,) and the gains to effort (n,), and the doubt.

    Args:
        loop: whose law it is; its plant only says how many coordinates there are.
    """
    sizes, n = input_sizes(loop), loop.plant.n
    names = ("q", "qd", "u", "v", "a")
    given = {name: symbol_of(name, (n,)) for name in names}
    gains = symbol_of("gains", sizes["gains"])
    x = {"reference": ex.vertcat(given["u"], given["v"], given["a"]), "gains": gains}
    commands = Commands(replace(loop, noisy=True), Trees(), given["q"], given["qd"], x)
    outputs = [commands.effort, commands.doubt]
    return ex.Function("closed_law", [*given.values(), gains], ex.cse(outputs))
