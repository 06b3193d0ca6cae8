"""Random MJCF files that use every feature the reader keeps, from a seed alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mafsil.arrays import Floats

TETRAHEDRON = "0 0 0  0.2 0 0  0 0.3 0  0 0 0.25", "0 2 1  0 1 3  0 3 2  1 2 3"
KINDS = ("sphere", "capsule", "cylinder", "box", "ellipsoid", "fitted", "mesh")


class RandomMjcf:
    """One file; `text()` writes it, with its further files in a folder.

    Args:
        seed: number of the file.
        folder: where included files and mesh files are written.
        meshes: whether meshes weigh, too.
    """

    def __init__(self, seed: int, folder: Path, *, meshes: bool) -> None:
        self.kinds = KINDS if meshes else KINDS[:5]
        self.rng = np.random.default_rng(seed)
        self.folder = folder
        self.count = 0
        self.hinges: list[str] = []
        self.radian = self.chance(0.5)
        self.sequence = "".join(self.rng.permutation(list("xYz"))) if self.chance(0.5) else "xyz"

    def chance(self, p: float) -> bool:
        return bool(self.rng.random() < p)

    def numbers(self, count: int, low: float = -0.3, high: float = 0.3) -> str:
        return " ".join(f"{x:.6g}" for x in self.rng.uniform(low, high, count))

    def angle(self, low: float, high: float) -> float:
        value = float(self.rng.uniform(low, high))
        return value if self.radian else float(np.degrees(value))

    def turn(self) -> str:
        """One of the ways to write a rotation, or none."""
        axis = self.numbers(3, 0.1, 1.0)
        ways = (
            "",
            f'quat="{self.numbers(4, 0.1, 1.0)}"',
            f'axisangle="{axis} {self.angle(-2, 2)}"',
            f'euler="{self.angle(-2, 2)} {self.angle(-1, 1)} {self.angle(-2, 2)}"',
            f'zaxis="{axis}"',
            f'xyaxes="{axis} {self.numbers(3, -1.0, -0.1)}"',
        )
        return ways[self.rng.integers(len(ways))]

    def text(self) -> str:
        """The document."""
        self._write_files()
        rng = self.rng
        bodies = "".join(self.body(3) for _ in range(2))
        while len(self.hinges) < 5:
            bodies += self.body(3)
        bodies += self.replicated() + self.attached() + '<include file="part.xml"/><include file="parts/more.xml"/>'
        bodies += '<body name="cube" pos="2 2 2"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>'
        off = [f for f in ("gravity", "damper", "frictionloss") if self.chance(0.2)]
        flags = " ".join(f'{flag}="disable"' for flag in off)
        compiler = f'angle="{"radian" if self.radian else "degree"}" eulerseq="{self.sequence}" meshdir="meshes"'
        compiler += ' balanceinertia="true"' if self.chance(0.3) else ""
        compiler += f' boundmass="0.01" boundinertia="{rng.uniform(1e-5, 1e-3):.3g}"' if self.chance(0.3) else ""
        compiler += ' inertiagrouprange="0 2"' if self.chance(0.3) else ""
        leader, *followers = self.hinges
        couplings = f'<joint joint1="{followers[0]}" joint2="{leader}" polycoef="0.1 0.7 0 0 0"/>'
        couplings += f'<joint joint1="{followers[1]}" polycoef="0.2 0 0 0 0"/>' if self.chance(0.3) else ""
        return f"""<mujoco model="random">
  <compiler {compiler}/>
  <option gravity="{self.numbers(3, -9, 9)}" timestep="0.001"><flag {flags}/></option>
  <default><geom density="700" size="0.05 0.07 0.06"/><joint armature="0.01" damping="0.1 0 0"/>
    <default class="light"><geom density="{rng.uniform(50, 90):.3f}" group="{rng.integers(4)}"/>
      <joint frictionloss="0.2"/></default>
  </default>
  <asset>{self.meshes()}<model name="tool" file="tool.xml"/></asset>
  <worldbody><geom type="plane" size="1 1 1"/>{bodies}</worldbody>
  <equality>{couplings}</equality>
  <tendon><fixed name="pull" armature="0.3"><joint joint="{leader}" coef="0.4"/></fixed></tendon>
  <actuator><motor joint="{leader}" gear="7" armature="0.002"/><motor joint="{followers[2]}"/></actuator>
</mujoco>"""

    def meshes(self) -> str:
        """Inline and in files, by all four rules."""
        vertices, faces = TETRAHEDRON
        found = ""
        for rule in ("convex", "exact", "legacy", "shell"):
            pose = f'refpos="{self.numbers(3)}" refquat="{self.numbers(4, 0.1, 1)}" scale="{self.numbers(3, 0.5, 1.5)}"'
            found += f'<mesh name="{rule}" inertia="{rule}" {pose} vertex="{vertices}" face="{faces}"/>'
        return (
            found + '<mesh file="block.stl" scale="1 1 -1"/><mesh name="wedge" file="wedge.obj"/><mesh file="old.msh"/>'
        )

    def geom(self) -> str:
        kind = self.kinds[self.rng.integers(len(self.kinds))]
        place = f'pos="{self.numbers(3)}" {self.turn()}'
        weight = f'mass="{self.rng.uniform(0.1, 2):.4g}"' if self.chance(0.3) else ""
        mesh = ("convex", "exact", "legacy", "shell", "block", "wedge", "old")[self.rng.integers(7)]
        if kind == "mesh":
            return f'<geom type="mesh" mesh="{mesh}" {place} {weight}/>'
        if kind == "fitted":
            form = ("sphere", "box", "ellipsoid", "cylinder")[self.rng.integers(4)]
            return f'<geom type="{form}" mesh="block" fitscale="1.2" {place} {weight}/>'
        weight += ' shellinertia="true"' if kind != "ellipsoid" and self.chance(0.2) else ""
        if kind in ("capsule", "cylinder", "box", "ellipsoid") and self.chance(0.4):
            return f'<geom type="{kind}" size="0.04" fromto="{self.numbers(6)}" {weight}/>'
        size = "" if self.chance(0.2) else f'size="{self.numbers(int(self.rng.integers(1, 4)), 0.02, 0.1)}"'
        style = 'class="light"' if self.chance(0.3) else ""
        return f'<geom type="{kind}" {size} {place} {weight} {style}/>'

    def joint(self) -> str:
        self.count += 1
        slides = self.chance(0.25)
        name = f"j{self.count}"
        if not slides:
            self.hinges.append(name)
        reference = f'ref="{0.1 if slides else self.angle(-1, 1)}"' if self.chance(0.3) else ""
        kind = "slide" if slides else "hinge"
        place = f'axis="{self.numbers(3, 0.1, 1.0)}" pos="{self.numbers(3)}"'
        joint = f'<joint name="{name}" type="{kind}" {place} {reference}/>'
        return f'<frame pos="{self.numbers(3)}" {self.turn()}>{joint}</frame>' if self.chance(0.3) else joint

    def body(self, depth: int) -> str:
        """A body with what hangs on it."""
        self.count += 1
        name = f'name="b{self.count}"' if self.chance(0.8) else ""
        joints = "".join(self.joint() for _ in range(1 if depth == 3 else int(self.rng.integers(0, 3))))
        inside = (
            joints
            + '<geom type="box" size="0.1 0.1 0.1" group="0"/>'
            + "".join(self.geom() for _ in range(int(self.rng.integers(1, 4))))
        )
        if self.chance(0.3):
            inertia = (
                'diaginertia="0.02 0.03 0.025"' if self.chance(0.5) else 'fullinertia="0.02 0.03 0.025 1e-3 -2e-3 1e-3"'
            )
            turn = self.turn() if "diag" in inertia else ""
            inside += f'<inertial pos="{self.numbers(3)}" mass="0.8" {inertia} {turn}/>'
        inside += "".join(self.body(depth - 1) for _ in range(int(self.rng.integers(1, 3)) if depth else 0))
        if self.chance(0.3):
            inside = f'<frame pos="{self.numbers(3)}" {self.turn()} childclass="light">{inside}</frame>'
        style = 'childclass="light"' if self.chance(0.2) else ""
        return f'<body {name} pos="{self.numbers(3)}" {self.turn()} {style}>{inside}</body>'

    def replicated(self) -> str:
        joint, geom = '<joint name="bend" axis="0 1 1" pos="0.1 0 0"/>', '<geom type="capsule" size="0.02 0.1"/>'
        inner = f'<body name="finger">{joint}{geom}</body>'
        turn = f'euler="{self.angle(0.1, 1)} 0 {self.angle(0.1, 1)}" offset="{self.numbers(3)}"'
        again = f'<replicate count="2" offset="0 0 0.3" sep="+">{inner}</replicate>'
        count = self.rng.integers(2, 12)
        return f'<frame {self.turn()}><replicate count="{count}" sep="_" {turn}>{again}</replicate></frame>'

    def attached(self) -> str:
        whole = f'<frame pos="{self.numbers(3)}" {self.turn()}><attach model="tool" prefix="a/"/></frame>'
        return whole + '<body name="holder" pos="0 0 1"><attach model="tool" body="jaw" prefix="b/"/></body>'

    def _write_files(self) -> None:
        (self.folder / "meshes").mkdir(exist_ok=True)
        (self.folder / "parts").mkdir(exist_ok=True)
        corners = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.3) for z in (0, 0.1)], np.float32)
        quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
        (self.folder / "meshes/block.stl").write_bytes(stl(corners, faces))
        lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f " + " ".join(str(i + 1) for i in q) for q in quads]
        (self.folder / "meshes/wedge.obj").write_text("\n".join(lines) + "\n")
        header = np.array([len(corners), 0, 0, len(faces)], "<i4").tobytes()
        old = header + (corners + np.float32(0.05)).astype("<f4").tobytes() + faces.astype("<i4").tobytes()
        (self.folder / "meshes/old.msh").write_bytes(old)
        ball = '<joint type="hinge" axis="1 0 0"/><geom type="sphere" size="0.1"/>'
        (self.folder / "part.xml").write_text(f'<mujocoinclude><body name="part">{ball}</body></mujocoinclude>')
        more = '<mujocoinclude><include file="deep.xml"/></mujocoinclude>'
        (self.folder / "parts/more.xml").write_text(more)
        deep = f'<mujocoinclude><body name="deep" pos="1 0 0">{ball}</body></mujocoinclude>'
        (self.folder / "parts/deep.xml").write_text(deep)
        (self.folder / "tool.xml").write_text(TOOL)


TOOL = """<mujoco model="tool"><compiler angle="radian" eulerseq="ZYX"/>
  <default><geom density="300"/><joint armature="0.02"/>
    <default class="jaw"><geom type="box" size="0.02 0.03 0.1"/></default></default>
  <worldbody><body name="hand" euler="0.3 0.4 0.5" childclass="jaw"><joint name="wrist" axis="0 1 0" ref="0.2"/><geom/>
    <body name="jaw" pos="0.1 0 0.1" euler="0.5 0 0"><joint name="slide" type="slide" axis="1 0 0"/><geom/></body>
    <body name="thumb" pos="-0.1 0 0.1"><joint name="thumb" type="slide" axis="1 0 0"/><geom/></body></body></worldbody>
  <equality><joint joint1="thumb" joint2="slide" polycoef="0 -1 0 0 0"/></equality>
  <actuator><motor joint="slide" gear="3" armature="0.1"/></actuator>
</mujoco>"""


def stl(vertices: Floats, faces: Floats) -> bytes:
    """A binary STL file."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records = np.zeros(len(faces), record)
    records["corners"] = vertices[faces]
    return bytes(80) + np.uint32(len(faces)).tobytes() + records.tobytes()
