"""Second order: a body that first order leaves free can still be held by the curvature at its contacts.

Along a first-order free motion y = (omega, v) the distance at a contact that y keeps opens like s^2/2 times

  d'' = v_t' K v_t - u' v_t - (K v_t - u)' (K + F)^-1 (K v_t - u),   u = n x omega

with the tangential velocity v_t of the contact point and the curvatures K of the body and F of the finger; in the
plane this is (f v_t - omega)(omega + k v_t)/(k + f). By Farkas, no acceleration saves y if and only if some
equilibrium of pushes x >= 0 makes sum x_i d_i''(y) < 0. One x and weights N >= 0 of products of the opening rates of
contacts that no equilibrium loads, with

  sum x_i d_i'' + sum N_pq (w_p . y)(w_q . y)   negative definite

on the motions that keep all loaded contacts, serve every y at once: the proof. It is found by a linear program whose
rows are the directions in which the last form was not negative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.grasp.clearance import extreme_rays
from mafsil.grasp.closure import Closure, conditioning, vector
from mafsil.grasp.contact import Contact
from mafsil.grasp.tolerances import OPTIMUM, TYPED
from mafsil.messages import say
from mafsil.solvers.linear_program import minimise

ROUNDS = 60
MOST_WEIGHT = 1e4
"""Of the products of rates, in units of the largest form."""
LOOKED_AT = 720
"""Directions in which a motion that stays possible is looked for."""
MOST_EQUILIBRIA = 16
"""Loaded contacts up to which the corner points of the equilibria are listed."""


class ImmobilityStatus(Status):
    """What makes the body immobile, if it is proven to be so."""

    FIRST_ORDER = ("grasp.first_order", True)
    SECOND_ORDER = ("grasp.second_order", True)
    NOT_SHOWN = ("grasp.not_immobile", False)
    NO_EQUILIBRIUM = ("grasp.no_equilibrium", False)


@dataclass(frozen=True, eq=False, repr=False)
class SecondOrderClosure(Answer, data="immobile pushes motion"):
    """Immobility to first or second order and its proof; true if the body is proven to be immobile.

    Attributes:
        status: first order, second order, or not shown.
        pushes: (n,) equilibrium of pushes of the proof, sum 1; zero if there is none.
        motions: (k, m) orthonormal basis of the twists that keep every contact which some equilibrium loads.
        form: (k, k) quadratic form sum x_i d_i'' on that basis.
        products: (n, n) symmetric weights >= 0 of products of the rates at contacts that no equilibrium loads: form
            plus sum products_pq (w_p . y)(w_q . y) is negative definite if immobile to second order.
        motion: (m,) a twist that both orders leave free, if one was found: the body is proven to be movable.
    """

    status: ImmobilityStatus
    pushes: Floats
    motions: Floats
    form: Floats
    products: Floats
    motion: Floats | None = None

    @property
    def immobile(self) -> bool:
        """Whether the body is proven to be immobile."""
        return self.status.succeeded

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence, with the motion that is left if one is known."""
        if self.status is ImmobilityStatus.NOT_SHOWN and self.motion is not None:
            return say("grasp.second_order_free", language=language, twist=vector(self.motion))
        return self.status.sentence(language)


class HasContacts(Protocol):
    """What second order asks of a grasp."""

    contacts: tuple[Contact, ...]

    def form_closure(self) -> Closure:
        """The verdict of first order."""
        ...


def second_order(grasp: HasContacts) -> SecondOrderClosure:
    """Is a body immobile without friction, if not to first order then by curvature? In the plane and in space.

    1. First order: form closure.
    2. A linear program finds the contacts that some equilibrium of pushes loads, and the twists that keep them.
    3. Opening rates of second order are symmetric forms on these twists.
    4. Linear programs with cutting planes look for pushes and weights that make the form negative definite: the proof.
    5. Without one, a motion that both orders leave free is looked for.

    Adding a contact never frees a body: it adds equilibria or takes motions away, and the old proof stays one.

    Args:
        grasp: curvatures of body and fingers as the contacts tell; flat and pointed if they do not.

    Raises:
        InputError: curvatures of a loaded contact by which body and finger overlap.

    Reference:
        E. Rimon, J. W. Burdick, Mobility of bodies in contact, IEEE Trans. Robotics and Automation 14(5), 1998.
    """
    contacts = grasp.contacts
    n, m = len(contacts), 3 * (contacts[0].dimension - 1)

    def unloaded(status: ImmobilityStatus) -> SecondOrderClosure:
        return SecondOrderClosure(status, np.zeros(n), np.zeros((0, m)), np.zeros((0, 0)), np.zeros((n, n)))

    if grasp.form_closure():  # 1
        return unloaded(ImmobilityStatus.FIRST_ORDER)
    loads = _loads(contacts)  # 2
    if not loads.loaded.any():
        return unloaded(ImmobilityStatus.NO_EQUILIBRIUM)
    if not len(loads.motions):
        return unloaded(ImmobilityStatus.FIRST_ORDER)
    pressed = [c for c, on in zip(contacts, loads.loaded, strict=True) if on]
    sizes, twists = loads.sizes[loads.loaded], loads.motions @ loads.frame  # 3
    forms = np.array([opening(c, twists) / size for c, size in zip(pressed, sizes, strict=True)])
    scale = max(_term_size(c, twists) / size for c, size in zip(pressed, sizes, strict=True))
    proof = _proof(loads, forms / scale if scale > 0 else forms)  # 4
    x, weights = (loads.even, None) if proof is None else proof
    share = 1.0 / float((x / sizes).sum())
    pushes = np.zeros(n)
    pushes[loads.loaded] = share * x / sizes
    basis = np.linalg.qr(twists.T)[0].T
    form = np.einsum("i,ijk->jk", pushes[loads.loaded], np.array([opening(c, basis) for c in pressed]))
    products = np.zeros((n, n))
    if weights is not None:
        rest = np.flatnonzero(~loads.loaded)
        products[np.ix_(rest, rest)] = share * scale * weights / np.outer(loads.sizes[rest], loads.sizes[rest])
        return SecondOrderClosure(ImmobilityStatus.SECOND_ORDER, pushes, basis, form, products)
    motion = _motion_left(loads, forms / scale) if scale > 0 else None  # 5
    return SecondOrderClosure(ImmobilityStatus.NOT_SHOWN, pushes, basis, form, products, motion)


@dataclass(frozen=True, eq=False)
class _Loads:
    """Equilibria, in wrenches about the middle of the contacts that are scaled to length 1.

    Attributes:
        frame: (m, m) of the scaling: twists y of the scaled frame are y @ frame outside.
        sizes: (n,) lengths of the wrenches before.
        loaded: (n,) contacts that some equilibrium loads.
        equilibria: (loaded, q) basis of the pushes that balance.
        even: (loaded,) one equilibrium, all > 0.
        motions: (k, m) orthonormal twists that keep the loaded contacts.
        rates: (n - loaded, k) of the other contacts along them.
    """

    frame: Floats
    sizes: Floats
    loaded: np.ndarray[tuple[int], np.dtype[np.bool_]]
    equilibria: Floats
    even: Floats
    motions: Floats
    rates: Floats


def _loads(contacts: Sequence[Contact]) -> _Loads:
    T = conditioning([c.point for c in contacts])
    W = T @ np.column_stack([c.basis[:, 0] for c in contacts])
    sizes = np.linalg.norm(W, axis=0)
    W = W / sizes
    m, n = W.shape
    U, s, _ = np.linalg.svd(W)
    rank = int((s > TYPED * s[0]).sum())
    S = U[:, :rank].T @ W
    # max sum t with S x = 0, 0 <= t <= 1, t <= x: t is 1 where some equilibrium pushes and 0 elsewhere.
    eye, none = np.eye(n), np.zeros((n, n))
    best = minimise(
        np.append(np.zeros(n), -np.ones(n)), np.hstack([S, np.zeros((rank, n))]), np.zeros(rank),
        np.block([[-eye, eye], [none, eye]]), np.append(np.zeros(n), np.ones(n)),
    )  # fmt: skip
    assert best is not None, "no push at all is a solution"
    loaded = best.x[n:] > 0.5
    x = best.x[:n][loaded]
    if not loaded.any():
        return _Loads(T, sizes, loaded, np.zeros((0, 0)), x, np.zeros((0, m)), np.zeros((n, 0)))
    V, rates_kept, Zt = np.linalg.svd(W[:, loaded], full_matrices=True)
    kept = int((rates_kept > TYPED * rates_kept[0]).sum())
    motions = V[:, kept:].T
    rates = W[:, ~loaded].T @ motions.T
    return _Loads(T, sizes, loaded, Zt[kept:].T, x / x.sum(), motions, np.where(np.abs(rates) < TYPED, 0.0, rates))


def _proof(loads: _Loads, forms: Floats) -> tuple[Floats, Floats] | None:
    """Pushes and weights of products of rates that make the form negative definite; None if there are none."""
    Z, R = loads.equilibria, loads.rates
    q, k = Z.shape[1], len(loads.motions)
    p, r = np.triu_indices(len(R))
    by_z = np.einsum("iq,ijk->qjk", Z, forms)
    by_product = 0.5 * (R[p][:, :, None] * R[r][:, None, :] + R[r][:, :, None] * R[p][:, None, :])
    cuts = list(np.linalg.eigh(np.einsum("i,ijk->jk", loads.even, forms))[1].T)
    cost = np.append(np.zeros(len(p) + q), -1.0)
    equal = np.append(np.zeros(len(p)), [*Z.sum(axis=0), 0.0])[None]
    bounds = [
        np.hstack([np.zeros((len(Z), len(p))), -Z, np.zeros((len(Z), 1))]),
        np.append(np.zeros(len(p) + q), 1.0)[None],
        np.append(np.ones(len(p)), np.zeros(q + 1))[None],
    ]
    limits = np.append(np.zeros(len(Z)), [1.0, MOST_WEIGHT])
    for _ in range(ROUNDS):
        v = np.array(cuts)
        rows = np.column_stack([
            np.einsum("cj,pjk,ck->cp", v, by_product, v), np.einsum("cj,qjk,ck->cq", v, by_z, v), np.ones(len(v)),
        ])  # fmt: skip
        best = minimise(cost, equal, np.ones(1), np.vstack([*bounds, rows]), np.append(limits, np.zeros(len(v))), q + 1)
        if best is None or best.x[-1] <= OPTIMUM:
            return None
        weights, z = best.x[: len(p)], best.x[len(p) : -1]
        x = np.maximum(Z @ z, 0.0)
        form = np.einsum("i,ijk->jk", x, forms) + np.einsum("p,pjk->jk", weights, by_product)
        values, directions = np.linalg.eigh(form)
        if values[-1] < -OPTIMUM and values[-1] < -0.1 * best.x[-1]:
            table = np.zeros((len(R), len(R)))
            table[p, r] += 0.5 * weights
            table[r, p] += 0.5 * weights
            return x, table
        cuts += [directions[:, j] for j in range(k) if values[j] > -0.9 * best.x[-1]]
    return None


def _motion_left(loads: _Loads, forms: Floats) -> Floats | None:
    """A twist along which every equilibrium lets the contacts open, among those looked at; None if none was seen."""
    k, Z = len(loads.motions), loads.equilibria
    if len(Z) > MOST_EQUILIBRIA:
        return None
    corners = extreme_rays(Z) @ Z.T
    corners = corners / corners.sum(axis=1, keepdims=True)
    if k == 1:
        looked = np.array([[1.0], [-1.0]])
    elif k == 2:
        angles = 2 * np.pi * np.arange(LOOKED_AT) / LOOKED_AT
        looked = np.column_stack([np.cos(angles), np.sin(angles)])
    else:
        looked = np.random.default_rng(1998).normal(size=(LOOKED_AT, k))
        looked /= np.linalg.norm(looked, axis=1)[:, None]
    own = np.linalg.eigh(np.einsum("i,ijk->jk", loads.even, forms))[1].T
    looked = np.vstack([looked, own, -own])
    looked = looked[(looked @ loads.rates.T >= 0.0).all(axis=1)]
    if not len(looked):
        return None
    opens = (np.einsum("cj,ijk,ck->ci", looked, forms, looked) @ corners.T).min(axis=1)
    if not opens.max() > OPTIMUM:
        return None
    twist = looked[int(np.argmax(opens))] @ loads.motions @ loads.frame
    return twist / np.linalg.norm(twist)


def opening(contact: Contact, motions: Floats) -> Floats:
    """(k, k) symmetric form of d'' on twists that keep the contact.

    Args:
        contact: with the curvatures of body and finger.
        motions: (k, m) twists (omega, v) in rows.

    Raises:
        InputError: curvatures by which body and finger overlap.
    """
    sideways, lean = _rates(contact, motions)
    K, F = contact.shape, contact.finger_shape
    form = sideways @ K @ sideways.T - 0.5 * (lean @ sideways.T + sideways @ lean.T)
    if F is None:
        return form
    if np.linalg.eigvalsh(K + F).min() <= 0:
        raise InputError("grasp.curvatures", body=_least(K), finger=_least(F))
    turned = sideways @ K - lean
    return form - turned @ np.linalg.inv(K + F) @ turned.T


def _rates(contact: Contact, motions: Floats) -> tuple[Floats, Floats]:
    """(k, d - 1) tangential velocities v_t and leans u = n x omega, along the contact's tangents."""
    d = contact.dimension
    omega, v = motions[:, : 2 * d - 3], motions[:, 2 * d - 3 :]
    if d == 2:
        velocity = v + omega * np.array([-contact.point[1], contact.point[0]])
        return velocity @ contact.tangents.T, -omega
    velocity = v + np.cross(omega, contact.point)
    return velocity @ contact.tangents.T, np.cross(contact.normal, omega) @ contact.tangents.T


def _term_size(contact: Contact, motions: Floats) -> float:
    """Size of the terms that may cancel in d''."""
    sideways, lean = (float(np.linalg.norm(part)) for part in _rates(contact, motions))
    bend = float(np.linalg.norm(contact.shape))
    return sideways * (bend * sideways + lean)


def _least(K: Floats) -> float:
    return float(np.linalg.eigvalsh(K).min())
