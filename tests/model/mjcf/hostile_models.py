"""MJCF models that the reader must not take as they stand, each with its verdict."""

from __future__ import annotations

from tests.model.urdf.hostile_files import Case

MASS = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
JOINT = '<joint name="j" axis="0 0 1" range="-1 1"/>'
SPRING = '<fixed stiffness="9"><joint joint="j" coef="1"/></fixed>'
CONNECT = '<connect body1="a" body2="b" anchor="0 0 0"/>'
BODY = f'<body name="a">\n{JOINT}\n{MASS}\n</body>\n'


def model(body: str = BODY, before: str = "", after: str = "") -> bytes:
    """A document: `before` in line 2, the bodies from line 4 (without `before`, 3), `after` at the end."""
    return f"<mujoco>\n{before}<worldbody>\n{body}</worldbody>\n{after}</mujoco>\n".encode()


def joint(text: str) -> bytes:
    """The joint in line 4."""
    return model(BODY.replace(JOINT, text))


def inertial(text: str) -> bytes:
    """The inertial in line 5."""
    return model(BODY.replace(MASS, text))


def equality(text: str, more: str = "") -> bytes:
    """A second joint, and a constraint in line 13, or what follows it in line 14."""
    after = f"<equality>\n{text}</equality>\n{more}"
    return model(BODY + BODY.replace('"a"', '"b"').replace('"j"', '"k"'), after=after)


CASES = (
    Case("empty colour", inertial(f'{MASS}<geom size=".1" rgba=""/>'), "F0128", 5, True, True, accepted=True),
    Case("wrong root", b"<robot/>", "F0130", 1, False, False),
    Case("no bodies", b"<mujoco><worldbody/></mujoco>", "S0310", 1, False, False),
    Case("free joint", joint("<freejoint/>"), "M0721", 4, False, True, accepted=True),
    Case("free joint by type", joint('<joint type="free"/>'), "M0721", 4, False, True, accepted=True),
    Case("free joint inside", inertial(f'{MASS}<body name="b"><freejoint/>{MASS}</body>'), "M0710", 5, True, True),
    Case("loose object", model(BODY + f'<body name="cube"><freejoint/>{MASS}</body>\n'), "M0722", 7, False, True,
         accepted=True),
    Case("floating in a loop", model(
        BODY + f'<body name="cube"><freejoint/>{MASS}</body>\n' + BODY.replace('"a"', '"b"').replace('"j"', '"k"'),
        after='<equality><connect body1="a" body2="cube" anchor="1 0 0"/>'
              '<connect body1="cube" body2="b" anchor="0 1 0"/></equality>\n',
    ), "M0729", 7, False, True, accepted=True),
    Case("ball joint", joint('<joint name="j" type="ball" pos="0 0 1"/>'), "M0711", 4, True, True,
         accepted=True),
    Case("armature of a ball", joint('<joint name="j" type="ball" armature="0.1"/>'), "M0730", 4, False, False),
    Case("unknown joint type", joint('<joint type="screw"/>'), "J0401", 4, True, True),
    Case("zero axis", joint('<joint axis="0 0 0"/>'), "J0404", 4, True, True),
    Case("inverted range", joint('<joint range="1 -1"/>'), "J0412", 4, True, True),
    Case("range nan", joint('<joint range="nan 1"/>'), "N0203", 4, False, False),
    Case("range of one", joint('<joint range="1"/>'), "N0205", 4, True, False),
    Case("unknown flag", joint('<joint limited="maybe"/>'), "M0706", 4, True, True),
    Case("damping negative", joint('<joint damping="-1"/>'), "J0430", 4, True, True),
    Case("spring", joint('<joint stiffness="5"/>'), "M0702", 4, False, True, accepted=True),
    Case("mass missing", inertial('<inertial diaginertia="1 1 1"/>'), "N0201", 5, False, False),
    Case("inertia missing", inertial('<inertial mass="1"/>'), "N0201", 5, False, False),
    Case("mass negative", inertial(MASS.replace('mass="1"', 'mass="-1"')), "I0503", 5, False, False),
    Case("moment negative", inertial(MASS.replace("1 1 1", "1 1 -1")), "I0504", 5, False, False),
    Case("quaternion zero", inertial(MASS.replace("<inertial", '<inertial quat="0 0 0 0"')), "M0714", 5, False, False),
    Case("no inertia", inertial(""), "I0501", 3, False, True, accepted=True),
    Case("huge geometry", inertial('<geom size="1e9"/>'), "N0207", 3, False, False),
    Case("size missing", inertial('<geom type="box" size="1 1"/>'), "N0205", 5, False, False),
    Case("size zero", inertial('<geom type="box" size="1 0 1"/>'), "G0603", 5, False, False),
    Case("mass from a mesh", model(BODY.replace(MASS, '<geom type="mesh" mesh="m"/>'),
                                   before='<asset><mesh name="m" file="m.stl"/></asset>\n'), "M0717", 4, False, False),
    Case("mesh not found", model(BODY.replace("</body>", '<geom type="mesh" mesh="m"/></body>'),
                                 before='<asset><mesh name="m" file="m.stl"/></asset>\n'),
         "G0613", 2, False, True, accepted=True),
    Case("unknown mesh", inertial(MASS + '<geom type="mesh" mesh="m"/>'), "M0718", 5, False, False),
    Case("unknown class", joint('<joint class="c"/>'), "M0705", 4, False, False),
    Case("replicate without count", model(BODY + "<replicate/>\n"), "N0201", 7, False, False),
    Case("soft part", inertial(MASS + '<flexcomp count="9 9 1"/>'), "M0701", 5, True, True),
    Case("soft object", model(BODY + '<flexcomp count="9 9 1"/>\n'), "M0722", 7, False, True, accepted=True),
    Case("unknown attribute", joint('<joint name="j" dampping="1"/>'), "M0719", 4, True, True),
    Case("strange attribute", joint('<joint name="j" colour="1"/>'), "M0719", 4, False, False),
    Case("attach of nothing", model(BODY + '<attach model="m" body="b" prefix="p"/>\n'), "M0718", 7, False, False),
    Case("attach of no body", model(BODY + '<attach body="x" prefix="p"/>\n'), "M0725", 7, False, False),
    Case("armature of a tendon", equality("", '<tendon><fixed armature="1"><joint joint="j" coef="1"/>'
         '<joint joint="k" coef="1"/></fixed></tendon>\n'), "M0724", 14, False, False),
    Case("global coordinates", model(before='<compiler coordinate="global"/>\n'), "M0701", 2, False, False),
    Case("euler sequence", model(before='<compiler eulerseq="abc"/>\n'), "M0706", 2, False, False),
    Case("include of a text", model(before='<include file="x.xml"/>\n'), "M0703", 2, False, False),
    Case("tendon with a spring", model(after=f"<tendon>{SPRING}</tendon>\n"),
         "M0702", 8, False, True, accepted=True),
    Case("joint of the world", model(BODY + "<joint/>\n"), "M0720", 7, False, False),
    Case("joint of the world in a frame", model(BODY + "<frame><joint/></frame>\n"), "M0720", 7, False, False),
    Case("two inertials", inertial(MASS + MASS), "M0726", 5, True, True),
    Case("nonsense section", model(after="<wobble/>\n"), "M0720", 8, False, False),
    Case("coupling of nothing", equality('<joint joint1="x" joint2="j"/>\n'), "M0712", 13, True, True),
    Case("coupling of no number", equality('<joint joint1="j" joint2="k" polycoef="0 1 nan"/>\n'),
         "N0203", 13, False, False),
    Case("coupling with itself", equality('<joint joint1="j" joint2="j"/>\n'), "J0421", 13, True, False),
    Case("connect", equality(f"{CONNECT}\n"), "M0728", 13, False, True, accepted=True),
    Case("weld of nothing", equality('<weld body1="x"/>\n'), "M0713", 13, True, True),
    Case("actuator of nothing", model(after='<actuator><motor joint="x"/></actuator>\n'), "M0712", 8, True, True),
    Case("loop named like a joint", equality('<weld name="j" body1="a" body2="b"/>\n'), "S0312", 1, False, False),
    Case("duplicate body", model(BODY + BODY.replace('"j"', '"k"')), "S0303", 7, False, False),
    Case("duplicate joint", model(BODY + BODY.replace('"a"', '"b"')), "S0304", 8, False, False),
)  # fmt: skip
