"""Force closure of many grasps at once, shared out over the cores: of sets of wrenches, or straight from contacts.

Memory beyond input and answer is a few matrices for each core. A compiled simplex method decides each set of wrenches;
answers too near the boundary for floating point go to the single test, with exact arithmetic. From contacts each
verdict comes with its proof.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.answer import Answer
from mafsil.arrays import Floats, as_batch, real_array, require_finite
from mafsil.errors import InputError
from mafsil.grasp import loops
from mafsil.grasp.closure import Closure, ClosureStatus, closure
from mafsil.grasp.contact import Contact
from mafsil.grasp.contact_closure import START, circle
from mafsil.grasp.enclosure import positive_weights
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.tolerances import SOLVER
from mafsil.messages import say

PART_OF_WRENCHES = 256
"""Sets handed to a core at once."""
_MEMBERS_OF_WRENCHES: NDArray[np.object_] = np.array([ClosureStatus.OPEN, ClosureStatus.CLOSED], dtype=np.object_)


@dataclass(frozen=True, eq=False, repr=False)
class WrenchClosureBatch(Answer, data="force_closure combination certificate"):
    """Verdicts on many sets of wrenches; true if all are closed.

    Attributes:
        status: (b,) members of `ClosureStatus`.
        wrenches: (b, m, n) the sets.
        force_closure: (b,) whether they are closed; marginal sets are not.
        combination: (b, n) x > 0 with A x = 0 and sum 1 where yes; NaN elsewhere.
        certificate: (b, m) y != 0 with A' y >= 0 where no; NaN elsewhere.
        rechecked: how many were too near the boundary and went to the single test.
    """

    status: NDArray[np.object_]
    wrenches: Floats
    force_closure: NDArray[np.bool_]
    combination: Floats
    certificate: Floats
    rechecked: int

    def __bool__(self) -> bool:
        return bool(self.force_closure.all())

    def __len__(self) -> int:
        return len(self.force_closure)

    def __iter__(self) -> Iterator[Closure]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int) -> Closure:
        """One set's verdict with its margin."""
        return closure(self.wrenches[index])

    def explain(self, language: str | None = None) -> str:
        """How many sets are closed."""
        return say("grasp.batch", language=language, closed=int(self.force_closure.sum()), count=len(self))


def wrench_closures(A: ArrayLike) -> WrenchClosureBatch:
    """Force closure of a batch of wrench sets.

    Args:
        A: (b, m, n) wrenches in columns; sets with fewer columns are filled up by repeating some.

    Raises:
        InputError: not (b, m, n) finite numbers.
    """
    W = np.asarray(A)
    if W.ndim != 3:
        raise InputError("input.shape", name="A", expected="(b, m, n)", got=W.shape, hint="")
    W = np.ascontiguousarray(as_batch("A", W, W.shape[1:]))
    verdict, x, y = _spans_of_wrenches(W)
    closed = verdict > 0
    status = _MEMBERS_OF_WRENCHES[closed.astype(np.intp)]
    doubtful = np.flatnonzero(verdict < 0)
    if len(doubtful):  # what is not finite always is
        require_finite("A", W)
    for k in doubtful:
        single = closure(W[k], margins=False)
        closed[k], status[k] = single.force_closure, single.status
        x[k] = np.nan if single.combination is None else single.combination
        y[k] = np.nan if single.certificate is None else single.certificate
    return WrenchClosureBatch(status, W, closed, x, y, len(doubtful))


def _spans_of_wrenches(W: Floats) -> tuple[Floats, Floats, Floats]:
    """Verdicts 1, 0 or -1 (doubtful), and the proofs."""
    b, m, n = W.shape
    verdict, x, y = np.empty(b), np.empty((b, n)), np.empty((b, m))
    weights, positive_spans = positive_weights(n), loops.positive_span_loops.positive_spans

    def part(k: int) -> None:
        s = slice(k * PART_OF_WRENCHES, (k + 1) * PART_OF_WRENCHES)
        positive_spans((0,) * m, W[s], weights, SOLVER, x[s], y[s], verdict[s])

    threads.run(part, -(-b // PART_OF_WRENCHES), threads.available())
    return verdict, x, y


PART = 64
"""Grasps handed to a core at once."""
_MEMBERS: NDArray[np.object_] = np.array([ClosureStatus.OPEN, ClosureStatus.CLOSED], dtype=np.object_)


@dataclass(frozen=True, eq=False, repr=False)
class ClosureBatch(Answer, data="force_closure forces torsions certificate"):
    """Verdicts on the force closure of many grasps with as many contacts each; true if all are closed.

    Attributes:
        status: (*batch,) members of `ClosureStatus`.
        forces: (*batch, k, d) where yes, the proof: forces strictly inside the cones that balance, total push 1, in the
            axes of the body; NaN elsewhere.
        torsions: (*batch, k) the moments about the normals that belong to them, of soft fingers.
        certificate: (*batch, m) where not, y != 0 with y . w >= 0 for every wrench of the contacts: the external wrench
            y cannot be resisted; NaN elsewhere.
        rechecked: how many were too near the boundary and went to the single test.
        contacts: (*batch, k, 2 d + 2) point, normal, mu and gamma of each contact.
    """

    status: NDArray[np.object_]
    forces: Floats
    torsions: Floats
    certificate: Floats
    rechecked: int
    contacts: Floats

    @property
    def force_closure(self) -> NDArray[np.bool_]:
        """(*batch,) whether every external wrench is resisted; marginal grasps do not."""
        return np.asarray(self.status == ClosureStatus.CLOSED, dtype=np.bool_)

    def __bool__(self) -> bool:
        return bool(self.force_closure.all())

    def __len__(self) -> int:
        return len(self.status)

    def __iter__(self) -> Iterator[Closure | ClosureBatch]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int | tuple[int, ...] | slice) -> Closure | ClosureBatch:
        """One grasp's verdict with columns, weights and margin; or some of the batch."""
        chosen: Any = self.status[index]
        if isinstance(chosen, ClosureStatus):
            return Grasp(_contacts_of(self.contacts[index])).closure()
        forces, torsions, certificate = self.forces[index], self.torsions[index], self.certificate[index]
        return ClosureBatch(chosen, forces, torsions, certificate, self.rechecked, self.contacts[index])

    def explain(self, *index: int, language: str | None = None) -> str:  # pyright: ignore[reportIncompatibleMethodOverride]
        """The verdict on one grasp as a sentence; without an index how many grasps are closed."""
        if index:
            return Grasp(_contacts_of(self.contacts[index])).closure().explain(language)
        closed, count = int(self.force_closure.sum()), self.status.size
        return say("grasp.batch", language=language, closed=closed, count=count)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        verdicts = [status.verdict for status in self.status.ravel().tolist()]
        return Answer.to_dict(self) | {"verdict": verdicts, "assumes": "rigid bodies"}


def contact_closures(
    points: ArrayLike, normals: ArrayLike, mu: ArrayLike = 0.0, gamma: ArrayLike = 0.0
) -> ClosureBatch:
    """Force closure of many grasps, round cones as they are, shared out over the cores.

    Args:
        points: (*batch, k, d) contact points in the frame of the body [m], d = 2 or 3.
        normals: (*batch, k, d) into the body, of any length but zero.
        mu: (*batch, k) or anything that broadcasts: friction coefficients.
        gamma: the same for torsional coefficients [m], in space only.

    Raises:
        InputError: wrong shapes, numbers that are not finite, a zero normal, a negative coefficient.
    """
    given = _gather(points, normals, mu, gamma)
    batch, k, d = given.shape[:-2], given.shape[-2], given.shape[-1] // 2 - 1
    flat, m = given.reshape(-1, k, given.shape[-1]), 3 * (d - 1)
    count = len(flat)
    forces, torsions = np.full((count, k, d), np.nan), np.full((count, k), np.nan)
    certificate, state = np.full((count, m), np.nan), np.empty(count, dtype=np.int8)
    _spans(flat, forces, torsions, certificate, state)
    statuses = _MEMBERS[(state == 1).astype(np.intp)]
    doubtful = np.flatnonzero(state < 0)
    for i in doubtful:
        contacts = _contacts_of(flat[i])
        found = Grasp(contacts).closure(margins=False)
        statuses[i] = found.status
        if found.combination is not None:
            forces[i], torsions[i] = _forces_of(contacts, found)
        certificate[i] = np.nan if found.certificate is None else found.certificate
    forces, torsions = forces.reshape(*batch, k, d), torsions.reshape(*batch, k)
    return ClosureBatch(
        statuses.reshape(batch), forces, torsions, certificate.reshape(*batch, m), len(doubtful), given
    )  # fmt: skip


def _gather(points: ArrayLike, normals: ArrayLike, mu: ArrayLike, gamma: ArrayLike) -> Floats:
    """(*batch, k, 2 d + 2) points, normals and coefficients of all contacts, checked."""
    r, n = real_array("points", points), real_array("normals", normals)
    if r.ndim < 2 or r.shape[-1] not in (2, 3) or not r.shape[-2]:
        raise InputError("input.shape", name="points", expected="(*batch, k, 2 | 3)", got=r.shape, hint="")
    if n.shape[-1:] != r.shape[-1:]:
        raise InputError("input.shape", name="normals", expected=r.shape, got=n.shape, hint="")
    coefficients = {"mu": real_array("mu", mu), "gamma": real_array("gamma", gamma)}
    try:
        batch = np.broadcast_shapes(r.shape[:-1], n.shape[:-1], *(one.shape for one in coefficients.values()))
    except ValueError:
        got = ", ".join(map(str, (r.shape, n.shape, *(one.shape for one in coefficients.values()))))
        raise InputError("call.batches", name="points, normals, mu, gamma", batches=got) from None
    d = r.shape[-1]
    given = np.empty((*batch, 2 * d + 2))
    given[..., :d], given[..., d : 2 * d] = r, n
    given[..., 2 * d], given[..., 2 * d + 1] = coefficients["mu"], coefficients["gamma"]
    for name, one in (("points", r), ("normals", n), *coefficients.items()):
        require_finite(name, one)
    if not given[..., d : 2 * d].any(axis=-1).all():
        row = np.argwhere(~given[..., d : 2 * d].any(axis=-1))[0]
        raise InputError("grasp.zero_normal", name="normals", point=str(tuple(row.tolist())))
    for name, one in coefficients.items():
        if (one < 0).any():
            raise InputError("grasp.negative_coefficient", name=name, value=float(one.min()))
    if d == 2 and coefficients["gamma"].any():
        raise InputError("grasp.soft_in_plane", name="gamma")
    return given


def _spans(flat: Floats, forces: Floats, torsions: Floats, certificate: Floats, state: NDArray[np.int8]) -> None:
    """Verdicts 1, 0 or -1 (doubtful), and the proofs."""
    k, m = flat.shape[1], certificate.shape[1]
    edges = 2 if m == 3 else START
    weights, spans = positive_weights(edges * k), loops.contact_span_loops.contact_spans

    def part(i: int) -> None:
        s = slice(i * PART, (i + 1) * PART)
        out = forces[s], torsions[s], certificate[s], state[s]
        spans((0,) * m, flat[s], circle(edges), weights, SOLVER, *out)

    threads.run(part, -(-len(flat) // PART), threads.available())


def _contacts_of(rows: Floats) -> list[Contact]:
    """The contacts of one grasp of a batch."""
    d = rows.shape[1] // 2 - 1
    return [Contact(row[:d], row[d : 2 * d], float(row[-2]), float(row[-1])) for row in rows]


def _forces_of(contacts: Sequence[Contact], found: Closure) -> tuple[Floats, Floats]:
    """Forces and torsions that the weights of a yes stand for: each column belongs to the contact that it fits."""
    assert found.combination is not None
    d = contacts[0].dimension
    forces, torsions = np.zeros((len(contacts), d)), np.zeros(len(contacts))
    for x, w in zip(found.combination, found.columns.T, strict=True):
        parts: list[Floats] = [np.linalg.lstsq(c.basis, w, rcond=None)[0] for c in contacts]
        residuals = [
            float(np.linalg.norm(c.basis @ z - w)) + max(0.0, -c.margin(z))
            for c, z in zip(contacts, parts, strict=True)
        ]
        i = int(np.argmin(residuals))
        forces[i] += x * w[-d:]
        torsions[i] += x * (parts[i][3] if contacts[i].model == "soft" else 0.0)
    return forces, torsions
