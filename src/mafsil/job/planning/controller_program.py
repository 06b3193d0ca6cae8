"""The plan of a job as a program of a robot controller, with tools, loads, signals, speeds and zones; and read back.

A plan becomes a list of instructions, whatever the language. A language is one row of `LANGUAGES`: a template for each
kind of instruction, by which it is written, and by which it is read. What it cannot say is listed beside the program.

Reference: Universal Robots, The URScript Programming Language; KUKA, Expert Programming (KRL); ABB, RAPID Instructions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Booleans, Floats, PoseMatrix
from mafsil.errors import FileError, InputError
from mafsil.geometry import rotation
from mafsil.geometry.euler import from_rpy, to_rpy
from mafsil.geometry.quaternion import from_quaternion, to_quaternion
from mafsil.job.language.description import Job
from mafsil.job.planning.instructions import CORNER, Instruction, instructions
from mafsil.job.planning.plan import Plan
from mafsil.job.remark import Remark
from mafsil.messages.visible import visible

NUMBER = r"[-+]?\d+(?:\.\d+)?"
SAME = 1e-10
"""Numbers that are read back differ by less [rad, m, s, kg, entries of the rotation]."""


@dataclass(frozen=True, slots=True)
class Language:
    """How a controller writes instructions.

    Attributes:
        endings: of its files.
        templates: of each kind; `<v>` are the values, of an arc the second ones, the first being `<w>`; `<m>` a mass,
            `<b>` the value of a signal and `<n>` its number, `<t>`, `<s>`, `<r>` time, speed and zone.
        turn, length: units of angles and lengths in its files.
        joints: fewest and most that the controller drives.
        written: axes that always stand in a target: those that a robot lacks are zero.
        orientation: rotation -> numbers, and back; in angles of the file if `in_angles`.
        in_angles: whether those numbers are angles.
        labels: before the values of joints and of poses.
        around: text before and after.
        keeps_time: whether a motion can be given its duration.
        first_signal: number of the first one.
    """

    endings: tuple[str, ...]
    templates: Mapping[str, str]
    turn: float
    length: float
    joints: tuple[int, int]
    written: int
    orientation: tuple[Callable[[Floats], Floats], Callable[[Floats], Floats]]
    in_angles: bool
    labels: Mapping[str, tuple[str, ...]]
    around: tuple[str, str]
    keeps_time: bool = True
    first_signal: int = 0


def _zyx(R: Floats) -> Floats:
    return np.asarray(to_rpy(R))[::-1]


def _of_zyx(abc: Floats) -> Floats:
    return np.asarray(from_rpy(abc[::-1]))


AXES = tuple(f"A{k} " for k in range(1, 7)) + tuple(f"E{k} " for k in range(1, 7))
XYZABC = ("X ", "Y ", "Z ", "A ", "B ", "C ")
ROBTARGET = ",[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
LASTING = "\\T:=<t>"
"""Where RAPID writes a duration, if there is one."""
RAPID_SPEED = f",[<s>,500,5000,1000]{LASTING},[<f>,<r>,<r>,<r>,0,<r>,0],mafsil_tool;"
JOINT_SPEED = 1.0
"""Written where a motion of the joints has no duration [m/s]."""
DEGREE = np.pi / 180.0

LANGUAGES: dict[str, Language] = {
    "urscript": Language(
        (".script", ".urscript"),
        {
            "tool": "set_tcp(p[<v>])", "load": "set_payload(<m>, [<v>])", "joints": "movej([<v>], t=<t>, r=<r>)",
            "line": "movel(p[<v>], v=<s>, t=<t>, r=<r>)", "arc": "movec(p[<w>], p[<v>], v=<s>, r=<r>)",
            "pause": "sleep(<v>)",
            "set": "set_standard_digital_out(<n>, <b>)",
            "wait": "while get_standard_digital_in(<n>) != <b>:\n  sync()\nend",
        },
        1.0, 1.0, (6, 6), 6, (rotation.log, rotation.exp), False, {}, ("def mafsil_job():\n", "end\nmafsil_job()\n"),
    ),
    "krl": Language(
        (".src",),
        {
            "tool": "$TOOL={<v>}", "load": "$LOAD={M <m>,CM {<v>,A 0,B 0,C 0},J {X 0,Y 0,Z 0}}",
            "joints": "PTP {<v>}", "line": "$VEL.CP=<s>\n$APO.CDIS=<r>\nLIN {<v>} C_DIS",
            "arc": "$VEL.CP=<s>\n$APO.CDIS=<r>\nCIRC {<w>},{<v>} C_DIS",
            "pause": "WAIT SEC <v>", "set": "$OUT[<n>]=<b>", "wait": "WAIT FOR $IN[<n>]==<b>",
        },
        DEGREE, 1e-3, (1, 12), 6, (_zyx, _of_zyx), True,
        {"joints": AXES, "line": XYZABC, "arc": XYZABC, "tool": XYZABC, "load": XYZABC},
        ("DEF mafsil_job()\nBAS(#INITMOV,0)\n$BASE=$NULLFRAME\n", "END\n"), keeps_time=False, first_signal=1,
    ),
    "rapid": Language(
        (".mod",),
        {
            "tool": "mafsil_tool.tframe:=[<v>];", "load": "mafsil_tool.tload:=[<m>,[<v>],[1,0,0,0],0,0,0];",
            "joints": "MoveAbsJ [[<v>]]" + RAPID_SPEED, "line": "MoveL [<v>" + ROBTARGET + RAPID_SPEED,
            "arc": "MoveC [<w>" + ROBTARGET + ",[<v>" + ROBTARGET + RAPID_SPEED,
            "pause": "WaitTime <v>;", "set": "SetDO mafsil_do<n>,<b>;", "wait": "WaitDI mafsil_di<n>,<b>;",
        },
        DEGREE, 1e-3, (1, 12), 12, (to_quaternion, from_quaternion), False, {},
        (
            "MODULE mafsil_job\nPERS tooldata mafsil_tool:=[TRUE,[[0,0,0],[1,0,0,0]],"
            "[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];\nPROC main()\nConfL \\Off;\n",
            "ENDPROC\nENDMODULE\n",
        ),
    ),
}  # fmt: skip
"""All of them, by name."""


@dataclass(frozen=True, slots=True)
class Program:
    """A program of a controller.

    Attributes:
        text: of it, read back: all numbers within 1e-10 of the plan's.
        count: instructions.
        lost: what the language cannot carry, or carries otherwise.
        scene: the obstacles as a second file, where the language has them; else empty.
    """

    text: str
    count: int
    lost: tuple[Remark, ...]
    scene: str = ""


def language_of(ending: str, others: tuple[str, ...] = ()) -> Language:
    """The language of a file, by its ending.

    Args:
        ending: such as `.src`.
        others: endings that the caller knows besides, for the sentence.

    Raises:
        InputError: it is that of no language.
    """
    for language in LANGUAGES.values():
        if ending.lower() in language.endings:
            return language
    known = ", ".join([*(one for language in LANGUAGES.values() for one in language.endings), *others])
    raise InputError("input.choice", name="program", value=ending, known=known)


def _signal_names(job: Job, language: Language) -> str:
    """Comments that say which signal has which number."""
    comment = "#" if language.turn == 1.0 else ";" if language.labels else "!"
    return "".join(
        f"{comment} {kind} {k}: {visible(name)}\n"
        for kind, table in (("output", job.output), ("input", job.input))
        for k, name in enumerate(table, start=language.first_signal)
    )


def write_program(job: Job, plan: Plan, language: Language) -> Program:
    """The plan of a job in a language, with what is lost.

    Args:
        job, plan: of an arm without loops.
        language: of the controller.

    Raises:
        InputError: joints that the controller does not drive, or loops; numbers that would not read back.
    """
    steps, lost = instructions(job, plan)
    mechanism, (fewest, most) = plan.legs[0].load.robot.mechanism, language.joints
    angular = mechanism.angular
    if job.track:
        raise InputError("job.program_track")
    if mechanism.loops or not fewest <= len(angular) <= most:
        raise InputError("job.program_joints", joints=len(angular), fewest=fewest, most=most)
    if not language.keeps_time:
        lost.append(Remark("warning", "job.program_times", {}))
    elif "<t>" not in language.templates["arc"] and any(step.kind == "arc" for step in steps):
        lost.append(Remark("warning", "job.program_arcs", {}))
    if any(step.zone > CORNER or (step.zone > 0.0 and step.kind != "joints") for step in steps):
        lost.append(Remark("warning", "job.program_corners", {}))
    lines = [line for step in steps for line in _written(step, language, angular).split("\n")]
    head, foot = language.around
    text = head + _signal_names(job, language) + "".join(f"  {line}\n" for line in lines) + foot
    for step, back in zip(steps, read_program(text, language, angular), strict=True):
        if step.kind != back.kind or not np.allclose(step.values, back.values, rtol=0.0, atol=SAME):
            raise InputError("job.program_differs", kind=step.kind)
    return Program(text, len(steps), tuple(lost))


def _written(step: Instruction, language: Language, angular: Booleans) -> str:
    if step.kind == "arc":
        first = _written(
            replace(step, kind="line", values=step.values[0]), replace(language, templates={"line": "<v>"}), angular
        )
        second = replace(language, templates={"line": language.templates["arc"].replace("<w>", first)})
        return _written(replace(step, kind="line", values=step.values[1]), second, angular)
    values = _in_units(step, language, angular)
    labels = language.labels.get(step.kind, ("",) * len(values))
    mass, shown = ("", values) if step.kind != "load" else (_digits(step.values[0]), values[1:])
    texts = [label + _digits(value) for label, value in zip(labels, shown, strict=False)]
    if step.kind in ("tool", "line") and len(texts) == len("xyz") + len("wxyz"):
        body = f"[{','.join(texts[:3])}],[{','.join(texts[3:])}]"
    elif step.kind == "joints" and language.written == 12:
        body = f"{','.join(texts[:6])}],[{','.join(texts[6:])}"
    else:
        body = ",".join(texts)
    truth = ("False", "True") if language.turn == 1.0 else ("FALSE", "TRUE") if language.labels else ("0", "1")
    speed = (step.speed or JOINT_SPEED) / (1.0 if language.labels else language.length)
    template = language.templates[step.kind].replace("" if step.time else LASTING, "")
    marks = {
        "v": body, "m": mass, "n": str(step.number + language.first_signal),
        "b": truth[int(step.values.flat[0] > 0.5)], "f": "FALSE" if step.zone > 0.0 else "TRUE",
        "t": _digits(step.time), "s": _digits(speed), "r": _digits(step.zone / language.length),
    }  # fmt: skip
    return re.sub("<([a-z])>", lambda match: marks[match[1]], template)


def _in_units(step: Instruction, language: Language, angular: Booleans) -> Floats:
    """Numbers of an instruction as they stand in the file."""
    values, length, turn = step.values, language.length, language.turn
    if step.kind in ("tool", "line"):
        around = np.asarray(language.orientation[0](values[:3, :3]))
        return np.append(values[:3, 3] / length, around / turn if language.in_angles else around)
    if step.kind == "load":
        return np.append(values[0], values[1:] / length)
    if step.kind != "joints":
        return values
    missing = np.zeros(max(language.written - len(values), 0))
    return np.append(values / np.where(angular, turn, length), missing)


def _digits(value: float) -> str:
    text = f"{value:.13f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def read_program(text: str, language: Language, angular: Booleans) -> list[Instruction]:
    """The instructions of a program that `write_program` wrote, in SI units.

    Args:
        text: of the program.
        language: of it.
        angular: (n,) whether each joint of the robot turns.

    Raises:
        FileError: a line that is no instruction; it is named.
    """
    patterns = [
        (kind, re.compile(_pattern(each)))
        for kind, template in language.templates.items()
        for each in dict.fromkeys((template, template.replace(LASTING, "")))
    ]
    found = list[Instruction]()
    head, foot = language.around
    place, end = text.find(head) + len(head), text.rfind(foot)
    if place < len(head) or end < place:
        raise FileError("job.program_line", line=1, text=text[:80].split("\n")[0])
    while (place := _after_blanks(text, place)) < end:
        hits = ((kind, one.match(text, place)) for kind, one in patterns)
        kind, match = next(((kind, match) for kind, match in hits if match is not None), ("", None))
        if match is None:
            rest = text[place : place + 80].split("\n")[0]
            raise FileError("job.program_line", line=text.count("\n", 0, place) + 1, text=rest)
        found.append(_read(kind, match.groupdict(), language, angular))
        place = match.end()
    return found


def _after_blanks(text: str, place: int) -> int:
    """Where blanks and lines of comments end."""
    blanks = re.compile(r"\s*(?:[#;!][^\n]*\n\s*)*").match(text, place)
    return place if blanks is None else blanks.end()


def _pattern(template: str) -> str:
    """A template as a regular expression: numbers for its marks, any blanks after line breaks."""
    marks = {"v": "(?P<v>.*?)", "w": "(?P<w>.*?)", "b": r"(?P<b>\w+)", "f": r"(?P<f>\w+)", "n": r"(?P<n>\d+)"}
    made, seen = "", set[str]()
    for k, piece in enumerate(re.split("<([a-z])>", template)):
        if k % 2 == 0:
            made += r"\n\s*".join(map(re.escape, piece.split("\n")))
        elif piece in seen:
            made += f"(?P={piece})"
        else:
            made += marks.get(piece, f"(?P<{piece}>{NUMBER})")
            seen.add(piece)
    return made + "(?=\n)"


def _read(kind: str, marks: Mapping[str, str], language: Language, angular: Booleans) -> Instruction:
    if kind == "arc":
        ends = [_read("line", {**marks, "v": marks[each], "w": ""}, language, angular) for each in ("w", "v")]
        return replace(ends[1], kind="arc", values=np.stack([one.values for one in ends]))
    numbers = np.array([float(each) for each in re.findall(rf"(?<![\w.]){NUMBER}", marks.get("v") or "")])
    zone = float(marks.get("r") or 0.0) * language.length
    number = int(marks["n"]) - language.first_signal if marks.get("n") else 0
    step = Instruction(kind, numbers, number, float(marks.get("t") or 0.0), zone=zone)
    if kind in ("set", "wait"):
        return replace(step, values=np.array([float(marks["b"].lower() in ("true", "1"))]))
    if kind == "load":
        return replace(step, values=np.append(float(marks["m"]), numbers[:3] * language.length))
    if kind == "joints":
        return replace(step, values=numbers[: len(angular)] * np.where(angular, language.turn, language.length))
    if kind == "pause":
        return step
    speed = float(marks.get("s") or 0.0) * (1.0 if language.labels else language.length)
    around = numbers[3:] * (language.turn if language.in_angles else 1.0)
    return replace(step, values=_pose(numbers[:3] * language.length, language.orientation[1](around)), speed=speed)


def _pose(p: Floats, R: Floats) -> PoseMatrix:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, p
    return T
