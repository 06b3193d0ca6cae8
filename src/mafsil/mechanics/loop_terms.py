"""A closed loop as data: what is compiled into one step, and the names and sizes of its inputs and outputs."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.mechanics.friction import friction_law
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint, friction_fingerprint


@dataclass(frozen=True, slots=True)
class Holding:
    """How the loops of a closed chain hold it.

    Attributes:
        rows: independent rows of its loops.
        driven: coordinates of the driven joints.
        deciding: which of them decide; see `mafsil.mechanics.loop_efforts`.
        tolerance: gap of a closed loop [rad | m].
    """

    rows: tuple[int, ...]
    driven: tuple[int, ...]
    deciding: tuple[int, ...]
    tolerance: float


@dataclass(frozen=True, slots=True)
class Term:
    """One summand of a control law.

    Attributes:
        kind: "computed_torque" (of the model), "feedback" (of each joint), "gravity", "feedforward" (of the model),
            "closed_computed_torque", "closed_gravity" (of a closed chain), "friction" alone, or "given": efforts that
            somebody else decides.
        model: the mechanism the law believes in; None for "feedback" and "given".
        holding: of the model, where it is taken as a closed chain.
        waits: whether its integral waits where it would drive efforts further beyond a limit. A "feedback" that waits
            has a model if it holds that up: limits are those of both together.
        friction: whether the friction of the model at the rates of the reference is added.
    """

    kind: str
    model: Mechanism | None = None
    holding: Holding | None = None
    waits: bool = False
    friction: bool = False

    @property
    def fed_back(self) -> bool:
        """Whether it has gains."""
        return self.kind in ("computed_torque", "feedback", "closed_computed_torque")

    @property
    def key(self) -> tuple[object, ...]:
        """Words that differ whenever the expression does, its holding aside."""
        rubbing = friction_fingerprint(self.model) if self.friction and self.model is not None else ""
        return (self.kind, None if self.model is None else fingerprint(self.model), self.waits, rubbing)

    @property
    def parts(self) -> tuple[str, ...]:
        """Kinds of what it adds up."""
        found = (self.kind, "gravity") if self.waits and self.model is not None else (self.kind,)
        return (*found, "friction") if self.friction and self.kind != "friction" else found


@dataclass(frozen=True, slots=True)
class Loop:
    """What decides the expression of a step.

    Attributes:
        plant: the mechanism that moves.
        terms: of the law; each "computed_torque" and "feedback" has gains of its own.
        shown: the mechanism whose tip is compared with the reference.
        scheme: ("runge_kutta", a, b), ("splitting", kicks, drifts) or ("implicit_friction", iterations).
        substeps: integration steps for each evaluation of the law.
        friction: width of the smoothed Coulomb friction [rad/s | m/s]; None for no friction.
        pushed, noisy, saturated: whether these inputs exist.
        integrates: whether the laws have an integral.
        varied: whether the inertias and the friction of the plant are inputs instead of its own numbers.
        holding: of the plant, if it is a closed chain.
    """

    plant: Mechanism
    terms: tuple[Term, ...]
    shown: Mechanism
    scheme: tuple[object, ...]
    substeps: int
    friction: float | None
    pushed: bool
    noisy: bool
    saturated: bool
    integrates: bool
    varied: bool = False
    holding: Holding | None = None

    @property
    def gains(self) -> int:
        """Number of terms that have gains."""
        return sum(term.fed_back for term in self.terms)

    @property
    def integrals(self) -> int:
        """Number of terms that have an integral."""
        return self.gains if self.integrates else 0


def input_sizes(loop: Loop) -> dict[str, tuple[int, ...]]:
    """Names and core shapes of the inputs; integrals, gains and limits hold one row for each term that has them.

    Bodies and friction are those of `mafsil.mechanics.tree_plant`.

    What would hold no numbers is left out: integrals without an integral, gains without feedback, limits at which no
    integral waits.
    """
    n = loop.plant.n
    sizes: dict[str, tuple[int, ...]] = {"state": (2, n), "integral": (loop.integrals, n), "reference": (3, n)}
    sizes |= {"gains": (loop.gains, 3, n), "step": (), "T_desired": (4, 4)}
    sizes["integral_limit"] = (sum(term.waits for term in loop.terms), n)
    if loop.saturated:
        sizes["limit"] = (n,)
    if loop.pushed:
        sizes["push"] = (6,)
    if loop.noisy:
        sizes["noise"] = (2, n)
    if any(term.kind == "given" for term in loop.terms):
        sizes["given"] = (n,)
    if loop.varied:
        sizes["bodies"] = (sum(joint.moves for joint in loop.plant.joints), 10)
    if loop.varied and loop.friction is not None:
        sizes["friction"] = (len(friction_law(loop.plant).viscous), 4)
    return _present(sizes)


def output_sizes(loop: Loop) -> dict[str, tuple[int, ...]]:
    """Names and core shapes of the outputs; tip errors are the tip's distance and angle from the reference.

    The state that a closed chain gets is closed first, and its next state not yet. Doubt is below one where the step
    holds; see `mafsil.mechanics.loop_dynamics`.
    """
    n = loop.plant.n
    sizes: dict[str, tuple[int, ...]] = {
        "next_state": (2, n), "next_integral": (loop.integrals, n), "command": (n,), "effort": (n,),
        "acceleration": (n,), "tip_errors": (2,),
    }  # fmt: skip
    if loop.holding is not None:
        sizes |= {"closed_state": (2, n), "doubt": ()}
    return _present(sizes)


def _present(sizes: dict[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
    return {name: shape for name, shape in sizes.items() if 0 not in shape}
