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
