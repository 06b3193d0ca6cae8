"""Loops in MJCF files: read as MuJoCo reads them, written back, refused where they mean nothing."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import parallel
from mafsil.errors import FileError, ModelError, ModelWarning
from mafsil.geometry import pose
from mafsil.model import JointKind, mjcf
from tests.parallel.closed_chains import four_bar, random_chain
from tests.sizes import size

mujoco = pytest.importorskip("mujoco")

LUMP = '<inertial pos="0.02 0.01 0.005" mass="0.2" diaginertia="2e-4 3e-4 4e-4"/>'
GRIPPER = f"""<mujoco model="gripper">
  <compiler angle="radian"/>
  <option><flag contact="disable" limit="disable"/></option>
  <worldbody><body name="hand">
    <body name="crank" pos="0 0.03 0"><joint name="a" axis="1 0 0"/>{LUMP}
      <body name="finger" pos="0 0.04 0.02"><joint name="b" axis="1 0 0" damping="0.1"/>{LUMP}
        <site name="knuckle" pos="0 -0.01 0.03"/></body>
    </body>
    <body name="rod" pos="0 0.01 0.04"><joint name="c" axis="1 0 0"/>{LUMP}
      <site name="end" pos="0 0.05 0.01"/></body>
    <body name="other" pos="0 -0.03 0" euler="0 0 3.141592653589793"><joint name="d" axis="1 0 0"/>{LUMP}
      <body name="tongue" pos="0 0.04 0.02"><joint name="e" axis="1 0 0"/>{LUMP}</body>
    </body>
    <body name="link" pos="0 -0.01 0.04"><joint name="f" axis="1 0 0"/>{LUMP}</body>
  </body></worldbody>
  <equality>
    <connect name="left" site1="knuckle" site2="end"/>
    <connect body1="tongue" body2="link" anchor="0.01 -0.01 0.03"/>
    <joint joint1="d" joint2="a" polycoef="0 1 0 0 0"/>
  </equality>
  <actuator><motor joint="a" gear="10"/></actuator>
</mujoco>"""


def read(text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mjcf.read(text)


class MuJoCoChain:
    """Mass matrix, bias and rows of the constraints as MuJoCo has them."""

    def __init__(self, text):
        self.model = mujoco.MjModel.from_xml_string(text)
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        self.model.dof_damping[:] = 0.0
        self.data = mujoco.MjData(self.model)

    def terms(self, q, qd):
        model, data = self.model, self.data
        data.qpos[:], data.qvel[:] = q, qd
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        return M, data.qfrc_bias.copy(), data.efc_J.reshape(-1, model.nv)[rows], data.efc_pos[rows]


def across(J):
    """Projection on what the rows span."""
    _, s, right = np.linalg.svd(J)
    base = right[: int((s > 1e-9 * s[0]).sum())]
    return base.T @ base


def agrees(text, mechanism, q, qd):
    """At closed configurations the tree and the span of the rows are MuJoCo's."""
    chain, peer = parallel.ClosedChain(mechanism), MuJoCoChain(text)
    for place, rate in zip(q, qd, strict=True):
        M, h, J, gap = peer.terms(place, rate)
        found = chain.terms(place, rate)
        assert np.abs(gap).max() < 1e-12
        np.testing.assert_allclose(found.M, M, atol=1e-12)
        np.testing.assert_allclose(found.h, h, atol=1e-11)
        np.testing.assert_allclose(across(found.J), across(J), atol=1e-9)


@pytest.mark.capability("08-1", "02-65")
def test_a_gripper_closes_as_in_mujoco():
    mechanism = read(GRIPPER)
    assert [(loop.name, loop.kind, loop.parent) for loop in mechanism.loops] == [
        ("left", JointKind.SPHERICAL, "finger"),
        ("connect", JointKind.SPHERICAL, "tongue"),
    ]
    chain = parallel.ClosedChain(mechanism)
    assert (chain.n, [mechanism.joint_names[k] for k in chain.actuated]) == (5, ["a"])
    found = chain.close_loops(np.linspace(-0.3, 0.3, 7)[:, None] * [1, 0, 0, 0, 0], hold=["a"])
    assert found
    peer = MuJoCoChain(GRIPPER)
    rng = np.random.default_rng(0)
    for q in found:
        qd, tau = chain.rates(q, rng.normal(size=5)), rng.normal(size=1)
        expand = np.array([q[0], q[1], q[2], q[0], q[3], q[4]])
        B = np.zeros((6, 5))
        B[[0, 1, 2, 3, 4, 5], [0, 1, 2, 0, 3, 4]] = 1.0
        M, h, J, gap = peer.terms(expand, B @ qd)
        assert np.abs(gap).max() < 1e-12
        terms = chain.terms(q, qd)
        np.testing.assert_allclose(terms.M, B.T @ M @ B, atol=1e-13)
        np.testing.assert_allclose(terms.h, B.T @ h, atol=1e-12)
        np.testing.assert_allclose(across(terms.J), across(J @ B), atol=1e-9)
        # At rest the accelerations follow from MuJoCo's own numbers alone.
        M, h, J, _ = peer.terms(expand, np.zeros(6))
        N = np.eye(5) - across(J @ B)
        left, s, _ = np.linalg.svd(N)
        free = left[:, s > 0.5]
        force = B.T @ (10.0 * 0.0 * expand - h)
        force[0] += tau[0]
        expected = free @ np.linalg.solve(free.T @ B.T @ M @ B @ free, free.T @ force)
        np.testing.assert_allclose(chain.forward_dynamics(q, np.zeros(5), tau).qdd, expected, rtol=1e-8, atol=1e-8)


def test_a_weld_and_an_anchor_on_the_world():
    body = f'<body name="a" pos="0.3 0 0.1"><joint name="j" type="slide" axis="1 0 0"/>{LUMP}</body>'
    other = f'<body name="b" pos="0.1 0.2 0.3" euler="0 0 0.4"><joint name="k" type="slide" axis="1 0 0"/>{LUMP}</body>'
    equality = '<weld name="w" body1="a" body2="b"/><connect body1="a" anchor="0 0 0.1"/>'
    inside = f"<worldbody>{body}{other}</worldbody><equality>{equality}</equality>"
    text = f'<mujoco><compiler angle="radian"/>{inside}</mujoco>'
    mechanism = read(text)
    weld, point = mechanism.loops
    assert (weld.kind, weld.parent, weld.child) == (JointKind.FIXED, "a", "b")
    assert (point.parent, point.child) == ("a", "connect/end")
    agrees(text, mechanism, np.zeros((1, 2)), np.zeros((1, 2)))
    assert parallel.ClosedChain(mechanism).forward_dynamics([0, 0], [0, 0], [0, 0]).rank == 2


@pytest.mark.capability("02-65")
@pytest.mark.parametrize("kind", [JointKind.SPHERICAL, JointKind.FIXED, JointKind.REVOLUTE])
@pytest.mark.parametrize("seed", range(size(1, 3)))
def test_what_is_written_is_what_mujoco_and_we_read(kind, seed):
    mechanism, q = random_chain(np.random.default_rng(seed), kind)
    text = mjcf.write(mechanism, without=["tip"])
    back = read(text)
    again = read(mjcf.write(back, without=["tip"]))
    assert again.link_names == back.link_names
    for one, two in zip((*back.joints, *back.loops), (*again.joints, *again.loops), strict=True):
        assert (one.name, one.kind, one.parent, one.child) == (two.name, two.kind, two.parent, two.child)
        np.testing.assert_allclose(one.T_pj, two.T_pj, atol=4e-16)
    first, second = parallel.ClosedChain(mechanism), parallel.ClosedChain(back)
    assert back.joint_names == mechanism.joint_names
    rng = np.random.default_rng(seed)
    places = first.close_loops(q + rng.uniform(-0.05, 0.05, (3, 9))).q
    rates, tau = first.rates(places, rng.normal(size=(3, 9))), rng.normal(size=(3, 9))
    assert np.abs(second.error(places)).max() < 1e-12
    one, two = first.forward_dynamics(places, rates, tau), second.forward_dynamics(places, rates, tau)
    np.testing.assert_array_equal(one.rank, two.rank)
    np.testing.assert_allclose(one.qdd, two.qdd, rtol=1e-7, atol=1e-7)
    agrees(text, back, places, rates)


def test_a_file_written_and_read_again_stays_as_it_is(tmp_path):
    text = mjcf.write(read(GRIPPER), without=["tip"])
    assert mjcf.write(read(text), without=["tip"]) == text
    path = tmp_path / "gripper.xml"
    path.write_text(text)
    robot = mf.load(path)
    assert "M0728" in {remark.code for remark in robot.mechanism.provenance.remarks}
    chain = parallel.ClosedChain(robot)
    q = chain.close_loops([0.2, 0, 0, 0, 0], hold=["a"])
    assert q
    run = parallel.simulate_closed(chain, q.q, efforts=[0.0], duration=0.2, step=1e-3)
    assert run
    assert run.error.max() < 1e-12


def test_what_cannot_be_written_is_named():
    universal, _ = random_chain(np.random.default_rng(0), JointKind.UNIVERSAL)
    with pytest.raises(ModelError, match=r"not with a universal joint \(loop"):
        mjcf.write(universal, without=["tip"])
    bars = four_bar()
    with pytest.raises(ModelError, match="helical joint"):
        mjcf.write(replace(bars, joints=(replace(bars.joints[0], kind=JointKind.HELICAL, pitch=0.1), *bars.joints[1:])))


def test_the_tip_and_bodies_without_mass_come_back():
    bars = four_bar()
    T = pose.from_translation([1, 0, 0])
    back = read(mjcf.write(bars.with_tip("coupler", T)))
    assert (back.tip, {joint.child: joint.parent for joint in back.joints}[back.tip]) == ("tip_", "coupler")
    massless = replace(bars, links=tuple(replace(link, inertial=None) for link in bars.links))
    with pytest.warns(ModelWarning, match="no masses"):
        text = mjcf.write(massless)
    assert all(link.inertial is None for link in read(text).links)
    assert mujoco.MjModel.from_xml_string(text).nv == 3


def equality(text):
    return GRIPPER.replace("</equality>", f"{text}</equality>")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ('<connect body1="finger" body2="rod" anchor="nan 0 0"/>', "N0203"),
        ('<connect body1="finger" body2="rod" anchor="0 inf 0"/>', "N0203"),
        ('<connect body1="finger" body2="rod" anchor="0 0"/>', "N0205"),
        ('<connect body1="finger" body2="rod"/>', "N0201"),
        ('<connect body1="nobody" anchor="0 0 0"/>', "M0713"),
        ('<connect anchor="0 0 0"/>', "N0201"),
        ('<connect site1="knuckle" site2="nowhere"/>', "M0727"),
        ('<connect site1="knuckle"/>', "N0201"),
        ('<weld body1="finger" body2="nobody"/>', "M0713"),
        ('<weld body1="finger" body2="rod" relpose="0 0 nan 1 0 0 0"/>', "N0203"),
        ('<joint joint1="a" joint2="nothing"/>', "M0712"),
        ('<joint joint1="b" joint2="a" polycoef="0 1 nan 0 0"/>', "N0203"),
        ('<hinge body1="finger"/>', "M0720"),
    ],
)
def test_hostile_constraints_are_refused_by_name(text, code):
    report = mjcf.diagnose(equality(text))
    assert code in [fault.code for fault in report.errors]
    with pytest.raises(FileError, match=code):
        read(equality(text))


def test_constraints_that_are_left_out_are_said():
    report = mjcf.diagnose(equality('<tendon tendon1="t"/>'))
    assert any(each.code == "M0702" and "tendon" in each.sentence("en") for each in report)


def test_loops_that_contradict_each_other_are_not_closed():
    two = '<weld body1="finger" body2="rod" relpose="{x} 0 0 1 0 0 0"/>'
    mechanism = read(equality(two.format(x="0.1") + two.format(x="0.2")))
    found = parallel.ClosedChain(mechanism).close_loops(np.zeros(5))
    assert not found
    assert found.error >= 0.05
    assert f"{float(found.error):.2g}" in found.explain("en")


def floating_platform(text):
    """The file of a platform on six legs with its platform loose in the world, all six legs tied to it."""
    begin, end = (
        text.index('          <body name="platform"'),
        text.index("          </body>") + len("          </body>\n"),
    )
    platform = re.sub(r'.*<joint name="ball.*\n| xyaxes="[^"]*"', "", text[begin:end])
    platform = platform.replace('name="platform"', 'name="platform" pos="0.212132 -0.212132 0.6"')
    platform = platform.replace("<inertial", "<freejoint/><inertial")
    rest = (text[:begin] + text[end:]).replace("    </body>\n  </worldbody>", f"    </body>\n{platform}  </worldbody>")
    return rest.replace(
        "<equality>", '<equality><connect name="ball 1" body1="rod 1" body2="platform" anchor="0 0 0"/>'
    )


def test_a_platform_that_floats_is_held_by_its_legs():
    """The same robot as the file in which one leg carries the platform: legs accelerate alike at a random place."""
    text = (Path(__file__).resolve().parents[3] / "examples" / "robots" / "stewart.xml").read_text()
    one, two = (mf.Robot(read(each).with_tip("platform")) for each in (text, floating_platform(text)))
    assert (one.n, two.n) == (21, 24)
    first, second = parallel.ClosedChain(one), parallel.ClosedChain(two)
    legs = [f"leg {k}" for k in range(1, 7)]
    assert [two.joint_names[k] for k in second.actuated] == legs
    rng = np.random.default_rng(0)
    q = first.close_loops(0.1 * rng.normal(size=21)).q
    home = [robot.forward_kinematics(np.zeros(robot.n)) for robot in (one, two)]
    found = parallel.closed_inverse_kinematics(second, one.forward_kinematics(q) @ np.linalg.inv(home[0]) @ home[1])
    assert found
    places = [[robot.joint_names.index(name) for name in legs] for robot in (one, two)]
    # The file gives lengths and directions to six digits.
    np.testing.assert_allclose(found.q[0][places[1]], q[places[0]], atol=1e-5)
    tau = 50 * rng.normal(size=6)
    expected = first.forward_dynamics(q, 0 * q, tau).qdd[places[0]]
    qdd = second.forward_dynamics(found.q[0], 0 * found.q[0], tau).qdd[places[1]]
    np.testing.assert_allclose(qdd, expected, rtol=1e-4)


def test_what_is_tied_once_hangs_on_the_robot_and_is_left_out():
    arm = '<body name="hand"><joint name="j" axis="0 0 1"/>' + LUMP + "</body>"
    cube = '<body name="cube" pos="0 0 1"><freejoint/>' + LUMP + "</body>"
    tie = '<connect body1="hand" body2="cube" anchor="0 0 1"/>'
    for count, loops in ((1, 0), (2, 2)):
        text = f"<mujoco><worldbody>{arm}{cube}</worldbody><equality>{tie * count}</equality></mujoco>"
        mechanism = read(text)
        assert len(mechanism.loops) == loops
        assert ("cube" in mechanism.link_names) is (loops > 0)


def test_a_mechanism_without_a_moving_joint_has_no_closed_chain():
    cubes = "".join(f'<body name="{name}" pos="{k} 0 0"><freejoint/>{LUMP}</body>' for k, name in enumerate("ab"))
    tie = '<equality><weld body1="a" body2="b"/></equality>'
    mechanism = read(f"<mujoco><worldbody>{cubes}</worldbody>{tie}</mujoco>")
    with pytest.raises(ModelError, match="no moving joint"):
        parallel.ClosedChain(mechanism)
