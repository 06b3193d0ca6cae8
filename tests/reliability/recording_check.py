"""What a recorded run shows, found again in plain NumPy, and held against all that the run says of itself."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import pi, radians

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from mafsil.job import Run
from mafsil.job.judging.judgement import summary
from mafsil.job.remark import Remark
from mafsil.messages import LANGUAGES
from mafsil.model import JointKind
from mafsil.report.contents import verdict
from mafsil.report.results import as_data
from tests.reliability.plain_arm import Load, PlainArm, angle_between

UNITS = {
    "m": 1.0, "mm": 1e-3, "µm": 1e-6, "s": 1.0, "ms": 1e-3, "°": pi / 180, "%": 0.01, "kg": 1.0, "m/s": 1.0,
    "mm/s": 1e-3, "°/s": pi / 180, "°/s²": pi / 180, "m/s²": 1.0, "Hz": 1.0, "": 1.0,
}  # fmt: skip
QUANTITY = re.compile(r"(-?[\d,]+(?:\.\d+)?) ?(\S*)")
CLOSE = 6e-3
"""Three digits were printed."""
EDGE = 1e-6
"""What lies this near a threshold may fall on either side."""
FEW_MISSES = 5
ENGINE_DETAILS = ("job.velocity_assumed", "job.acceleration_assumed", "job.effort_unknown", "job.tight_limit")
"""What is said of the description and the plan, not of the recording."""


def value_of(text: object) -> float:
    """The SI value of a printed quantity."""
    match = QUANTITY.fullmatch(str(text))
    assert match, text
    return float(match.group(1).replace(",", "")) * UNITS[match.group(2)]


def same(text: object, value: float, least: float = 1e-9) -> bool:
    """Whether a printed quantity is that value, to the digits that are printed."""
    return abs(value_of(text) - value) <= CLOSE * abs(value) + least


@dataclass
class Check:
    """A run and what was found wrong in its words; `arm` is empty-handed with the masses that the model knows."""

    run: Run
    wrong: list[str] = field(default_factory=list)

    def expect(self, fine: bool, *words: object) -> None:
        """Note a complaint."""
        if not fine:
            self.wrong.append(" ".join(map(str, words)))

    @cached_property
    def arm(self) -> PlainArm:
        return PlainArm(self.run.robot.mechanism)

    @cached_property
    def turning(self) -> np.ndarray:
        return np.array([j.kind is not JointKind.PRISMATIC for j in self.run.robot.mechanism.coordinates])

    @cached_property
    def ends(self) -> np.ndarray:
        return np.cumsum([leg.trajectory.duration for leg in self.run.plan.legs])

    @cached_property
    def stretch_of(self) -> np.ndarray:
        """Which stretch a leg belongs to: it changes where the load does."""
        legs = self.run.plan.legs
        return np.cumsum([0, *(int(a.load != b.load) for a, b in pairwise(legs))])

    @cached_property
    def misses(self) -> dict[int, tuple[float, float, np.ndarray, float]]:
        """Leg with a goal: distance, angle, errors of the joints, largest share of a tolerance."""
        run, tape, found = self.run, self.run.recording, {}
        spline = CubicHermiteSpline(tape.t, tape.q, tape.qd) if len(tape.t) > 1 else None
        for k, leg in enumerate(run.plan.legs):
            if leg.kind in ("pause", "settle") or self.ends[k] > tape.t[-1] + 1e-9 or spline is None:
                continue
            q = np.atleast_2d(spline(min(self.ends[k], tape.t[-1])))
            goal = np.atleast_2d(leg.trajectory.at(leg.trajectory.duration).u)
            R, p = self.arm.tip(q)
            S, r = self.arm.tip(goal) if leg.target is None else (leg.target[None, :3, :3], leg.target[None, :3, 3])
            distance, angle = float(np.linalg.norm(p - r)), float(angle_between(R, S)[0])
            errors = np.abs(q - goal)[0]
            position, orientation, joints = self.allowed(leg.index)
            by_joints = leg.kind == "joint" and leg.target is None
            share = float((errors / joints).max()) if by_joints else max(distance / position, angle / orientation)
            found[k] = (distance, angle, errors, share)
        return found

    def allowed(self, index: int | None) -> tuple[float, float, np.ndarray]:
        """Tolerances of a move, or of the job in general, by the rules of the page on job files."""
        job = self.run.job
        own = None if index is None else job.move[index].tolerance
        layers = [layer for layer in (own, job.tolerance) if layer is not None]

        def first(name: str) -> float | None:
            return next((getattr(layer, name) for layer in layers if getattr(layer, name) is not None), None)

        position, orientation, joints = first("position"), first("orientation"), first("joints")
        metres, angle = position or 1e-3, orientation or radians(0.5)
        return metres, angle, np.where(self.turning, joints or angle, metres)

    @cached_property
    def missed(self) -> list[int]:
        return [k for k, (*_, share) in self.misses.items() if share > 1.0]

    @cached_property
    def edgy(self) -> bool:
        """Whether some target lies on the edge of its tolerance."""
        return any(abs(share - 1.0) < EDGE for *_, share in self.misses.values())

    @cached_property
    def gripped(self) -> dict[int, bool]:
        """By stretch: whether the part that it should carry was taken."""
        found = {}
        for k, leg in enumerate(self.run.plan.legs):
            if leg.kind == "pick":
                found[int(self.stretch_of[k]) + 1] = k not in self.missed
        return found

    def loads(self, stretch: int) -> tuple[Load | None, Load | None]:
        """What the tool really holds in a stretch, and what the controller believes."""
        held = self.run.plan.legs[int(np.argmax(self.stretch_of == stretch))].load.carried
        if held is None:
            return None, None
        a, b, c = np.square(held.size)
        load = Load(held.mass, np.array(held.offset), held.mass / 12 * np.diag([b + c, a + c, a + b]))
        return (load if self.gripped.get(stretch, True) else None), (load if held.known else None)

    def push(self, stretch: int, t: float) -> np.ndarray:
        """(1, 6) sum of the pushes that the simulation holds during the tick at t."""
        start = float(self.ends[np.argmax(self.stretch_of == stretch) - 1]) if stretch else 0.0
        period = 1.0 / self.run.job.controller.rate if self.run.job.controller.rate else self.run.job.simulation.step
        local = round((t - start) / period) * period
        total = np.zeros(6)
        for d in self.run.job.disturbance:
            begin, end = max(d.start - start, 0.0), d.start + d.duration - start
            if begin <= local < begin + (end - begin):
                total = total + np.array(d.wrench)
        return total[None]


def complaints(run: Run) -> tuple[dict[str, int], list[str]]:
    """Counts of a run, and all that it says falsely or leaves out."""
    check = Check(run)
    if not check.edgy:
        for part in (_targets, _verdict, _limits, _holding, _stray, _collapse, _misses, _dynamics, _texts):
            part(check)
    said = Counter(remark.key for remark in run.remarks)
    counts = {
        "sentences": len(run.remarks),
        "targets": len(check.misses),
        "missed": len(check.missed),
        "causes": sum(remark.cause is not None for remark in run.remarks),
        "edges": int(check.edgy),
        f"verdict_{verdict(run).level}": 1,
        "collapsed": int("job.gives_way" in said),
        "stopped": int(run.stopped is not None),
        "not_held": int(bool(said.keys() & {"job.cannot_hold", "job.cannot_hold_part"})),
    }
    return counts, check.wrong


def _said(check: Check, *keys: str) -> list[Remark]:
    return [remark for remark in check.run.remarks if remark.key in keys]


def _targets(check: Check) -> None:
    """results.json: every target, its errors, whether it is reached; the sentence that all are."""
    run = check.run
    data = as_data(run, summary(run))
    wanted = [k for k, leg in enumerate(run.plan.legs) if leg.kind not in ("pause", "settle")]
    check.expect([target["step"] for target in data["targets"]] == wanted, "targets", data["targets"])
    for target in data["targets"]:
        k = target["step"]
        check.expect(target["reached"] == (k in check.misses and k not in check.missed), "reached of", k)
        if k in check.misses:
            distance, angle, errors, _ = check.misses[k]
            check.expect(abs(target["position_error"] - distance) < 1e-9 + 1e-6 * distance, "distance of", k)
            check.expect(abs(target["orientation_error"] - angle) < 1e-7, "angle of", k, target, angle)
            check.expect(np.allclose(target["joint_errors"], errors, atol=1e-9), "joints of", k)
    all_reached = run.stopped is None and bool(wanted) and set(wanted) == set(check.misses) and not check.missed
    said = _said(check, "job.all_reached")
    check.expect(bool(said) == all_reached, "all_reached is", bool(said))
    if said:
        check.expect(said[0].details["count"] == len(wanted), "count")
        check.expect(same(said[0].details["position"], max(m[0] for m in check.misses.values())), "largest distance")
        check.expect(same(said[0].details["angle"], max(m[1] for m in check.misses.values()), 1e-7), "largest angle")
    check.expect(data["simulation"]["method"] == run.recording.metadata["integrator"], "method")
    asked = run.job.simulation.method
    replaced = run.recording.metadata["integrator"] != (asked or "rk4")
    check.expect(bool(_said(check, "job.method_chosen")) == (asked is None and replaced), "method chosen")
    check.expect(asked is None or not replaced, "integrator replaced")


def _verdict(check: Check) -> None:
    """Green only if nothing is wrong; the level is that of the worst finding; failures come first."""
    levels = [remark.level for remark in check.run.remarks]
    level = next((name for name in ("failure", "warning") if name in levels), "good")
    check.expect(verdict(check.run).level == level, "verdict", verdict(check.run).level, level)
    bad = bool(check.missed) or check.run.stopped is not None
    check.expect(not bad or level == "failure", "a miss without a failure")
    check.expect(levels == sorted(levels, key=lambda name: name != "failure"), "order", levels)
    check.expect(bool(check.missed) == bool([r for r in check.run.remarks if "not_reached" in r.key]), "misses said")


def _limits(check: Check) -> None:
    """Efforts, ranges, speeds and accelerations against the limits of the description."""
    run, tape = check.run, check.run.recording
    dt = np.diff(tape.t)
    dt = np.append(dt, dt[-1:])
    collapsed = bool(_said(check, "job.gives_way"))
    for k, joint in enumerate(run.robot.mechanism.coordinates):
        name, limits = joint.name, joint.limits

        def said(key: str, name: str = name) -> Remark | None:
            return next((r for r in _said(check, key) if r.details["joint"] == name), None)

        beyond = np.abs(tape.tau_commanded[:, k]) > limits.effort * (1 + 1e-9)
        remark = said("job.at_saturation")
        check.expect((remark is not None) == bool((beyond * dt).sum() > 0.0), name, "saturation", remark)
        if remark is not None:
            check.expect(same(remark.details["time"], float((beyond * dt).sum())), name, "time at the limit")
            share = np.abs(tape.tau_commanded[:, k]).max() / limits.effort
            check.expect(same(remark.details["share"], share), name, "largest demand", remark.details, share)
            level = "failure" if check.missed or run.stopped is not None else "warning"
            check.expect(remark.level == level, name, "level of saturation")
        elif remark := said("job.near_saturation"):
            share = np.abs(tape.tau_commanded[:, k]).max() / limits.effort
            check.expect(0.9 < share <= 1.0 + 1e-9 and same(remark.details["share"], share), name, "near", share)
        excess = max((limits.lower - tape.q[:, k]).max(), (tape.q[:, k] - limits.upper).max())
        remark = said("job.limit_crossed")
        check.expect((remark is not None) == (excess > 1e-5 and not collapsed), name, "range", excess)  # as documented
        if remark is not None:
            check.expect(same(remark.details["excess"], excess), name, "excess", remark.details, excess)
            allowed = check.allowed(None)[2][k]
            check.expect(remark.level == ("failure" if excess > allowed else "warning"), name, "level of excess")
        for what, peak, limit in (
            ("speed", np.abs(tape.qd[:, k]).max(), limits.velocity),
            ("acceleration", np.abs(tape.qdd[:, k]).max(), limits.acceleration),
        ):
            remark = said(f"job.{what}_crossed")
            share = peak / limit if limit > 0 else 0.0
            check.expect((remark is not None) == (share > 1 + 1e-9 and not collapsed), name, what, share)
            if remark is not None:
                fine = same(remark.details["over"], share - 1.0) and same(remark.details["limit"], limit)
                check.expect(fine, name, what, remark.details, peak)
                check.expect(remark.level == ("failure" if share > 1.02 else "warning"), name, what, "level")


def _holding(check: Check) -> None:
    """Static loads along the plan."""
    run = check.run
    needed: dict[int, float] = {}
    held_of: dict[int, object] = {}
    for stretch in range(len(run.driven)):
        legs = [leg for k, leg in enumerate(run.plan.legs) if check.stretch_of[k] == stretch]
        load, _ = check.loads(stretch)
        arm = PlainArm(run.robot.mechanism, 1.0 + run.job.simulation.mass_error, load)
        q = np.concatenate([leg.trajectory.at(np.linspace(0, leg.trajectory.duration, 30)).u for leg in legs])
        most = float((_need(check, arm, q) / _efforts(check)).max())
        held = legs[0].load.carried if load is not None else None
        needed[id(held)] = max(most, needed.get(id(held), 0.0))
        held_of[id(held)] = held
    said = _said(check, "job.cannot_hold", "job.cannot_hold_part")
    claims = {str(remark.details.get("part", "")): remark for remark in said if remark.key == "job.cannot_hold"}
    parts = [remark for remark in said if remark.key == "job.cannot_hold_part"]
    beyond = {key: most for key, most in needed.items() if most > 1.0 + 1e-3}
    check.expect(len(said) >= len(beyond), "overload unsaid", beyond)
    check.expect(bool(claims) <= (needed.get(id(None), 0.0) > 0.97), "cannot hold itself", needed)
    for remark in said:
        joint = run.robot.joint_names.index(str(remark.details["joint"]))
        driven, t = _at(check, remark, parts)
        load, _ = check.loads(driven)
        arm = PlainArm(run.robot.mechanism, 1.0 + run.job.simulation.mass_error, load)
        share = _need(check, arm, t)[:, joint] / _efforts(check)[joint]
        near = np.abs(share - value_of(remark.details["share"])) <= 0.02 * share + 1e-3
        check.expect(bool(near.any()), "share of", remark.details, share)


def _at(check: Check, remark: Remark, parts: list[Remark]) -> tuple[int, np.ndarray]:
    """The stretch that a claim speaks of, and configurations of the plan about its time."""
    run = check.run
    time = value_of(remark.details["time"])
    rows = []
    chosen = 0
    for moment in np.linspace(time * 0.995 - 1e-3, time * 1.005 + 1e-3, 41):
        leg = int(np.clip(np.searchsorted(check.ends, moment), 0, len(check.ends) - 1))
        load, _ = check.loads(int(check.stretch_of[leg]))
        if (load is not None) != (remark in parts):
            continue
        chosen = int(check.stretch_of[leg])
        begin = check.ends[leg] - run.plan.legs[leg].trajectory.duration
        rows.append(run.plan.legs[leg].trajectory.at(float(np.clip(moment - begin, 0, None))).u)
    check.expect(bool(rows), "nothing of the kind is held at", time)
    return chosen, np.array(rows).reshape(-1, run.robot.n)


def _need(check: Check, arm: PlainArm, q: np.ndarray) -> np.ndarray:
    """Least efforts that hold the arm still: static friction helps."""
    rubbing = arm.coulomb() if check.run.job.simulation.friction else 0.0
    return np.maximum(np.abs(arm.gravity(q)) - rubbing, 0.0)


def _efforts(check: Check) -> np.ndarray:
    limit = np.array([joint.limits.effort for joint in check.run.robot.mechanism.coordinates])
    return np.where(limit > 0.0, limit, np.inf)


def _stray(check: Check) -> None:
    """The tip off its path; a part kept; a push too late."""
    run, tape = check.run, check.run.recording
    (R, p), (S, r) = check.arm.tip(tape.q), check.arm.tip(tape.q_ref)
    astray, numbers = np.linalg.norm(p - r, axis=1), summary(run)
    check.expect(abs(numbers.tip_error - astray.max()) < 1e-9 + 1e-6 * astray.max(), "tip error", astray.max())
    check.expect(abs(numbers.tip_turn - angle_between(R, S).max()) < 1e-6, "tip turn", numbers.tip_turn)
    said = _said(check, "job.large_error")
    check.expect(bool(said) == (astray.max() > 5e-3), "stray", astray.max())
    if said:
        check.expect(same(said[0].details["error"], astray.max()), "stray by", said[0].details)
    kinds = [leg.kind for leg in run.plan.legs if leg.kind in ("pick", "place")]
    check.expect(bool(_said(check, "job.part_kept")) == (bool(kinds) and kinds[-1] == "pick"), "part kept", kinds)
    late = sum(push.start >= tape.t[-1] for push in run.job.disturbance)
    check.expect(len(_said(check, "job.late_disturbance")) == late, "late pushes")


def _collapse(check: Check) -> None:
    """An arm gives way when a joint is a quarter turn or half a metre beyond all that was planned."""
    tape = check.run.recording
    far = np.maximum(tape.q - tape.q_ref.max(axis=0), tape.q_ref.min(axis=0) - tape.q)
    share = far / np.where(check.turning, pi / 2, 0.5)
    said = _said(check, "job.gives_way")
    check.expect(bool(said) == bool(share.max() > 1.0), "gives way", share.max())
    for remark in said:
        k = check.run.robot.joint_names.index(str(remark.details["joint"]))
        check.expect(same(remark.details["excess"], far[:, k].max()), "excess", remark.details, far[:, k].max())
        first = tape.t[int((share[:, k] > 1.0).argmax())]
        check.expect(same(remark.details["time"], first), "time", remark.details, first)


def _misses(check: Check) -> None:
    """Each miss with its numbers, and its cause where one is named."""
    run = check.run
    said = [r for r in run.remarks if r.key.startswith("job.not_reached_")]
    check.expect(len(said) == min(len(check.missed), FEW_MISSES), "misses", len(said), check.missed)
    more = _said(check, "job.more_not_reached")
    check.expect(
        sum(int(str(r.details["count"])) for r in more) == max(len(check.missed) - FEW_MISSES, 0), "more missed"
    )
    for k, remark in zip(check.missed, said, strict=False):
        distance, angle, errors, _ = check.misses[k]
        leg, details = run.plan.legs[k], remark.details
        kind = leg.kind if leg.kind in ("pick", "place") else "joints" if leg.target is None else "pose"
        check.expect(remark.key == f"job.not_reached_{kind}", remark.key, leg.kind)
        check.expect(
            same(details["position"], distance) and same(details["angle"], angle, 1e-7), details, distance, angle
        )
        joint = run.robot.joint_names.index(str(details["joint"]))
        check.expect(same(details["error"], errors[joint]), details, errors)
        if remark.cause is not None:
            _cause(check, k, remark.cause)
    for remark in _said(check, "job.remaining"):
        k = max(check.misses, key=lambda k: check.misses[k][3])
        check.expect(same(remark.details["share"], check.misses[k][3]), "remaining", remark.details)


def _cause(check: Check, k: int, cause: object) -> None:
    """The cause is one that the job has, its first number the miss, its second allowed or half of it at most."""
    run, tape = check.run, check.run.recording
    key, details = cause.key.removeprefix("job.cause_"), cause.details  # type: ignore[attr-defined]
    if key == "not_sought":
        return
    distance, angle, errors, _ = check.misses[k]
    position, orientation, joints = check.allowed(run.plan.legs[k].index)
    numbers = [(distance, position), (angle, orientation), *zip(errors, joints, strict=True)]
    fitting = [(value, allowed) for value, allowed in numbers if same(details["before"], value, 1e-7)]
    check.expect(bool(fitting), "before", details, numbers)
    if key == "unknown":
        return
    most = max((max(allowed, value / 2.0) for value, allowed in fitting), default=0.0)
    check.expect(value_of(details["after"]) <= most * (1.0 + CLOSE), "cause", key, "leaves", details, numbers)
    check.expect(_there(check, k, key), key, "is not in the job")
    if key == "limit":
        limited = run.robot.joint_names.index(str(details["limited"]))
        before = tape.t < check.ends[k] - 1e-9
        beyond = np.abs(tape.tau_commanded[before]) > run.robot.limits.effort
        check.expect(bool(beyond.any()), "no limit was reached")
        check.expect(bool(np.isfinite(run.robot.limits.effort[limited])), "no limit of", details)
    if key == "rate":
        rate = run.job.controller.rate or 1.0 / run.job.simulation.step
        check.expect(same(details["rate"], rate), "rate", details)
        check.expect(value_of(details["growth"]) >= 1.0, "growth", details)
    if key == "model":
        _unknown(check, k, str(details["what"]))


def _there(check: Check, k: int, key: str) -> bool:
    """Whether a job has what its cause is called by, before the end of a leg."""
    job, mechanism = check.run.job, check.run.robot.mechanism
    noise = job.simulation.noise
    there = {
        "noise": noise.position > 0.0 or noise.velocity > 0.0 or noise.force > 0.0 or noise.resolution > 0.0,
        "friction": job.simulation.friction and any(joint.friction for joint in mechanism.coordinates),
        "push": any(one.start < check.ends[k] for one in job.disturbance),
        "delay": job.controller.delay > 0.0,
        "contact": bool(job.surface or job.hole or job.door or job.guide),
        "surface_friction": any(one.friction for one in job.surface),
        "law": job.controller.kind in ("pid", "pd_gravity"),
        "integral": job.controller.kind == "pid",
        "gains": any((job.controller.frequency, job.controller.kp, job.controller.kd)),
    }
    return bool(there.get(key, True))


def _unknown(check: Check, k: int, what: str) -> None:
    """What the model does not know at some time of the job up to a leg."""
    loads = [check.loads(stretch) for stretch in range(int(check.stretch_of[k]) + 1)]
    part = any((load is None) != (believed is None) for load, believed in loads)
    masses = check.run.job.simulation.mass_error != 0.0
    known = {(True, True): "both", (False, True): "masses", (True, False): "part"}.get((part, masses), "nothing")
    word = what.removeprefix("@job.").replace("missing_", "unknown_").removeprefix("unknown_")
    check.expect(word in (known, "both"), "what is unknown", what, known)


def _dynamics(check: Check) -> None:
    """The recorded efforts are those of the arm with what it is said to hold, less friction where that is smooth."""
    run, tape = check.run, check.run.recording
    if run.recording.metadata["integrator"] == "implicit_friction":
        return
    for k in check.misses:
        row = max(int(np.searchsorted(tape.t, check.ends[k] - 1e-9)) - 1, 0)
        stretch = int(check.stretch_of[k])
        arm = PlainArm(run.robot.mechanism, 1.0 + run.job.simulation.mass_error, check.loads(stretch)[0])
        q, qd, qdd, tau = (x[row : row + 1] for x in (tape.q, tape.qd, tape.qdd, tape.tau))
        efforts = arm.efforts(q, qd, qdd, check.push(stretch, float(tape.t[row])))
        if run.job.simulation.friction:
            efforts = efforts + _friction(check, qd)
        scale = np.abs(tau).max() + np.abs(arm.gravity(q)).max() + np.abs(efforts).max() + 1.0
        check.expect(np.abs(efforts - tau).max() < 1e-6 * scale, "efforts at", k, efforts - tau)


def _friction(check: Check, qd: np.ndarray) -> np.ndarray:
    """Efforts (1, n) of friction, Coulomb's part smoothed over 1 mrad/s as the page on dynamics says."""
    lost = np.zeros_like(qd)
    for k, joint in enumerate(check.run.robot.mechanism.coordinates):
        if joint.friction is not None:
            f = joint.friction
            negative = f.coulomb if f.coulomb_negative is None else f.coulomb_negative
            side = np.where(qd[:, k] >= 0, f.coulomb, negative)
            lost[:, k] = f.viscous * qd[:, k] + side * np.tanh(qd[:, k] / 1e-3) + f.offset
    return lost


def _texts(check: Check) -> None:
    """Every sentence can be said in both languages, holds its numbers, and has no exponent."""
    known: Iterator[Remark] = iter(check.run.remarks)
    for remark in known:
        for language in LANGUAGES:
            sentence = remark.sentence(language)
            check.expect(not re.search(r"\d[eE][+-]?\d|\bnan\b|\binf\b", sentence), "exponent in", sentence)
            check.expect("{" not in sentence and "@" not in sentence, "placeholder in", sentence)
            shown: Callable[[object], bool] = lambda fact: isinstance(fact, str) and fact[:1].isdigit()  # noqa: E731
            unsaid = [
                fact
                for name, fact in remark.details.items()
                if shown(fact) and str(fact) not in sentence and not remark.key.startswith("job.not_reached") and name
            ]
            check.expect(not unsaid, "numbers left out of", sentence, unsaid)
