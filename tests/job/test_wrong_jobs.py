"""Jobs as people write them wrong: each is refused, or judged, with the place, the reason and what to do.

Checked, not driven: what a check refuses is refused before anything moves.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import mafsil as mf
from mafsil.cli.run import check_job
from mafsil.errors import MafsilError

H = 'robot = "planar2r"\n'
U = 'robot = "ur5e"\nangles = "degrees"\n[start]\njoints = [0, -90, 90, -90, -90, 0]\n'
FLAT = U.replace("[0, -90, 90, -90, -90, 0]", "[0, 0, 0, 0, 0, 0]")
G = "[[move]]\njoints = [0.5, 0.5]\n"
J = '[[move]]\nname = "go"\njoints = [10, -80, 80, -90, -90, 0]\n'
WRONG: dict[str, tuple[str, int, str]] = {
    "no moves": (H, 0, "add it"),
    "a robot that nobody knows": ('robot = "ur5ee"\n' + G, 1, "did you mean: ur5, ur5e, ur3e, ur10e?"),
    "a file that is not there": ('robot = "arms/ur5e.urdf"\n' + G, 1, "check the path"),
    "a misspelt key": (H + "[limits]\nvelocty = 1.0\n" + G, 3, "did you mean: velocity?"),
    "a misspelt table": (H + '[controler]\nkind = "pid"\n' + G, 2, "did you mean: controller, tolerance?"),
    "a law that does not exist": (
        H + '[controller]\nkind = "computed torque plus"\n' + G,
        3,
        "choose one of: computed_torque",
    ),
    "a text for a number": (H + '[limits]\nvelocity = "fast"\n' + G, 3, "must be a number"),
    "too few joints": (H + "[[move]]\njoints = [0.5]\n", 3, "the joints are: joint1, joint2"),
    "too many joints": (H + "[[move]]\njoints = [0.5, 0.5, 0.5]\n", 3, "the joints are: joint1, joint2"),
    "degrees without saying so": (
        'robot = "ur5e"\n[[move]]\njoints = [90, -90, 90, -90, -90, 0]\n',
        3,
        'write angles = "degrees"',
    ),
    "millimetres without saying so": (
        'robot = "ur5e"\n[[move]]\npose = { position = [400, 100, 300], rpy = [3.14, 0, 0] }\n',
        2,
        "divide its translation by 1000",
    ),
    "out of reach": (
        U + '[[move]]\nname = "far"\npose = { position = [2.0, 0.0, 0.3], rpy = [180, 0, 0] }\n',
        5,
        "move the pose or the base",
    ),
    "beyond the limits": (
        U + '[[move]]\nname = "wound"\njoints = [400, -90, 90, -90, -90, 0]\n',
        7,
        "choose a value within them",
    ),
    "not a number": (H + "[[move]]\njoints = [nan, 0.5]\n", 3, "write a finite number"),
    "infinite": (H + "[[move]]\njoints = [inf, 0.5]\n", 3, "write a finite number"),
    "negative duration": (H + "[[move]]\njoints = [0.5, 0.5]\nduration = -1.0\n", 4, "it must be >= 1e-09"),
    "a duration too short": (
        H + "[limits]\nvelocity = 1.0\nacceleration = 2.0\n"
        '[[move]]\nname = "hurry"\njoints = [1.5, 0.5]\nduration = 0.1\n',
        5,
        "the shortest duration within the limits is 2.000 s",
    ),
    "no time": (H + "[[move]]\njoints = [0.5, 0.5]\nduration = 0\n", 4, "it must be >= 1e-09"),
    "place without pick": (H + G + '[[move]]\nname = "let go"\nplace = true\n', 6, "pick one before"),
    "pick twice": (H + "[[move]]\npick = { mass = 0.1 }\n[[move]]\npick = { mass = 0.1 }\n", 5, "place it before"),
    "negative mass": (H + "[[move]]\npick = { mass = -1 }\n", 3, "it must be >= 0.0"),
    "a part too heavy": (
        U + J + '[[move]]\nname = "lift the engine"\npick = { name = "engine", mass = 400 }\n' + J,
        0,
        "carry less",
    ),
    "two goals of one move": (
        U + '[[move]]\nname = "both"\njoints = [10, -80, 80, -90, -90, 0]\npose = { position = [0.4, 0.1, 0.3] }\n',
        5,
        "make a [[move]] of each",
    ),
    "a move of nothing": (H + '[[move]]\nname = "what"\n', 2, "give one of: joints, pose"),
    "a tool that is not declared": (H + '[[move]]\ntool = "gripper"\n', 3, "there is no [tools] gripper"),
    "a signal that nobody sets": (
        H + '[[move]]\nname = "wait"\nwait = { part_there = true }\n',
        4,
        "outputs stand in [output], inputs in [input.NAME]",
    ),
    "an output that is not declared": (H + "[[move]]\nset = { lamp = true }\n", 3, "outputs stand in [output]"),
    "a signal that never comes": (
        H + '[input.part]\nstart = false\n[[move]]\nname = "wait"\nwait = { part = true }\ntimeout = 2.0\n' + G,
        4,
        "add a change to the table of the input",
    ),
    "an endless loop": (
        H + "[[move]]\nwhile = { part = false }\ndo = [{ joints = [0.1, 0.1] }, { joints = [0.2, 0.1] }]\n"
        "[input.part]\nstart = false\n",
        2,
        "so that it ends",
    ),
    "a million repetitions": (
        H + "[[move]]\nrepeat = 10000000\ndo = [{ joints = [0.1, 0.1] }, { joints = [0.2, 0.1] }]\n",
        3,
        "it must be <= 100000",
    ),
    "not a rotation": (
        U + "[[move]]\npose = { position = [0.4, 0.1, 0.3], quaternion = [0, 0, 0, 0] }\n",
        6,
        "write (w, x, y, z), for example [1, 0, 0, 0]",
    ),
    "two orientations": (
        U + "[[move]]\npose = { position = [0.4, 0.1, 0.3], rpy = [180, 0, 0], quaternion = [1, 0, 0, 0] }\n",
        6,
        "keep one of them",
    ),
    "an obstacle of no size": (
        U + '[[obstacle]]\nname = "thin"\nbox = [0, 1, 1]\nposition = [1, 0, 0]\n' + J,
        7,
        "it must be >= 1e-09",
    ),
    "an obstacle of two kinds": (
        U + '[[obstacle]]\nname = "both"\nbox = [0.1, 0.1, 0.1]\nsphere = 0.1\nposition = [1, 0, 0]\n' + J,
        5,
        "exactly one of box",
    ),
    "an obstacle around the arm": (
        U + '[[obstacle]]\nname = "cage"\nbox = [3, 3, 3]\nposition = [0, 0, 0]\n' + J,
        3,
        "choose another start, or move the obstacle",
    ),
    "an obstacle at the goal": (
        U + '[[obstacle]]\nname = "post"\nsphere = 0.3\n'
        "position = [0.5, 0.2, 0.5]\n"
        '[[move]]\nname = "into it"\n'
        "pose = { position = [0.5, 0.2, 0.5], rpy = [180, 0, 0] }\n",
        9,
        "`avoid = true` plans around it",
    ),
    "a mesh that is not there": (
        U + '[[obstacle]]\nname = "fixture"\nmesh = "fixture.stl"\nposition = [1, 0, 0]\n' + J,
        7,
        "check the path",
    ),
    "negative clearance": (U + "[collision]\nclearance = -0.01\n" + J, 6, "it must be >= 0.0"),
    "two obstacles of one name": (
        U + '[[obstacle]]\nname = "a"\nsphere = 0.1\n'
        "position = [1, 0, 0]\n"
        '[[obstacle]]\nname = "a"\nsphere = 0.1\n'
        "position = [1, 1, 0]\n" + J,
        10,
        "give each its own name",
    ),
    "gains below zero": (H + '[controller]\nkind = "pid"\nkp = [-5, -5]\n' + G, 4, "it must be >= 1e-09"),
    "gains of three joints": (H + '[controller]\nkind = "pid"\nkp = [5, 5, 5]\n' + G, 4, "one number or 2"),
    "pid without gains of another law": (
        H + '[controller]\nkind = "computed_torque"\nnormal_force = 5.0\n' + G,
        4,
        "its gains are: frequency",
    ),
    "normal force without a surface": (
        U + '[controller]\nkind = "hybrid"\nnormal_force = 15.0\n' + J,
        6,
        "add a table [[surface]], or choose another law",
    ),
    "a push before the beginning": (
        H + "[[disturbance]]\nstart = -1.0\nduration = 0.1\nwrench = [0, 0, 0, 1, 0, 0]\n" + G,
        3,
        "it must be >= 0.0",
    ),
    "a push of five numbers": (
        H + "[[disturbance]]\nstart = 0.1\nduration = 0.1\nwrench = [0, 0, 0, 1, 0]\n" + G,
        5,
        "needs 6 values",
    ),
    "a push after the end": (
        H + "[[disturbance]]\nstart = 1e6\nduration = 0.1\nwrench = [0, 0, 0, 1, 0, 0]\n" + G,
        0,
        "has no effect",
    ),
    "a step of a second": (H + "[simulation]\nstep = 1.0\n" + G, 3, "it must be <= 0.1"),
    "a step of nothing": (H + "[simulation]\nstep = 0\n" + G, 3, "it must be >= 1e-06"),
    "a step too fine": (H + "[simulation]\nstep = 1e-12\n" + G, 3, "it must be >= 1e-06"),
    "noise below zero": (H + "[simulation]\nnoise = { position = -1e-3 }\n" + G, 3, "it must be >= 0.0"),
    "a plant that does not exist": (
        H + '[simulation]\nplant = "gazebo"\n' + G,
        3,
        "choose one of: mafsil, mujoco, kinematic",
    ),
    "tolerance of zero": (H + "[tolerance]\nposition = 0\n" + G, 3, "it must be >= 1e-09"),
    "a joint that is not there": (H + "[lock]\nelbow9 = 0.3\n" + G, 2, "there are: joint1, joint2"),
    "a limit of zero": (H + "[limits]\nvelocity = 0\n" + G, 3, "it must be >= 1e-09"),
    "shares above one": (H + "[limits]\nspeed_scale = 3.0\n" + G, 3, "it must be <= 1.0"),
    "a frame that is not declared": (
        U + '[[move]]\npose = { position = [0.1, 0, 0], frame = "table" }\n',
        6,
        "declare it as [frame.table], or correct the name",
    ),
    "frames in a circle": (
        U + '[frame.a]\nposition = [0, 0, 0]\nframe = "b"\n[frame.b]\nposition = [0, 0, 0]\nframe = "a"\n' + J,
        10,
        "one of them has to stand in {s}",
    ),
    "a variable that is not there": (H + '[[move]]\njoints = ["${reach}", 0.5]\n', 3, "must be a number"),
    "half a file": (H + "[[move]]\njoints = [0.5, 0.5\n", 0, "not closed by ]"),
    "a key twice": (H + "[[move]]\njoints = [0.5, 0.5]\njoints = [0.6, 0.5]\n", 4, "given twice"),
    "JSON": ('{"robot": "planar2r", "move": [{"joints": [0.5, 0.5]}]}', 1, "neither a key nor a table"),
    "nothing": ("", 0, "add it"),
    "a line through a singularity": (
        'robot = "planar2r"\n[start]\njoints = [0.0, 1.0]\n'
        '[[move]]\nname = "across"\n'
        "pose = { position = [-0.9, 0.3, 0] }\n"
        'path = "line"\n',
        4,
        "turn the path, or take task='position'",
    ),
    "a blend before a pause": (
        U + '[[move]]\nname = "a"\njoints = [10, -80, 80, -90, -90, 0]\nblend = 0.1\n[[move]]\npause = 1.0\n' + J,
        8,
        "with nothing between",
    ),
    "a blend at the end": (
        U + '[[move]]\nname = "last"\njoints = [10, -80, 80, -90, -90, 0]\nblend = 0.1\n',
        8,
        "with nothing between",
    ),
    "a profile that does not exist": (
        H + '[[move]]\njoints = [0.5, 0.5]\nprofile = "cubicle"\n',
        4,
        "choose one of: cubic",
    ),
    "a branch that does not exist": (
        U + '[[move]]\npose = { position = [0.4, 0.1, 0.3], rpy = [180, 0, 0], branch = { elbow = "sideways" } }\n',
        6,
        "choose one of: up, down, in, out",
    ),
    "speed of the tip for joints alone": (
        H + "[[move]]\njoints = [0.5, 0.5]\ntip_speed = -0.1\n",
        4,
        "it must be >= 1e-09",
    ),
    "a surface without a normal": (
        U + '[[surface]]\nname = "plate"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]\nstiffness = 1e4\n' + J,
        8,
        "give three numbers, such as [0, 0, 1]",
    ),
    "a start in the table": (
        FLAT + '[[obstacle]]\nname = "table"\nbox = [4, 4, 0.2]\nposition = [0, 0, 0.0]\n' + J,
        3,
        "choose another start, or move the obstacle",
    ),
    "a pose to a two-joint arm with an orientation": (
        H + '[[move]]\nname = "turned"\npose = { position = [1.0, 0.5, 0.3], rpy = [1, 0, 0] }\n',
        2,
        'task = "position"',
    ),
    "a robot below the floor": (
        U + '[[obstacle]]\nname = "floor"\nfloor = true\nposition = [0, 0, 0.5]\n' + J,
        3,
        "choose another start, or move the obstacle",
    ),
    "a pause of minus one": (H + "[[move]]\npause = -1.0\n", 3, "it must be >= 1e-09"),
    "an upright cup that must turn over": (
        U + '[[move]]\nname = "pour"\nconstraints = { upright = 5 }\njoints = [0, -90, 90, -90, 90, 0]\n',
        5,
        "loosen the constraints",
    ),
    "a velocity per joint too many": (U + "[limits]\nvelocity = [1, 1, 1, 1, 1, 1, 1]\n" + J, 6, "or 6, got 7"),
    "two arms of one name": (
        U + '[[other_robot]]\nname = "b"\nrobot = "ur5e"\n'
        "position = [2, 0, 0]\n"
        '[[other_robot]]\nname = "b"\nrobot = "ur5e"\n'
        "position = [4, 0, 0]\n" + J,
        10,
        "give each its own",
    ),
    "two arms in one place": (
        U + '[[other_robot]]\nname = "twin"\nrobot = "ur5e"\nposition = [0, 0, 0]\n' + J,
        3,
        "choose another start, or move the obstacle",
    ),
    "look at itself": (
        U + '[[move]]\nname = "look"\npose = { position = [0.4, 0.1, 0.3], look_at = [0.4, 0.1, 0.3] }\n',
        7,
        "another one than the position",
    ),
    "a pattern of minus two": (
        U + "[pattern.grid]\n"
        "position = [0.4, 0, 0.3]\ncount = [-2, 2, 1]\npitch = [0.1, 0.1, 0]\n"
        '[[move]]\neach = "grid"\ndo = [{ pose = "grid" }]\n',
        7,
        "it must be >= 1",
    ),
    "runs of a variation that varies nothing": (H + "[variation]\nruns = 10\n" + G, 2, "give one of: payload"),
    "a language of nobody": (H + '[report]\nlanguage = "tlh"\n' + G, 3, "choose one of: en, ar"),
}
"""The job, the line that is at fault (0: the file or the motion as a whole), and what is said to be done."""


def said_of(path: Path, language: str = "en") -> str:
    """What a check says of a job: its error, its refusal, or its findings."""
    mf.language(language)
    try:
        answer = check_job(str(path))
        return answer.refusal or "\n".join(map(str, answer.lines))
    except MafsilError as error:
        return error.message(language)
    finally:
        mf.language("en")


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_job_is_refused_with_place_and_remedy(name: str, tmp_path: Path) -> None:
    """The line where the fault is, and words that lead on; in both languages."""
    text, line, remedy = WRONG[name]
    path = tmp_path / "job.toml"
    path.write_text(text, "utf-8")
    sentence = said_of(path)
    places = re.findall(r"job\.toml:(\d+)|\(line (\d+)\)", sentence)
    assert int("".join(places[0])) == line if line else not places, sentence
    assert remedy in sentence
    assert re.search(r"[\u0600-\u06ff]", said_of(path, "ar"))
