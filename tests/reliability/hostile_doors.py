"""F5: files of every kind that is read, damaged, cut, swollen, and pipes, devices, folders and bombs in their place.

`python -m tests.reliability.hostile_doors --files 1000000 --shard 20000 --resume DIR`

Every reader of a file is a door: robots in five formats, loops, meshes, clouds, heights, SRDF, motions, logs,
recordings, results, jobs, grasps, linkages. Whatever stands in the file, the door answers or refuses in our words,
within 2 s of the processor for each megabyte begun and 256 MB more than for sound files. What a recording or a log that
was let in says is finite and of one length.
"""

from __future__ import annotations

import json
import os
import random
import resource
import struct
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import mafsil as mf
from mafsil import job, trajectory
from mafsil.cli.main import main
from mafsil.collision import srdf
from mafsil.errors import MafsilError
from mafsil.grasp import read_grasp
from mafsil.identification import read_log
from mafsil.mobility import read_linkage
from mafsil.model import mesh, scan
from mafsil.model.loop_file import with_loops
from mafsil.report import compare_results
from tests.identification.simulated import write_csv
from tests.model.mesh.test_mesh_files import TRIANGLE, ascii_stl, binary_stl, collada
from tests.model.test_scan import POINTS, ply, png, rows
from tests.reliability import figures
from tests.reliability.file_mutation import mutated
from tests.reliability.fuzz_reader import in_child, peak_memory
from tests.reliability.robot_files import SEEDS

GROWTH = 256 << 20
SECONDS = 2.0
SPECIAL_EVERY = 25
"""One of so many files is none: a pipe, a device, a folder, a link to nothing or to itself, or a bomb."""
COUNTS = (
    "files",
    "accepted",
    "refused",
    "special",
    "bad_exception",
    "bad_slow",
    "bad_memory",
    "bad_content",
    "bad_crash",
)

JOB = """robot = "planar2r"
[[obstacle]]
name = "post"
sphere = 0.05
position = [1, 1, 1]
[[move]]
name = "there"
joints = [0.4, -0.2]
"""
GRASP = """load = { force = [0, -1], moment = 0.1 }
[body]
outline = [[-2, -1], [2, -1], [2, 1], [-2, 1]]
[[contact]]
point = [0.5, 1]
normal = [0, -1]
mu = 0.5
"""
LINKAGE = "".join(
    f'[[joint]]\nname = "{name}"\nkind = "R"\nbodies = ["{a}", "{b}"]\nat = {at}\n'
    for name, a, b, at in (("A", "ground", "a", [0, 0]), ("B", "a", "b", [0, 1]), ("C", "b", "c", [2, 1]),
                           ("D", "c", "ground", [3, 0]))
)  # fmt: skip
LOOPS = (
    '[[loop]]\nname = "rod"\nkind = "spherical"\nparent = "link2"\nchild = "link1"\nparent_at = { xyz = [0, 0, 0.4] }\n'
)
NAMES = (
    '<robot name="r"><group name="arm"><chain base_link="base" tip_link="l3"/></group><group_state name="up" '
    'group="arm"><joint name="j1" value="0.1"/></group_state><disable_collisions link1="base" link2="l1" reason="x"/>'
    "</robot>"
)


def run_finite(recording: mf.Recording) -> bool:
    """Whether all arrays of a recording are finite and of the length of its times."""
    arrays = [value for value in recording.arrays().values() if value.dtype.kind == "f"]
    return all(np.isfinite(value).all() for value in arrays) and bool((np.diff(recording.t) > 0).all())


def motion_finite(motion: trajectory.Trajectory) -> bool:
    """Whether the motion of a file is finite all along."""
    return bool(np.isfinite(motion.at(np.linspace(0.0, motion.duration, 7)).u).all())


def finite(values: Any) -> bool:
    """Whether an array, or the points of a surface, are finite."""
    return bool(np.isfinite(getattr(values, "vertices", values)).all())


def anything(_: object) -> bool:
    """What other readers give has rows of its own: F1, the tests of models."""
    return True


DOORS: dict[str, tuple[Callable[[Path], Any], Callable[[Any], bool]]] = {
    "robot.urdf": (mf.load, anything),
    "robot.xacro": (mf.load, anything),
    "robot.xml": (mf.load, anything),
    "robot.sdf": (mf.load, anything),
    "robot.toml": (mf.load, anything),
    "arm.loops.toml": (lambda path: with_loops(mf.load("planar2r").mechanism, path), anything),
    "names.srdf": (srdf.read, anything),
    "part.stl": (mesh.read, finite),
    "text.stl": (mesh.read, finite),
    "part.obj": (mesh.read, finite),
    "part.dae": (mesh.read, finite),
    "part.msh": (mesh.read, finite),
    "cloud.ply": (scan.read_points, finite),
    "cloud.xyz": (scan.read_points, finite),
    "cloud.npy": (scan.read_points, finite),
    "ground.png": (scan.read_heights, finite),
    "ground.csv": (scan.read_heights, finite),
    "ground.npy": (scan.read_heights, finite),
    "motion.csv": (trajectory.read_trajectory, motion_finite),
    "log.csv": (lambda path: read_log(path, "planar2r"), lambda log: finite(log.q) and len(log.q) == len(log.t)),
    "run.npz": (mf.Recording.load, run_finite),
    "run.mcap": (mf.Recording.load, run_finite),
    "results.json": (lambda path: compare_results(path, path), bool),
    "job.toml": (job.read_job, anything),
    "grasp.toml": (read_grasp, anything),
    "linkage.toml": (read_linkage, anything),
}
"""File name -> its reader, and whether what was let in is sound."""

BOMBS = (
    b"[" * 100_000, b"{" * 100_000, b'{"a":' * 50_000, b"<a>" * 50_000, b"a = " + b"[" * 50_000,
    b"a." * 50_000 + b"b = 1", b"a = 1\n" * 200_000, b"\0" * 3_000_000, b"1," * 1_000_000, b"9" * 3_000_000,
    b"[[joint]]\n" * 100_000, b"v 0 0 0\n" * 300_000, b"1 2 3\n" * 300_000, b"x" * 20 + b"\n" * 2_000_000,
    b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty double x\nproperty double y\n"
    b"property double z\nend_header\n",
    bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(200), struct.pack("<4i", 2**30, 2**30, 2**30, 2**30),
    b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 3), }" + b" " * 40 + b"\n",
    b"<!DOCTYPE a [" + b"".join(b"<!ENTITY e%d '%s'>" % (k, b"&e%d;" % (k - 1) * 10) for k in range(1, 12))
    + b"]><a>&e11;</a>",
    b"k0: &k0 [x]\n" + b"".join(b"k%d: &k%d [%s]\n" % (k, k, b",".join([b"*k%d" % (k - 1)] * 9)) for k in range(1, 9)),
)  # fmt: skip
"""What takes time or memory to be read, whatever the name of the file."""


def specimens(folder: Path) -> dict[str, bytes]:
    """A sound file for every door.

    Args:
        folder: where those that programs write are written.
    """
    arm = mf.load("planar2r")
    motion = trajectory.quintic([0.0, 0.0], [0.4, -0.2], 0.5)
    (folder / "job.toml").write_text(JOB)
    assert main(["run", str(folder / "job.toml"), "--out", str(folder / "run"), "--log", str(folder / "run.mcap")]) == 0
    arm.simulate(motion, step=0.01).save(folder / "run.npz")
    times = np.linspace(0.0, 0.5, 30)
    values = np.column_stack([times, motion.at(times).u])
    np.savetxt(folder / "motion.csv", values, delimiter=",", header="t,q[joint1],q[joint2]", comments="")
    log = mf.identification.MotionLog(t=times, q=values[:, 1:], tau=values[:, 1:])
    write_csv(log, arm, folder / "log.csv")
    arm.save(folder / "robot.toml")
    np.save(folder / "cloud.npy", POINTS)
    np.save(folder / "ground.npy", np.ones((4, 5)))
    written = ("run.npz", "motion.csv", "log.csv", "robot.toml", "cloud.npy", "ground.npy", "job.toml")
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], "<i4")
    return {
        **{name: (folder / name).read_bytes() for name in written},
        **{f"robot.{'xml' if kind == 'mjcf' else kind}": seeds[0] for kind, seeds in SEEDS.items()},
        "arm.loops.toml": LOOPS.encode(),
        "names.srdf": NAMES.encode(),
        "part.stl": binary_stl(np.repeat(TRIANGLE, 4, axis=0)),
        "text.stl": ascii_stl(np.repeat(TRIANGLE, 4, axis=0)),
        "part.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/2 4/4\nf -4 -1 -2\nf 2 3 4\n",
        "part.dae": collada(),
        "part.msh": struct.pack("<4i", 4, 0, 0, 4) + corner.tobytes() + faces.tobytes(),
        "cloud.ply": ply("binary_little_endian", rows("<")),
        "cloud.xyz": "\n".join(" ".join(map(str, row)) for row in POINTS).encode(),
        "ground.png": png(np.arange(12).reshape(3, 4), 8, [0, 0, 0]),
        "ground.csv": b"0,1,2\n3,4,5\n6,7,8\n",
        "run.mcap": (folder / "run.mcap").read_bytes(),
        "results.json": (folder / "run" / "results.json").read_bytes(),
        "grasp.toml": GRASP.encode(),
        "linkage.toml": LINKAGE.encode(),
    }


def damaged(dice: random.Random, data: bytes) -> bytes:
    """A file with bits flipped, bytes replaced, cut, or, as text, words and numbers exchanged."""
    if dice.random() < 0.5:
        return mutated(dice, data)
    damage = bytearray(data)
    for _ in range(dice.choice((1, 1, 2, 5, 20))):
        place = dice.randrange(len(damage))
        damage[place] = damage[place] ^ (1 << dice.randrange(8)) if dice.random() < 0.5 else dice.randrange(256)
    return bytes(damage[: dice.randrange(1, len(damage))] if dice.random() < 0.2 else damage)


def put(dice: random.Random, path: Path, data: bytes) -> bool:
    """Put a damaged file, or what is no file, at a path; whether it is no damaged file.

    Args:
        dice: generator.
        path: where.
        data: of the sound file.
    """
    special = dice.randrange(SPECIAL_EVERY) == 0
    kind = dice.choice(("pipe", "device", "folder", "nothing", "itself", "bomb", "bomb", "bomb")) if special else "file"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind in ("device", "nothing", "itself"):
        path.symlink_to({"device": "/dev/zero", "nothing": path.with_name("nothing"), "itself": path}[kind])
    else:
        path.write_bytes(dice.choice(BOMBS) if kind == "bomb" else damaged(dice, data))
    return special


def judge(name: str, path: Path, count: dict[str, int]) -> Iterator[str]:
    """What a door does with what stands at a path; what must not be is said.

    Args:
        name: of the door.
        path: of the file.
        count: changed.
    """
    reader, is_sound = DOORS[name]
    started = time.process_time()
    try:
        answer = reader(path)
        count["accepted"] += 1
        if not is_sound(answer):
            count["bad_content"] += 1
            yield "let in, and not sound"
    except MafsilError as error:
        count["refused"] += 1
        if not all(error.message(language) for language in ("en", "ar")):
            yield "nothing said"
    except Exception as error:  # The row's question: does anything foreign come out.
        count["bad_exception"] += 1
        yield f"{type(error).__name__}: {error}"
    seconds = time.process_time() - started
    if seconds > SECONDS * (1.0 + (path.stat().st_size / 1e6 if path.is_file() else 0.0)):
        count["bad_slow"] += 1
        yield f"{seconds:.1f} s"


def work(seed: int, files: int) -> dict[str, int]:
    """One child reads `files` files."""
    return in_child("tests.reliability.hostile_doors", seed, files, COUNTS)


def child(seed: int, files: int, last: Path) -> dict[str, int]:
    """Drive all doors under a limit of memory; what goes wrong is printed with its file."""
    dice, count = random.Random(seed), dict.fromkeys(COUNTS, 0)
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory(prefix="mafsil-F5-") as place:
        folder = Path(place)
        (folder / "made").mkdir()
        sound = specimens(folder / "made")
        for name, data in sound.items():
            (folder / name).write_bytes(data)
            reader, is_sound = DOORS[name]
            assert is_sound(reader(folder / name)), name
            (folder / name).unlink()
        before = peak_memory()
        most = before + (1 << 30)
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
        for _ in range(files):
            name = dice.choice(list(DOORS))
            path = folder / name
            count["special"] += put(dice, path, sound[name])
            last.unlink(missing_ok=True)
            last.symlink_to(path)
            for said in judge(name, path, count):
                head = path.read_bytes()[:160] if path.is_file() else b"no file"
                print(f"{name}: {said}: {head!r}", file=sys.stderr)
            path.rmdir() if path.is_dir() else path.unlink()
        grown = peak_memory() - before
        if grown > GROWTH:
            print(f"grown by {grown >> 20} MB", file=sys.stderr)
        return {**count, "files": files, "bad_memory": int(grown > GROWTH)}


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(child(int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))))
    else:
        figures.run("F5", figures.arguments(__doc__ or "", "files", 20_000, 5_000), work)
