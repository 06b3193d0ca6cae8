"""Sound robot files from which the fuzzer starts."""

from __future__ import annotations

from tests.model.mjcf.mjcf_models import ARM, COUPLED, DEGREES

URDF_ARM = b"""<?xml version="1.0"?>
<robot name="arm">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"><visual><geometry><box size="0.1 0.1 0.1"/></geometry><material name="grey"/></visual></link>
  <joint name="j1" type="revolute">
    <origin xyz="0 0 0.3" rpy="0 1.5707963267948966 0"/>
    <parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
    <limit lower="-2.9" upper="2.9" effort="80" velocity="2.1"/><dynamics damping="0.1" friction="0.2"/>
  </joint>
  <link name="l1">
    <inertial><origin xyz="0 0 0.1" rpy="0.1 0.2 0.3"/><mass value="2.5"/>
      <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0" izz="0.025"/></inertial>
    <collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
  </link>
  <joint name="j2" type="prismatic">
    <origin xyz="0 0.1 0"/><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.4" effort="20" velocity="0.5"/>
  </joint>
  <link name="l2">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <visual name="v"><geometry><mesh filename="package://arm/l2.stl" scale="1 1 1"/></geometry></visual>
  </link>
  <joint name="j3" type="continuous"><parent link="l2"/><child link="l3"/><axis xyz="1 0 0"/></joint>
  <link name="l3"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="f1" type="prismatic">
    <parent link="l3"/><child link="finger1"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" effort="20" velocity="0.2"/>
  </joint>
  <link name="finger1"/>
  <joint name="f2" type="prismatic">
    <parent link="l3"/><child link="finger2"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" effort="20" velocity="0.2"/><mimic joint="f1" multiplier="1" offset="0"/>
  </joint>
  <link name="finger2"/>
  <joint name="tool" type="fixed"><parent link="l3"/><child link="tcp"/><origin xyz="0 0 0.1"/></joint>
  <link name="tcp"/>
  <transmission name="t"><type>simple</type><joint name="j1"/>
    <actuator name="m"><mechanicalReduction>100</mechanicalReduction></actuator></transmission>
</robot>
"""

URDF_SMALL = (
    b'<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute">'
    b'<parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
    b'<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)

SEEDS: dict[str, tuple[bytes, ...]] = {
    "urdf": (URDF_ARM, URDF_ARM, URDF_SMALL),
    "mjcf": (ARM.encode(), DEGREES.encode(), COUPLED.encode()),
}
