"""The hostile robot files of RELIABILITY.md section 2, made in code, each with what must be said about it."""

from __future__ import annotations

from dataclasses import dataclass

MOMENTS = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
INERTIAL = f'<inertial><mass value="1"/>{MOMENTS}</inertial>'
LINKS = f'<link name="a">{INERTIAL}</link>\n<link name="b">\n{INERTIAL}\n</link>\n'
ENDS = '<parent link="a"/><child link="b"/>'
LIMIT = '<limit lower="-1" upper="1" effort="5" velocity="2"/>'
AXIS = '<axis xyz="0 0 1"/>'
JOINT = f'<joint name="j" type="revolute">\n{ENDS}\n{AXIS}\n{LIMIT}\n</joint>\n'


@dataclass(frozen=True)
class Case:
    """A file and its verdict.

    Attributes:
        name: of the case.
        data: the file.
        code: of the diagnostic that must be there.
        line: where it must be.
        repair: whether a repair is offered.
        mended: whether the repaired file can be read.
        accepted: whether the file as it stands can be read (with warnings).
    """

    name: str
    data: bytes
    code: str
    line: int
    repair: bool
    mended: bool
    accepted: bool = False


def robot(*parts: str) -> bytes:
    """A document; the robot starts in line 1, the first part in line 2."""
    return ('<robot name="r">\n' + "".join(parts) + "</robot>\n").encode()


def sound() -> bytes:
    """Two links and a revolute joint, nothing wrong."""
    return robot(LINKS, JOINT)


def _mass(value: str) -> bytes:
    return sound().replace(b'<mass value="1"/>', f'<mass value="{value}"/>'.encode(), 1)


def _joint(old: str, new: str) -> bytes:
    assert old.encode() in sound()
    return sound().replace(old.encode(), new.encode(), 1)


def _joint_between(name: str, parent: str, child: str, extra: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="revolute">{ends}{AXIS}{LIMIT}{extra}</joint>\n'


def _mimic(name: str, leader: str) -> str:
    return f'<mimic joint="{leader}"/>'


def _two_mimics() -> bytes:
    links = LINKS + '<link name="c"/>\n'
    first = _joint_between("j", "a", "b", _mimic("j", "k"))
    return robot(links, first, _joint_between("k", "b", "c", _mimic("k", "j")))


def _bomb() -> bytes:
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">\n' for k in range(1, 10))
    head = f'<!DOCTYPE robot [\n<!ENTITY e0 "lol">\n{entities}]>\n'
    return head.encode() + sound().replace(b'name="r"', b'name="&e9;"')


def _quadratic() -> bytes:
    head = f'<!DOCTYPE robot [<!ENTITY e "{"x" * 50_000}">]>\n'
    return head.encode() + sound().replace(b'name="r"', b'name="' + b"&e;" * 2_000 + b'"')


def _external() -> bytes:
    head = '<!DOCTYPE robot [<!ENTITY e SYSTEM "file:///etc/passwd">]>\n'
    return head.encode() + sound().replace(b"</robot>", b"&e;</robot>")


def _harmless_doctype() -> bytes:
    return b"<!DOCTYPE robot>\n" + sound()


def chain(links: int) -> bytes:
    parts = [f'<link name="l{k}">{INERTIAL}</link>\n' for k in range(links)]
    return robot(*parts, *(_joint_between(f"j{k}", f"l{k}", f"l{k + 1}") for k in range(links - 1)))


def _mesh(reference: str) -> bytes:
    visual = f'<visual><geometry><mesh filename="{reference}"/></geometry></visual>'
    return sound().replace(b'<link name="b">\n', f'<link name="b">\n{visual}'.encode())


def _moment(ixx: str, iyy: str = "1", izz: str = "1") -> bytes:
    old = b'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'
    return sound().replace(old, f'ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"'.encode(), 1)


def _chain_of_mimics(multiplier: str, links: int) -> bytes:
    parts = [f'<link name="l{k}"/>\n' for k in range(links + 1)]
    mimic = [f'<mimic joint="j{k - 1}" multiplier="{multiplier}" offset="1"/>' if k else "" for k in range(links)]
    return robot(*parts, *(_joint_between(f"j{k}", f"l{k}", f"l{k + 1}", mimic[k]) for k in range(links)))


def _after_fixed(extra: str) -> bytes:
    fixed = '<joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint>\n<link name="c"/>\n'
    return robot(LINKS, fixed, _joint_between("j", "a", "b", extra))


def _shape(inside: str) -> bytes:
    """A visual in line 4."""
    return sound().replace(b'<link name="b">\n', f'<link name="b">\n<visual>{inside}</visual>'.encode())


_QUARTER = '<origin quat_xyzw="0 0 1 1"/>'


def _of_version(version: str, origin: str = "", limits: str = "") -> bytes:
    head, limited = f'<robot version="{version}" name', f'{limits}lower="-1"'
    parts = ((b"<robot name", head), (ENDS.encode(), ENDS + origin), (b'lower="-1"', limited))
    text = sound()
    for old, new in parts:
        text = text.replace(old, new.encode(), 1)
    return text


BOX = '<collision><geometry><box size="1 -1 1"/></geometry></collision>'

CASES = (
    Case("mass nan", _mass("nan"), "N0203", 2, True, False),
    Case("mass inf", _mass("inf"), "N0203", 2, True, False),
    Case("mass one kg", _mass("one kg"), "N0205", 2, True, False),
    Case("mass word", _mass("heavy"), "N0202", 2, True, False),
    Case("mass with comma", _mass("1,5"), "N0208", 2, True, True),
    Case("mass 1e400", _mass("1e400"), "N0204", 2, True, False),
    Case("mass 1e-400", _mass("1e-400"), "N0206", 2, True, True, accepted=True),
    Case("mass 1e20", _mass("1e20"), "N0207", 2, True, False),
    Case("mass hexadecimal", _mass("0x10"), "N0209", 2, True, True),
    Case("mass in Arabic digits", _mass("١٫٥"), "N0210", 2, True, True),
    Case("mass with unit", _mass("1.5 kg"), "N0211", 2, True, True),
    Case("mass empty", _mass(""), "N0205", 2, True, False),
    Case("mass negative", _mass("-1"), "I0503", 2, True, False),
    Case("mass zero", _mass("0"), "I0508", 2, False, True, accepted=True),
    Case("moment negative", _moment("-1"), "I0504", 2, True, False),
    Case("triangle violated", _moment("5"), "I0506", 2, True, True, accepted=True),
    Case("axis zero", _joint('xyz="0 0 1"', 'xyz="0 0 0"'), "J0404", 8, False, False),
    Case("axis of two numbers", _joint('xyz="0 0 1"', 'xyz="0 1"'), "N0205", 8, True, False),
    Case("axis not unit", _joint('xyz="0 0 1"', 'xyz="0 0 2"'), "J0405", 8, True, True, accepted=True),
    Case("no axis", _joint(AXIS, ""), "J0406", 6, True, True, accepted=True),
    Case("limits inverted", _joint('lower="-1"', 'lower="2"'), "J0412", 9, True, False),
    Case("limits exchanged", _joint('lower="-1" upper="1"', 'lower="2" upper="-1"'), "J0428", 9, True, True,
         accepted=True),
    Case("misspelt revolute", _joint('type="revolute"', 'type="revolut"'), "J0401", 6, True, True),
    Case("misspelt prismatic", _joint('type="revolute"', 'type="prizmatic"'), "J0401", 6, True, True),
    Case("axis without numbers", _joint('axis xyz="0 0 1"', "axis"), "J0406", 8, True, True, accepted=True),
    Case("floating joint behind the base",
         robot(LINKS, JOINT, '<link name="c"/>\n', _joint_between("k", "b", "c").replace("revolute", "floating")),
         "J0403", 12, False, False),
    Case("the same link twice", sound().replace(b'<link name="a">', b'<link name="c"/>\n' * 2 + b'<link name="a">'),
         "S0303", 3, True, False),
    Case("only macros", b'<robot name="r" xmlns:xacro="x"><xacro:macro name="m"/></robot>', "F0131", 1, False, False),
    Case("limit nan", _joint('lower="-1"', 'lower="nan"'), "N0203", 9, True, False),
    Case("limit missing", _joint(LIMIT, ""), "J0410", 6, False, True, accepted=True),
    Case("effort zero", _joint('effort="5"', 'effort="0"'), "J0416", 9, False, True, accepted=True),
    Case("velocity negative", _joint('velocity="2"', 'velocity="-2"'), "J0417", 9, True, False),
    Case("loop of joints", robot(LINKS, JOINT, _joint_between("k", "b", "a")), "S0309", 6, False, False),
    Case("joint to itself", _joint('child link="b"', 'child link="a"'), "S0306", 6, False, False),
    Case("two roots", robot(LINKS, JOINT, '<link name="c"/>\n'), "S0308", 11, False, False),
    Case("two parents", robot(LINKS, JOINT, _joint_between("k", "a", "b")), "S0307", 11, False, False),
    Case("duplicate link", robot(LINKS, '<link name="b"/>\n', JOINT), "S0303", 6, False, False),
    Case("duplicate joint", robot(LINKS, JOINT, '<link name="c"/>\n', _joint_between("j", "b", "c")),
         "S0304", 12, True, True),
    Case("unknown link", _joint('child link="b"', 'child link="x"'), "S0305", 7, False, False),
    Case("unknown joint type", _joint('type="revolute"', 'type="wobbly"'), "J0401", 6, False, False),
    Case("misspelt joint type", _joint('type="revolute"', 'type="Hinge"'), "J0401", 6, True, True),
    Case("floating joint", _joint('type="revolute"', 'type="floating"'), "J0402", 6, False, True, accepted=True),
    Case("no joint type", _joint(' type="revolute"', ""), "J0401", 6, False, False),
    Case("no child", _joint('<child link="b"/>', ""), "F0135", 6, False, False),
    Case("mimic of nothing", robot(LINKS, _joint_between("j", "a", "b", _mimic("j", "x"))),
         "J0420", 6, True, True, accepted=True),
    Case("mimic of itself", robot(LINKS, _joint_between("j", "a", "b", _mimic("j", "j"))), "J0421", 6, True, False),
    Case("mimic in a circle", _two_mimics(), "J0422", 7, True, False),
    Case("cut in half", sound()[: len(sound()) // 2], "F0111", 4, False, False),
    Case("mismatched tag", sound().replace(b"</joint>", b"</link>"), "F0112", 10, False, False),
    Case("entity bomb", _bomb(), "F0116", 1, False, False),
    Case("quadratic blow-up", _quadratic(), "F0116", 1, False, False),
    Case("external entity", _external(), "F0116", 1, False, False),
    Case("harmless DOCTYPE", _harmless_doctype(), "F0129", 1, True, True, accepted=True),
    Case("undefined entity", sound().replace(b"</robot>", b"&e;</robot>"), "F0115", 11, True, True,
         accepted=True),
    Case("deep nesting", b"<robot>\n" + b"<a>" * 200_000, "F0122", 2, False, False),
    Case("too many links", chain(10_001), "F0121", 10_002, False, False),
    Case("too many elements", robot("<a/>\n" * 250_001), "F0120", 250_001, False, False),
    Case("too many attributes", robot("<a " + " ".join(f'k{k}=""' for k in range(200)) + "/>"),
         "F0123", 2, False, False),
    Case("mesh outside its package", _mesh("package://../../../../etc/passwd"), "G0610", 4, True, True, accepted=True),
    Case("mesh outside the model", _mesh("file:///etc/passwd"), "G0611", 4, False, True, accepted=True),
    Case("mesh of no package", _mesh("package://nowhere/mesh.stl"), "G0612", 4, False, True, accepted=True),
    Case("mesh from the network", _mesh("http://example.org/mesh.stl"), "G0614", 4, False, True, accepted=True),
    Case("size negative", sound().replace(b'<link name="b">\n', b'<link name="b">\n' + BOX.encode()),
         "G0603", 4, True, True, accepted=True),
    Case("UTF-16", sound().decode().encode("utf-16"), "F0109", 1, False, True, accepted=True),
    Case("Latin-1, not declared", sound().replace(b'"r"', b'"r\xe9"'), "F0126", 1, True, True, accepted=True),
    Case("not the Chinese that it declares",
         b'<?xml version="1.0" encoding="gbk"?>' + sound().replace(b'"r"', b'"\xff"'), "F0106", 0, False, False),
    Case("UTF-16 that is UTF-8", b'<?xml version="1.0" encoding="utf-16"?>' + sound(), "F0127", 1, True, True,
         accepted=True),
    Case("unknown encoding", b'<?xml version="1.0" encoding="EBCDIC"?>\n' + sound(), "F0107", 1, True, True),
    Case("byte order mark", b"\xef\xbb\xbf" + sound(), "F0108", 1, False, True, accepted=True),
    Case("NUL", sound().replace(b'"r"', b'"r\0"'), "F0105", 1, False, False),
    Case("empty", b"", "F0104", 0, False, False),
    Case("no links", b'<robot name="r"/>', "S0310", 1, False, False),
    Case("another format", b"<mujoco/>", "F0130", 1, False, False),
    Case("xacro", robot(LINKS, JOINT, "<xacro:arm/>"), "X1122", 11, True, True, accepted=True),
    Case("xacro that is used", robot(LINKS, '<xacro:arg name="n" default="1"/><xacro:arm/>'), "X1101", 6, False, False),
    Case("link without name", sound().replace(b'name="b"', b'nom="b"'), "S0301", 3, False, False),
    Case("direction override in a name", sound().replace(b'"b"', '"b\u202ea"'.encode()),
         "S0302", 3, True, True, accepted=True),
    Case("not well-formed", sound().replace(b"<axis", b"<<axis"), "F0110", 8, False, False),
    Case("attribute twice", _joint('type="revolute"', 'type="revolute" type="fixed"'), "F0113", 6, False, False),
    Case("junk after the end", sound() + b"<a/>", "F0114", 11, True, True, accepted=True),
    Case("a second end", sound() + b"</robot>", "F0114", 11, True, True, accepted=True),
    Case("hyphens in a comment", sound().replace(b"<link", b"<!-- -- --><link", 1), "F0117", 2, True, True,
         accepted=True),
    Case("blank before the declaration", b' <?xml version="1.0"?>' + sound(), "F0118", 1, True, True, accepted=True),
    Case("no blank", _joint('name="j" ', 'name="j"'), "F0119", 6, True, True, accepted=True),
    Case("bracket in a name", sound().replace(b'"b"', b'"b<"'), "F0124", 3, True, True, accepted=True),
    Case("attributes of an end", sound().replace(b"</robot>", b'</robot name="r">'), "F0125", 11, True, True,
         accepted=True),
    Case("too many errors", robot(LINKS, JOINT, "<joint/>\n" * 1_001), "F0132", 261, False, False),
    Case("too many remarks", robot(LINKS, JOINT, "<wobble/>\n" * 1_001), "F0137", 1_010, False, True, accepted=True),
    Case("misspelt element", _joint("<limit", "<limits"), "F0133", 9, False, True, accepted=True),
    Case("nameless robot", sound().replace(b'name="r"', b""), "S0311", 1, False, True, accepted=True),
    Case("no range", _joint('lower="-1" upper="1"', ""), "J0411", 9, False, True, accepted=True),
    Case("range of 0", _joint('lower="-1" upper="1"', 'lower="0" upper="0"'), "J0414", 9, False, True, accepted=True),
    Case("limits equal", _joint('lower="-1" upper="1"', 'lower="1" upper="1"'), "J0413", 9, False, True, accepted=True),
    Case("half a range", _joint('lower="-1"', ""), "J0419", 9, False, True, accepted=True),
    Case("no effort", _joint('effort="5"', ""), "J0415", 9, False, True, accepted=True),
    Case("continuous with a range", _joint("revolute", "continuous"), "J0418", 9, False, True, accepted=True),
    Case("mimic of a mimic", _chain_of_mimics("2", 3), "J0423", 8, False, True, accepted=True),
    Case("mimics beyond floating point", _chain_of_mimics("1e15", 30), "J0427", 54, False, False),
    Case("mimic on a fixed joint", robot(LINKS, JOINT.replace("revolute", "fixed").replace(AXIS, '<mimic joint="j"/>')),
         "J0424", 8, False, True, accepted=True),
    Case("mimic of fixed", _after_fixed('<mimic joint="k" offset="1"/>'), "J0425", 8, False, True, accepted=True),
    Case("mimic times zero", _chain_of_mimics("0", 2), "J0426", 6, False, True, accepted=True),
    Case("safety controller", _joint(AXIS, AXIS + '<safety_controller k_velocity="1"/>'),
         "J0431", 8, False, True, accepted=True),
    Case("transmission of two", robot(LINKS, JOINT, '<transmission name="t"/>\n'),
         "J0432", 11, False, True, accepted=True),
    Case("massless", sound().replace(INERTIAL.encode(), INERTIAL.replace('"1"', '"0"').encode()),
         "I0502", 2, False, True, accepted=True),
    Case("inertia zero", _moment("0", "0", "0"), "I0507", 2, False, True, accepted=True),
    Case("inertia not written", sound().replace(MOMENTS.encode(), b""), "I0507", 2, False, True, accepted=True),
    Case("inertia of a diagonal", sound().replace(b'ixy="0" ixz="0" ', b""), "I0509", 2, True, True, accepted=True),
    Case("moment not written", sound().replace(b'ixx="1" ', b""), "N0201", 2, True, False),
    Case("inertia not positive", _moment("-0.1"), "I0505", 2, True, True, accepted=True),
    Case("geometry empty", _shape("<geometry/>"), "G0601", 4, False, True, accepted=True),
    Case("geometry unknown", _shape("<geometry><cone/></geometry>"), "G0602", 4, True, True, accepted=True),
    Case("geometry missing", _shape(""), "F0135", 4, True, True, accepted=True),
    Case("scale zero", _shape('<geometry><mesh filename="a.stl" scale="1 0 1"/></geometry>'),
         "G0604", 4, True, True, accepted=True),
    Case("colour out of range", _shape('<geometry><sphere radius="1"/></geometry><material name="m">'
                                       '<color rgba="255 0 0 1"/></material>'), "G0620", 4, False, True, accepted=True),
    Case("material unknown", _shape('<geometry><sphere radius="1"/></geometry><material name="m"/>'),
         "G0621", 4, False, True, accepted=True),
    Case("damping negative", _joint(AXIS, AXIS + '<dynamics damping="-1"/>'), "J0430", 8, True, False),
    Case("misspelt attribute", _joint('xyz="0 0 1"', 'xzy="0 0 1"'), "F0139", 8, True, True, accepted=True),
    Case("quaternion in URDF 1.0", _joint(ENDS, ENDS + _QUARTER), "F0140", 7, True, True, accepted=True),
    Case("URDF of the future", _of_version("3.0"), "F0141", 1, True, False),
    Case("version of one number", _of_version("1"), "F0141", 1, True, True),
    Case("quaternion of zeros", _of_version("1.1", _QUARTER.replace("1 1", "0 0")), "N0212", 7, False, False),
    Case("rotation twice", _of_version("1.1", _QUARTER.replace("quat", 'rpy="0 0 1" quat')), "N0213", 7, False, False),
    Case("quaternion not unit", _of_version("1.1", _QUARTER), "N0214", 7, True, True, accepted=True),
    Case("effort -1", _joint('effort="5"', 'effort="-1"'), "J0433", 9, True, True, accepted=True),
    Case("upper inf", _joint('upper="1"', 'upper="inf"'), "J0434", 9, True, True, accepted=True),
    Case("deceleration", _of_version("1.2", "", 'acceleration="3" deceleration="2" '), "J0435", 9, False, True,
         accepted=True),
    Case("open range", _of_version("1.2").replace(b'upper="1"', b""), "J0436", 9, False, True, accepted=True),
    Case("two inertials", robot(LINKS.replace(INERTIAL, INERTIAL * 2), JOINT), "F0134", 2, True, True, accepted=True),
)  # fmt: skip
