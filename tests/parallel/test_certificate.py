"""Proofs of the poses of platforms on six legs."""

import numpy as np
import pytest

from mafsil.geometry import pose, rotation
from mafsil.parallel import SingularKind, StewartPlatform
from mafsil.parallel.platforms.certificate import CertificateStatus, certificate_of
from tests.parallel.test_assembly_modes import planted


@pytest.mark.capability("08-27")
def test_forty_poses_are_proven_to_be_all():
    a, b, _, s = planted(7, 12)
    for k in range(12):
        robot = StewartPlatform(a[k], b[k])
        found, modes = robot.certificate(s[k]), robot.forward_kinematics(s[k])
        assert found.status is CertificateStatus.ALL
        assert (found.proven, found.real) == (40, modes.count)
        assert found.radius < 1e-6
        assert found.largest_h < 0.5
        assert "none is missing" in found.explain("en")


def test_a_pose_that_is_none_is_not_proven():
    a, b, T, s = planted(8, 1)
    q = np.array([[0.9, 0.1, -0.2, 0.3]], complex)
    q /= np.sqrt((q * q).sum())
    found = certificate_of(a[0], b[0], s[0], np.hstack([q, [[0.3, 0.1, 0.2]]]), np.array([True]))
    assert found.status is CertificateStatus.NOT_PROVEN
    assert found.proven == 0
    twice = np.repeat(np.hstack([q, T[:, :3, 3]]), 2, axis=0)
    assert certificate_of(a[0], b[0], s[0], twice, np.array([True, True])).proven == 0


@pytest.mark.capability("08-53", "08-60")
def test_kind_of_a_platform_on_six_legs():
    robot = StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    home = pose.from_translation([0, 0, 1.5])
    turned = home.copy()
    turned[:3, :3] = rotation.rot_z(np.pi / 2)
    found = robot.singularity(np.stack([home, turned]))
    assert list(found) == [SingularKind.REGULAR, SingularKind.SECOND]
    np.testing.assert_allclose(robot.jacobian(turned) @ _twist(robot, turned), 0, atol=1e-8)
    special = robot.certificate(robot.lengths(home))
    assert special.status in (CertificateStatus.THESE, CertificateStatus.NOT_PROVEN)
    far = pose.from_translation([30.0, -20, 10])
    moved = StewartPlatform(robot.base + far[:3, 3], robot.platform)
    assert moved.singularity(far @ home).of_A == pytest.approx(found.of_A[0], rel=1e-9)


def _twist(robot, T):
    """The free motion, from the middle of the platform to the origin of {s}."""
    V = robot.singularity(T).free_motion
    return np.concatenate([V[:3], V[3:] + np.cross(T[:3, 3], V[:3])])
