"""Control laws: time, measured state and reference in, joint efforts out.

call      mf.control.computed_torque, pd_gravity, impedance_control ...; mf.simulate takes the law
computed  `laws.law` is their shape; `laws.joint_feedback`, `contact.impedance`, `joints.friction_compensation`;
          `analysis.tune_gains`, `analysis.suitability` judge and advise
compiled  `laws.law_trace` traces a law for `mafsil.simulation`
tested    tests/control
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
