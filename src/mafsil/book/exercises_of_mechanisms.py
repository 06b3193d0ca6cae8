"""Families of exercises for chapters 2 and 3: mobility, contacts, grasps."""

from __future__ import annotations

from typing import Any

import numpy as np

from mafsil.book.family import Draw, Task, asks
from mafsil.book.judging import ask
from mafsil.grasp import Contact, Grasp, two_fingers
from mafsil.mobility import gruebler_count

LEGS = {
    "UPS": (2, 1, 3), "SPS": (3, 1, 3), "UPU": (2, 1, 2), "RUS": (1, 2, 3), "PUS": (1, 2, 3), "RPS": (1, 1, 3),
    "PRS": (1, 1, 3),
}  # fmt: skip
"""Freedoms of the three joints of a leg by its kind."""


@asks("2.2.1 linkage")
def linkage(draw: Draw) -> Task | None:
    """Mobility of a planar linkage."""
    links, slots, mobility = draw.whole(4, 5 + 2 * draw.level), draw.whole(0, 2 * draw.level - 2), draw.whole(1, 3)
    pins, odd = divmod(3 * (links - 1) - slots - mobility, 2)
    if odd or pins + slots < links - 1:
        return None
    sliders = draw.whole(0, min(pins, 2))
    freedoms = [1] * pins + [2] * slots
    M = int(gruebler_count(links, freedoms, "planar").mobility)
    joints = pins + slots
    inner = links - 1 - joints
    mistakes: dict[str, Any] = ({"two_as_one": M - slots} if slots else {}) | (
        {"spatial_rule": M + 3 * inner} if inner < -1 else {}
    )
    return Task(
        {"links": links, "pins": pins - sliders, "sliders": sliders, "slots": slots, "joints": joints,
         "total": sum(freedoms), "inner": inner, "M": M},
        [
            ask("mobility", M, ground_moves=M + 3, ground_left_out=M - 3, **mistakes),
            ask("loops", -inner, ground_left_out=1 - inner, loops_no_one=-inner - 1),
        ],
    )  # fmt: skip


@asks("2.2.1 platform")
def platform(draw: Draw) -> Task:
    """Mobility of a platform on equal legs, and its idle freedoms."""
    legs, kind = draw.choice((3, 6) if draw.level == 1 else (3, 4, 5, 6)), draw.choice(sorted(LEGS))
    freedoms, links = LEGS[kind], 2 + 2 * legs
    M = int(gruebler_count(links, list(freedoms) * legs, "spatial").mobility)
    idle = legs if kind == "SPS" else 0
    mistakes: dict[str, Any] = {} if legs == 3 else {"planar_rule": M - 3 * (1 - legs)}
    return Task(
        {"legs": legs, "kind": kind, "links": links, "joints": 3 * legs, "total": legs * sum(freedoms), "M": M,
         "idle": idle, "each": sum(freedoms)},
        [
            ask("mobility", M, ground_moves=M + 6, ground_left_out=M - 6, **mistakes),
            ask("idle", idle),
        ],
    )  # fmt: skip


@asks("3.2.2 four contacts")
def four_contacts(draw: Draw) -> Task:
    """A rectangle between four frictionless pins: one wrench, and force closure."""
    w, h = draw.number(0.4, 1.2), draw.number(0.3, 0.9)
    x, y = draw.numbers(2, 0.1, w - 0.1, 0.05), draw.numbers(2, 0.1, h - 0.1, 0.05)
    points = np.array([[x[0], 0.0], [w, y[0]], [x[1], h], [0.0, y[1]]])
    normals = np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]])
    grasp = Grasp([Contact(p, n) for p, n in zip(points, normals, strict=True)])
    wrenches, k = np.asarray(grasp.matrix()).T, draw.whole(0, 3)
    (m, fx, fy), (px, py), (nx, ny) = wrenches[k], points[k], normals[k]
    return Task(
        {"w": w, "h": h, **{f"p{i + 1}": point for i, point in enumerate(points)}, "k": k + 1, "n": normals[k],
         "moments": wrenches[:, 0], "F": wrenches[k]},
        [
            ask("contact_wrench", wrenches[k], cross_order=[-m, fx, fy], outward=[-m, -fx, -fy],
                  dot_for_cross=[px * nx + py * ny, fx, fy], moment_last=[fx, fy, m]),
            ask("closure", bool(grasp.closure())),
        ],
    )  # fmt: skip


@asks("3.3.3 two fingers", unknown="mu")
def two_contacts(draw: Draw) -> Task:
    """Two fingers with friction: friction angle and Nguyen's test."""
    mu, width, shift = draw.number(0.3, 1.0, 0.05), draw.number(0.4, 1.0), draw.number(-0.5, 0.5, 0.05)
    tilt = 0 if draw.level == 1 else draw.whole(-6, 6) * 5
    normal = np.array([-np.cos(np.radians(tilt)), -np.sin(np.radians(tilt))])
    verdict = two_fingers(Contact([0.0, 0.0], [1.0, 0.0], mu), Contact([width, shift], normal, mu))
    line = np.degrees(np.arctan2(shift, width))
    beta = float(np.arctan(mu))
    return Task(
        {"mu": mu, "width": width, "shift": shift, "tilt": tilt, "line": line, "off": line - tilt,
         "beta": np.degrees(beta)},
        [
            ask("friction_angle", beta, "rad", sine_for_tangent=np.arcsin(min(mu, 1.0)), mu_as_angle=mu,
                  cone_width=2 * beta),
            ask("closure", bool(verdict)),
        ],
    )  # fmt: skip


@asks("3.1 slip", unknown="f_t f_n")
def slip(draw: Draw) -> Task:
    """Angle of a contact force, and whether the contact slips."""
    f_t, f_n, mu = draw.number(0.5, 9, 0.5), draw.number(1, 9, 0.5), draw.number(0.2, 1.2)
    ratio = f_t / f_n
    return Task(
        {"f_t": f_t, "f_n": f_n, "mu": mu, "ratio": ratio, "beta": np.arctan(ratio), "alpha": np.arctan(mu)},
        [
            ask("force_angle", np.arctan(ratio), "rad", reciprocal=np.arctan(1 / ratio), mu_as_angle=ratio),
            ask("slips", bool(ratio > mu)),
        ],
    )


@asks("3.3.1 squeeze", unknown="m mu")
def squeeze(draw: Draw) -> Task:
    """Normal force of two fingers that hold a weight by friction."""
    m, mu = draw.number(0.2, 5), draw.number(0.2, 0.9, 0.05)
    force = m * 9.81 / (2 * mu)
    return Task(
        {"m": m, "mu": mu, "weight": m * 9.81, "half": m * 9.81 / 2, "force": force},
        [ask("squeeze", force, "N", not_halved=2 * force, no_g=force / 9.81, friction_times=m * 9.81 * mu / 2)],
    )


@asks("2.1 points")
def points_of_body(draw: Draw) -> Task:
    """Independent constraints among points of a rigid body."""
    space, count = draw.choice((2, 3)), draw.whole(5, 6 + draw.level)
    pairs = [(i, j) for i in range(count) for j in range(i)]
    points, rows = draw.numbers(space * count, -2, 2, 0.01).reshape(count, space), np.zeros((len(pairs), count, space))
    for row, (i, j) in zip(rows, pairs, strict=True):
        row[i], row[j] = points[i] - points[j], points[j] - points[i]
    independent = int(np.linalg.matrix_rank(rows.reshape(len(pairs), -1)))
    other = space * count - (3 if space == 3 else 6)
    return Task(
        {"count": count, "space": space, "coordinates": space * count, "distances": len(pairs)},
        [ask("independent", independent, all_distances=len(pairs), other_space=other, coordinates_alone=space * count)],
    )


@asks("2.2.2 coordinates")
def coordinates(draw: Draw) -> Task:
    """Explicit and implicit coordinates of the configuration space of a chain."""
    revolute, prismatic = draw.whole(2, 3 + draw.level), draw.whole(1, 2)
    return Task(
        {"revolute": revolute, "prismatic": prismatic, "n": revolute + prismatic},
        [
            ask("dimension", revolute + prismatic, circles_alone=revolute, circle_as_plane=2 * revolute + prismatic),
            ask("implicit", 2 * revolute + prismatic, circle_as_line=revolute + prismatic, circles_alone=2 * revolute),
        ],
    )


@asks("2.2.3 constraints")
def constraints(draw: Draw) -> Task:
    """Freedoms of position and of velocity under holonomic and nonholonomic constraints."""
    n, holonomic, rolling = draw.whole(6, 7 + draw.level), draw.whole(1, 2), draw.whole(1, 3)
    rates = n - holonomic - rolling
    return Task(
        {"n": n, "holonomic": holonomic, "rolling": rolling, "all": holonomic + rolling},
        [
            ask("positions", n - holonomic, rolling_as_holonomic=rates, all_coordinates=n),
            ask("velocities", rates, rolling_left_out=n - holonomic, all_coordinates=n),
        ],
    )


@asks("2.2.4 reach", unknown="L1")
def reach(draw: Draw) -> Task | None:
    """Radii and area of the workspace of a planar 2R arm."""
    L1, L2 = draw.number(0.7, 1.5), draw.number(0.2, 0.6)
    return Task(
        {"L1": L1, "L2": L2, "outer": L1 + L2, "inner": L1 - L2},
        [
            ask("inner_radius", L1 - L2, "m", other_radius=L1 + L2, second_link=L2),
            ask("reach_area", np.pi * ((L1 + L2) ** 2 - (L1 - L2) ** 2), "m²", hole_left_out=np.pi * (L1 + L2) ** 2,
                radii_not_squared=2 * np.pi * L2),
        ],
    )  # fmt: skip


@asks("3.2.1 supports")
def supports(draw: Draw) -> Task | None:
    """Forces of two frictionless supports under a weight."""
    weight, a, b = draw.number(10, 90, 5.0), draw.number(0.1, 0.9), draw.number(0.1, 0.9)
    if a == b:
        return None
    F = np.asarray(Grasp([Contact([x, 0.0], [0.0, 1.0]) for x in (0.0, a + b)]).matrix())
    x = np.linalg.lstsq(F, [a * weight, 0.0, weight], rcond=None)[0]
    return Task(
        {"weight": weight, "a": a, "b": b, "span": a + b, "x": x},
        [ask("supports", x, "N", arms_swapped=x[::-1], halves=[weight / 2, weight / 2])],
    )


@asks("3.2.3 hull")
def hull(draw: Draw) -> Task | None:
    """The combination of three forces that is zero, and whether the origin lies inside their hull."""
    f = draw.numbers(6, -3, 3, 0.5).reshape(3, 2)
    rows = np.vstack([f.T, np.ones(3)])
    if abs(np.linalg.det(rows)) < 1 or min(abs(np.linalg.det(f[[i, j]])) for i, j in ((0, 1), (0, 2), (1, 2))) < 1:
        return None
    weights = np.linalg.solve(rows, [0.0, 0.0, 1.0])
    return Task(
        {"f1": f[0], "f2": f[1], "f3": f[2], "weights": weights},
        [
            ask("weights", weights, not_normalised=weights / weights[2], cyclic=np.roll(weights, 1)),
            ask("inside", bool((weights > 0).all())),
        ],
    )


@asks("3.2.4 elimination", unknown="d")
def elimination(draw: Draw) -> Task | None:
    """One step of elimination."""
    a, b, c, d = draw.number(1, 6, 1.0), draw.number(1, 6, 1.0), draw.number(-6, 6, 1.0), draw.number(1, 9, 1.0)
    reduced = d - c / a * b
    return None if abs(reduced) < 0.5 or a == abs(c) else Task(
        {"a": a, "b": b, "c": c, "d": d, "ratio": c / a, "reduced": reduced},
        [
            ask("multiplier", c / a, reciprocal=a / c, quotient_left_out=c),
            ask("reduced", reduced, term_sign=d + c / a * b, reciprocal=d - a / c * b),
        ],
    )  # fmt: skip


@asks("3.3.2 edges")
def edges(draw: Draw) -> Task:
    """Wrenches of the two edges of a friction cone."""
    mu, (x, y) = draw.number(0.2, 0.9, 0.05), draw.numbers(2, -1, 1)
    wrenches = np.array([[x - s * y, s, 1.0] for s in (mu * 1.0, -mu)])
    half = np.array([[x - s * y, s, 1.0] for s in (np.arctan(mu), -np.arctan(mu))])
    return Task(
        {"mu": mu, "p": [x, y], "w1": wrenches[0], "w2": wrenches[1]},
        [ask("edge_wrenches", wrenches, unordered=True, cross_order=wrenches * [-1, 1, 1],
             moment_last=wrenches[:, [1, 2, 0]], angle_for_tangent=half)],
    )  # fmt: skip


@asks("3.3.4 plane")
def plane(draw: Draw) -> Task | None:
    """The plane of three contacts."""
    a, b, c = draw.numbers(9, -1, 1).reshape(3, 3)
    normal = np.cross(b - a, c - a)
    if np.linalg.norm(normal) < 0.3:
        return None
    unit, between = normal / np.linalg.norm(normal), b + c - 2 * a
    return Task(
        {"a": a, "b": b, "c": c, "ab": b - a, "ac": c - a, "cross": normal},
        [ask("normal", unit, twin=np.negative, not_unit=normal, edges_added=between / np.linalg.norm(between),
             points_for_edges=np.cross(b, c))],
    )  # fmt: skip
