"""Further worked numbers of part 03: every case, every key, through the public face."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import asin
from pathlib import Path

import numpy as np
import pytest

from mafsil.grasp import (
    Contact,
    ContactMotion,
    Grasp,
    line_contact,
    motion_within_clearance,
    three_fingers,
    two_fingers,
)

READ: set[tuple[str, ...]] = set()
ABOUT = {"id", "section", "what", "how"}
"""Keys that are words about the case."""


class Noted(Mapping):
    """A table that remembers which of its keys were read."""

    def __init__(self, data, path):
        self.data, self.path = data, path

    def __getitem__(self, key):
        READ.add((*self.path, key))
        value = self.data[key]
        return Noted(value, (*self.path, key)) if isinstance(value, dict) else value

    def __iter__(self):
        return iter(self.data)

    def __len__(self):
        return len(self.data)


RAW = {case["id"]: case for case in json.loads(Path(__file__).with_name("03-more.json").read_text())}
CASES = {name: Noted(case, (name,)) for name, case in RAW.items()}


def leaves(data, path):
    for key, value in data.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key)


def close(case, got, expected):
    assert np.shape(got) == np.shape(expected)
    assert np.asarray(got, float) == pytest.approx(np.asarray(expected, float), rel=case["tol"], abs=case["tol"])


@pytest.mark.capability("03-76", "03-4")
def test_wiggle_with_a_gap_of_its_own_at_each_contact():
    case = CASES["ch03-101-wiggle-unequal-clearances"]
    A = np.roll(np.array(case["inputs"]["A"]), 1, axis=0)
    found = motion_within_clearance(A, case["inputs"]["clearances"])
    want = case["expected"]
    assert found.bounded
    for row, name in ((1, "vx"), (2, "vy"), (0, "wz")):
        close(case, found.range[row], want["range"][name])
    corners = found.corners[:, [1, 2, 0]]
    close(case, corners[np.lexsort(np.round(corners, 9).T[::-1])], sorted(want["corners_vx_vy_wz"]))


@pytest.mark.capability("03-74", "03-67", "03-68")
def test_a_cone_without_section_leaves_the_moment_about_the_others():
    case = CASES["ch03-103-no-section-certificate"]
    given, want = case["inputs"], case["expected"]
    triples = zip(given["points"], given["normals"], given["mu"], strict=True)
    contacts = [Contact(p, n, mu) for p, n, mu in triples]
    found = three_fingers(contacts)
    close(case, [s.tilt for s in found.sections], np.abs(want["tilt_rad"]))
    close(case, [asin(c.normal[2]) for c in contacts], want["tilt_rad"])
    close(case, [c.alpha for c in contacts], want["alpha_rad"])
    assert [s.kind.value for s in found.sections] == want["section"]
    for section, half in zip(found.sections, want["half_angle_rad"], strict=True):
        assert section.half_angle == (0.0 if half is None else pytest.approx(half, abs=case["tol"]))
    assert found.force_closure is want["force_closure"] is Grasp(contacts).closure().force_closure
    y = found.certificate
    close(case, [*y[3:], *y[:3]], want["y_f_m"])
    for contact, (low, high) in zip(contacts, want["min_max_y_dot_w_unit_push"], strict=True):
        g = contact.basis.T @ y
        swing = contact.mu * np.hypot(g[1], g[2])
        close(case, [g[0] - swing, g[0] + swing], [low, high])


@pytest.mark.capability("03-78", "03-79", "03-61")
def test_nguyen_in_any_frame():
    case = CASES["ch03-105-nguyen-anywhere"]
    given, want = case["inputs"], case["expected"]
    first, second = (Contact(p, n, mu) for p, n, mu in zip(given["p"], given["n"], given["mu"], strict=True))
    found = two_fingers(first, second)
    close(case, np.degrees(found.theta), want["theta_deg"])
    close(case, np.degrees(found.delta), want["delta_deg"])
    assert found.force_closure is want["force_closure"]
    # Facets of the theorem: left and right of the line; of the contact: -mu and +mu along its tangent.
    x = found.combination
    close(case, x, want["null_vector_unit_edges_sum1"])
    assert np.abs(found.matrix @ x).max() < case["tol"]
    turned = Contact(second.point, given["n2_case_ii"], second.mu)
    open_ = two_fingers(first, turned)
    ii = want["case_ii"]
    close(case, np.degrees(open_.theta), ii["theta_deg"])
    assert open_.force_closure is ii["force_closure"] is Grasp([first, turned]).closure().force_closure
    y = open_.unresisted
    close(case, [*y[1:], y[0]], ii["y_fx_fy_m"])
    columns = Grasp([first, turned]).matrix(unit=True)
    close(case, np.sort(y @ columns), np.sort(ii["y_dot_columns"]))


@pytest.mark.capability("03-81", "03-8")
def test_a_pinch_with_its_weight_beside_the_middle():
    case = CASES["ch03-107-pinch-off-centre-weight"]
    given, want = case["inputs"], case["expected"]
    r, weight = given["r"], given["mass"] * given["g"]
    pinch = Grasp([Contact((-r, 0), (1, 0), given["mu"]), Contact((r, 0), (-1, 0), given["mu"])])
    for k, c in enumerate(given["c"]):
        load = [-c * weight, 0, -weight]
        held = pinch.resist(load)
        close(
            case,
            [contact.to_contact(f)[-1] for contact, f in zip(pinch.contacts, held.forces, strict=True)],
            2 * [want["N"][k]],
        )
        close(case, held.forces[:, 1], [want["f_t_left"][k], want["f_t_right"][k]])
        assert not pinch.resist(load, push=0.999 * want["N"][k]).holds


@pytest.mark.capability("03-51", "03-52", "03-53")
def test_motions_of_the_contacts():
    case = CASES["ch03-109-contact-motions"]
    grasp = Grasp([Contact(c["p"], c["n"]) for c in case["inputs"]["contacts"]])
    words = {
        ContactMotion.BREAKING: "breaking",
        ContactMotion.PENETRATING: "penetrating",
        ContactMotion.SLIDING: "keeps: sliding",
        ContactMotion.ROLLING: "keeps: rolling",
    }
    table = case["expected"]["table"]
    assert [row["twist"] for row in table] == case["inputs"]["twists_vx_vy_wz"]
    for row in table:
        assert set(row) == {"twist", "v_dot_n", "motion"}
        vx, vy, wz = row["twist"]
        close(case, np.array([wz, vx, vy]) @ grasp.normals_matrix, row["v_dot_n"])
        assert [words[m] for m in grasp.contact_motions([wz, vx, vy])] == row["motion"]


@pytest.mark.capability("03-87", "03-13")
def test_a_box_on_a_floor_slides_or_tips():
    case = CASES["ch03-111-line-contact-box-on-floor"]
    given, want = case["inputs"], case["expected"]
    a, weight = given["a"], given["weight"]
    floor = Grasp([line_contact((-a, 0), (a, 0), (0, 1), given["mu"])])

    def holds(push, height):
        return floor.resist([-push * height, push, -weight]).holds

    assert [holds(c["F"], c["height"]) for c in given["cases"]] == want["holds"]
    assert {key for c in given["cases"] for key in c} == {"height", "F"}
    for label in want["limit"]:
        verb, at, limit = want["limit"][label].split()
        height = float(label.removeprefix("h="))
        slides, tips = given["mu"] * weight, weight * a / height
        assert (verb, at) == ("slides" if slides < tips else "tips", "at")
        assert float(limit) == pytest.approx(min(slides, tips), abs=case["tol"])
        assert holds(float(limit) * (1 - 1e-6), height)
        assert not holds(float(limit) * (1 + 1e-6), height)


def test_zz_every_key_of_every_case_was_read():
    """Last in the file: run alone it has nothing to check, so the others are run first."""
    for name, task in list(globals().items()):
        if name.startswith("test_") and name != "test_zz_every_key_of_every_case_was_read":
            task()
    unread = [
        path
        for name, case in RAW.items()
        for path in leaves(case, (name,))
        if path[1] not in ABOUT and path not in READ
    ]
    assert unread == []
