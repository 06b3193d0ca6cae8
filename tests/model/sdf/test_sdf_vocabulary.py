"""The table of SDFormat holds the specification of 1.4 to 1.12; what is unknown is said."""

from __future__ import annotations

import pytest

from mafsil.model import sdf
from mafsil.model.sdf.scope import ROWS

SPECIFICATION = {
    "world": "name|actor atmosphere audio frame gravity gui include joint light magnetic_field model physics "
    "plugin population road scene spherical_coordinates state wind",
    "model": "canonical_link name namespace placement_frame|allow_auto_disable enable_wind frame gripper "
    "include joint link model model_state plugin pose self_collide static",
    "include": "merge|model_state name namespace placement_frame plugin pose static uri",
    "link": "name|audio_sink audio_source battery collision enable_wind frame gravity inertial kinematic "
    "light must_be_base_link particle_emitter pose projector self_collide sensor velocity_decay "
    "visual",
    "inertial": "auto|auto_inertia_params density fluid_added_mass frame inertia mass pose",
    "inertia": "|ixx ixy ixz iyy iyz izz",
    "collision": "name|auto_inertia_params density frame geometry laser_retro max_contacts pose surface",
    "visual": "name|cast_shadows frame geometry laser_retro material meta plugin pose transparency visibility_flags",
    "geometry": "|box capsule cone cylinder ellipsoid empty heightmap image mesh plane polyline sphere",
    "box": "|size",
    "cylinder": "|length radius",
    "capsule": "|length radius",
    "sphere": "|radius",
    "mesh": "optimization|convex_decomposition scale submesh uri",
    "material": "|ambient diffuse double_sided emissive lighting pbr render_order script shader shininess specular",
    "joint": "name type|axis axis2 child frame gearbox_ratio gearbox_reference_body parent physics pose "
    "screw_thread_pitch sensor thread_pitch",
    "axis": "|dynamics initial_position limit mimic use_parent_model_frame xyz",
    "axis2": "|dynamics initial_position limit mimic use_parent_model_frame xyz",
    "xyz": "expressed_in|",
    "dynamics": "|damping friction spring_reference spring_stiffness",
    "limit": "|dissipation effort lower stiffness upper velocity",
    "mimic": "axis joint|multiplier offset reference",
    "frame": "attached_to name|pose",
    "pose": "degrees frame relative_to rotation_format|",
}  # fmt: skip
"""Attributes|elements of any version from 1.4 to 1.12 in the specification of libsdformat (Apache 2.0 licence)."""


def test_the_published_specification_is_whole_in_the_table() -> None:
    for place, names in SPECIFICATION.items():
        attributes, parts = (set(part.split()) for part in names.split("|"))
        assert attributes <= set(ROWS[place].words), place
        assert parts <= set(ROWS[place].parts), place


def model(inside: str = "", version: str = "1.12", axis: str = "", link: str = "", pose: str = "") -> str:
    """Two links and a hinge."""
    body = f"<link name='b'><pose {pose}>0 0 1 0 0 90</pose>{link}</link>"
    joint = (
        f"<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz>{axis}</axis></joint>"
    )
    return f"<sdf version='{version}'><model name='m'><link name='a'/>{body}{joint}{inside}</model></sdf>"


SAID = {
    "pose rotation_fmt": (model(pose="rotation_fmt='quat_xyzw'"), "F0139", "rotation_format"),
    "degress": (model(pose="degress='true'"), "F0139", "degrees"),
    "dampng": (model(axis="<dynamics><dampng>1</dampng></dynamics>"), "F0133", "damping"),
    "lowr": (model(axis="<limit><lowr>1</lowr></limit>"), "F0133", "lower"),
    "inertail": (model(link="<inertail/>"), "F0133", "inertial"),
    "frame of 1.6": (model(pose="frame='a'"), "F0140", ""),
    "parent model frame": (model(axis="<use_parent_model_frame>1</use_parent_model_frame>"), "F0140", ""),
    "no gravity": (model(link="<gravity>0</gravity>"), "M0702", ""),
    "decay": (model(link="<velocity_decay><linear>1</linear></velocity_decay>"), "M0702", ""),
}


@pytest.mark.parametrize("name", SAID)
def test_what_is_unknown_or_left_out_is_said(name: str) -> None:
    text, code, near = SAID[name]
    report = sdf.diagnose(text)
    assert report.ok
    (said,) = (d for d in report if d.code == code)
    assert said.details.get("known", "") == near


QUIET = (
    "<gravity>1</gravity>", "<velocity_decay/>", "<velocity_decay><linear>0</linear></velocity_decay>",
    "<sensor name='s'><anything/></sensor>", "<mysim:extra/>", "<kinematic>false</kinematic>",
)  # fmt: skip


@pytest.mark.parametrize("link", QUIET)
def test_what_changes_nothing_is_not_said(link: str) -> None:
    assert not {"F0133", "F0139", "F0140", "M0702"} & set(sdf.diagnose(model(link=link)).codes)


def test_words_that_were_given_up_are_read_in_their_versions_and_ignored_later() -> None:
    placed = {v: sdf.read(model(version=v, pose="frame='a'", inside="")) for v in ("1.5", "1.6")}
    assert all(mechanism.n == 1 for mechanism in placed.values())
    for version in ("1.5", "1.6"):
        assert "F0140" not in sdf.diagnose(model(version=version, pose="frame='a'")).codes
    assert "F0140" not in sdf.diagnose(model(version="1.4", pose="relative_to='a' degrees='true'")).codes


FINGERS = """<sdf version='1.9' xmlns:drake='http://drake.mit.edu'>
<model name='m'><link name='a'/><link name='b'/><link name='c'/>
<joint name='l' type='prismatic'><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz></axis></joint>
<joint name='r' type='prismatic'><parent>a</parent><child>c</child>
{}<axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"""


def test_what_drake_adds_is_read_or_said() -> None:
    follower = sdf.read(FINGERS.format("<drake:mimic joint='l' multiplier='-0.5' offset='0.25'/>"))
    assert follower.n == 1
    (mimic,) = (joint.mimic for joint in follower.joints if joint.mimic is not None)
    assert (mimic.leader, mimic.multiplier, mimic.offset) == ("l", -0.5, 0.25)
    plain = sdf.read(FINGERS.format("<drake:mimic joint='l'/>")).joints[-1].mimic
    assert plain is not None
    assert (plain.multiplier, plain.offset) == (1.0, 0.0)
    for slip, code in (("<drake:mimc joint='l'/>", "F0133"), ("<drake:nothing/>", "F0133"), ("<mine:extra/>", "")):
        codes = sdf.diagnose(FINGERS.format(slip)).codes
        assert (code in codes) == bool(code)
    ball = "</joint><drake:ball_constraint><drake:body_A>a</drake:body_A></drake:ball_constraint></model>"
    assert "M0702" in sdf.diagnose(FINGERS.format("").replace("</joint></model>", ball)).codes
