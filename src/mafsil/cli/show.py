"""`mafsil show`: what a robot is made of; `mafsil list`: those of the library; `mafsil studio`: a page for one."""

from __future__ import annotations

import webbrowser
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil.cli.answer import Answer, draw_picture
from mafsil.cli.state import shown, unit
from mafsil.cli.table import brief, table
from mafsil.cli.tolerances import ROUNDOFF
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model import Joint, JointKind, Mechanism, library
from mafsil.model.loading import load_mechanism

if TYPE_CHECKING:
    import mafsil.page.show as pages
    import mafsil.studio.opening as opening
else:
    pages = lazily("mafsil.page.show")
    opening = lazily("mafsil.studio.opening")


LARGEST_PORT = 65535
_LETTERS = {JointKind.REVOLUTE: "R", JointKind.PRISMATIC: "P", JointKind.HELICAL: "H"}
PICTURES = (".html", ".png", ".svg", ".pdf")


def show(
    robot: str,
    tip: str | None,
    picture: str | None,
    degrees: bool,
    out: str | None = None,
    open: bool = False,
    view: list[str] | None = None,
) -> Answer:
    """Joints, limits, masses, screws, provenance and diagnostics of a robot.

    Args:
        robot: name or file.
        tip: another tip link.
        picture: file to draw it into (.html, .png, .svg, .pdf), or None.
        degrees: print angles in degrees.
        out: file for the page that runs the robot in a browser, or None.
        open: show that page in the browser.
        view: files with views of your own for that page.

    Raises:
        MafsilError: no such robot, a broken file, an unknown kind of picture, a view that cannot be read.
    """
    if picture is not None and Path(picture).suffix.lower() not in PICTURES:
        raise InputError("cli.picture_kind", path=picture, known=", ".join(PICTURES))
    mechanism = load_mechanism(robot, tip=tip)
    remarks = _diagnostics(robot)
    data = _data(mechanism, remarks)
    lines = [*_summary(mechanism), *_joints(mechanism, degrees), *_masses(mechanism), *_screws(mechanism)]
    lines += [*_provenance(mechanism), *_remarks(remarks)]
    if picture is not None:
        lines.append(draw_picture(partial(_draw, mechanism), picture, data))
    if out is not None or open:
        data["page"] = _page(robot, mechanism, out, view or (), show=open)
        lines.append(say("cli.page_written", path=data["page"]))
    return Answer(data, tuple(lines))


def _page(robot: str, mechanism: Mechanism, out: str | None, views: Sequence[str], *, show: bool) -> str:
    """Write the page, into a file of its own where none is named, and show it where that is wanted."""
    page = pages.show_as(mechanism, robot, views)
    if out is None:
        return str(page.open())
    path = page.write(out)
    if show:
        webbrowser.open(path.resolve().as_uri())
    return str(path)


def _summary(mechanism: Mechanism) -> list[str]:
    mass = sum(link.inertial.mass for link in mechanism.links if link.inertial)
    frames = len(mechanism.frame_names)
    links, loops = len(mechanism.links) - frames, len(mechanism.loops)
    counts = {"n": mechanism.n, "links": links, "frames": frames, "loops": loops}
    return [say("cli.show_title", language=None, **counts, robot=mechanism.name, mass=brief(mass), tip=mechanism.tip)]


def _joints(mechanism: Mechanism, degrees: bool) -> list[str]:
    head = [say(f"cli.{key}") for key in ("joint", "kind", "lower", "upper", "speed", "effort", "unit", "child")]
    rows: list[list[str]] = []
    for joint in mechanism.joints:
        bounds = joint.limits
        numbers = [brief(shown(x, joint.kind, degrees=degrees)) for x in (bounds.lower, bounds.upper, bounds.velocity)]
        known = [*numbers, brief(bounds.effort), unit(joint.kind, degrees=degrees)] if joint.moves else [""] * 5
        rows.append([joint.name, say(f"cli.kind_{joint.kind.value}") + _remark(joint), *known, joint.child])
    return ["", say("cli.joints"), *table(head, rows)]


def _remark(joint: Joint) -> str:
    if joint.mimic is not None:
        higher = "".join(f"{c:+g}·{joint.mimic.leader}^{k}" for k, c in enumerate(joint.mimic.higher, 2) if c)
        return f" = {joint.mimic.multiplier:g}·{joint.mimic.leader}{joint.mimic.offset:+g}{higher}"
    return "" if joint.actuated else " " + say("cli.passive")


def _masses(mechanism: Mechanism) -> list[str]:
    heavy = [(link.name, link.inertial) for link in mechanism.links if link.inertial is not None]
    if not heavy:
        return ["", say("cli.no_masses")]
    head = [say("cli.link"), say("cli.mass"), *(say("cli.com", axis=a) for a in "xyz"), "Ixx", "Iyy", "Izz"]
    rows = [[name, *(brief(float(x)) for x in (body.mass, *body.com, *np.diag(body.inertia)))] for name, body in heavy]
    return ["", say("cli.masses"), *table(head, rows)]


def _screws(mechanism: Mechanism) -> list[str]:
    if mechanism.loops:
        return ["", say("cli.screws_of_loops")]
    rows = [[name, *(brief(x) for x in screw)] for name, screw in space_screws(mechanism).items()]
    return [
        "",
        say("cli.screws"),
        *table([say("cli.joint"), *(f"ω{a}" for a in "xyz"), *(f"v{a}" for a in "xyz")], rows),
    ]


def space_screws(mechanism: Mechanism) -> dict[str, list[float]]:
    """Screw axis (omega, v) of each joint in {s} at q = 0, roundoff removed; none where loops may gape there."""
    if mechanism.loops:
        return {}
    poses = [np.asarray(mechanism.T_sb)]
    screws: dict[str, list[float]] = {}
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        T = poses[parent] @ joint.T_pj
        poses.append(T)
        if joint.moves:
            omega, v = T[:3, :3] @ joint.screw[:3], T[:3, :3] @ joint.screw[3:]
            both = np.concatenate([omega, v + np.cross(T[:3, 3], omega)])
            screws[joint.name] = [0.0 if abs(x) < ROUNDOFF else float(x) for x in both]
    return screws


def _provenance(mechanism: Mechanism) -> list[str]:
    origin = mechanism.provenance
    lines = ["", say("cli.provenance"), "  " + (origin.source or say("cli.unknown"))]
    if origin.licence:
        lines.append("  " + say("cli.licence", licence=origin.licence))
    return lines + [f"  - {note}" for note in origin.notes]


def _diagnostics(robot: str) -> list[Any]:
    """What the reader remarked about a robot file; nothing for a robot of the library."""
    match Path(robot).suffix.lower():
        case ".urdf":
            from mafsil.model import urdf

            return list(urdf.diagnose(Path(robot)))
        case ".xml" | ".mjcf":
            from mafsil.model import mjcf

            return list(mjcf.diagnose(Path(robot)))
        case _:
            return []


def _remarks(remarks: list[Any]) -> list[str]:
    if not remarks:
        return []
    return ["", say("cli.diagnostics"), *("  " + item.line_of_text() for item in remarks)]


def _data(mechanism: Mechanism, remarks: list[Any]) -> dict[str, Any]:
    return {
        "robot": mechanism.name,
        "n": mechanism.n,
        "tip": mechanism.tip,
        "gravity": mechanism.gravity,
        "joints": [_joint_data(joint) for joint in mechanism.joints],
        "links": [
            {
                "name": link.name,
                "mass": link.inertial.mass if link.inertial else None,
                "com": link.inertial.com if link.inertial else None,
                "inertia": link.inertial.inertia if link.inertial else None,
            }
            for link in mechanism.links
        ],
        "space_screws": space_screws(mechanism),
        "provenance": {
            "source": mechanism.provenance.source,
            "licence": mechanism.provenance.licence,
            "notes": list(mechanism.provenance.notes),
        },
        "diagnostics": [item.to_dict() for item in remarks],
    }


def _joint_data(joint: Joint) -> dict[str, Any]:
    bounds = {name: getattr(joint.limits, name) for name in ("lower", "upper", "velocity", "acceleration", "effort")}
    return {
        "name": joint.name,
        "kind": joint.kind.value,
        "parent": joint.parent,
        "child": joint.child,
        "pose_in_parent": joint.T_pj,
        "axis": joint.axis,
        "limits": {name: value if np.isfinite(value) else None for name, value in bounds.items()},
        "mimic": joint.mimic.leader if joint.mimic else None,
        "actuated": joint.actuated,
    }


def _draw(mechanism: Mechanism, path: Path) -> None:
    if path.suffix.lower() == ".html":
        from mafsil.page import show as page_of

        page_of(mechanism).write(path)
    elif path.suffix.lower() == ".png" and pages.chromium() is not None:
        pages.show_as(mechanism, mechanism.name).photograph(path)
    else:
        from mafsil.figures import plot_mechanism

        plot_mechanism(mechanism, path)


def robots() -> Answer:
    """Name, joints, freedoms, masses and description of every robot of the library."""
    entries = [_entry(name, library.load(name)) for name in library.robots()]
    head = [say(f"cli.{key}") for key in ("robot", "kinds", "has_masses", "described_as")]
    rows = [
        [
            entry["name"],
            entry["kinds"],
            say("cli.yes" if entry["masses"] else "cli.no"),
            say(f"library.{entry['name']}"),
        ]
        for entry in entries
    ]
    return Answer({"robots": entries}, (say("cli.list_title", count=len(entries)), *table(head, rows, words=(3,))))


def _entry(name: str, mechanism: Mechanism) -> dict[str, Any]:
    return {
        "name": name,
        "title": say(f"library.{name}"),
        "n": mechanism.n,
        "kinds": "".join(_LETTERS[joint.kind] for joint in mechanism.coordinates),
        "joints": list(mechanism.joint_names),
        "tip": mechanism.tip,
        "masses": any(link.inertial is not None for link in mechanism.links),
        "source": mechanism.provenance.source,
        "licence": mechanism.provenance.licence,
    }


def studio(what: list[str], port: str | None, open: bool, view: list[str] | None = None) -> Answer:
    """Serve until Ctrl-C.

    Args:
        what: a robot, a job file, or one or more recordings; the default robot if empty.
        port: at which to listen; any that is free if None.
        open: show the page in the browser.
        view: files with views of your own.

    Raises:
        MafsilError: what is given cannot be read, or the port is no port or is taken.
    """
    with opening.studio_of(what, _port(port), view or ()) as served:
        print(say("cli.studio_address", address=served.address), say("cli.studio_leave"), sep="\n", flush=True)
        served.serve(show=open)
    return Answer()


def _port(text: str | None) -> int:
    if text is None:
        return 0
    if not (text.isascii() and text.isdigit() and len(text) <= len(str(LARGEST_PORT))) or int(text) > LARGEST_PORT:
        raise InputError("studio.port", value=text, most=LARGEST_PORT)
    return int(text)
