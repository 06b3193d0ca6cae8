"""Whether the tables of a job file beside its moves make sense: start, tools, controller, surfaces, robots, signals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from mafsil.job.language.description import Controller, Obstacle, Simulation, Variable
from mafsil.job.language.driving_tables import SPREADS, Normal, PerAxis, Spread, has_free_direction
from mafsil.job.language.frames import Complaint
from mafsil.job.language.move_checks import check_pose
from mafsil.job.language.part import Between, Condition, Input, SignalValue, Test
from mafsil.job.language.statements import JobFile, OtherProgram, OtherStatement, PlacedGoal, Statement
from mafsil.job.language.surrounding_tables import FILE_KEYS
from mafsil.job.language.text import Keys
from mafsil.job.tolerances import NO_DIRECTION
from mafsil.messages.visible import visible
from mafsil.simulation.rigid_plant import METHODS

TESTS = ("if", "while")
"""Keys that look at variables, too."""
KINDS_OF_OBSTACLE = ("box", "sphere", "cylinder", "capsule", "cone", "floor", *FILE_KEYS)
KEYS_OF_FILES: dict[str, tuple[str, ...]] = {
    "scale": FILE_KEYS,
    "hull": ("mesh",),
    "radius": ("cloud",),
    "size": ("heights",),
    "base": ("heights",),
}
"""Keys that have an effect beside some kinds of files only."""
NEEDED = {"cloud": "radius", "heights": "size"}
"""What has to be said beside a file."""
FORMS = {"track": ("direction", "axis"), "surface": ("normal", "sphere", "cylinder"), "guide": ("direction", "normal")}
"""Keys of what is touched of which exactly one is given."""
DIRECTIONS = {
    "track": ("direction", "axis"),
    "surface": ("normal", "axis"),
    "hole": ("axis",),
    "door": ("axis",),
    "guide": ("direction", "normal"),
}
COMPLIANCE = ("tip_stiffness", "rotational_stiffness", "tip_damping", "rotational_damping")
GAINS = {
    "computed_torque": ("frequency", "damping"),
    "pd_gravity": ("kp", "kd"),
    "pid": ("kp", "kd", "integral"),
    "feedforward": ("kp", "kd"),
    "sliding_mode": ("mass_uncertainty", "margin", "width"),
    "min_max": ("mass_uncertainty", "width"),
    "model_predictive": ("frequency", "horizon", "interval"),
    "linear_quadratic": ("frequency",),
    "adaptive": ("learning",),
    "task_computed_torque": ("frequency", "damping"),
    "impedance": (*COMPLIANCE, "damping"),
    "admittance": ("tip_mass", "turn_inertia", *COMPLIANCE, "damping"),
    "hybrid": ("frequency", "damping", "normal_force", "force_gain", "force_integral"),
}
"""Gains of each law; those of another one have no effect and are refused."""
SHORTEST_NORMAL = 1e-6
"""Length of a vector that is taken as a direction."""
WHOLE = 1e-6
"""How far the period of the law, in steps, may be from a whole number."""


def check_tables(file: JobFile, data: dict[str, Any], error: Complaint) -> None:
    """Refuse tables that make no sense.

    Args:
        file: checked key by key.
        data: what was typed.
        error: makes the complaint about a key.
    """
    check_obstacles(file.obstacle, data.get("obstacle", ()), error)
    _check_start(file, data.get("start", {}), error)
    _check_controller(file.controller, file.simulation, error)
    _check_variation(file, error)
    _check_contacts(file, error)
    for k, track in enumerate(file.track):
        if not track.range[0] < track.range[1]:
            raise error("job.track_range", ("track", k, "range"))
    _check_other_robots(file.other_robot, error)


def check_obstacles(obstacles: tuple[Obstacle, ...], data: Sequence[dict[str, Any]], error: Complaint) -> None:
    """Each obstacle is exactly one thing."""
    names: set[str] = set()
    for k, obstacle in enumerate(obstacles):
        if obstacle.name in names:
            raise error("job.obstacle_twice", ("obstacle", k, "name"), given=visible(obstacle.name))
        names |= {obstacle.name} - {""}
        given = [name for name in KINDS_OF_OBSTACLE if getattr(obstacle, name) not in (None, False)]
        if len(given) != 1:
            known = ", ".join(KINDS_OF_OBSTACLE)
            raise error("job.obstacle_kind", ("obstacle", k), given=", ".join(given) or "-", known=known)
        for name, owners in KEYS_OF_FILES.items():
            if name in data[k] and given[0] not in owners:
                raise error("job.mesh_key", ("obstacle", k, name), given=name, known=", ".join(owners))
        needed = NEEDED.get(given[0])
        if needed is not None and getattr(obstacle, needed) is None:
            raise error("job.file_needs", ("obstacle", k, given[0]), needed=needed)
        check_pose(obstacle, ("obstacle", k), data[k], error)


def _check_start(file: JobFile, data: dict[str, Any], error: Complaint) -> None:
    """One way to say where the robot begins."""
    if file.start.joints is not None and file.start.pose is not None:
        raise error("job.two_starts", ("start", "pose"))
    if isinstance(file.start.pose, PlacedGoal):
        check_pose(file.start.pose, ("start", "pose"), data["pose"], error)
    for path, tool in ((("tool",), file.tool), *((("tools", name), tool) for name, tool in file.tools.items())):
        if tool.offset is not None:
            check_pose(tool.offset, (*path, "offset"), {"position": ()}, error)


def _check_contacts(file: JobFile, error: Complaint) -> None:
    """What is touched makes sense; a door is held where the tip starts."""
    _check_forms(file, error)
    for k, surface in enumerate(file.surface):
        if (surface.cylinder is None) != (surface.axis is None):
            raise error("job.bar_axis", ("surface", k, "axis"))
        if surface.hollow and surface.normal is not None:
            raise error("job.hollow_plane", ("surface", k, "hollow"))
        _check_rigid(file, k, error)
    begin = file.start.pose
    held = file.pose.get(begin) if isinstance(begin, str) else begin
    from_start = [k for k, door in enumerate(file.door) if not door.grip]
    if from_start and not (held is None and begin is not None) and not _is_whole(held):
        raise error("job.door_start", ("door", from_start[0]))
    if file.controller.kind == "hybrid" and not file.surface:
        raise error("job.no_surface", ("controller", "kind"))


def _check_forms(file: JobFile, error: Complaint) -> None:
    """Each has one form, and its directions a length."""
    for kind, choices in FORMS.items():
        for k, one in enumerate(getattr(file, kind)):
            given = [name for name in choices if getattr(one, name) is not None]
            if len(given) != 1:
                known = ", ".join(choices)
                raise error("job.contact_form", (kind, k), given=", ".join(given) or "-", known=known)
    for kind, names in DIRECTIONS.items():
        for k, one in enumerate(getattr(file, kind)):
            for name in names:
                if getattr(one, name) is not None and math.hypot(*getattr(one, name)) < SHORTEST_NORMAL:
                    raise error("job.no_normal", (kind, k, name), given=name)


def _check_rigid(file: JobFile, k: int, error: Complaint) -> None:
    """A surface gives way or is rigid; what a rigid one does not go together with."""
    one, path = file.surface[k], ("surface", k)
    if not one.rigid:
        if one.stiffness is None:
            raise error("job.soft_surface", (*path, "stiffness"))
        if one.restitution is not None:
            raise error("job.soft_restitution", (*path, "restitution"))
        return
    for name in ("stiffness", "damping"):
        if getattr(one, name):
            raise error("job.rigid_gives", (*path, name), given=name)
    if file.variation is not None:
        raise error("job.rigid_varied", ("variation",))
    if file.simulation.plant not in (None, "mafsil"):
        raise error("job.rigid_plant", ("simulation", "plant"))
    if file.simulation.method not in (None, *METHODS):
        raise error("job.rigid_method", ("simulation", "method"), known=", ".join(METHODS))


def _is_whole(pose: PlacedGoal | None) -> bool:
    """Whether a pose says all of its orientation."""
    return pose is not None and pose.task == "pose" and (pose.rpy is not None or pose.quaternion is not None)


def _check_variation(file: JobFile, error: Complaint) -> None:
    """What is drawn has an order, changes something, and makes sense."""
    asked = file.variation
    if asked is None:
        return
    given: dict[str, Spread] = {name: getattr(asked, name) for name in SPREADS if getattr(asked, name) is not None}
    if not given:
        raise error("job.variation_empty", ("variation",), known=", ".join(SPREADS))
    for name, spread in given.items():
        path = ("variation", name)
        low = spread.mean if isinstance(spread, Normal) else spread[0]
        if isinstance(spread, tuple) and spread[1] < low:
            raise error("job.variation_order", path, low=low, high=spread[1])
        if low < 0.0 and name != "payload_offset":
            raise error("job.variation_negative", path, value=low)
    noise = file.simulation.noise
    if "noise" in given and noise.position == noise.velocity == 0.0:
        raise error("job.variation_noise", ("variation", "noise"))
    if "payload_offset" in given and "payload" not in given:
        raise error("job.variation_offset", ("variation", "payload_offset"))


def _check_controller(controller: Controller, simulation: Simulation, error: Complaint) -> None:
    """Every gain that is given belongs to the law that is chosen, whose period is a whole number of steps."""
    step, rate = simulation.step, controller.rate
    if rate is not None:
        steps = 1.0 / (rate * step)
        if steps < 1.0 - WHOLE or abs(steps - round(steps)) > WHOLE * steps:
            near = sorted({max(math.floor(steps), 1), math.ceil(steps)}, reverse=True)
            rates = ", ".join(f"{1.0 / (k * step):.9g}" for k in near)
            raise error("job.rate_not_whole", ("controller", "rate"), value=rate, step=step, near=rates)
    own = GAINS[controller.kind]
    for name in {name: None for names in GAINS.values() for name in names if name not in own}:
        if getattr(controller, name) is not None:
            raise error("job.no_gain", ("controller", name), kind=controller.kind, known=", ".join(own))
    for name in COMPLIANCE:
        given: PerAxis | None = getattr(controller, name)
        if isinstance(given, tuple) and len(given) != 3:
            raise error("job.per_axis", ("controller", name), got=len(given))
    for stiffness, damping in (COMPLIANCE[0::2], COMPLIANCE[1::2]):
        if has_free_direction(getattr(controller, stiffness)) and getattr(controller, damping) is None:
            raise error("job.free_undamped", ("controller", stiffness), damping=damping)


def _check_other_robots(robots: tuple[OtherProgram, ...], error: Complaint) -> None:
    """One way to say how a base is turned."""
    for k, robot in enumerate(robots):
        if robot.rpy is not None and robot.quaternion is not None:
            raise error("job.two_orientations", ("other_robot", k), given="rpy, quaternion")
        if robot.quaternion is not None and math.hypot(*robot.quaternion) < NO_DIRECTION:
            raise error("job.zero_quaternion", ("other_robot", k, "quaternion"))


def require_signals(file: JobFile, error: Complaint) -> None:
    """Refuse what cannot be set, waited for or answered.

    Args:
        file: checked key by key.
        error: makes the complaint about a key.

    Raises:
        JobError: a name that is output and input, or neither; a value of another kind; a table out of order.
    """
    for name, source in file.input.items():
        if name in file.output:
            raise error("job.signal_twice", ("input", name), signal=visible(name))
        _require_source(source, ("input", name), file, error)
    digital = {name: isinstance(value, bool) for name, value in file.output.items()}
    for name, source in file.input.items():
        digital[name] = isinstance(source.start, bool) if source.follows is None else digital[source.follows]
    _require_moves(file, digital, error)
    for name, frame in file.frame.items():
        if frame.since is not None and not (frame.since in file.input and digital[frame.since]):
            known = ", ".join(visible(one) for one in file.input if digital[one]) or "-"
            raise error("job.frame_since", ("frame", name, "since"), given=visible(frame.since), known=known)
    _require_others(file, digital, error)


def _require_moves(file: JobFile, digital: Mapping[str, bool], error: Complaint) -> None:
    """What moves set, wait for and ask fits the kinds of signals; a search by force has something to touch."""
    for statement, path in _statements(file.move, ("move",)):
        for values, here in outputs_of(statement, path):
            _require_values(values, file, digital, here, error)
        until = statement.until if isinstance(statement, Statement) else {}
        for key, conditions in (("wait", statement.wait), ("until", until)):
            for name, wanted in conditions.items():
                _require_kind(wanted, digital, name, (*path, key, name), error)
        for key, tests in (("if", statement.if_), ("while", statement.while_)):
            for name, test in tests.items():
                _require_test(test, digital, file.variables, name, (*path, key, name), error)
    touched = file.surface or file.hole or file.door or file.guide
    for statement, path in _statements(file.move, ("move",)):
        if isinstance(statement, Statement) and statement.until_force is not None and not touched:
            raise error("job.search_surface", (*path, "until_force"))


def _require_others(file: JobFile, digital: Mapping[str, bool], error: Complaint) -> None:
    """Signals of other robots, each output set by one robot alone."""
    statements = _statements(file.move, ("move",))
    main = (name for one, path in statements for values, _ in outputs_of(one, path) for name in values)
    owners = dict.fromkeys(main, "@job.owner_main")
    for k, robot in enumerate(file.other_robot):
        for move, path in _statements(robot.move, ("other_robot", k, "move")):
            _require_values(move.set, file, digital, path, error)
            for name, wanted in move.wait.items():
                _require_kind(wanted, digital, name, (*path, "wait", name), error)
            for key, tests in (("if", move.if_), ("while", move.while_)):
                for name, test in tests.items():
                    _require_test(test, digital, file.variables, name, (*path, key, name), error)
            for name in move.set:
                first = owners.setdefault(name, visible(robot.name))
                if first != visible(robot.name):
                    details = {"signal": visible(name), "first": first, "second": visible(robot.name)}
                    raise error("job.signal_owner", (*path, "set", name), **details)


def outputs_of(statement: Statement | OtherStatement, path: Keys) -> Iterator[tuple[Mapping[str, SignalValue], Keys]]:
    """What a statement sets, at rest and on the way, and where that stands."""
    yield statement.set, path
    if isinstance(statement, Statement):
        yield from ((one.set, (*path, "outputs", k)) for k, one in enumerate(statement.outputs))


def _require_values(
    values: Mapping[str, SignalValue], file: JobFile, digital: Mapping[str, bool], path: Keys, error: Complaint
) -> None:
    """Outputs, and values of their kind."""
    for name, value in values.items():
        here = (*path, "set", name)
        if name in file.input:
            raise error("job.signal_input", here, signal=visible(name))
        _require_kind(value, digital, name, here, error)


def _require_source(source: Input, path: Keys, file: JobFile, error: Complaint) -> None:
    """A table in order, or the answer to an output."""
    if source.follows is not None:
        given = {"start": source.start is not False, "changes": bool(source.changes), "every": source.every is not None}
        for key in (key for key, there in given.items() if there):
            raise error("job.signal_answer", (*path, key))
        if source.follows not in file.output:
            known = ", ".join(map(visible, file.output)) or "-"
            raise error("job.signal_follows", (*path, "follows"), given=visible(source.follows), known=known)
        return
    if source.after > 0.0:
        raise error("job.signal_after", (*path, "after"))
    if source.every is not None and not source.changes:
        raise error("job.signal_every", (*path, "every"))
    last = -1.0
    for k, (time, value) in enumerate(source.changes):
        if time <= last or (source.every is not None and time >= source.every):
            raise error("job.signal_order", (*path, "changes", k), time=f"{time:g}")
        if isinstance(value, bool) is not isinstance(source.start, bool):
            raise error("job.signal_start", (*path, "changes", k))
        last = time


def _require_kind(
    given: SignalValue | Condition,
    digital: Mapping[str, bool],
    name: str,
    path: Keys,
    error: Complaint,
    variables: Iterable[str] = (),
) -> None:
    """The name of a signal, and a value, or condition, of its kind."""
    if name not in digital:
        there = [*digital, *variables]
        known = ", ".join(map(visible, get_close_matches(name, there, n=1, cutoff=0.55) or there)) or "-"
        key = "job.test_unknown" if path[-2] in TESTS else "job.signal_unknown"
        raise error(key, path, signal=visible(name), known=known)
    if isinstance(given, Between):
        if given.above is None and given.below is None:
            raise error("job.signal_bounds", path)
        if given.above is not None and given.below is not None and not given.above < given.below:
            raise error("job.signal_bounds", path)
    if isinstance(given, bool) is not digital[name]:
        raise error("job.signal_digital" if digital[name] else "job.signal_number", path, signal=visible(name))


def _require_test(
    test: Test, digital: Mapping[str, bool], variables: Mapping[str, Variable], name: str, path: Keys, error: Complaint
) -> None:
    """The name of a signal or of a variable, not of both, and what its values can be compared with."""
    if name not in variables:
        if isinstance(test, str):
            raise error("job.test_text", path, signal=visible(name))
        _require_kind(test, digital, name, path, error, variables)
        return
    value = variables[name]
    if name in digital:
        raise error("job.test_both", path, signal=visible(name))
    if isinstance(value, tuple):
        raise error("job.test_list", path, variable=visible(name))
    if isinstance(test, str) is not isinstance(value, str):
        raise error("job.test_kind", path, variable=visible(name), value=visible(str(value)))
    if not isinstance(test, str):
        _require_kind(test, {name: isinstance(value, bool)}, name, path, error)


def _statements(
    statements: Sequence[Statement | OtherStatement], path: Keys
) -> Iterator[tuple[Statement | OtherStatement, Keys]]:
    """All statements, those in loops and choices too, each with its place."""
    for k, statement in enumerate(statements):
        yield statement, (*path, k)
        for key, inner in (("do", statement.do), ("then", statement.then), ("else", statement.else_)):
            yield from _statements(inner or (), (*path, k, key))
