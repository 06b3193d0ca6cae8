"""One step of a closed loop as one expression: measured state and reference in, next state and what is recorded out.

One call of a control law as an expression: measured state, reference and integrals in, efforts and integrals out.
"""

from __future__ import annotations

from dataclasses import replace

import mafsil.expression as ex
from mafsil.algebra import so3
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.friction import SMOOTHING, friction_law
from mafsil.mechanics.loop_constraints import loops
from mafsil.mechanics.loop_dynamics import HeldTree, spread
from mafsil.mechanics.loop_efforts import Passive, accelerations_of_all, efforts
from mafsil.mechanics.loop_terms import Holding, Loop, Term, input_sizes, output_sizes
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.forward_dynamics import by_mass_matrix_shorter, mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.quantities.kinematics import forward_kinematics
from mafsil.mechanics.tree_plant import Friction, HeldPlant, TreePlant, body_inertias, closed_state
from mafsil.model import Mechanism


def function(loop: Loop) -> ex.Function:
    """The step as a function, inputs and outputs as `input_sizes` and `output_sizes` say, columns in C order.

    Args:
        loop: what is built.
    """
    sizes = input_sizes(loop)
    x = {name: symbol_of(name, shape) for name, shape in sizes.items()}
    n, trees = loop.plant.n, Trees()
    tree = trees.true(loop.plant) if loop.varied else trees.of(loop.plant)
    inertias = body_inertias(tree, x["bodies"]) if loop.varied else None
    q, qd, doubt = _closed(loop, tree, inertias, x["state"][:n], x["state"][n:])
    measured_q, measured_qd = (q + x["noise"][:n], qd + x["noise"][n:]) if loop.noisy else (q, qd)
    law = Commands(loop, trees, measured_q, measured_qd, x)
    effort = clip_command(law.effort, x["limit"]) if loop.saturated else law.effort
    plant = _plant(loop, tree, effort, x)
    here, rate, first = plant.step(q, qd, x["step"])
    for _ in range(loop.substeps - 1):
        here, rate, more = _closed(loop, tree, inertias, here, rate)
        here, rate, _ = plant.step(here, rate, x["step"])
        doubt = doubt + more
    T = forward_kinematics(trees.true(loop.shown), q, trees.true(loop.shown).tip)
    desired = ex.reshape(x["T_desired"], 4, 4).T
    distance = ex.sqrt(ex.sumsqr(desired[:3, 3] - T[:3, 3]))
    angle = so3.angle_between(T[:3, :3], desired[:3, :3])
    results = {
        "next_state": ex.vertcat(here, rate), "next_integral": law.integral, "command": law.effort, "effort": effort,
        "acceleration": first, "tip_errors": ex.vertcat(distance, angle),
        "closed_state": ex.vertcat(q, qd), "doubt": doubt + law.doubt + plant.doubt,
    }  # fmt: skip
    return ex.Function("closed_loop", list(x.values()), ex.cse([results[name] for name in output_sizes(loop)]))


class Trees:
    """Trees of mechanisms: equal mechanisms share one, so that their expressions share what they have in common."""

    def __init__(self) -> None:
        self._full: list[tuple[Mechanism, BodyTree, BodyTree]] = []

    def _both(self, mechanism: Mechanism) -> tuple[BodyTree, BodyTree]:
        for known, full, short in self._full:
            if known is mechanism:
                return full, short
        full = in_chosen_frames(lump_bodies(mechanism))
        self._full.append((mechanism, full, regroup(full)))
        return self._full[-1][1:]

    def of(self, mechanism: Mechanism) -> BodyTree:
        """The shortest tree with the same dynamics."""
        return self._both(mechanism)[1]

    def true(self, mechanism: Mechanism) -> BodyTree:
        """The tree with true frames."""
        return self._both(mechanism)[0]


def symbol_of(name: str, shape: tuple[int, ...]) -> Expression:
    """A column of symbols, the shape's entries in C order."""
    size = 1
    for length in shape:
        size *= length
    return ex.symbol(name, size)


class Commands:
    """What a law asks for.

    Args:
        loop: whose law it is.
        trees: of its mechanisms.
        q, qd: (n,) measured.
        x: inputs by name, as `input_sizes` says.

    Attributes:
        effort: (n,) commanded.
        integral: the next integrals.
        doubt: of what was solved for closed chains.
    """

    def __init__(self, loop: Loop, trees: Trees, q: Expression, qd: Expression, x: dict[str, Expression]) -> None:
        n = loop.plant.n
        self._loop, self._trees, self._q, self._qd = loop, trees, q, qd
        self._u, self._v, self._a = x["reference"][:n], x["reference"][n : 2 * n], x["reference"][2 * n :]
        self.effort, self.doubt = ex.zeros(n, 1), ex.Expression(0)
        integrals: list[Expression] = []
        row, waiting = 0, 0
        for term in loop.terms:
            feedback = ex.zeros(n, 1)
            if term.fed_back:
                kp, kd, ki = (x["gains"][(3 * row + part) * n : (3 * row + part + 1) * n] for part in range(3))
                feedback = kp * (self._u - q) + kd * (self._v - qd)
                if term.waits and term.model is not None:
                    feedback = feedback + self._held_up(term.model) + self._friction(term)
                if loop.integrates:
                    before, growth = x["integral"][row * n : (row + 1) * n], ki * (self._u - q)
                    if term.waits:
                        limit = x["integral_limit"][waiting * n : (waiting + 1) * n]
                        growth = _unless_beyond(growth, feedback + before + growth, limit)
                        waiting += 1
                    integrals.append(before + growth)
                    feedback = feedback + integrals[-1]
                row += 1
            self.effort = self.effort + (x["given"] if term.kind == "given" else self._efforts(term, feedback))
            if not term.waits:
                self.effort = self.effort + self._friction(term)
        self.integral = ex.vertcat(ex.zeros(0, 1), *integrals)

    def _held_up(self, model: Mechanism) -> Expression:
        """(n,) efforts against gravity."""
        rest = ex.zeros(self._loop.plant.n, 1)
        return inverse_dynamics(self._trees.of(model), self._q, rest, rest)

    def _efforts(self, term: Term, feedback: Expression) -> Expression:
        """(n,) of one term."""
        if term.kind in ("feedback", "friction"):
            return feedback
        model = term.model
        assert model is not None
        if term.holding is not None:
            return self._closed(model, term.holding, term.kind, feedback)
        if term.kind == "computed_torque":
            return _efforts(self._loop, self._trees, model, self._q, self._qd, self._a + feedback)
        if term.kind == "gravity":
            return self._held_up(model)
        return inverse_dynamics(self._trees.of(model), self._u, self._v, self._a)

    def _friction(self, term: Term) -> Expression:
        """(n,) efforts of the friction of a term's model at the rates of the reference; zero of terms without."""
        if not term.friction or term.model is None:
            return ex.zeros(self._loop.plant.n, 1)
        friction = Friction(friction_law(term.model), SMOOTHING, None)
        return friction.slope(self._v) @ self._v + friction.offset

    def _closed(self, model: Mechanism, holding: Holding, kind: str, feedback: Expression) -> Expression:
        """(n,) of the driven joints of a closed chain: to hold it up, or for the accelerations asked of them."""
        tree, n = self._trees.of(model), model.n
        q, qd, qdd = self._q, ex.zeros(n, 1), ex.zeros(n, 1)
        if kind == "closed_computed_torque":
            qd = self._qd
        asked = loops(tree, model.loops, q, qd)
        if kind == "closed_computed_torque":
            wanted = self._a + feedback
            given = ex.vertcat(*(wanted[k] for k in holding.driven))
            qdd, doubt = accelerations_of_all(asked.rows, asked.bias, given, holding.driven, holding.rows)
            self.doubt = self.doubt + doubt
        w, passive = inverse_dynamics(tree, q, qd, qdd), Passive(asked.rows, holding.driven, holding.rows)
        if passive.decided:
            tau, doubt = passive.efforts(asked.rows, w), passive.doubt
        else:
            found = efforts(HeldTree(ex.eye(n), asked.rows, holding.rows), w, holding.driven, holding.deciding)
            tau, doubt = found.tau, found.doubt
        self.doubt = self.doubt + doubt + HeldTree.finite(tau)
        return spread(tau, holding.driven, n)


def _closed(
    loop: Loop, tree: BodyTree, inertias: list[CompositeInertia] | None, q: Expression, qd: Expression
) -> tuple[Expression, Expression, Expression]:
    """Coordinates and rates with closed loops, if the plant has any, and the doubt of them."""
    if loop.holding is None:
        return q, qd, ex.Expression(0)
    q, qd, _, doubt = closed_state(tree, loop.plant.loops, loop.holding, q, qd, inertias)
    return q, qd, doubt


def _plant(loop: Loop, tree: BodyTree, effort: Expression, x: dict[str, Expression]) -> TreePlant:
    if loop.holding is None:
        return TreePlant(loop, tree, effort, x)
    return HeldPlant(loop, loop.holding, tree, effort, x)


def _efforts(loop: Loop, trees: Trees, model: Mechanism, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """Inverse dynamics of the law's model.

    A law that knows the plant and its state shares M and h = c + g with the plant's own step: M qdd + h is shorter.
    """
    tree = trees.of(model)
    if model is not loop.plant or loop.noisy or loop.varied or not by_mass_matrix_shorter(tree):
        return inverse_dynamics(tree, q, qd, qdd)
    return mass_matrix(tree, q) @ qdd + inverse_dynamics(tree, q, qd, ex.zeros(tree.n, 1))


def _unless_beyond(growth: Expression, ahead: Expression, limit: Expression) -> Expression:
    """(n,) growth of an integral: none where it would drive the efforts ahead further beyond their limits."""
    waits = [ex.logic_and(ex.fabs(ahead[i]) > limit[i], ahead[i] * growth[i] > 0.0) for i in range(growth.shape[0])]
    return ex.vertcat(*(ex.if_else(wait, 0.0, growth[i]) for i, wait in enumerate(waits)))


def clip_command(command: Expression, limit: Expression) -> Expression:
    """Clipped elementwise; NaN passes through."""
    return ex.vertcat(
        *(
            ex.if_else(command[i] > limit[i], limit[i], ex.if_else(command[i] < -limit[i], -limit[i], command[i]))
            for i in range(command.shape[0])
        )
    )


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
