"""Writes docs/mjcf.md from the table that the MJCF reader itself obeys.

python docs/make_mjcf.py            writes the page
python docs/make_mjcf.py --check    fails if the page is not what would be written
"""

from __future__ import annotations

import sys
from pathlib import Path

from mafsil.model.mjcf.settings import MOTORS, ROWS
from mafsil.model.vocabulary import Row, Treatment

PAGE = Path(__file__).parent / "mjcf.md"
HEAD = """# MJCF: what is read, and what becomes of the rest

Made by `docs/make_mjcf.py` from the table that the reader obeys (`mafsil.model.mjcf.settings`). The rule: every
element and every attribute of a file is read, or stands here with the reason why a mechanism does not depend on it, or
is left out with a warning (M0702, in `provenance.notes`) where its value is not neutral. What the table does not
know is an error (M0719, M0720). A test holds the table against the schema that MuJoCo prints.

```python
from mafsil.model import mjcf

mechanism = mjcf.read('''<mujoco>
  <option><flag gravity="disable"/></option>
  <worldbody>
    <body name="arm"><joint name="turn" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03"/></body>
    <body name="cube" pos="1 0 0"><freejoint/><geom type="box" size="0.02 0.02 0.02"/></body>
  </worldbody>
</mujoco>''')
print(mechanism.joint_names, mechanism.gravity, mechanism.provenance.notes)
```

- **Free bodies.** A loose object beside a fixed robot is left out with what it carries (M0722). A robot that floats
  is fixed in the world where the file draws it (M0721): mechanisms have no floating base. A floating body counts as
  a robot if it carries at least one moving joint and no part fixed in the world carries more.
- **Inertia from geometry** follows MuJoCo: primitives, shells, meshes by the rules convex, exact, legacy and shell
  (STL, OBJ, Collada, MSH, or numbers in the file), shapes fitted to meshes, groups, bounds, balance, total mass. A
  mesh that cannot be read stops the reader only if a joint moves its body (M0717).
- **Flags.** Without gravity, damper, frictionloss, equality or constraint the mechanism has none of it.
- **Couplings.** `<joint>` of `equality` becomes a mimic or a locked joint. `<weld>` and `<connect>`, between bodies
  or sites, close loops by a fixed and by a ball joint (M0728): `parallel.ClosedChain` keeps them closed, and
  functions of open chains refuse the robot. A body with a free joint that two constraints or more
  tie to the robot, such as the platform on six legs, gets three slides and three hinges that nothing drives (M0729).
  Welds to `mocap` bodies are said to stay open (M0723); other constraints (`tendon`,
  `flex`) are left out with their names (M0702).
- **Sites and frames** with names are links without mass, which every `tip=` and `frame=` takes
  ([robot files](robot_files.md#named-frames)); sites that hold loops are not.
- **Writing.** `mf.save(robot, "arm.xml")` writes a file with the same mechanics, loops as constraints between sites
  ([robot files](robot_files.md#writing-robot-files)). `boundmass` and `boundinertia` of 1e-12 or less stand for none.
- **Tendons.** `armature` of a fixed tendon, or of a motor that pulls it, adds inertia where its joints are coupled to
  one coordinate; across independent joints, and of a spatial tendon, it is refused (M0724).
- **Files.** Includes and meshes are looked for beside the model, then beside the file that names them, inside the
  package or repository that the model was published in (the nearest folder upwards with `package.xml`, `.git`,
  `pyproject.toml`, `setup.py` or a licence, or the outermost Python package) and the folders named in `packages`.
- **Ball joints** are read as three hinges about the axes of the body (M0711); damping, friction and range of a
  ball are left out and said, and one with armature is refused (M0730).
"""


def main() -> int:
    """Write or check the page."""
    text = HEAD + "\n" + "\n".join(lines()) + "\n"
    if "--check" in sys.argv:
        return int(not PAGE.exists() or PAGE.read_text("utf-8") != text)
    PAGE.write_text(text, "utf-8")
    return 0


def lines() -> list[str]:
    """The table in Markdown."""
    found = ["## The table", ""]
    for place, row in ROWS.items():
        title = "the elements of `actuator`: " + ", ".join(MOTORS) if place == "actuator/motor" else f"`{place}`"
        found += [f"### {title}", "", *_attributes(row), ""]
    return found[:-1]


def _attributes(row: Row) -> list[str]:
    listed = [f"- read: {_names(row.read)}"] if row.read else []
    listed += [
        f"- {treatment.value}: {_names(names)}"
        for treatment, names in row.other.items()
        if treatment is not Treatment.READ
    ]
    listed += [f"- elements read: {_names(row.children)}"] if row.children else []
    listed += [f"- elements, {treatment.value}: {_names(names)}" for treatment, names in row.whole.items()]
    return listed


def _names(text: str) -> str:
    return ", ".join(f"`{name}`" for name in text.split())


if __name__ == "__main__":
    raise SystemExit(main())
