"""Parts that are no tree: the cause that is named is the one that a change of it removes; reasons are whole."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.errors import ModelError
from mafsil.messages import say
from mafsil.model import Joint, JointKind, Link, Mechanism, mjcf, sdf, urdf


def assembled(links, ways):
    """Links and (parent, child) pairs; the joint of a pair is named after both."""
    joints = [Joint(f"{a}>{b}", JointKind.FIXED, a, b) for a, b in ways]
    return Mechanism.assemble("r", [Link(name) for name in links], joints)


@pytest.mark.parametrize(
    ("links", "ways", "apart"),
    [
        ("abc", ["ab"], "c"),
        ("abcde", ["ab", "ce", "de"], "ab"),
        ("abcdef", ["ab", "bf", "ce", "de"], "c, d, e"),
        ("abcde", ["ab", "bc", "de", "ed"], "d, e"),
        ("xab", ["ab"], "x"),
    ],
)
def test_what_hangs_on_nothing_is_named_before_what_is_wrong_inside_it(links, ways, apart):
    with pytest.raises(ModelError) as caught:
        assembled(links, ways)
    assert caught.value.key == "model.unconnected"
    assert caught.value.details["links"] == ", ".join(apart.replace(", ", ""))


def test_the_joint_that_is_named_closes_the_ring():
    """Rings of random size with random tails, in random order: cutting the joint that is named leaves a tree."""
    for seed in range(200):
        rng = np.random.default_rng(seed)
        ring, tails = int(rng.integers(1, 6)), int(rng.integers(0, 8))
        names = [f"l{k}" for k in range(ring + tails)]
        ways = [(names[k], names[(k + 1) % ring]) for k in range(ring)]
        ways += [(names[int(rng.integers(k))], names[k]) for k in range(ring, len(names))]
        ways = [ways[k] for k in rng.permutation(len(ways))]
        with pytest.raises(ModelError) as caught:
            assembled(rng.permutation(names), ways)
        assert caught.value.key == "model.cycle"
        cut = tuple(str(caught.value.details["joint"]).split(">"))
        if ring + tails > 1:
            assert assembled(names, [way for way in ways if way != cut]).links[0].name == cut[1]
        text = "".join(f'<link name="{name}"/>' for name in names) + "".join(
            f'<joint name="{a}&gt;{b}" type="fixed"><parent link="{a}"/><child link="{b}"/></joint>' for a, b in ways
        )
        said = [d for d in urdf.diagnose(f'<robot name="r">{text}</robot>').errors if d.code in ("S0309", "S0306")]
        assert [d.details["joint"] for d in said] == [">".join(cut)]


def test_the_reason_that_a_reader_gives_is_whole_and_in_both_languages():
    name = "a_link_with_quite_a_long_name_" * 3
    ends = f"<parent>{name}</parent><child>{name}</child>"
    joint = f'<joint name="j" type="revolute">{ends}<axis><xyz>0 0 1</xyz></axis></joint>'
    model = f'<sdf version="1.9"><model name="m"><link name="{name}"/>{joint}</model></sdf>'
    (error,) = sdf.diagnose(model).errors
    assert error.code == "S0312"
    for language in ("en", "ar"):
        said = error.sentence(language)
        assert said.endswith(say("model.loop_on_itself", language=language, joint="j", link=name))
        assert said.isprintable()
        assert len(said) < 500


def test_reasons_from_meshes_are_whole_too(tmp_path):
    (tmp_path / "part.stl").write_bytes(b"solid x\nendsolid x\n")
    model = (
        '<mujoco><asset><mesh name="part" file="part.stl"/></asset><worldbody><body name="b"><joint name="j"/>'
        '<geom type="mesh" mesh="part"/></body></worldbody></mujoco>'
    )
    path = tmp_path / "m.xml"
    path.write_text(model)
    said = [d for d in mjcf.diagnose(path) if isinstance(d.details.get("reason"), Exception)]
    assert said
    for each in said:
        reason = each.details["reason"]
        assert str(reason) in each.sentence("en")
        assert reason.message("ar") in each.sentence("ar")
