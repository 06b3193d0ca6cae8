"""Robots as tables in TOML files: Denavit-Hartenberg rows, screws, or free frames; read and written.

    name = "two_link"
    convention = "modified"         # DH: modified | classic; screws: space | body; free frames: frames
    units = { angle = "deg" }       # of this file; angle: rad (default) | deg, length: m (default) | mm
    gravity = [0.0, -9.81, 0.0]     # m/s^2, in the space frame; [0, 0, -9.81] by default
    tool = { xyz = [0.5, 0.0, 0.0] }

    [[joint]]
    name = "shoulder"
    limits = { lower = -170.0, upper = 170.0, velocity = 90.0, effort = 20.0 }
    inertial = { mass = 2.0, com = [0.5, 0.0, 0.0], inertia = [0.0, 0.17, 0.17] }

    [[joint]]
    name = "elbow"
    a = 1.0

    [provenance]
    source = "my notes"

A joint holds, by convention: `modified`, `classic`: a, alpha, d, theta, kind (R or P), offset; `space`, `body`: screw
(omega, v), six numbers, for which `home` has to be given; `frames`: xyz and rpy, or matrix, of the joint frame in the
link before, axis, pitch, and kind (R, P, H). Any joint may hold link (name of the link that it moves), limits,
inertial, actuator, friction. `inertia` is about the centre of mass: three moments, or six numbers xx, yy, zz, xy, xz,
yz. `base`, `tool` and `home` are poses: { xyz, rpy } or { matrix } of 4 rows.

Angles are in the file's unit in alpha, theta, offset, rpy and the limits of revolute joints; lengths in a, d, xyz, com,
v of screws, pitch and the limits of prismatic joints. Everything else is SI: kg, kg m^2, N m, N, m/s^2, s.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
