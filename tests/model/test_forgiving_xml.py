"""What tinyxml2 takes is read, and said: faults of XML held against Pinocchio, which reads by tinyxml2."""

from __future__ import annotations

import random
import re
import string
from contextlib import suppress
from pathlib import Path

import pytest

import mafsil as mf
from mafsil.errors import FileError
from mafsil.model import lint, mjcf, sdf, urdf
from mafsil.model.faults import PARDONED
from mafsil.model.robot_source import root_tag
from mafsil.model.xml_tree import Refusal, parse
from tests.budget import within

GOOD = (
    '<robot name="r"><link name="a"/><link name="b"/>\n<joint name="j" type="continuous"><parent link="a"/>'
    '<child link="b"/><axis xyz="1 0 0"/></joint>\n</robot>\n'
)
END = "</robot>\n"


def _with(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new, 1)


TAKEN = {
    "hyphens": "<!-- run: tool --show arm -->" + GOOD,
    "hyphen at the end": "<!-- a --->" + GOOD,
    "nested": "<!-- a <!-- b -->" + GOOD,
    "blank first": '\n <?xml version="1.0"?>' + GOOD,
    "two declarations": '<?xml version="1.0"?><?xml version="1.0"?>' + GOOD,
    "no version": '<?xml encoding="utf-8"?>' + GOOD,
    "capitals": '<?XML version="1.0"?>' + GOOD,
    "no quotes": "<?xml version=1.0?>" + GOOD,
    "no blank": _with('name="j" type', 'name="j"type'),
    "ampersand": _with('name="j"', 'name="j & k"'),
    "half a reference": _with('name="j"', 'name="j&k;"'),
    "ampersand in text": _with(END, "a & b" + END),
    "HTML": _with(END, "&copy;" + END),
    "bracket": _with('name="j"', 'name="j<k"'),
    "second end": GOOD + END,
    "second root": GOOD + "<a/>",
    "text first": "hello" + GOOD,
    "form feed": "\x0c" + _with('<link name="b"/>', '\x0c<link name="b"/>'),
    "control": _with(END, "\x01" + END),
    "end of data": _with(END, "]]>" + END),
    "attribute of an end": _with(END, '</robot x="1">'),
    "blank in a tag": _with('<link name="a"/>', '< link name="a"/>'),
    "no character": _with('name="j"', 'name="j&#0;"'),
    "no number": _with('name="j"', 'name="j&#xZZ;"'),
    "document type": "<!DOCTYPE robot>" + GOOD,
    "document type elsewhere": '<!DOCTYPE robot PUBLIC "-//x//y" "http://nowhere/robot.dtd">' + _with('"j"', '"j&k;"'),
    "unknown markup": "<!FOO bar>" + GOOD,
    "noncharacter": _with(END, "\uffff" + END),
}
REFUSED = {
    "unquoted": _with('name="j"', "name=j"),
    "no value": _with('name="j"', 'name="j" foo'),
    "bracket in text": _with(END, "a < b" + END),
    "blank in an end": _with(END, "</ robot>"),
    "wrong case": _with(END, "</Robot>"),
    "not closed": _with(END, ""),
    "comma": _with('name="j" type', 'name="j",type'),
    "lone bracket": _with(END, "<" + END),
    "twice": _with("type=", 'name="k" type='),
}
LATIN = {
    "comment": "<!-- © é -->".encode("latin-1") + GOOD.encode(),
    "surrogate": GOOD.encode() + b"<!--\xed\xa0\x80-->",
}


@pytest.mark.parametrize("name", TAKEN)
def test_what_tinyxml2_takes_is_read_said_and_mended(name: str) -> None:
    pin = pytest.importorskip("pinocchio")
    text = TAKEN[name]
    report = urdf.diagnose(text.encode())
    assert report.mechanism is not None
    assert pin.buildModelFromXML(text).njoints == 2
    said = [d for d in report if d.fault in PARDONED]
    assert said
    assert all(d.line >= 1 and d.column >= 1 and d.repair is not None for d in said)
    assert all(any("\u0600" <= c <= "\u06ff" for c in d.sentence("ar")) for d in said)
    mended, changes = urdf.repair(text.encode())
    if any(d.repair is not None and d.repair.guess for d in said):
        return
    assert changes
    again = urdf.diagnose(mended)
    assert again.mechanism is not None
    assert not [d for d in again if d.fault in PARDONED]
    assert repr(again.mechanism.joints) == repr(report.mechanism.joints)


@pytest.mark.parametrize("name", REFUSED)
def test_what_tinyxml2_refuses_is_refused(name: str) -> None:
    pin = pytest.importorskip("pinocchio")
    with pytest.raises(ValueError, match="URDF"):
        pin.buildModelFromXML(REFUSED[name])
    with pytest.raises(FileError, match="F01"):
        urdf.read(REFUSED[name].encode())


@pytest.mark.parametrize("name", LATIN)
def test_undeclared_western_text(name: str) -> None:
    report = urdf.diagnose(LATIN[name])
    assert report.ok
    assert "F0126" in report.codes
    assert "F0126" not in urdf.diagnose(urdf.repair(LATIN[name])[0]).codes


def test_places_and_repairs_behind_a_pardon_are_those_of_the_file() -> None:
    text = "<!-- -- -->" + GOOD.replace('type="continuous"', 'type="Hinge"').replace(
        'name="a"/>', 'name="a"colour="é"/>'
    )
    report = urdf.diagnose(text)
    (kind,) = (d for d in report if d.code == "J0401")
    line = text.splitlines()[kind.line - 1]
    assert line[kind.column - 1 :].startswith('type="Hinge"')
    (blank,) = (d for d in report if d.code == "F0119")
    assert text[blank.column - 1 :].startswith("colour")
    mended, _ = urdf.repair(text)
    assert '<joint name="j" type="revolute">' in mended
    assert '<link name="a" colour="é"/>' in mended
    assert "<!-- - - -->" in mended


def test_other_formats_forgive_too(tmp_path: Path) -> None:
    body = '<body name="l"><joint name="h"axis="0 1 0"/><geom size=".1"/></body>'
    arm = f"<!-- a -- b --><mujoco><worldbody>{body}</worldbody></mujoco></mujoco>"
    assert mjcf.diagnose(arm).codes.count("F0119") == 1
    assert mjcf.read(arm).joint_names == ("h",)
    model = '<!-- a -- b --><sdf version="1.9"><model name="m"><link name="a & b"/></model></sdf>'
    assert sdf.read(model).link_names[-1] == "a & b"
    (tmp_path / "arm.xml").write_text(" " + '<?xml version="1.0"?>' + arm)
    assert mf.load(tmp_path / "arm.xml").n == 1
    (tmp_path / "part.xml").write_text(
        "<mujoco><!-- x -- y --><body name='k'><joint name='g'/><geom size='.1'/></body></mujoco>"
    )
    (tmp_path / "whole.xml").write_text('<mujoco><worldbody><include file="part.xml"/></worldbody></mujoco>')
    said = [d for d in mjcf.diagnose(tmp_path / "whole.xml") if d.code == "F0117"]
    assert [d.file for d in said] == ["part.xml"]


def test_lint_mends_what_was_pardoned(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(TAKEN["no blank"].replace("<link", "<!-- -- --><link", 1))
    assert "F0119" in lint.lint(path).codes
    text, changes = lint.repair(path)
    assert {change.diagnostic.code for change in changes} >= {"F0119", "F0117"}
    path.write_text(text)
    assert not {"F0117", "F0119"} & set(lint.lint(path).codes)


ENCODINGS = {
    "gbk": "臂", "gb2312": "臂", "gb18030": "臂", "big5": "臂", "shift_jis": "腕", "euc-jp": "腕",
    "euc-kr": "팔",
             "koi8-r": "рука", "windows-1251": "рука", "cp1256": "ذراع", "iso-8859-6": "ذراع", "cp936": "臂",
             "latin-1": "é", "utf_8": "ذراع", "UTF8": "ذراع"}  # fmt: skip


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_every_encoding_of_python_is_read(encoding: str, tmp_path: Path) -> None:
    text = f'<?xml version="1.0" encoding="{encoding}"?>' + GOOD.replace('"b"', f'"{ENCODINGS[encoding]}"')
    path = tmp_path / "arm.urdf"
    path.write_bytes(text.encode(encoding))
    assert mf.load(path).mechanism.link_names == ("a", ENCODINGS[encoding])


NO_ENCODINGS = (
    "foo", "hex", "zlib", "base64", "rot13", "idna", "punycode", "unicode_escape", "undefined", "raw_unicode_escape",
    "mbcs", "aliases", "..", "uu", "cp037", "utf-7", "utf-32",
)  # fmt: skip


@pytest.mark.parametrize("encoding", NO_ENCODINGS)
@pytest.mark.parametrize("suffix", ["urdf", "xml", "sdf", "xacro", "world"])
def test_no_exception_of_a_codec_leaves_the_readers(encoding: str, suffix: str, tmp_path: Path) -> None:
    roots = {"xml": "<mujoco/>", "sdf": "<sdf/>", "world": "<sdf/>"}
    path = tmp_path / f"arm.{suffix}"
    for tail in (b"", b"\xff\xfe", "é".encode()):
        path.write_bytes(
            f'<?xml version="1.0" encoding="{encoding}"?>{roots.get(suffix, GOOD)}<!--'.encode() + tail + b"-->"
        )
        lint.lint(path)
        with suppress(FileError):
            mf.load(path)


@pytest.mark.parametrize("seed", range(4))
def test_mutations_never_raise_anything_else(seed: int) -> None:
    """What expat takes is the same as ever; everything else is read or refused by us."""
    rng = random.Random(seed)
    signs = "<>/&;'\"=-!?[] \n\t\x00\x01\x0c" + string.ascii_letters + "é\uffff"
    for _ in range(1500):
        letters = list(rng.choice([GOOD, TAKEN["nested"], TAKEN["no blank"], '<?xml version="1.0"?>' + GOOD]))
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(letters))
            letters[at : at + rng.randint(0, 2)] = rng.choice(signs) * rng.randint(0, 2)
        try:
            parse(
                "".join(letters).encode(),
            )
        except Refusal:
            continue


SIGNS = ("&", "<", ">", "-", "--", " ", "\x0c", '"', "'", "/", "<!-- -- -->", "", "]]>")


def test_what_tinyxml2_takes_of_mutations_we_take() -> None:
    """Of a thousand damaged files we refuse none that urdfdom reads, and read the same joints."""
    pin = pytest.importorskip("pinocchio")
    rng = random.Random(18)
    read = 0
    for _ in range(3000):
        letters = list(rng.choice([GOOD, '<?xml version="1.0"?><!-- c -->' + GOOD]))
        at = rng.randrange(len(letters))
        letters[at : at + rng.randint(0, 1)] = rng.choice(SIGNS)
        text = "".join(letters)
        if re.search("</[^>]*/>", text):
            continue  # for tinyxml2 that is an element, which nobody writes
        try:
            model = pin.buildModelFromXML(text)
        except (ValueError, RuntimeError, IndexError):
            continue
        try:
            root = parse(text.encode()).root
        except Refusal as refusal:
            pytest.fail(f"{refusal.diagnostic.code}: {text!r}")
        assert {e.get("name") for e in root.walk() if e.tag == "joint"} >= {
            name.replace("\x0c", " ") for name in list(model.names)[1:]
        }
        read += 1
    assert read > 200


def test_root_tags_are_found_where_xml_refuses(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    for text in (*TAKEN.values(), "<!-- <mujoco> -->" + GOOD, "<!DOCTYPE robot [ <!ENTITY e 'x'> ]>" + GOOD):
        path.write_text(text)
        assert root_tag(path) == "robot", text
    path.write_bytes(GOOD.encode("utf-16"))
    assert root_tag(path) == "robot"
    path.write_bytes(b"<!--" + b"<" * 200_000)
    assert root_tag(path) == ""


def test_a_large_document_with_one_fault_is_read_in_time() -> None:
    parts = "".join(f'<link name="l{k}"/>\n' for k in range(9_000)) + "<!-- -- -->" + "<a b='&'/>" * 20_000
    text = f"<robot>{parts}</robot>".encode()
    document = within(2.0, lambda: parse(text))
    assert len(document.remarks) < 210
    assert document.root.children[-1].get("b") == "&"


@pytest.mark.parametrize("attribute", ["pos", "rgba", "mass", "quat", "group"])
def test_empty_numbers_of_mjcf_are_as_if_not_given(attribute: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    classes = '<default><geom pos="0 0 1" mass="2" rgba="1 0 0 1" quat="0 1 0 0"/></default>'
    geom = '<geom size=".1 .2 .3" type="box" {}/>'
    body = f'<worldbody><body name="l"><joint name="h" axis="0 1 0"/>{geom}</body></worldbody>'
    plain, empty = (f"<mujoco>{classes}{body}</mujoco>".replace("{}", text) for text in ("", f'{attribute}=""'))
    assert mujoco.MjModel.from_xml_string(empty).body_mass[1] == 2.0
    report = mjcf.diagnose(empty)
    assert "F0128" in report.codes
    assert report.mechanism is not None
    assert repr(report.mechanism.links) == repr(mjcf.read(plain).links)
    assert "F0128" not in mjcf.diagnose(mjcf.repair(empty)[0]).codes


def test_a_broken_colour_stops_no_mechanics() -> None:
    body = '<body name="l"><joint name="h"/><geom size=".1" rgba="1 nan 0"/></body>'
    assert mjcf.diagnose(f"<mujoco><worldbody>{body}</worldbody></mujoco>").ok


def test_lint_mends_mjcf_and_sdf(tmp_path: Path) -> None:
    body = '<body name="l"><joint name="h"axis="0 1 0"/><geom size=".1"/></body>'
    files = {
        "arm.xml": f"<mujoco><worldbody>{body}</worldbody></mujoco>",
        "arm.sdf": '<!-- a -- b --><sdf version="1.9"><model name="m"><link name="a"/></model></sdf>',
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        mended, changes = lint.repair(tmp_path / name)
        assert len(changes) == 1
        (tmp_path / name).write_text(mended)
        assert not {"F0117", "F0119"} & set(lint.lint(tmp_path / name).codes)
