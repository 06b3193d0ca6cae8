"""MJCF models that together use every feature the reader keeps."""

from __future__ import annotations

ARM = """<mujoco model="arm">
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0 0.1 -9.7"/>
  <default>
    <joint damping="0.3" armature="0.02"/>
    <geom density="800" rgba="0.2 0.3 0.4 1"/>
    <default class="wrist"><joint frictionloss="0.4" range="-1 1"/><geom type="box" size="0.03 0.02 0.05"/>
      <default class="tip"><geom density="2000"/></default></default>
    <motor ctrlrange="-2 2"/>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="base" pos="0 0 0.1" quat="0.9 0.1 0.2 -0.3">
      <geom type="cylinder" size="0.1 0.05"/>
      <body name="l1" pos="0.1 0 0.2" euler="0.3 -0.5 0.7">
        <joint name="j1" axis="0 0 1" range="-2 2.5"/>
        <inertial pos="0.01 0.02 0.1" quat="0.5 0.1 -0.4 0.2" mass="2" diaginertia="0.03 0.02 0.025"/>
        <geom type="capsule" fromto="0 0 0 0.05 0.02 0.3" size="0.04"/>
        <body name="l2" pos="0 0 0.3" axisangle="1 2 3 0.8">
          <joint name="j2" type="slide" axis="1 1 0" range="0 0.4" pos="0.1 0.2 0.3" damping="0.9"/>
          <inertial pos="0 0 0.1" mass="1.5" fullinertia="0.03 0.04 0.05 0.001 -0.002 0.003"/>
          <body name="l3" pos="0 0.1 0.2" xyaxes="1 0.1 0 0 1 1" childclass="wrist">
            <joint name="j3" axis="0 1 1" pos="0.01 0.02 0.03"/>
            <geom/><geom pos="0.1 0 0" zaxis="1 1 1" class="tip"/>
            <body name="l4" pos="0.2 0 0"><joint name="j4" axis="1 0 0" ref="0.4"/>
              <geom type="ellipsoid" size="0.02 0.03 0.04" mass="0.2"/></body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="j1" gear="50"/><position joint="j2" kp="10" forcerange="-30 30"/><motor joint="j3"/>
    <motor joint="j4"/></actuator>
</mujoco>"""

DEGREES = """<mujoco>
  <compiler angle="degree" eulerseq="ZYx" boundmass="0.05" boundinertia="1e-5"/>
  <worldbody>
    <frame pos="0.1 0.2 0.3" euler="10 20 30">
      <body name="a" euler="-40 50 60"><joint name="ja" range="-90 45" ref="30"/><geom type="sphere" size="0.05"/>
        <frame pos="0 0 0.1" axisangle="0 1 0 25"><geom type="box" size="0.01 0.02 0.03" pos="0.1 0 0"/>
          <body name="b" pos="0.1 0 0"><joint name="jb" axis="0.2 1 -3"/><geom type="sphere" size="0.001"/></body>
        </frame></body>
    </frame>
    <body name="c" pos="1 0 0">
      <joint name="c1" type="slide" axis="1 0 0"/><joint name="c2" type="slide" axis="0 1 0"/>
      <joint name="c3" axis="0 0 1" pos="0.1 0.2 0"/><joint name="c4" axis="1 0 0" pos="0 0.1 0.2" ref="15"/>
      <geom type="capsule" size="0.1 0.2"/>
    </body>
  </worldbody>
</mujoco>"""

COUPLED = """<mujoco>
  <compiler angle="radian" inertiafromgeom="true" settotalmass="3" inertiagrouprange="0 1"/>
  <worldbody>
    <body name="hand"><geom type="box" size="0.1 0.1 0.1"/>
      <body name="f1" pos="0 0 0.2"><joint name="f1" type="slide" axis="0 1 0" ref="0.01" range="0 0.04"/>
        <inertial pos="0 0 0" mass="9" diaginertia="1 1 1"/><geom type="box" size="0.01 0.02 0.03"/>
        <geom type="sphere" size="1" group="3"/></body>
      <body name="f2" pos="0 0 0.2"><joint name="f2" type="slide" axis="0 -1 0"/>
        <geom type="box" size="0.01 0.02 0.03"/>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="f2" joint2="f1" polycoef="0.002 0.5 0 0 0"/></equality>
</mujoco>"""

MODELS = {"arm": ARM, "degrees": DEGREES, "coupled": COUPLED}
