"""All operations of the command line."""

from __future__ import annotations

from dataclasses import replace

from mafsil.cli.operation import Operation, Parameter
from mafsil.messages import LANGUAGES

_ROBOT = Parameter("robot", "text", positional=True, required=True, reads=True, explained="cli.given_robot")
_TIP = Parameter("tip", "text", explained="cli.given_tip")
_DEGREES = Parameter("degrees", "flag", explained="cli.given_degrees")
_RUNS = (Parameter("out", "path"), Parameter("progress", "flag"), Parameter("open", "flag"))
_MOTIONS = (
    ("rpy", "A"), ("quaternion", "W"), ("matrix", "M"), ("axis_angle", "X"), ("euler", "SEQUENCE"),
    ("rotation_vector", "R"), ("gibbs", "G"), ("pose", "T"), ("exponential", "V"), ("screw", "S"), ("planar", "P"),
)  # fmt: skip
"""Ways to type a motion in `convert`, and what stands for their numbers in the help."""

COMMON = (
    Parameter("json", "flag", explained="cli.json"),
    Parameter("lang", "text", choices=LANGUAGES, explained="cli.lang"),
    Parameter("no_color", "flag", explained="cli.no_color"),
    Parameter("debug", "flag", explained="cli.debug"),
)
"""Options of every command; they may stand before it too."""
ROBOT_OPTIONS = (
    Parameter("lock", "text", metavar="JOINT=VALUE"),
    Parameter("tool", "angle", many=True, metavar="M"),
    Parameter("payload", "number", metavar="KG"),
    Parameter("xacro_arg", "text", metavar="NAME:=VALUE"),
    Parameter("model", "text", metavar="NAME"),
    Parameter("base", "angle", many=True, metavar="M"),
    Parameter("gravity", "number", many=True, metavar="M/S^2"),
)
"""Options of every command that takes a robot, applied to it before the command sees it."""
REPEATED = ("lock", "xacro_arg")
"""Those of them that may be given several times."""
UNEQUIPPED = ("lint",)
"""Commands that look at the file of a robot as it is."""
_VIEW = Parameter("view", "path", many=True, metavar="FILE")
_Q = Parameter("q", "angle", positional=True, many=True, metavar="Q", explained="cli.given_q")

_TRAJECTORY_ACTIONS = ("check", "suggest-fixes", "compare", "export")

OPERATIONS: tuple[Operation, ...] = (
    Operation(
        "run",
        "mafsil.cli.run:run",
        (
            Parameter("job", "path", positional=True, required=True, reads=True),
            *_RUNS,
            Parameter("dry_run", "flag"),
            Parameter("set", "text", many=True, metavar="NAME=VALUE"),
            Parameter("plant", "text", choices=("mafsil", "mujoco", "kinematic")),
            Parameter("real_time", "flag"),
            Parameter("log", "path", metavar="FILE.mcap"),
            Parameter("runs", "text", metavar="N"),
            Parameter("cluster", "text", metavar="N|ADDRESS"),
        ),
    ),
    Operation(
        "check-job",
        "mafsil.cli.run:check_job",
        (
            Parameter("job", "path", positional=True, required=True, reads=True),
            Parameter("program", "path", metavar="FILE"),
        ),
    ),
    Operation("demo", "mafsil.cli.run:demo", _RUNS),
    Operation(
        "sweep",
        "mafsil.cli.sweep:sweep",
        (
            Parameter("job", "path", positional=True, required=True, reads=True),
            Parameter("over", "text", positional=True, many=True, required=True, metavar="NAME=V,V"),
            Parameter("simulate", "flag"),
            Parameter("progress", "flag"),
        ),
    ),
    Operation(
        "compare",
        "mafsil.cli.compare:compare",
        (
            Parameter("what", "text", positional=True, required=True, choices=("control", "planners", "log")),
            Parameter("job", "path", positional=True, required=True, reads=True),
            Parameter("laws", "text", many=True, metavar="LAW"),
            Parameter("planners", "text", many=True, metavar="PLANNER"),
            Parameter("seeds", "count"),
            Parameter("seconds", "number"),
            Parameter("replay", "path"),
            Parameter("log", "path", reads=True, endings=(".csv",)),
            *_RUNS,
        ),
    ),
    Operation(
        "diff",
        "mafsil.cli.diff:diff",
        (
            Parameter("before", "path", positional=True, required=True, reads=True),
            Parameter("after", "path", positional=True, required=True, reads=True),
        ),
    ),
    Operation(
        "studio",
        "mafsil.cli.studio:studio",
        (
            Parameter("what", "text", positional=True, many=True),
            Parameter("port", "count"),
            Parameter("open", "flag"),
            _VIEW,
        ),
        serves=True,
    ),
    Operation("list", "mafsil.cli.library_list:robots"),
    Operation(
        "book",
        "mafsil.cli.book:book",
        (
            Parameter("what", "text", positional=True),
            Parameter("number", "text", positional=True),
            Parameter("picture", "path"),
            Parameter("seed", "count"),
            Parameter("level", "count"),
            Parameter("answer", "text", many=True, metavar="NAME=NUMBERS"),
            Parameter("solution", "flag"),
            Parameter("students", "path", reads=True, metavar="FILE.csv"),
            Parameter("exam", "flag"),
            Parameter("eastern_digits", "flag"),
            Parameter("files", "path", many=True, reads=True, metavar="FILE.csv"),
            Parameter("out", "path", metavar="FOLDER"),
        ),
    ),
    Operation(
        "show",
        "mafsil.cli.show:show",
        (
            _ROBOT,
            _TIP,
            Parameter("picture", "path"),
            Parameter("out", "path"),
            Parameter("open", "flag"),
            _VIEW,
            replace(_DEGREES, explained=""),
        ),
    ),
    Operation(
        "fk",
        "mafsil.cli.fk:fk",
        (
            _ROBOT,
            _Q,
            Parameter("frame", "text"),
            _TIP,
            _DEGREES,
        ),
    ),
    Operation(
        "ik",
        "mafsil.cli.ik:ik",
        (
            _ROBOT,
            Parameter("pose", "angle", many=True, required=True, metavar="P"),
            Parameter("all", "flag"),
            Parameter("near", "angle", many=True, metavar="Q"),
            Parameter("task", "text", choices=("pose", "position", "axis")),
            Parameter("frame", "text"),
            _TIP,
            replace(_DEGREES, explained=""),
            Parameter("picture", "path"),
        ),
    ),
    Operation(
        "dynamics",
        "mafsil.cli.dynamics:dynamics",
        (
            _ROBOT,
            Parameter("q", "angle", many=True, required=True, metavar="Q"),
            Parameter("qd", "angle", many=True, metavar="QD"),
            Parameter("qdd", "angle", many=True, metavar="QDD"),
            Parameter("tau", "number", many=True, metavar="TAU"),
            Parameter("duration", "number"),
            Parameter("out", "path"),
            Parameter("frictionless", "flag"),
            Parameter("quantities", "text", many=True, metavar="NAME"),
            _TIP,
            _DEGREES,
        ),
    ),
    Operation(
        "plan",
        "mafsil.cli.plan:plan",
        (
            _ROBOT,
            Parameter("start", "angle", many=True, required=True, metavar="Q", explained="cli.given_q"),
            Parameter("goal", "angle", many=True, metavar="Q"),
            Parameter("pose", "angle", many=True, metavar="P"),
            Parameter("box", "number", many=True, metavar="M"),
            Parameter("angle", "angle"),
            Parameter("upright", "angle"),
            Parameter("orientation", "flag"),
            Parameter("line", "number", many=True, metavar="D"),
            Parameter("plane", "number", many=True, metavar="N"),
            Parameter("scene", "path", reads=True),
            Parameter("clearance", "number"),
            Parameter("self_clearance", "number"),
            Parameter(
                "planner",
                "text",
                choices=(
                    "rrt_connect",
                    "prm",
                    "rrt_star",
                    "lazy_prm_star",
                    "trajectory_optimisation",
                    "cell_decomposition",
                ),
            ),
            Parameter("srdf", "path", reads=True),
            Parameter("known_free", "angle", many=True, metavar="Q"),
            Parameter("active_joints", "text", many=True, metavar="JOINT"),
            Parameter("seed", "count"),
            Parameter("seconds", "number"),
            Parameter("out", "path"),
            _TIP,
            _DEGREES,
        ),
    ),
    Operation(
        "base-placement",
        "mafsil.cli.base_placement:base_placement",
        (
            _ROBOT,
            Parameter("targets", "path", required=True, reads=True),
            Parameter("scene", "path", reads=True),
            Parameter("x", "number", many=True, metavar="M"),
            Parameter("y", "number", many=True, metavar="M"),
            Parameter("height", "number", many=True, metavar="M"),
            Parameter("yaws", "count"),
            Parameter("spacing", "number"),
            Parameter("enough_clearance", "number"),
            Parameter("stands_on", "text", many=True, metavar="NAME"),
            Parameter("picture", "path"),
            _TIP,
            replace(_DEGREES, explained=""),
        ),
    ),
    Operation(
        "design",
        "mafsil.cli.design:design",
        (
            Parameter(
                "what",
                "text",
                positional=True,
                required=True,
                choices=("robot", "tasks", "accuracy", "allocate", "drives", "search"),
            ),
            Parameter("file", "path", positional=True, required=True, reads=True, endings=(".toml",)),
            Parameter("values", "text", many=True, metavar="NAME=VALUE"),
            Parameter("catalogue", "path"),
            Parameter("seed", "count"),
            Parameter("out", "path"),
        ),
    ),
    Operation(
        "singularity",
        "mafsil.cli.singularity:find_singularity",
        (_ROBOT, _Q, Parameter("task", "text"), _TIP, _DEGREES),
    ),
    Operation(
        "statics",
        "mafsil.cli.statics:statics",
        (
            _ROBOT,
            _Q,
            Parameter("wrench", "number", many=True, metavar="F"),
            Parameter("tau", "number", many=True, metavar="TAU"),
            Parameter("given_in", "text", choices=("body", "space", "tip")),
            _TIP,
            _DEGREES,
        ),
    ),
    Operation(
        "workspace",
        "mafsil.cli.workspace:workspace",
        (
            _ROBOT,
            Parameter("view", "text", choices=("xyz", "xy", "xz", "yz", "radial")),
            Parameter("samples", "count"),
            Parameter("cell", "number"),
            Parameter("seed", "count"),
            Parameter("picture", "path"),
            _TIP,
        ),
    ),
    Operation(
        "dh",
        "mafsil.cli.dh:dh",
        (
            _ROBOT,
            Parameter("convention", "text", choices=("modified", "classic")),
            Parameter("radians", "flag"),
            Parameter("picture", "path"),
            _TIP,
        ),
    ),
    Operation(
        "derive",
        "mafsil.cli.derive:derive",
        (
            _ROBOT,
            Parameter("what", "text", positional=True, required=True, choices=("fk", "jacobian", "ik", "dynamics")),
            _TIP,
            Parameter("method", "text", choices=("dh", "screws")),
            Parameter("convention", "text", choices=("modified", "classic")),
            Parameter("format", "text", choices=("text", "latex", "html")),
            Parameter("out", "path"),
        ),
    ),
    Operation(
        "check-homework",
        "mafsil.cli.check_homework:check_homework",
        (
            _ROBOT,
            Parameter("file", "path", positional=True, reads=True),
            Parameter("dh", "text", many=True, metavar="ROW"),
            Parameter("screws", "text", many=True, metavar="ROW"),
            Parameter("jacobian", "text", many=True, metavar="ROW"),
            Parameter("convention", "text", choices=("modified", "classic")),
            Parameter("kind", "text", choices=("space", "body", "tip")),
            Parameter("q", "angle", many=True, metavar="Q"),
            Parameter("letter", "text", many=True, metavar="NAME=VALUE"),
            _TIP,
            _DEGREES,
        ),
    ),
    Operation(
        "convert",
        "mafsil.cli.convert:convert",
        (
            *(Parameter(name, "angle", many=True, metavar=marks) for name, marks in _MOTIONS),
            Parameter("position", "number", many=True, metavar="X"),
            Parameter("all_sequences", "flag"),
            Parameter("picture", "path"),
            Parameter("project", "flag"),
            replace(_DEGREES, explained=""),
        ),
    ),
    Operation(
        "mobility",
        "mafsil.cli.mobility:mobility_of",
        (
            Parameter("mechanism", "path", positional=True, required=True, reads=True),
            Parameter("q", "angle", many=True, metavar="Q"),
            Parameter("rule", "text", choices=("planar", "spherical", "spatial")),
            Parameter("play", "number", metavar="M"),
            Parameter("locked_joints", "text", many=True, metavar="JOINT"),
            Parameter("actuated", "text", many=True, metavar="JOINT"),
            Parameter("subsets", "count"),
            Parameter("surfaces", "flag"),
            Parameter("picture", "path"),
        ),
    ),
    Operation(
        "linkage",
        "mafsil.cli.linkage:linkage_of_file",
        (
            Parameter("file", "path", positional=True, required=True, reads=True),
            Parameter("turn", "flag"),
            Parameter("crank", "text", metavar="JOINT"),
            Parameter("speed", "number", metavar="RAD/S"),
            Parameter("rows", "count"),
            Parameter("picture", "path"),
            Parameter("out", "path", many=True, metavar="FILE"),
        ),
    ),
    Operation(
        "parallel",
        "mafsil.cli.parallel:parallel",
        (
            Parameter("file", "path", positional=True, required=True, reads=True),
            Parameter("pose", "angle", many=True, metavar="X"),
            Parameter("motors", "angle", many=True, metavar="Q"),
            Parameter("load", "number", many=True, metavar="F"),
            Parameter("ways", "flag"),
            _DEGREES,
            Parameter("picture", "path"),
        ),
    ),
    Operation(
        "synthesis",
        "mafsil.cli.synthesis:synthesis_of",
        (
            Parameter("file", "path", positional=True, required=True, reads=True),
            Parameter("candidate", "count"),
            Parameter("picture", "path"),
        ),
    ),
    Operation(
        "grasp",
        "mafsil.cli.grasp:grasp",
        (
            Parameter("file", "path", positional=True, required=True, reads=True),
            Parameter("facets", "count"),
            Parameter("steps", "flag"),
            Parameter("fingers", "count"),
            Parameter("mu", "number"),
            Parameter("gamma", "number"),
            Parameter("opening", "number"),
            Parameter("length", "number"),
            Parameter("about", "number", many=True),
            Parameter("clearance", "number"),
            Parameter("push", "number"),
            Parameter("picture", "path"),
        ),
    ),
    Operation(
        "lint",
        "mafsil.cli.lint:lint",
        (_ROBOT, Parameter("fix", "path"), Parameter("only", "text", many=True, metavar="CODE")),
    ),
    Operation(
        "verify",
        "mafsil.cli.verify:verify",
        (
            _ROBOT,
            _TIP,
            Parameter("against", "text", choices=("pinocchio", "mujoco"), many=True),
            Parameter("states", "count"),
            Parameter("seed", "count"),
        ),
    ),
    Operation(
        "identify",
        "mafsil.cli.identify:identify",
        (
            replace(_ROBOT, explained=""),
            Parameter("log", "path", positional=True, required=True, reads=True, endings=(".csv",)),
            Parameter("out", "path"),
            Parameter("payload", "flag"),
            Parameter("at_rest", "flag"),
            Parameter("rotor_inertia", "flag"),
            Parameter("validation", "path"),
            Parameter("held_out", "number"),
            Parameter("bandwidth", "number"),
            _TIP,
            replace(_DEGREES, explained=""),
        ),
    ),
    Operation(
        "export",
        "mafsil.cli.export:export",
        (
            _ROBOT,
            Parameter("quantity", "text", positional=True),
            Parameter("to", "text", choices=("c", "object", "ptx", "wasm", "page")),
            Parameter("target", "text"),
            Parameter("real", "text", choices=("double", "float")),
            Parameter("frame", "text"),
            Parameter("function", "text"),
            Parameter("out", "path"),
            _TIP,
        ),
    ),
    Operation(
        "trajectory",
        "mafsil.cli.trajectory:trajectory",
        (
            Parameter("action", "text", positional=True, required=True, choices=_TRAJECTORY_ACTIONS),
            _ROBOT,
            Parameter("file", "path", positional=True, required=True, reads=True, endings=(".csv",)),
            Parameter("out", "path"),
            Parameter("rate", "number"),
            Parameter("acceleration", "number"),
            Parameter("jerk", "number"),
            Parameter("curve", "text", choices=("spline", "stops")),
            Parameter("remedy", "text", choices=("slower", "slower_leg", "stop", "leave_out")),
            _TIP,
            Parameter("driven", "flag"),
            Parameter("failed", "flag"),
        ),
    ),
    Operation(
        "completion",
        "mafsil.cli.completion:completion",
        (Parameter("shell", "text", positional=True, required=True, choices=("bash", "zsh", "fish")),),
    ),
    Operation("man", "mafsil.cli.manual:manual"),
    Operation("info", "mafsil.cli.info:info", (Parameter("export_check", "flag"), Parameter("build", "flag"))),
)


def robot_options(operation: Operation) -> tuple[Parameter, ...]:
    """The options of its robot that an operation takes beside its own."""
    own = [parameter.name for parameter in operation.parameters]
    if "robot" not in own:
        return ()
    allowed = ("xacro_arg", "model") if operation.name in UNEQUIPPED else tuple(option.name for option in ROBOT_OPTIONS)
    return tuple(option for option in ROBOT_OPTIONS if option.name in allowed and option.name not in own)


def operation(name: str) -> Operation:
    """The operation of that name.

    Raises:
        KeyError: there is none.
    """
    return next(item for item in OPERATIONS if item.name == name)
