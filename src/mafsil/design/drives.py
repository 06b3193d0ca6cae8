"""Motor and gear for every joint from a catalogue, all joints together: a heavier wrist needs a stronger shoulder.

Efforts are linear in the masses of the drives, and those of a joint depend on the drives behind it alone. So drives are
chosen from the last joint inward, and branch and bound proves the choice: what a joint needs at the least, whatever
masses within their bounds lie behind it, bounds the rest of the sum.

The motor of a joint gives m = tau / (G eta) while it drives, tau eta / G while it brakes, and I G qdd for its rotor. A
drive serves if |m| keeps to the peak torque, the root mean square of m over the motion to the continuous one (the
heat), and G |qd| to the speed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Literal, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, frozen, not_negative, single, spread, whole
from mafsil.design.arm import ArmDesign, ParametricArm
from mafsil.design.family import ArmNumbers
from mafsil.design.parts import Catalogue, Drive
from mafsil.design.tasks import TaskSet
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.model.loading import RobotLike

REASONS = ("serves", "too_fast", "too_weak", "overheats", "too_much_backlash")
"""Why a drive is rejected, in the order in which it is tested."""
Rows: TypeAlias = NDArray[np.int64]
"""Places in the catalogue; -1 for none."""
ROUNDING = 1e-9
"""Share by which a limit may seem exceeded."""


class DriveStatus(Status):
    """Whether drives were found, and the best."""

    BEST = ("design.drives_best", True)
    FOUND = ("design.drives_found", True)
    NONE = ("design.drives_none", False)
    STOPPED = ("design.drives_stopped", False)


@dataclass(frozen=True, eq=False, repr=False)
class DriveChoice(Answer, data="names total goal mass peak heat speed rejected nodes"):
    """A drive for each joint; true if there is one.

    Attributes:
        status: the best of the catalogue, proved; the best found before the search was stopped; none.
        goal: what is least in sum: `mass` or `cost`.
        joints: (n,) names.
        catalogue: it was chosen from.
        chosen: (n,) rows of it; -1 where nothing serves.
        reasons: (n, K) index into REASONS, with the drives behind the joint as chosen (none where none serves).
        peak, heat, speed: (n,) shares of what the motors may: torque, rms torque, speed.
        nodes: partial choices that were looked at.
    """

    status: DriveStatus
    goal: str
    joints: tuple[str, ...]
    catalogue: Catalogue
    chosen: NDArray[np.int64]
    reasons: NDArray[np.int8]
    peak: Floats
    heat: Floats
    speed: Floats
    nodes: int

    @property
    def names(self) -> tuple[str, ...]:
        """(n,) of the drives; empty where nothing serves."""
        return tuple(self.catalogue.name[k] if k >= 0 else "" for k in cast("list[int]", self.chosen.tolist()))

    @property
    def mass(self) -> Floats:
        """(n,) of the drives [kg]."""
        return np.where(self.chosen >= 0, self.catalogue.mass[self.chosen], np.nan)

    @property
    def total(self) -> float:
        """Sum of the goal over all joints."""
        return float(getattr(self.catalogue, self.goal)[self.chosen].sum()) if self else inf

    @property
    def rejected(self) -> dict[str, dict[str, str]]:
        """By joint, why each drive that does not serve is rejected."""
        names = self.catalogue.name
        codes = cast("list[list[int]]", self.reasons.tolist())
        rows = [{name: REASONS[k] for name, k in zip(names, row, strict=True) if k} for row in codes]
        return dict(zip(self.joints, rows, strict=True))

    @property
    def joint(self) -> str:
        """The first joint, from the last inward, for which nothing serves; empty if all have a drive."""
        missing = np.flatnonzero(self.chosen < 0)
        return self.joints[int(missing[-1])] if len(missing) else ""

    def explain(self, language: str | None = None) -> str:
        """The sum, the drive of each joint with its shares, and how many are rejected for which reason."""
        details = {"total": self.total, "goal": self.goal, "nodes": self.nodes, "joint": self.joint}
        lines = [self.status.sentence(language, **details)]
        for k, joint in enumerate(self.joints):
            counts = [
                f"{say(f'design.drive_{REASONS[code]}', language=language)}: {int((self.reasons[k] == code).sum())}"
                for code in range(1, len(REASONS)) if (self.reasons[k] == code).any()
            ]  # fmt: skip
            share = {name: 100.0 * float(getattr(self, name)[k]) for name in ("peak", "heat", "speed")}
            key = "design.drive_of_joint" if self.chosen[k] >= 0 else "design.no_drive_of_joint"
            reasons = "; ".join(counts) or "-"
            lines.append(say(key, language=language, joint=joint, name=self.names[k], reasons=reasons, **share))
        return "\n".join(lines)


def pick_drives(
    design: ArmDesign | RobotLike,
    catalogue: Catalogue,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    payload: float = 0.0,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    goal: Literal["mass", "cost"] = "mass",
    backlash: ArrayLike = inf,
    max_nodes: int = 100_000,
) -> DriveChoice:
    """The drives of a catalogue that move an arm along its duty cycle at the least sum of mass or cost.

    Args:
        design: its own drives are taken away first; the masses of a plain robot are those without drives.
        catalogue: to choose from.
        q, qd, qdd: (T, n) the duty cycle, moments evenly spaced in time.
        payload: mass at the tip [kg].
        centre: (3,) of it, in the tip frame [m].
        goal: what shall be least in sum.
        backlash: the largest allowed, one for all joints or one for each [rad].
        max_nodes: partial choices after which the search stops; the answer is not proved then.

    Raises:
        InputError: wrong shapes, numbers out of range, an unknown goal.
    """
    given = ArmDesign.of(design)
    if goal not in ("mass", "cost"):
        raise InputError("input.choice", name="goal", value=goal, known="mass, cost")
    if not isinstance(cast("object", catalogue), Catalogue):
        raise InputError("input.kind", name="catalogue", expected="Catalogue", got=type(catalogue).__name__)
    arms, n = ArmNumbers.of(given.robot), given.robot.n
    rows = [as_batch(name, x, (n,), finite=True).reshape(-1, n) for name, x in (("q", q), ("qd", qd), ("qdd", qdd))]
    if len({len(row) for row in rows}) > 1 or not len(rows[0]):
        raise InputError("input.shape", name="qd", expected=rows[0].shape, got=rows[1].shape, hint="")
    loads = TaskSet(np.eye(4)[None], payload=not_negative("payload", payload), centre=single("centre", centre, (3,)))
    fixed, unit = _efforts(given, loads.with_payload(arms), *rows)
    allowed = spread("backlash", backlash, (n,), finite=False)
    if np.isnan(allowed).any() or (allowed < 0).any():
        raise InputError("input.range", name="backlash", value=backlash, low=0.0, high=inf)
    search = _Search(catalogue, fixed, unit, rows[1], rows[2], allowed, goal, whole("max_nodes", max_nodes, least=1))
    search.descend(n - 1, np.full(n, -1), 0.0)
    return search.answer(given.robot.joint_names)


def fit_drives(arm: ParametricArm, choice: DriveChoice) -> ParametricArm:
    """The arm with the chosen drives: masses, rotors behind their gears, and what they allow as joint limits.

    Args:
        arm: whose joints the choice is for.
        choice: of `pick_drives`; radius, length and stiffness of the drives stay as the arm has them.

    Raises:
        InputError: there is no choice, or it is for another number of joints.
    """
    joints = [dict(joint) for joint in arm.table["joint"]]
    if not choice or len(joints) != len(choice.joints):
        raise InputError("design.no_choice", expected=len(joints), got=int((choice.chosen >= 0).sum()))
    unit = np.pi / 180.0 if arm.table.get("units", {}).get("angle") == "deg" else 1.0
    c = choice.catalogue
    for joint, row in zip(joints, choice.chosen.tolist(), strict=True):
        G = float(c.ratio[row])
        joint["drive"] = {**joint.get("drive", {}), "mass": float(c.mass[row])}
        joint["actuator"] = {"rotor_inertia": float(c.rotor_inertia[row]), "gear_ratio": G}
        allowed = {
            "velocity": float(c.speed[row]) / G / unit,
            "effort": float(c.peak_torque[row] * G * c.efficiency[row]),
        }
        joint["limits"] = {**joint.get("limits", {}), **allowed}
    return replace(arm, table={**arm.table, "joint": joints})


def _efforts(design: ArmDesign, arms: ArmNumbers, q: Floats, qd: Floats, qdd: Floats) -> tuple[Floats, Floats]:
    """Efforts (T, n) without any drive, and (n, T, n) those that a kilogram of drive at each joint adds."""
    n, none = arms.n, np.zeros(6)
    added = np.zeros((n, n, 10))
    for k in range(1, n):
        shape = design.drives[k] or Drive()
        T, one = arms.places[k], replace(shape, mass=1.0)
        added[k, k - 1] = one.parameters(T[:3, :3], T[:3, 3], np.array([0.0, 0.0, 1.0]))
    own = np.array([0.0 if drive is None else drive.mass for drive in design.drives[:n]])
    bare = replace(arms, bodies=frozen(arms.bodies - np.einsum("k,kij->ij", own, added)), armature=np.zeros(n))
    units = replace(bare, bodies=added[:, None])
    return bare.torque(q, qd, qdd, none), units.torque(q, qd, qdd, none)


class _Search:
    """Branch and bound from the last joint inward.

    Attributes:
        best, value: the best choice so far (rows of the catalogue) and its sum; infinite before the first.
        nodes: partial choices looked at.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        fixed: Floats,
        unit: Floats,
        qd: Floats,
        qdd: Floats,
        backlash: Floats,
        goal: str,
        most: int,
    ) -> None:
        self.catalogue, self.fixed, self.unit, self.qd, self.qdd = catalogue, fixed, unit, qd, qdd
        self.backlash, self.goal, self.most = backlash, goal, most
        self.weight: Floats = getattr(catalogue, goal)
        self.best, self.value, self.nodes, self.stopped = np.full(fixed.shape[1], -1), inf, 0, False
        self.furthest = self.best
        self.rest = np.zeros(fixed.shape[1] + 1)

    def descend(self, i: int, chosen: Rows, spent: float) -> None:
        """Choose drives of the joints i, i - 1, ... 0 behind which `chosen` are."""
        if i < 0:
            self.best, self.value = chosen, spent
            return
        if self.nodes >= self.most:
            self.stopped = True
            return
        self.nodes += 1
        if i < int((self.furthest < 0).sum()) - 1 or self.nodes == 1:
            self.furthest = chosen
        room = self.value - spent
        least = self._least_of_rest(i, chosen, room)
        affordable = np.flatnonzero(self.weight <= room)
        served = affordable[self.reasons(i, chosen, affordable) == 0]
        known = set[float]()
        for row in served[np.argsort(self.weight[served], kind="stable")].tolist():
            mass = float(self.catalogue.mass[row])
            # Inward joints feel a drive by its mass alone: of equal masses the first is the best.
            if mass in known:
                continue
            known.add(mass)
            if spent + self.weight[row] + least >= self.value * (1.0 - ROUNDING):
                break
            after = chosen.copy()
            after[i] = row
            self.descend(i - 1, after, spent + float(self.weight[row]))

    def _least_of_rest(self, i: int, chosen: Rows, room: float) -> float:
        """What the joints i - 1 ... 0 weigh at least, whatever stands at joint i; infinite if that beats no best.

        Args:
            i: joint that is chosen next.
            chosen: drives behind it.
            room: what may be spent on the joints i ... 0: what is more is no improvement.
        """
        masses = np.where(chosen >= 0, self.catalogue.mass[chosen], 0.0)
        low, high = masses.copy(), masses.copy()
        total = 0.0
        for k in range(i, -1, -1):
            possible = self._possible(k, low, high, np.flatnonzero(self.weight <= room - total))
            if not len(possible):
                return inf
            low[k], high[k] = self.catalogue.mass[possible].min(), self.catalogue.mass[possible].max()
            if k < i:
                total += float(self.weight[possible].min())
        return total

    def _possible(self, k: int, low: Floats, high: Floats, rows: Rows) -> Rows:
        """Those of some drives that some masses behind joint k, between the bounds, would let serve."""
        ends = np.stack([self.unit[:, :, k] * low[:, None], self.unit[:, :, k] * high[:, None]])
        behind = slice(k + 1, None)
        least, most = (self.fixed[:, k] + pick(axis=0)[behind].sum(axis=0) for pick in (ends.min, ends.max))
        m_low, m_high = self._motor(k, least, rows), self._motor(k, most, rows)
        smallest = np.where(m_low * m_high <= 0.0, 0.0, np.minimum(np.abs(m_low), np.abs(m_high)))
        return rows[self._judge(k, smallest, rows) == 0]

    def reasons(self, k: int, chosen: Rows, rows: Rows) -> NDArray[np.int8]:
        """Index into REASONS of some drives at joint k, with the chosen ones behind it."""
        return self._judge(k, np.abs(self._motor(k, self.effort(k, chosen), rows)), rows)

    def effort(self, k: int, chosen: Rows) -> Floats:
        """(T,) of joint k."""
        masses = np.where(chosen >= 0, self.catalogue.mass[chosen], 0.0)
        return self.fixed[:, k] + masses[k + 1 :] @ self.unit[k + 1 :, :, k]

    def _motor(self, k: int, effort: Floats, rows: Rows) -> Floats:
        """(rows, T) torque of each motor for an effort (T,) of the joint: growing with it."""
        c, driving = self.catalogue, effort * self.qd[:, k] >= 0.0
        eta, G = c.efficiency[rows, None], c.ratio[rows, None]
        return effort * np.where(driving, 1.0 / eta, eta) / G + c.rotor_inertia[rows, None] * G * self.qdd[:, k]

    def _judge(self, k: int, torque: Floats, rows: Rows) -> NDArray[np.int8]:
        peak, heat, speed = self._shares(k, torque, rows)
        loose = self.catalogue.backlash[rows] > self.backlash[k]
        tests = (speed > 1.0 + ROUNDING, peak > 1.0 + ROUNDING, heat > 1.0 + ROUNDING, loose)
        return np.select(tests, range(1, len(REASONS)), 0).astype(np.int8)

    def _shares(self, k: int, torque: Floats, rows: Rows) -> tuple[Floats, Floats, Floats]:
        c, rms = self.catalogue, np.sqrt((torque**2).mean(axis=1))
        fastest = np.abs(self.qd[:, k]).max()
        return (
            torque.max(axis=1) / c.peak_torque[rows],
            rms / c.continuous_torque[rows],
            c.ratio[rows] * fastest / c.speed[rows],
        )

    def answer(self, joints: tuple[str, ...]) -> DriveChoice:
        """The best choice with its reasons."""
        found = self.value < inf
        chosen = self.best if found else self.furthest
        if found:
            status = DriveStatus.FOUND if self.stopped else DriveStatus.BEST
        else:
            status = DriveStatus.STOPPED if self.stopped else DriveStatus.NONE
        n = len(chosen)
        every = np.arange(len(self.catalogue))
        reasons = np.array([self.reasons(k, chosen, every) for k in range(n)])
        shares = np.full((3, n), np.nan)
        for k in np.flatnonzero(chosen >= 0).tolist():
            row = chosen[[k]]
            shares[:, k] = np.ravel(self._shares(k, np.abs(self._motor(k, self.effort(k, chosen), row)), row))
        return DriveChoice(
            status, self.goal, joints, self.catalogue, chosen, reasons, shares[0], shares[1], shares[2], self.nodes
        )
