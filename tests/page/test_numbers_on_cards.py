"""Every number on every card of a page against Python's own, to the last digit that is shown."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.arrays import Floats
from mafsil.geometry import rotation
from mafsil.mobility.library import four_bar
from mafsil.model import JointKind
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.page import Session, show
from mafsil.page.arm import Arm
from mafsil.parallel import ClosedChain
from mafsil.scene.modules import read
from tests.page.browser import Browser
from tests.page.test_pages_of_loops import LEGS, PALLETISER
from tests.sizes import few

ROBOTS: dict[str, Any] = {
    name: name
    for name in (
        "panda", "ur5e", "puma560", "iiwa7", "scara_rrrp", "stanford_arm", "planar2r", "rrprrr",
        "examples/robots/ur5.urdf",
    )
} | {"palletiser": PALLETISER, "four_bar": four_bar(), "stewart": LEGS}  # fmt: skip
READ = """((selector, root = document) => [...root.querySelectorAll(selector)]
  .map((e) => (e.tagName === 'INPUT' ? e.value : e.textContent).replaceAll('−', '-').replaceAll('∞', 'inf')))"""
FEWEST = {"joints": 2, "pose": 28, "jacobian": 6, "tree": 4, "grasp": 2}
"""Numbers that stand on each card of every robot at least."""
WITHOUT_NUMBERS = {"code", "loops", "plot"}
"""Cards that hold lines of Python, sentences, and a canvas."""
CARDS = "[...document.querySelectorAll('#views > details')].map(e => e.id.slice(5))"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("numbers"), (1280, 800)) as found:
        yield found
        assert not found.errors


class Card:
    """The numbers of a page, read one after the other."""

    def __init__(self, browser: Browser, name: str) -> None:
        self.browser, self.name, self.count = browser, name, 0

    def read(self, selector: str) -> list[str]:
        root = "#tree" if self.name == "tree" else f"#view-{self.name}"
        return self.browser.ask(f"{READ}({selector!r}, document.querySelector('{root}'))")

    def equal(self, selector: str, wanted: Floats | list[float]) -> None:
        """The numbers in the texts of these elements, in their order, each to the last digit that it shows."""
        words = [word for text in self.read(selector) for word in text.replace("(", " ").replace(")", " ").split()]
        shown = [word.strip(",") for word in words if is_number(word.strip(","))]
        assert len(shown) == np.size(wanted), (self.name, selector, shown, wanted)
        self.count += len(shown)
        for text, value in zip(shown, np.ravel(wanted).tolist(), strict=True):
            ulp = 10.0 ** -len(text.partition(".")[2].partition("e")[0])
            assert float(text) == pytest.approx(value, rel=1e-9, abs=0.5 * ulp + 2e-7), (
                self.name,
                selector,
                text,
                value,
            )


def is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize("name", few(ROBOTS, 4))
def test_every_number_on_every_card_is_that_of_python(browser: Browser, tmp_path: Path, name: str) -> None:
    page = show(ROBOTS[name], language="en")
    session, rng, counts = Session(page.robot), np.random.default_rng(7), dict[str, int]()
    browser.load(page.write(tmp_path / "page.html"))
    for angle, length in (("rad", "m"), ("deg", "mm")):
        browser.ask(f"mafsil.measure({{ angle: '{angle}', length: '{length}' }})")
        for _ in range(3):
            lead_somewhere(session, browser, rng)
            shown = set(browser.ask(CARDS))
            assert shown <= WITHOUT_NUMBERS | CHECKS.keys(), "a card whose numbers nobody checks"
            for name_of_card, check in CHECKS.items():
                card = Card(browser, name_of_card)
                if card.name != "tree":
                    if card.name not in shown:
                        continue
                    browser.ask(f"mafsil.unfold('{card.name}'); mafsil.frame(performance.now())")
                check(
                    card, session.arm, session.q, (1.0 if angle == "rad" else degrees(1), 1.0 if length == "m" else 1e3)
                )
                counts[card.name] = card.count
    assert all(counts[card] >= count for card, count in FEWEST.items())


def lead_somewhere(session: Session, browser: Browser, rng: np.random.Generator) -> None:
    """A random configuration, or a driven joint a bit further; the same in the page and in Python."""
    robot = session.arm.robot
    if (driven := session.arm.settings["driven"]) is not None:
        joint, step = int(rng.choice(driven)), 0.1 * float(rng.uniform(-1, 1))
        action = {"do": "set_joint", "with": {"joint": joint, "value": float(session.q[joint] + step)}}
    else:
        bounds = np.clip([robot.limits.lower, robot.limits.upper], -2.0, 2.0)
        action = {"do": "set_joints", "with": {"values": rng.uniform(*bounds).tolist()}}
    session.do([action])
    browser.ask(f"mafsil.store.do('{action['do']}', {action['with']})")
    assert browser.ask("Array.from(mafsil.store.state.q)") == session.q.tolist()


def factors(arm: Arm, units: tuple[float, float]) -> Floats:
    return np.array([units[j.kind is JointKind.PRISMATIC] for j in arm.robot.mechanism.coordinates])


def joints(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    factor, driven, limits = factors(arm, units), arm.settings["driven"], arm.robot.limits
    moved = list(range(arm.robot.n)) if driven is None else driven
    card.equal(".joint input[type=number]", (q * factor)[moved])
    bounded = [k for k in moved if np.isfinite(limits.lower[k])]
    card.equal(
        ".joint:has(input) .bounds",
        [float(x) for k in bounded for x in factor[k] * np.array([limits.lower[k], limits.upper[k]])],
    )
    card.equal(".joint:not(:has(input)) .soft", [float(q[k] * factor[k]) for k in range(arm.robot.n) if k not in moved])


def pose(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    T = np.asarray(arm.robot.forward_kinematics(q))
    R = T[:3, :3]
    angles = np.array([np.arctan2(R[2, 1], R[2, 2]), np.arcsin(np.clip(-R[2, 0], -1, 1)), np.arctan2(R[1, 0], R[0, 0])])
    card.equal(".fields input", np.concatenate([T[:3, 3] * units[1], angles * units[0]]))
    card.equal("mn", T)
    quaternion = np.asarray(rotation.to_quaternion(R))
    shown = float(card.read("dd")[0].strip("()").split(",")[int(np.abs(quaternion).argmax())])
    card.equal("dd:first-of-type", quaternion * np.sign(shown * quaternion[np.abs(quaternion).argmax()]))
    card.equal("dd:last-of-type", np.asarray(rotation.log(R)))


def jacobian(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    J = np.asarray(arm.robot.jacobian_body(q)) if arm.closed is None else closed_jacobian(arm, q)
    card.equal("mn", J)
    sizes = np.linalg.svd(J, compute_uv=False)
    moving = np.linalg.svd(np.vstack([J[3:], np.zeros((3, J.shape[1]))]) @ np.eye(J.shape[1], max(3, J.shape[1])))[1][
        :3
    ]
    card.equal("dd:nth-of-type(1)", sizes)
    card.equal("dd:nth-of-type(2)", [float(np.prod(sizes))])
    card.equal("dd:nth-of-type(3)", moving)
    card.equal("dd:nth-of-type(4)", [1 / size if size > 1e-6 * moving[0] else np.inf for size in moving.tolist()])


def closed_jacobian(arm: Arm, q: Floats) -> Floats:
    """Of the driven joints, by central differences of the closed chain."""
    chain, driven, h = ClosedChain(arm.robot), arm.settings["driven"], 1e-5
    T, columns = np.asarray(arm.robot.forward_kinematics(q)), list[Floats]()
    for joint in driven:
        ends = []
        for way in (h, -h):
            there = q.copy()
            there[joint] += way
            ends.append(np.asarray(arm.robot.forward_kinematics(chain.close_loops(there, hold=driven, tries=1).q)))
        rate = np.linalg.inv(T) @ (ends[0] - ends[1]) / (2 * h)
        columns.append(np.array([rate[2, 1], rate[0, 2], rate[1, 0], *rate[:3, 3]]))
    return np.array(columns).T


def loads(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    still, limits = 0 * q, arm.robot.limits.effort
    if arm.closed is None:
        motors, tau = list(range(arm.robot.n)), np.asarray(arm.robot.gravity_torque(q))
    else:
        motors, tau = arm.settings["motors"], np.asarray(ClosedChain(arm.robot).inverse_dynamics(q, still, still).tau)
    card.equal(".value", tau)
    card.equal(".bar > :last-child > .soft", limits[motors][np.isfinite(limits[motors])])


def branches(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    rows = card.read(".branches button")
    if not rows:
        assert arm.form is None
        return
    T, factor, solved = np.asarray(arm.robot.forward_kinematics(q)), factors(arm, units)[arm.places], 0
    session = Session(arm.robot)
    for row, text in enumerate(rows):
        session.set_joints(q.tolist())
        session.choose(row)
        assert text.startswith(f"{row} · ")
        assert (session.status == "no_branch") is ("no solution" in text), text
        if session.status != "solved":
            continue
        solved += 1
        np.testing.assert_allclose(arm.robot.forward_kinematics(session.q), T, atol=1e-8)
        assert arm.branch_names is not None
        own = session.q[arm.places]
        assert arm.branch_names.branches(own[None], np.array([row]))[0].label("en") in text
        card.equal(f".branches button:nth-of-type({row + 1}) .soft", own * factor)
    assert solved
    if not arm.settings["locked"]:
        found = mf.inverse_kinematics(arm.robot, T)
        assert solved == len({tuple(np.round(one, 6)) for one in found.q[found.within]})


def table(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    rows = dh_from_mechanism(arm.robot.mechanism).rows
    shown = [
        [degrees(r.alpha), r.a, r.d + r.offset * (r.kind == "P"), degrees(r.theta + r.offset * (r.kind == "R"))]
        for r in rows
    ]
    card.equal("tbody input", np.array(shown))


def closed_loop(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    card.equal("p bdi", [0.0, 0.0])


def grasp(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    """The grasp of the card, in the Python that it shows, against its friction and its verdict."""
    rng = np.random.default_rng(abs(int(1e6 * q.sum())))
    given = {"fingers": rng.uniform(0, 6, rng.integers(2, 6)).tolist(), "mu": round(float(rng.uniform(0, 1)), 2)}
    card.browser.ask(f"Object.assign(mafsil.grasp, {given}); mafsil.frame(performance.now())")
    scope: dict[str, Any] = {}
    exec(card.read("#grasp-code")[0], scope)
    closure = scope["grasp"].closure()
    card.equal(".friction bdi bdi", [given["mu"]])
    if closure:
        card.equal(".verdict", [closure.margin])
        return
    words = card.read(".verdict")[0].partition("wrench (")[2].partition(")")[0].split(",")
    wrench = np.array([float(word) for word in words])
    assert np.linalg.norm(wrench) == pytest.approx(1.0, abs=2e-3)
    assert (wrench @ closure.columns >= -2e-3 * np.linalg.norm(closure.columns, axis=0)).all()
    card.count += len(words)


def tree(card: Card, arm: Arm, q: Floats, units: tuple[float, float]) -> None:
    masses = [float(link.inertial.mass) for link in arm.robot.mechanism.links if link.inertial and link.inertial.mass]
    card.equal("ul:first-of-type .soft", masses)
    place = np.asarray(arm.robot.forward_kinematics(q))[:3, 3] * units[1]
    card.equal("ul:nth-of-type(2) .soft", [0.0, 0.0, 0.0, *place])


CHECKS = {
    "joints": joints, "pose": pose, "jacobian": jacobian, "gravity": loads, "branches": branches, "dh": table,
    "loop": closed_loop, "grasp": grasp, "tree": tree,
}  # fmt: skip

TEXTS = ("ink", "soft", "accent", "bad", "good", "warn")
GROUNDS = {
    "ink": ("paper", "card", "stage-top", "stage-low"),
    "soft": ("paper", "card", "stage-top", "stage-low", "good-soft", "warn-soft", "bad-soft"),
    "accent": ("card",),
    "bad": ("card", "bad-soft"),
    "good": ("card", "good-soft"),
    "warn": ("card", "warn-soft"),
}


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb. Reference: WCAG 2.2, definition of relative luminance."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def test_of_black_and_white() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)


def test_texts_stand_out() -> None:
    """Light and dark: WCAG 2.2, 1.4.3, at least 4.5 to 1."""
    rows = re.findall(r"--([\w-]+): light-dark\((#[0-9a-f]{6}), (#[0-9a-f]{6})\)", read("page/page.css"))
    for name, place in (("light", 1), ("dark", 2)):
        colours = {row[0]: row[place] for row in rows}
        pairs = [(a, b) for a in TEXTS for b in GROUNDS[a] if a in colours and b in colours]
        assert len(pairs) >= 9
        found = {f"{name} {a} on {b}": round(contrast(colours[a], colours[b]), 2) for a, b in pairs}
        found[f"{name} on accent"] = contrast(colours["on-accent"], colours["accent"])
        assert not {pair: ratio for pair, ratio in found.items() if ratio < 4.5}
