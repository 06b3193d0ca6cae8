"""A grasp: a body's frame and the contacts on it, with every question one can ask of its statics."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cached_property
from html import escape
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive
from mafsil.errors import InputError, MafsilError
from mafsil.grasp import loops
from mafsil.grasp.clearance import (
    ClearanceMotion,
    ContactMotion,
    FreeMotions,
    RestPosition,
    contact_motion,
    free_motions,
    motion_within_clearance,
    rest_position,
)
from mafsil.grasp.closure import Closure, closure, conditioning, counted_out, vector
from mafsil.grasp.closure_methods import count_contacts
from mafsil.grasp.contact import MOST_FACETS, Contact, force_wrench, require_one_dimension
from mafsil.grasp.contact_closure import round_closure
from mafsil.grasp.description import contact_data, parse_description
from mafsil.grasp.enclosure import ConeWrenches, has_round_cones
from mafsil.grasp.forces import ContactForces, resist
from mafsil.grasp.friction import friction_remarks
from mafsil.grasp.quality import GraspQuality, hull_volume, quality_of_discs, quality_of_wrenches
from mafsil.grasp.second_order import ImmobilityStatus, SecondOrderClosure, second_order
from mafsil.messages import say
from mafsil.solvers.rational import exact

MOST_SHOWN = 20
"""Contacts that are printed."""


class Grasp:
    """Contacts on one rigid body.

    Everything rests on rigid bodies: contacts do not give way. Wrenches are (m, f) about the origin of the frame in
    which the points are written; where a number depends on the origin or on the unit of length, both can be chosen.

    Attributes:
        contacts: in order.
        name: for reports.
    """

    def __init__(self, contacts: Sequence[Contact | Sequence[Any]], name: str = "") -> None:
        """Gather contacts; a list of contacts inside the list (line, patch, corner) counts as its members.

        A plain (point, normal), with mu and gamma behind if wanted, is a contact too.

        Args:
            contacts: all in the plane or all in space.
            name: for reports.

        Raises:
            InputError: none, or of mixed dimension.
        """
        flat: list[Contact] = []
        for index, item in enumerate(contacts):
            flat.extend(_members(item, index))
        if not flat:
            raise InputError("grasp.no_contacts")
        require_one_dimension(flat)
        self.contacts = tuple(flat)
        self.name = name

    def __repr__(self) -> str:
        """The contacts, one a line where there are several; the first twenty."""
        shown = [repr(contact) for contact in self.contacts[:MOST_SHOWN]]
        if len(self) > MOST_SHOWN:
            shown.append(f"... {len(self)} contacts")
        name = f"{self.name}: " if self.name else ""
        return f"Grasp({name}{shown[0]})" if len(shown) == 1 else f"Grasp({name}\n  " + ",\n  ".join(shown) + ")"

    def __len__(self) -> int:
        return len(self.contacts)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.contacts[0].dimension

    @property
    def rows(self) -> int:
        """m: 3 in the plane, 6 in space."""
        return 3 * (self.dimension - 1)

    @property
    def frictionless(self) -> bool:
        """Whether no contact has friction."""
        return all(contact.model == "frictionless" for contact in self.contacts)

    def matrix(self, facets: int = 16, *, outer: bool = False, unit: bool = False, order: str = "mf") -> Floats:
        """The grasp matrix A: one column for each cone edge, A x = -(m_ext, f_ext), x >= 0.

        Args:
            facets: edges of a cone in space; a plane cone has two.
            outer: circumscribe round cones instead of inscribing.
            unit: edges of length 1 instead of unit push.
            order: rows `mf`, or `fm` as many texts on grasping write them.

        Returns:
            (m, n).
        """
        A = self._columns(facets, outer=outer, unit=unit)
        return A if order == "mf" else np.vstack([A[self.rows - self.dimension :], A[: self.rows - self.dimension]])

    def _columns(self, facets: int, *, outer: bool, unit: bool) -> Floats:
        """The columns of all contacts; of hard fingers in space with inscribed cones by one compiled call."""
        plain = self.dimension == 3 and not (outer or unit) and 3 <= facets <= MOST_FACETS
        if plain and all(contact.model == "hard" for contact in self.contacts):
            return ConeWrenches.of(self.contacts, np.eye(self.rows)).rim(facets)
        return np.hstack([c.wrenches(facets, outer=outer, unit=unit) for c in self.contacts])

    @cached_property
    def normals_matrix(self) -> Floats:
        """(m, contacts) wrenches of unit pushes without friction: the matrix of form closure."""
        return np.column_stack([c.basis[:, 0] for c in self.contacts])

    @cached_property
    def map(self) -> Floats:
        """(m, sum k_i) contact force components (`Contact.basis`) to wrench."""
        return np.hstack([c.basis for c in self.contacts])

    def resultant(self, forces: ArrayLike) -> Floats:
        """Wrench (m, f) of forces at the contacts.

        Args:
            forces: (contacts, d) in the frame of the body [N].
        """
        given = as_batch("forces", forces, (len(self), self.dimension), finite=True)
        return np.sum([force_wrench(c.point, f) for c, f in zip(self.contacts, given, strict=True)], axis=0)

    def in_frame(self, T: ArrayLike) -> Grasp:
        """The same grasp in another frame.

        Args:
            T: (d + 1, d + 1) pose of the old frame in the new one.
        """
        return Grasp([contact.in_frame(T) for contact in self.contacts], self.name)

    def with_friction(self, mu: float) -> Grasp:
        """The same contacts with another friction coefficient.

        Args:
            mu: for all.
        """
        return Grasp([c.with_friction(mu, c.gamma) for c in self.contacts], self.name)

    def closure(self, facets: int | None = None, *, outer: bool = False, margins: bool = True) -> Closure:
        """Force closure with its proof; round cones as they are, unless polyhedral ones are asked for.

        Args:
            facets: edges of polyhedral cones; None for the true cones.
            outer: circumscribed polyhedral cones.
            margins: False: the margin is not requested, and NaN; else it is found when it is looked at.
        """
        if facets is None and has_round_cones(self.contacts):
            found = round_closure(self.contacts, margins=margins)
        else:
            A = self.matrix(facets or 16, outer=outer)
            M = conditioning([c.point for c in self.contacts])
            found = closure(A, exact=self._exact_columns, transform=M, margins=margins)
        return found if found else self._count(found)

    def _count(self, found: Closure) -> Closure:
        """Too few contacts for their models are a no, never marginal: no change of numbers helps."""
        if found.rank == self.rows and all(c.mu > 0 or c.gamma > 0 for c in self.contacts):
            return found
        count = count_contacts(self.contacts)
        if count.enough or not count.frictional:
            return found
        free = [c.basis[:, 0] for c in self.contacts if c.mu == 0 and c.gamma == 0]
        details = {"spanned": count.spanned, "needed": count.needed, "there": count.frictionless}
        pushes = np.column_stack(free) if free else np.zeros((self.rows, 0))
        return counted_out(found, count.open_directions, pushes, details)

    def bracket(self, facets: int = 16) -> tuple[Closure, Closure]:
        """Verdicts with inscribed and circumscribed cones: a yes of the first and a no of the second are certain.

        Args:
            facets: edges of each cone.
        """
        return self.closure(facets), self.closure(facets, outer=True)

    def form_closure(self) -> Closure:
        """Are all motions impossible whatever the forces (first order, friction ignored)?"""
        return self.frictionless_part().closure()

    def frictionless_part(self) -> Grasp:
        """Normals alone."""
        return Grasp([c.with_friction(0.0) for c in self.contacts], self.name)

    def second_order(self) -> SecondOrderClosure:
        """Is the body held by the curvature at its contacts where first order leaves it free? Friction ignored."""
        return second_order(self)

    def free_motions(self) -> FreeMotions:
        """Twists that the normals allow."""
        return free_motions(self.normals_matrix)

    def contact_motions(self, twist: ArrayLike) -> tuple[ContactMotion, ...]:
        """What a twist (omega, v) of the body does at each contact.

        Args:
            twist: (m,).
        """
        y = as_batch("twist", twist, (self.rows,), finite=True)
        return tuple(contact_motion(y, c.point, c.normal) for c in self.contacts)

    def motion_within_clearance(self, clearance: ArrayLike) -> ClearanceMotion:
        """How far the body moves if every finger stands off a little.

        Args:
            clearance: [m], one for all or (contacts,).
        """
        return motion_within_clearance(self.normals_matrix, clearance)

    def rest_position(self, wrench: ArrayLike, clearance: ArrayLike) -> RestPosition:
        """Where the body comes to rest between fingers that stand off, under a load and without friction.

        Args:
            wrench: (m,) external (m, f) [N m, N].
            clearance: [m], one for all or (contacts,).
        """
        return rest_position(self.normals_matrix, wrench, clearance)

    def resist(
        self,
        wrench: ArrayLike,
        *,
        push: float | ArrayLike | None = None,
        jacobian: ArrayLike | None = None,
        torque: ArrayLike | None = None,
    ) -> ContactForces:
        """Smallest contact forces that hold the body under one external wrench; arguments as of `grasp.resist`.

        Args:
            wrench: (m,) external (m, f) on the body [N m, N].
            push, jacobian, torque: limits of the forces.
        """
        return resist(self.contacts, wrench, push=push, jacobian=jacobian, torque=torque)

    def quality(self, length: float = 1.0, *, about: ArrayLike | None = None, together: bool = False) -> GraspQuality:
        """Epsilon: radius of the largest ball of external wrenches that unit pushes resist (Ferrari and Canny).

        Args:
            length: moments are divided by it [m]; epsilon depends on it.
            about: (d,) point about which moments are taken [m]; the origin if None. Epsilon depends on it.
            together: every contact pushes up to 1 (L-infinity) instead of 1 in total (L1).
        """
        M = self.measure(length, about)
        if not self.closure(margins=False):
            return GraspQuality(0.0, 0.0, np.zeros(self.rows), 0)
        if not together and not has_round_cones(self.contacts):
            return quality_of_wrenches(M @ self.matrix())
        found = quality_of_discs(ConeWrenches.of(self.contacts, M).discs, together=together)
        if found is None:
            raise MafsilError("grasp.no_quality")
        return found

    def volume(self, length: float = 1.0, facets: int = 16) -> float:
        """Volume of the hull of the wrenches of unit push; independent of the origin.

        Args:
            length: moments are divided by it [m].
            facets: edges of each cone.
        """
        return hull_volume(self.measure(length, None) @ self.matrix(facets))

    def measure(self, length: float, about: ArrayLike | None = None) -> Floats:
        """(m, m) what wrenches are multiplied by before they are compared: moments about a point, divided by a length.

        Args:
            length: [m].
            about: (d,) point [m]; the origin if None.
        """
        origin = np.zeros(self.dimension) if about is None else as_batch("about", about, (self.dimension,), finite=True)
        M = np.empty((self.rows, self.rows))
        loops.disc_loops.about(origin, positive("length", length), M)
        return M

    def _exact_columns(self) -> list[list[Any]] | None:
        """Columns up to positive factors, exactly as typed; None where cones have irrational edges."""
        if self.dimension == 3:
            if not self.frictionless:
                return None
            triples = [
                ([exact(v) for v in c.point.tolist()], [exact(v) for v in c.direction.tolist()]) for c in self.contacts
            ]
            return [
                [y * fz - z * fy, z * fx - x * fz, x * fy - y * fx, fx, fy, fz] for (x, y, z), (fx, fy, fz) in triples
            ]
        columns: list[list[Any]] = []
        for c in self.contacts:
            x, y = (exact(v) for v in c.point.tolist())
            nx, ny = (exact(v) for v in c.direction.tolist())
            mu = exact(c.mu)
            for sign in (-1, 1) if c.mu else (0,):
                fx, fy = nx - sign * mu * ny, ny + sign * mu * nx
                columns.append([x * fy - y * fx, fx, fy])
        return columns

    def explain(self, language: str | None = None) -> str:
        """The verdicts on force closure, form closure and second order, free motions and remarks: a sentence a line."""
        force, form = self.closure(), self.form_closure()
        lines = [force.explain(language)]
        lines.append(say("grasp.form_yes" if form else "grasp.form_no", language=language))
        if not form:
            lines.append(self._second_order_sentence(language))
        free = self.free_motions()
        lines += [say("grasp.free_both_ways", language=language, twist=vector(y)) for y in free.reversible]
        lines += [say("grasp.free_one_way", language=language, twist=vector(y)) for y in free.rays]
        lines += friction_remarks(self.contacts, language)
        lines.append(say("grasp.rigid", language=language))
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """In a notebook the contacts as a table's text."""
        return f"<pre>{escape(repr(self))}</pre>"

    def _second_order_sentence(self, language: str | None) -> str:
        """What second order says, and on which condition where the curvature of the body was not given."""
        found = self.second_order()
        if found.status is ImmobilityStatus.NO_EQUILIBRIUM or all(c.curvature_given for c in self.contacts):
            return found.explain(language)
        return say("grasp.if_flat", language=language, finding=found.explain(language))

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as `from_dict` reads it."""
        return {"name": self.name, "contact": [contact_data(c) for c in self.contacts]}

    def to_json(self) -> str:
        """The grasp as JSON text."""
        return json.dumps(self.to_dict(), ensure_ascii=False, indent=1)

    @staticmethod
    def from_dict(data: dict[str, Any]) -> Grasp:
        """A grasp from plain data.

        Args:
            data: as `to_dict` gives, or as in a grasp file.
        """
        found = parse_description(data, source="data")
        return Grasp(found.contacts, found.name)


def _members(item: Any, index: int) -> list[Contact]:
    """The contacts that one entry stands for."""
    if isinstance(item, Contact):
        return [item]
    kind: str = type(item).__name__
    several = isinstance(item, Sequence | np.ndarray) and not isinstance(item, str)
    entries: list[Any] = list(cast("Sequence[Any]", item)) if several else []
    if entries and all(isinstance(entry, Contact) for entry in entries):
        return [entry for entry in entries if isinstance(entry, Contact)]
    if not 2 <= len(entries) <= 4 or any(np.ndim(v) != 1 for v in entries[:2]):
        raise InputError("grasp.contact_entry", index=index, got=kind)
    return [Contact(*entries)]


def rank_grasps(
    grasps: Sequence[Grasp], length: float = 1.0, about: ArrayLike | None = None
) -> list[tuple[Grasp, GraspQuality]]:
    """Grasps of one body, the most robust first, each with its quality.

    Args:
        grasps: written in one frame.
        length: moments are divided by it [m].
        about: (d,) point of the moments; the origin if None.
    """
    rated = [(grasp, grasp.quality(length, about=about)) for grasp in grasps]
    return sorted(rated, key=lambda pair: -pair[1].epsilon)


def compare_under_load(
    grasps: Sequence[Grasp], wrench: ArrayLike, clearance: ArrayLike
) -> list[tuple[Grasp, RestPosition]]:
    """Fixtures of one body, the one that yields least under a load first: by the work the load does until it rests.

    Args:
        grasps: written in one frame.
        wrench: (m,) external (m, f) [N m, N].
        clearance: of every finger [m].
    """
    rated = [(grasp, grasp.rest_position(wrench, clearance)) for grasp in grasps]
    return sorted(rated, key=lambda pair: pair[1].work)
