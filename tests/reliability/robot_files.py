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

XACRO_ARM = b"""<robot name="$(arg n)" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="n" default="x"/><xacro:property name="l" value="${[0.1, 0.2][1] * 2}"/>
<xacro:property name="t" value="${dict(a=1, b=radians(90))}"/>
<xacro:macro name="seg" params="name parent:=^|a k:=2 *origin **more">
<link name="${name}"><inertial><mass value="${k}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
</link><joint name="${name}_j" type="revolute"><parent link="${parent}"/><child link="${name}"/>
<xacro:insert_block name="origin"/><axis xyz="0 0 1"/><limit lower="${-t.b}" upper="${t['b']}" effort="1" velocity="1"/>
</joint><xacro:insert_block name="more"/>
<xacro:if value="${k > 0}"><xacro:seg name="${name}${k}" parent="${name}" k="${k - 1}"><origin xyz="${l} 0 0"/><m/>
</xacro:seg></xacro:if></xacro:macro>
<link name="a"/><xacro:seg name="b"><origin xyz="0 ${-l/2} 0" rpy="0 0 ${pi/2}"/><m><material name="m"/></m></xacro:seg>
<xacro:unless value="${'x' in ['y'] or not True}"><material name="$(optenv NOTHING q)"/></xacro:unless></robot>"""
SDF_ARM = b"""<sdf version="1.7"><world name="w"><gravity>0 0 -9.8</gravity><model name="m"><pose>0 0 1 0 0 0</pose>
<frame name="f" attached_to="a"><pose>0.1 0 0 0 0 1</pose></frame>
<link name="a"><inertial><pose>0 0 1 0 0 0</pose><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
</inertial><visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual></link>
<link name="b"><pose relative_to="f">0 0 1 0.1 0.2 0.3</pose></link><link name="c"/>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><pose>0 0 0.1 0 0 0</pose><axis>
<xyz expressed_in="__model__">0 1 1</xyz><limit><lower>-1</lower><upper>1</upper></limit><dynamics><damping>1</damping>
</dynamics></axis></joint><joint name="k" type="universal"><parent>b</parent><child>c</child>
<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model></world></sdf>"""

SEEDS: dict[str, tuple[bytes, ...]] = {
    "urdf": (URDF_ARM, URDF_ARM, URDF_SMALL),
    "mjcf": (ARM.encode(), DEGREES.encode(), COUPLED.encode()),
    "xacro": (XACRO_ARM,),
    "sdf": (SDF_ARM,),
}
