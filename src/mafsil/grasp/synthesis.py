"""Finding grasps: the best place for one more finger, fixtures of six locators and a clamp, the least friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.grasp.closure import closure
from mafsil.grasp.contact import Contact
from mafsil.grasp.contact_batch import wrench_closures
from mafsil.grasp.description import contact_data
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.tolerances import ROUNDOFF

MOST_FRICTION = 10.0


class NextFingerStatus(Status):
    """Whether some candidate closes the grasp."""

    FOUND = ("grasp.next_finger", True)
    NOT_FOUND = ("grasp.no_next_finger", False)


class FixtureStatus(Status):
    """Whether locators and a clamp fix a body."""

    HOLDS = ("grasp.fixture_holds", True)
    UNLOADED = ("grasp.fixture_unloaded", False)
    UNDETERMINED = ("grasp.fixture_undetermined", False)


@dataclass(frozen=True, eq=False, repr=False)
class NextFinger(Answer, data="epsilon closing"):
    """A finger that was added; true if some candidate closes the grasp.

    Attributes:
        contact: where it is best; None if no candidate closes the grasp.
        epsilon: quality of the grasp with it; 0 if none closes.
        closing: indices of the candidates that close the grasp.
    """

    contact: Contact | None
    epsilon: float
    closing: tuple[int, ...]

    @property
    def status(self) -> NextFingerStatus:
        """Found or not."""
        return NextFingerStatus.NOT_FOUND if self.contact is None else NextFingerStatus.FOUND

    def explain(self, language: str | None = None) -> str:
        """How many candidates close the grasp, and which is best."""
        best = "-" if self.contact is None else repr(self.contact)
        return self.status.sentence(language, closing=len(self.closing), contact=best, epsilon=self.epsilon)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"contact": None if self.contact is None else contact_data(self.contact)}


@dataclass(frozen=True, eq=False, repr=False)
class Fixture(Answer, data="determined holds reactions unloaded"):
    """Six locators and a clamp; true if they fix the body.

    Attributes:
        determined: the locators fix the body: their matrix is regular.
        reactions: (6,) or (3,) reactions per unit of clamp force; all > 0 if the clamp holds the body on all of them.
        holds: determined and all reactions positive.
        unloaded: locators whose reaction is not positive.
    """

    determined: bool
    reactions: Floats
    holds: bool
    unloaded: tuple[int, ...]

    @property
    def status(self) -> FixtureStatus:
        """Whether it holds, or what is missing."""
        if not self.determined:
            return FixtureStatus.UNDETERMINED
        return FixtureStatus.HOLDS if self.holds else FixtureStatus.UNLOADED

    def explain(self, language: str | None = None) -> str:
        """Whether it holds, and which locators are not loaded."""
        return self.status.sentence(language, locators=", ".join(map(str, self.unloaded)))


def polygon_contacts(outline: ArrayLike, per_edge: int = 9, mu: float = 0.0) -> list[Contact]:
    """Candidate contacts on a polygon, inside its edges, normals inwards.

    Args:
        outline: (k, 2) corners in either sense [m].
        per_edge: candidates on each edge.
        mu: friction coefficient.

    Raises:
        InputError: fewer than three corners, or no area.
    """
    corners = as_batch("outline", outline, (2,), finite=True)
    if len(corners) < 3:
        raise InputError("grasp.few_corners", got=len(corners))
    after = np.roll(corners, -1, axis=0)
    area = 0.5 * float(np.sum(corners[:, 0] * after[:, 1] - after[:, 0] * corners[:, 1]))
    if area == 0.0:
        raise InputError("grasp.no_area")
    found: list[Contact] = []
    for k, (a, b) in enumerate(zip(corners, after, strict=True)):
        edge = b - a
        if not np.linalg.norm(edge) > 0:
            continue
        normal = np.array([-edge[1], edge[0]]) * np.sign(area)
        for t in (np.arange(per_edge) + 0.5) / per_edge:
            found.append(Contact(a + t * edge, normal, mu, name=f"edge {k} at {t:.3g}"))
    return found


def best_next_finger(
    grasp: Grasp, candidates: Sequence[Contact], length: float = 1.0, facets: int = 8, rate: int = 24
) -> NextFinger:
    """Where one more finger makes the grasp most robust.

    Closure of all candidates is tested in one batch; of those that close, at most `rate`, evenly chosen, are rated by
    their epsilon quality.

    Args:
        grasp: the fingers that are there.
        candidates: places for the new one.
        length: moments are divided by it [m].
        facets: edges of round cones.
        rate: how many closing candidates are rated.
    """
    there = grasp.matrix(facets)
    added = [c.wrenches(facets) for c in candidates]
    widest = max(W.shape[1] for W in added)
    filled = [np.hstack([there, W, np.repeat(W[:, :1], widest - W.shape[1], axis=1)]) for W in added]
    closing = np.flatnonzero(wrench_closures(np.array(filled)).force_closure)
    if not len(closing):
        return NextFinger(None, 0.0, ())
    picked: list[int] = closing[
        np.unique(np.linspace(0, len(closing) - 1, min(rate, len(closing))).astype(int))
    ].tolist()
    rated = [(epsilon_with_contact(grasp, candidates[k], length, facets), k) for k in picked]
    epsilon, best = max(rated)
    return NextFinger(candidates[best], epsilon, tuple(int(k) for k in closing))


def epsilon_with_contact(grasp: Grasp, contact: Contact, length: float, facets: int) -> float:
    """GraspQuality radius of a grasp with one more contact, polyhedral cones.

    Args:
        grasp: the fingers that are there.
        contact: the new one.
        length: moments are divided by it [m].
        facets: edges of round cones.
    """
    W = Grasp([*grasp.contacts, contact]).matrix(facets)
    W[: grasp.rows - grasp.dimension] /= length
    return max(0.0, closure(W).margin)


def fixture(locators: Sequence[Contact], clamp: Contact) -> Fixture:
    """Do six locators (three in the plane) place the body, and does the clamp press it on all of them?

    Args:
        locators: frictionless; 3-2-1 on three faces is the classic choice.
        clamp: frictionless.

    Raises:
        InputError: not as many locators as dimensions of the wrench.
    """
    A = Grasp(locators).normals_matrix
    m = len(A)
    if A.shape[1] != m:
        raise InputError("grasp.locators", got=A.shape[1], expected=m)
    push = Grasp([clamp]).normals_matrix[:, 0]
    if np.linalg.matrix_rank(A / np.linalg.norm(A, axis=0)) < m:
        return Fixture(False, np.full(m, np.nan), False, tuple(range(m)))
    reactions: Floats = np.asarray(np.linalg.solve(A, -push), float)
    unloaded = tuple(int(i) for i in np.flatnonzero(reactions <= ROUNDOFF * np.abs(reactions).max()))
    return Fixture(True, reactions, not unloaded, unloaded)


def box_fixture(size: ArrayLike, inset: float = 0.2) -> tuple[list[Contact], Contact]:
    """A 3-2-1 fixture of a box with one corner at the origin, and a clamp that loads all locators.

    The clamp pushes at the far top corner's neighbourhood towards the origin; its place is searched on the top face.

    Args:
        size: (3,) edges [m].
        inset: distance of locators from the edges, as a share of the edges, below 0.5.

    Raises:
        InputError: sizes not positive, or no clamp that holds was found.
    """
    a, b, c = as_batch("size", size, (3,), finite=True)
    if min(a, b, c) <= 0:
        raise InputError("input.positive", name="size", value=min(a, b, c))
    near, far = inset, 1 - inset
    locators = [
        *(Contact((x * a, y * b, 0), (0, 0, 1)) for x, y in ((near, near), (far, near), (0.5, far))),
        *(Contact((x * a, 0, 0.5 * c), (0, 1, 0)) for x in (near, far)),
        Contact((0, 0.5 * b, 0.5 * c), (1, 0, 0)),
    ]
    best: tuple[float, Contact] | None = None
    for x in np.linspace(0.05, 0.95, 19):
        for y in np.linspace(0.05, 0.95, 19):
            for weight in (0.25, 0.5, 1.0, 2.0, 4.0):
                clamp = Contact((x * a, y * b, c), (-1, -1, -weight))
                found = fixture(locators, clamp)
                least = float(found.reactions.min())
                if found.holds and (best is None or least > best[0]):
                    best = (least, clamp)
    if best is None:
        raise InputError("grasp.no_clamp", size=(float(a), float(b), float(c)))
    return locators, best[1]


def least_friction(grasp: Grasp, tolerance: float = 1e-6) -> float | None:
    """The friction coefficient from which on the same contacts close, by bisection; None if 10 does not do.

    More friction never opens a grasp, so there is one such number.

    Args:
        grasp: contacts; their own coefficients do not matter.
        tolerance: of the answer.
    """

    def closes(mu: float) -> bool:
        return grasp.with_friction(mu).closure(margins=False).force_closure

    if closes(0.0):
        return 0.0
    low, high = 0.0, MOST_FRICTION
    if not closes(high):
        return None
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if closes(middle) else (middle, high)
    return high
