"""Figures of chapters 9 and 10: a link cut free; control loops, one joint, friction, force and impedance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, pi, sin

import numpy as np

import mafsil.control as control
import mafsil.one_joint as oj
from mafsil.arrays import Floats
from mafsil.book.drawing import add_blocks, circle, tube
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.book.programs import Bench, Reference, computed_torque_loop, feedforward_loop, listing, pid_loop
from mafsil.figures.panel import ACCENT, BLUE, COLOURS, GREEN, INK, RED, SECOND, SOFT, Panel
from mafsil.figures.touching import push_response
from mafsil.one_joint.drives import SpeedFriction
from mafsil.performance.statics import joint_reactions
from mafsil.robot import as_robot

ARM = oj.JointArm.of(0.5, 1.0, 0.1, 0.1)
"""The arm of the chapter: M = 0.5 kg m^2, m = 1 kg, r = 0.1 m, b = 0.1 N m s/rad."""
MODEL = oj.JointArm.of(0.5, 1.0, 0.08, 0.1)
"""The same arm, its mass centre believed at 0.08 m."""
GAINS = np.array([2.205, 1.0, 2.0])
"""kp, ki, kd of figure 10.6."""
TIME, ERROR = "$t$ [s]", r"$\theta_e$ [rad]"


@draws("9.1", elbow=Slider(-2.5, 2.5, 0.9))
def free_body_of_a_link(elbow: float) -> Drawing:
    """The second link of a planar 3R arm with the wrenches at its two joints and its weight."""
    robot = as_robot("planar3r")
    q = np.array([0.4, elbow, -0.5])
    places = np.array([robot.forward_kinematics(q, frame=link.name)[:3, 3] for link in robot.mechanism.links[-3:]])
    start, end = places[1, :2], places[2, :2]
    reactions = joint_reactions(robot, q)
    panel = Panel().line([start, end], BLUE, width=9.0, name="link").dots([start, end], "#2a2a2a", width=8.0)
    middle = (start + end) / 2
    along = (end - start) / np.linalg.norm(end - start)
    T = np.eye(3)
    T[:2, :2], T[:2, 2] = np.column_stack([along, [-along[1], along[0]]]), middle
    panel.frame(T, 0.25, "i").arrow(middle, [0, -0.35], r"$m_i g$", colour=RED, name="weight")
    panel.arrow(start - 0.45 * along, 0.4 * along, r"$F_i$", colour=ACCENT, reach=-0.15, name="wrench i")
    panel.arrow(
        end + 0.45 * along, -0.4 * along, r"$-\mathrm{Ad}^\top F_{i+1}$", colour=GREEN, reach=-0.35, name="wrench i+1"
    )
    panel.arc(start, 0.14, (1.0, 4.0), colour=SOFT, head=True, name="torque")
    return Drawing({"a": panel}, {"robot": robot, "q": q, "reactions": reactions}, [Fact("links", robot.n)])


@draws("10.1")
def control_system() -> Drawing:
    """The loop with amplifier, actuator and sensors, and the simplified one."""
    law = control.pid(1, GAINS[0], GAINS[2])
    both = {"a": control.block_diagram(law), "b": control.block_diagram(law, idealised=True)}
    panels = {name: add_blocks(Panel(), diagram) for name, diagram in both.items()}
    facts = Fact("blocks_a", len(both["a"].blocks)), Fact("blocks_b", len(both["b"].blocks))
    return Drawing(panels, both, facts, columns=1, cell=(9.0, 2.6))


@draws("10.2", theta=Slider(-pi, pi, 0.6))
def one_joint_arm(theta: float) -> Drawing:
    """A link in a vertical plane with its mass centre, gravity and torque."""
    u, torque = np.array([cos(theta), sin(theta)]), float(ARM.gravity_moment) * cos(theta)
    panel = Panel().line([[0, 0], [0.3, 0]], SOFT, "--").line([[0, 0], 0.25 * u], BLUE, width=7.0, name="link")
    panel.dots([0, 0], INK, width=9.0, name="joint").dots(0.1 * u, ACCENT, width=9.0, name="mass centre")
    panel.arrow(0.1 * u, [0.0, -0.12], "$mg$", colour=RED, name="gravity").label(0.1 * u, "$r$", offset=(-6, 14))
    panel.arc([0, 0], 0.16, (0.0, theta), r"$\theta$", name="angle", head=True)
    panel.arc([0, 0], 0.06, (2.2, 2.2 + 3.6), r"$\tau$", colour=GREEN, name="torque", head=True)
    return Drawing({"a": panel}, {"arm": ARM}, [Fact("gravity_torque", torque, unit="N m")])


@draws("10.3")
def pid_diagram() -> Drawing:
    """The three terms of PID, their sum, and what comes back."""
    diagram = control.block_diagram(control.pid(1, GAINS[0], GAINS[2], GAINS[1]), idealised=True)
    facts = [Fact("terms", len(diagram.terms))]
    return Drawing({"a": add_blocks(Panel(), diagram)}, {"diagram": diagram}, facts, cell=(8.0, 4.0))


@draws("10.4", damping_ratio=Slider(0.1, 0.9, 0.3, "1"))
def error_response(damping_ratio: float) -> Drawing:
    """An underdamped error with steady error, overshoot and the band of 2 %."""
    loop, rest = oj.SecondOrder.of(6.0, damping_ratio), 0.1
    t = np.linspace(0.0, 6.0 / (6.0 * damping_ratio) + 1.0, 1201)
    error = rest + (1.0 - rest) * loop.response(t)
    seen = oj.measure_response(t, error, steady_error=rest)
    settled, peak = float(seen.settling_time), float(loop.peak_time)
    panel = Panel((TIME, ERROR), equal=False).line(np.column_stack([t, error]), BLUE, width=2.0, name="error")
    for k, level in enumerate((rest, rest + 0.02 * (1 - rest), rest - 0.02 * (1 - rest))):
        panel.line([[0.0, level], [t[-1], level]], SOFT, "--" if k == 0 else ":", name=f"level {k}")
    panel.line([[settled, -0.4], [settled, 1.0]], GREEN, "--", name="settling").label([settled, 0.8], r"$t_{2\%}$")
    panel.arrow([peak, rest], [0.0, error.min() - rest], colour=RED, name="overshoot").label([t[-1], rest], "$e_{ss}$")
    facts = (
        Fact("overshoot", 100 * float(seen.overshoot), unit="%"), Fact("settling", settled, unit="s"),
        Fact("rule", float(loop.settling_by_rule), unit="s"), Fact("steady_error", rest, unit="rad"),
    )  # fmt: skip
    return Drawing({"a": panel}, {"loop": loop, "measures": seen}, facts, cell=(6.4, 4.4))


def _locus(locus: oj.RootLocus, gains: Mapping[float, str], limits: tuple[float, float, float, float]) -> Panel:
    """Branches, and crosses at gains with their colours."""
    panel = Panel(("Re $s$ [1/s]", "Im $s$ [1/s]"), limits=limits, equal=False)
    for k in range(locus.roots.shape[1]):
        branch = locus.roots[:, k]
        panel.line(np.column_stack([branch.real, branch.imag]), SOFT, width=1.4, name=f"branch {k}")
    for gain, colour in gains.items():
        s = locus.roots[int(np.argmin(np.abs(locus.gains - gain)))]
        panel.dots(np.column_stack([s.real, s.imag]), colour, "x", 9.0, f"roots {gain:g}")
    return panel


@draws("10.5")
def roots_of_pd() -> Drawing:
    """Roots of M s^2 + (b + Kd) s + Kp as Kp grows, and the responses at three of them."""
    kp = np.round([float(oj.kp_for_damping_ratio(0.5, 10.1, zeta)) for zeta in (1.5, 1.0, 0.5)], 4)
    gains = np.unique(np.concatenate([np.linspace(0.0, 300.0, 601), kp]))
    locus = oj.root_locus([0.5, 10.1, 0.0], [1.0], gains)
    colours = dict(zip(kp.tolist(), (SECOND, BLUE, ACCENT), strict=True))
    t, responses = np.linspace(0.0, 2.0, 401), Panel((TIME, ERROR), equal=False)
    for gain, colour in colours.items():
        error = oj.SecondOrder.of_joint(0.5, 10.1, gain).response(t)
        responses.line(np.column_stack([t, error]), colour, width=2.0, name=f"response {gain:g}")
        at = int(np.argmin(np.abs(error - (0.25 if gain < 40.0 else 0.7 if gain < 100.0 else -0.1))))
        responses.label([t[at], error[at]], f"$K_p = {gain:.4g}$", colour, (38, -14 if gain > 100.0 else 10), 8.0)
    loops = oj.SecondOrder.of_joint(0.5, 10.1, kp)
    facts = (
        Fact("kp", kp), Fact("settling", loops.settling_time(), unit="s"),
        Fact("rule", loops.settling_by_rule, unit="s"),
        Fact("overshoot", 100 * float(loops.overshoot[2]), unit="%"),
        Fact("short", 100 * float(1 - loops.settling_by_rule[1] / loops.settling_time()[1]), unit="%"),
    )  # fmt: skip
    panels = {"a": _locus(locus, colours, (-21, 4, -22, 22)), "b": responses}
    return Drawing(panels, {"locus": locus, "loops": loops}, facts, cell=(4.6, 4.2))


@draws("10.6", status=EntryStatus.REBUILT, start=Slider(-pi, pi, -pi / 2))
def pd_and_pid_under_gravity(start: float) -> Drawing:
    """Error and torque of PD and PID from a start at rest to the horizontal, and the poses."""
    laws = {"PD": oj.JointLaw.pid(GAINS[0], 0.0, GAINS[2]), "PID": oj.JointLaw.pid(*GAINS)}
    runs = {name: oj.simulate_joint(ARM, law, 0.0, 10.0, start=start, step=0.005) for name, law in laws.items()}
    panels = {"a": Panel((TIME, ERROR), equal=False), "b": Panel((TIME, r"$\tau$ [N m]"), equal=False), "c": Panel()}
    for (name, run), colour in zip(runs.items(), (ACCENT, BLUE), strict=True):
        for panel, values in ((panels["a"], run.error), (panels["b"], run.torque)):
            panel.line(np.column_stack([run.t, values]), colour, width=1.8, name=name)
            panel.label([8.5, values[1700]], name, colour, (0, 9))
        end = run.theta[-1]
        panels["c"].line([[0, 0], [cos(end), sin(end)]], colour, width=3.0, name=name)
    panels["c"].line([[0, 0], [cos(start), sin(start)]], SOFT, width=5.0, name="start")
    panels["c"].line([[0, 0], [1, 0]], INK, ":", name="goal").dots([0, 0]).label([1, 0], r"$\theta_d$", offset=(10, 0))
    rest = oj.steady_state_error(GAINS[0], ARM.gravity_moment, 0.0)
    facts = Fact("pd_error", float(rest.error), unit="rad"), Fact("pid_error", float(runs["PID"].error[-1]), unit="rad")
    return Drawing(panels, {"runs": runs, "rest": rest}, facts)


@draws("10.7")
def roots_of_pid() -> Drawing:
    """Three roots as Ki grows from zero."""
    limit = float(oj.ki_limit(0.5, 2.1, 2.205))
    gains = np.unique(np.concatenate([np.linspace(0.0, 14.0, 1401), [0.686, 1.0, limit]]))
    locus = oj.root_locus([0.5, 2.1, 2.205, 0.0], [1.0], gains)
    panel = _locus(locus, {0.0: INK, 1.0: BLUE, limit: RED}, (-5.4, 1.4, -3.4, 3.4))
    panel.line([[0, -3.4], [0, 3.4]], SOFT, ":").label([0.0, 2.1], f"$K_i = {limit:.4g}$", RED, (-34, 4), 8.0)
    facts = Fact("limit", limit), Fact("meeting", float(locus.meeting_gains.max()))
    return Drawing({"a": panel}, {"locus": locus}, facts, cell=(5.0, 5.0))


def _still(goal: float) -> Reference:
    return lambda _: (goal, 0.0, 0.0)


def _program(text: str, t: Floats, error: Floats, marks: tuple[float, ...]) -> dict[str, Panel]:
    graph = Panel((TIME, ERROR), equal=False).line(np.column_stack([t, error]), BLUE, width=1.8, name="error")
    at = [round(float(time / (t[1] - t[0]))) for time in marks]
    graph.dots(np.column_stack([t[at], error[at]]), ACCENT, name="marks")
    code = Panel(limits=(0.0, 1.0, -1.0, 0.0), equal=False).code([0.02, -0.03], text, 8.5)
    return {"a": code, "b": graph}


@draws("10.8", period=Slider(0.001, 0.1, 0.01, "s"))
def program_of_pid(period: float) -> Drawing:
    """The PID loop as a program, and the error when it runs."""
    bench, ticks = Bench(ARM, -pi / 2, period), round(5.0 / period)
    pid_loop(bench.sense, bench.command, _still(0.0), GAINS, period, ticks)
    t, error = np.linspace(0.0, period * ticks, ticks + 1), -bench.theta
    facts = [Fact(f"error_{k}", error[round(k / period)], unit="rad") for k in (1, 2, 5)]
    return Drawing(_program(listing(pid_loop), t, error, (1.0, 2.0)), {"bench": bench}, facts, cell=(5.0, 3.6))


def _task(middle: float, amplitude: float = 1.0) -> Reference:
    return lambda t: (middle - amplitude * cos(t), amplitude * sin(t), amplitude * cos(t))


def _cosine(middle: float, amplitude: float = 1.0) -> Callable[[Floats], tuple[Floats, Floats, Floats]]:
    return lambda t: (middle - amplitude * np.cos(t), amplitude * np.sin(t), amplitude * np.cos(t))


@draws("10.9")
def program_of_feedforward() -> Drawing:
    """The feedforward loop as a program, and the error when it runs with the right model."""
    dt, ticks, task = 0.005, 628, _task(-pi / 2)
    bench = Bench(ARM, task(0.0)[0], dt)
    feedforward_loop(bench.command, task, ARM, dt, ticks)
    t = np.linspace(0.0, dt * ticks, ticks + 1)
    error = np.array([task(one)[0] for one in t]) - bench.theta
    facts = [Fact("largest", float(np.abs(error).max()), unit="rad")]
    return Drawing(_program(listing(feedforward_loop), t, error, ()), {"bench": bench}, facts, cell=(5.4, 3.4))


@draws("10.10", status=EntryStatus.REBUILT, amplitude=Slider(0.1, 1.2, 1.0))
def feedforward_with_a_wrong_mass_centre(amplitude: float) -> Drawing:
    """Two tasks under feedforward alone, its mass centre at 0.08 m for 0.1 m."""
    panels: dict[str, Panel] = {}
    runs: dict[str, oj.JointRun] = {}
    for name, middle in (("a", -pi / 2), ("b", pi / 2)):
        task = _task(middle, amplitude)
        law = oj.JointLaw.feedforward(MODEL)
        run = oj.simulate_joint(ARM, law, _cosine(middle, amplitude), pi, start=task(0.0)[0], step=pi / 1000)
        panel = Panel((TIME, r"$\theta$ [rad]"), equal=False)
        panel.line(np.column_stack([run.t, run.theta + run.error]), SOFT, "--", 1.8, name="wanted")
        panels[name] = panel.line(np.column_stack([run.t, run.theta]), BLUE, width=2.0, name="angle")
        runs[name] = run
    left_out = float(ARM.gravity_moment - MODEL.gravity_moment)
    facts = (
        Fact("left_out", left_out, unit="N m"), Fact("task_1", float(runs["a"].largest_error), unit="rad"),
        Fact("task_2", float(runs["b"].largest_error), unit="rad"),
    )  # fmt: skip
    return Drawing(panels, {"arm": ARM, "model": MODEL, "runs": runs}, facts, cell=(4.4, 3.6))


@draws("10.11")
def computed_torque_diagram() -> Drawing:
    """Feedback to an acceleration, the mass matrix, the bias, the arm."""
    diagram = control.block_diagram(control.computed_torque(as_robot("planar2r")), idealised=True)
    facts = [Fact("terms", len(diagram.terms))]
    return Drawing({"a": add_blocks(Panel(), diagram)}, {"diagram": diagram}, facts, cell=(8.6, 3.2))


@draws("10.12", status=EntryStatus.REBUILT)
def feedforward_feedback_and_both() -> Drawing:
    """Error and effort of three laws in task 2 of figure 10.10."""
    laws = {
        "feedforward": oj.JointLaw.feedforward(MODEL), "PID": oj.JointLaw.pid(*GAINS),
        "computed torque": oj.JointLaw.computed_torque(MODEL, *GAINS),
    }  # fmt: skip
    runs = {
        name: oj.simulate_joint(ARM, law, _cosine(pi / 2), pi, start=pi / 2 - 1, step=pi / 1000)
        for name, law in laws.items()
    }
    error, effort = Panel((TIME, ERROR), equal=False), Panel((TIME, r"$\int\tau^2\,dt$"), equal=False)
    for k, (name, run) in enumerate(runs.items()):
        spent = np.concatenate([[0.0], np.cumsum(np.diff(run.t) * (run.torque[1:] ** 2 + run.torque[:-1] ** 2) / 2)])
        for panel, values in ((error, run.error), (effort, spent)):
            panel.line(np.column_stack([run.t, values]), COLOURS[k], width=1.8, name=name)
            panel.label([run.t[800], values[800]], ("$a$", "$b$", "$c$")[k], COLOURS[k], (0, 9))
    facts = (
        Fact("rms", [float(run.rms_error) for run in runs.values()], unit="rad"),
        Fact("effort", [float(run.effort) for run in runs.values()], unit="N^2 m^2 s"),
    )  # fmt: skip
    return Drawing({"a": error, "b": effort}, {"runs": runs}, facts, cell=(4.6, 3.8))


@draws("10.13", period=Slider(0.001, 0.05, 0.005, "s"))
def program_of_computed_torque(period: float) -> Drawing:
    """The computed torque loop as a program, and the error when it runs with the wrong mass centre."""
    task, ticks = _task(pi / 2), round(pi / period)
    bench = Bench(ARM, task(0.0)[0], period)
    computed_torque_loop(bench.sense, bench.command, task, MODEL, GAINS, period, ticks)
    t = np.linspace(0.0, period * ticks, ticks + 1)
    error = np.array([task(one)[0] for one in t]) - bench.theta
    facts = [Fact("rms", float(np.sqrt(np.mean(error**2))), unit="rad")]
    return Drawing(_program(listing(computed_torque_loop), t, error, ()), {"bench": bench}, facts, cell=(5.4, 3.6))


@draws("10.14")
def six_friction_laws() -> Drawing:
    """Friction against speed; at rest all that it can be."""
    laws = {
        "a": SpeedFriction.viscous_only(0.5), "b": SpeedFriction.coulomb(0.6),
        "c": SpeedFriction.static_viscous(0.6, 0.3), "d": SpeedFriction.static_kinetic(0.9, 0.6),
        "e": SpeedFriction.static_kinetic_viscous(0.9, 0.6, 0.3), "f": SpeedFriction.stribeck(0.9, 0.5, 0.2, 0.15),
    }  # fmt: skip
    panels: dict[str, Panel] = {}
    for name, law in laws.items():
        panel = Panel((r"$\dot\theta$ [rad/s]", r"$\tau$ [N m]"), limits=(-1.1, 1.1, -1.2, 1.2), equal=False)
        for side in (-1.0, 1.0):
            w = side * np.linspace(1e-6, 1.0, 101)
            panel.line(np.column_stack([w, law.torque(w)]), BLUE, width=2.0, name=f"moving {side:+.0f}")
        low, high = (float(end) for end in law.interval(0.0))
        panels[name] = panel.line([[0, low], [0, high]], BLUE, width=2.0, name="rest")
    facts = [Fact("breakaway", [float(law.interval(0.0)[1]) for law in laws.values()], unit="N m")]
    return Drawing(panels, laws, facts, cell=(3.2, 2.9))


@draws("10.15", status=EntryStatus.SCHEMATIC)
def wrist_sensor() -> Drawing:
    """A six-axis sensor between arm and tool: it feels the tip's wrench and the tool's weight."""
    lever, force, weight = np.array([0.0, 0.0, 0.18]), np.array([2.0, 0.0, 5.0]), np.array([0.0, 0.0, -4.0])
    panel = Panel(elevation=16.0, zoom=1.25)
    for name, span, radius, colour in (
        ("arm", (-0.22, 0.0), 0.05, SOFT), ("sensor", (0.0, 0.04), 0.06, BLUE), ("tool", (0.04, 0.18), 0.02, ACCENT),
    ):  # fmt: skip
        panel.surface(tube([0, 0, span[0]], [0, 0, span[1]], radius), colour, 0.6, name)
        panel.line(circle([0, 0, span[1]], [0.0, 0.0, 1.0], radius), colour, width=1.2)
    panel.arrow(lever, 0.02 * force, "$f$", colour=RED, name="force")
    panel.arrow([0.02, 0, 0.12], 0.02 * weight, "$mg$", colour=INK, name="weight").frame(np.eye(4), 0.11, "c")
    felt = np.concatenate([np.cross(lever, force), force + weight])
    facts = [Fact("felt", felt, unit="N m, N")]
    return Drawing({"a": panel}, {"lever": lever, "force": force, "weight": weight}, facts)


@draws("10.16", heading=Slider(-pi, pi, 0.5))
def board_and_eraser(heading: float) -> Drawing:
    """An eraser on a board, the frames of both, and what each leaves free."""
    names, blocked = ("phi_x", "phi_y", "phi_z", "x", "y", "z"), (True, True, False, False, False, True)
    table = control.constraint_table(blocked, (0.0, 0.0, 0.0, 1.0, 0.0, 2.0), names)
    T = np.eye(4)
    T[:2, :2] = [[cos(heading), -sin(heading)], [sin(heading), cos(heading)]]
    T[:3, 3] = 0.12, 0.10, 0.015
    panel = Panel(elevation=35.0).fill(_sheet(np.array([0.12, 0.09, 0.0]), 0.14, 0.11), SOFT, 0.2, name="board")
    for side in (-1, 1):
        face = _sheet(np.array([0.0, 0.0, side * 0.015]), 0.035, 0.02) @ T[:3, :3].T + T[:3, 3]
        panel.fill(face, BLUE, 0.4, name=f"eraser {side}")
    panel.frame(np.eye(4), 0.06, "s").frame(T, 0.06, "b")
    panel.arrow(T[:3, 3] + [0, 0, 0.09], [0, 0, -0.05], "$F_z$", colour=RED, reach=-0.2, name="pressing")
    facts = Fact("constraints", sum(blocked), 3), Fact("freedoms", 6 - sum(blocked), 3)
    return Drawing({"a": panel}, {"table": table, "T_sb": T}, facts)


def _sheet(centre: Floats, half_x: float, half_y: float) -> Floats:
    return centre + np.array([[sx * half_x, sy * half_y, 0.0] for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


@draws("10.17", status=EntryStatus.REBUILT, stiffness=Slider(5.0, 200.0, 50.0, "N/m"))
def haptic_device(stiffness: float) -> Drawing:
    """A virtual mass on a spring and a damper, pushed by a hand, and its motion."""
    mass, damping, push = 1.0, 4.0, 5.0
    coil = np.linspace(0.3, 1.2, 29)
    spring = np.column_stack([[0.0, *coil, 1.5], 0.3 + np.array([0.0, *(0.12 * np.sin(np.arange(29) * pi / 2)), 0.0])])
    panel = Panel().line([[0, -0.6], [0, 0.7]], INK, width=3.0, name="wall").line(spring, BLUE, name="spring")
    panel.line([[0, -0.3], [0.6, -0.3]], INK).line([[1.1, -0.15], [0.6, -0.15], [0.6, -0.45], [1.1, -0.45]], INK)
    panel.line([[0.85, -0.13], [0.85, -0.43]], INK, width=2.4, name="damper").line([[0.85, -0.28], [1.5, -0.28]], INK)
    panel.fill([[1.5, -0.55], [2.2, -0.55], [2.2, 0.55], [1.5, 0.55]], ACCENT, name="mass").label([1.85, 0], "$m$")
    panel.label([0.75, 0.55], "$k$").label([0.85, -0.62], "$b$")
    panel.arrow([3.0, 0.0], [-0.8, 0.0], "$F$", colour=RED, reach=-0.15, name="push")
    t, x = push_response(mass, damping, stiffness, push)
    graph = Panel((TIME, "$x$ [m]"), equal=False).line(np.column_stack([t, x]), BLUE, width=1.8, name="motion")
    graph.line([[0, push / stiffness], [t[-1], push / stiffness]], RED, "--", name="rest")
    felt = control.Impedance.of(1, inertia=mass, damping=damping, stiffness=stiffness)
    facts = Fact("rest", push / stiffness, unit="m"), Fact("frequency", float(np.sqrt(stiffness / mass)), unit="rad/s")
    return Drawing({"a": panel, "b": graph}, {"impedance": felt}, facts, cell=(4.6, 3.4))
