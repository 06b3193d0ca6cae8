"""Worked numbers of part 08 (parallel robots): four-bar, five-bar and parallel cranks, through the public face."""

from itertools import combinations

import numpy as np
import pytest

from mafsil.mobility import FourBar
from mafsil.parallel import FiveBar, LoopSingularity, ParallelCranks, PlanarChain, choose_actuators, driven_rates
from mafsil.parallel.planar import output_angles, singular_points
from tests.acceptance.reading import unread_after
from tests.acceptance.test_08_closed_chains import CASES, near

OWN = {
    name: CASES[name]
    for name in (
        "ch08-13-fourbar-bifurcations",
        "ch08-14-fivebar-regular",
        "ch08-15-fivebar-singularities",
        "ch08-113-fivebar-links-2-3-aligned",
        "ch08-115-fourbar-branch-and-isolated-points",
        "ch08-117-three-crank-parallelogram",
    )
}
"""Cases of which the tests here read every key."""


def pairs(count=5):
    return {f"{i + 1}{j + 1}": (i, j) for i, j in combinations(range(count), 2)}


@pytest.mark.capability("08-16", "08-47", "08-49", "08-52")
def test_four_bar_bifurcations():
    for case in CASES["ch08-13-fourbar-bifurcations"]["cases"]:
        linkage = FourBar(*case["L"])
        if "assemblable" in case:
            assert bool(linkage.space) is case["assemblable"]
            none = output_angles(linkage, np.linspace(0, 6, 50))
            assert (none.missing >= linkage.space.excess - 1e-12).all()
            assert np.isfinite(none.phi).all()
        elif "theta_deg" in case:
            found = output_angles(linkage, np.radians(case["theta_deg"]))
            assert found.every
            near(found.phi, [np.pi, 0.0])
        else:
            found = singular_points(linkage)
            near(
                np.degrees([[p.theta, p.phi] for p in found]).reshape(-1, 2),
                np.reshape([p["at"] for p in case["points"]], (-1, 2)),
            )
            for point, given in zip(found, case["points"], strict=True):
                assert not point.isolated
                if "slopes" in given:
                    near(point.slopes, given["slopes"], 1e-8)
        if "theta_ranges_deg" in case:
            low, high = np.degrees(linkage.input_range)
            near([[low, high], [360 - high, 360 - low]], case["theta_ranges_deg"], 1e-6)
            angles = np.radians([low - 1e-3, low + 1e-3, high - 1e-3, high + 1e-3])
            closes = output_angles(linkage, angles).missing == 0.0
            assert closes.tolist() == [False, True, True, False]


@pytest.mark.capability("08-49", "08-51")
def test_four_bar_branch_and_isolated_points():
    case = CASES["ch08-115-fourbar-branch-and-isolated-points"]
    expected = case["expected"]
    assert expected["det_Hessian"].startswith("-e1*e2*e3*L1*L2*L3*L4")
    for given in expected["cases"]:
        L = np.array(given["L"], float)
        point = next(p for p in singular_points(FourBar(*L)) if np.allclose(np.degrees([p.theta, p.phi]), given["at"]))
        e1, e3 = np.cos(point.theta), np.cos(point.phi)
        e2 = (L[3] + e3 * L[2] - e1 * L[0]) / L[1]
        near(np.linalg.det(point.curvature), -e1 * e2 * e3 * L.prod(), 1e-9)
        if "isolated" in given:
            assert point.isolated is given["isolated"]
            assert point.slopes.size == 0
        else:
            assert not point.isolated
            slopes = sorted(np.inf if s == "infinite" else s for s in given["slopes"])
            near(point.slopes, slopes, case["tol"])


@pytest.mark.capability("08-17", "08-29", "08-30", "08-42", "08-43", "08-50", "08-62")
def test_five_bar_regular():
    case = CASES["ch08-14-fivebar-regular"]
    robot, q = FiveBar(*case["L"]), np.radians([case["alpha_deg"], case["beta_deg"]])
    near(robot.forward_kinematics(q).x, [case["C_plus"], case["C_minus"]], 1e-8)
    theta = robot.chain_angles(q)
    near(theta, case["theta_plus"], 1e-8)
    near(robot.chain.closure(theta[:4]), [0, 0], 1e-12)
    near(robot.chain.last_angle(theta[:4]), theta[4], 1e-12)
    H = robot.chain.closure_matrix(theta[:4])
    near(H, case["H_4col"], 1e-8)
    assert np.linalg.matrix_rank(H) == case["rank_H"]
    wide = robot.chain.loop_matrix(theta[:4])
    for name, driven in pairs().items():
        passive = np.delete(wide, driven, axis=1)
        near(np.linalg.det(passive), case["detHp_by_actuated_pair"][name], 1e-7)
        assert driven_rates(wide, driven).regular
    near(robot.jacobian(q, case["C_plus"]), case["J_C_wrt_alpha_beta"], 1e-8)
    both = np.degrees(robot.inverse_kinematics(case["C_plus"]).choices)
    near(sorted(both.round(6).tolist()), sorted(np.round(case["ik_of_C_plus_alpha_beta_deg"], 6).tolist()), 1e-6)


@pytest.mark.capability("08-51", "08-53", "08-54", "08-55", "08-56", "08-57", "08-58", "08-59", "08-60")
def test_five_bar_singularities():
    classes = {
        "actuator, nondegenerate": LoopSingularity.NONDEGENERATE,
        "actuator, degenerate (self-motion over theta2)": LoopSingularity.DEGENERATE,
        "C-space, self-intersection (indefinite form)": LoopSingularity.CROSSING,
        "C-space, isolated point (definite form, cannot move)": LoopSingularity.ISOLATED,
        "end-effector (point C, links 1-2 aligned)": LoopSingularity.TASK,
    }
    for case in CASES["ch08-15-fivebar-singularities"]["cases"]:
        robot = FiveBar(*case["L"])
        theta = np.radians(case["theta_deg"]) if "theta_deg" in case else np.array(case["theta"])
        near(robot.chain.closure(theta), [0, 0], 1e-7)
        found = robot.singularity(theta)
        assert found.status is classes[case["cls"]]
        assert found.rank == case["rank_H"]
        H = robot.chain.loop_matrix(theta)
        if "rank_Hp" in case:
            good = choose_actuators(H, 2, 3)
            for name, driven in pairs().items():
                assert driven_rates(H, driven).rank_passive == case["rank_Hp"][name]
                assert driven_rates(H, driven).regular is (case["rank_Hp"][name] == 3)
                assert (driven in good) is (case["rank_Hp"][name] == 3)
        if "abs_second_order_w_g_vv_unit_w_v" in case:
            near(abs(found.second_order), case["abs_second_order_w_g_vv_unit_w_v"], 1e-7)
        if "signature_on_kernel" in case:
            plus, minus, zero = found.signature
            assert zero == 0
            said = case["signature_on_kernel"]
            assert (
                (sorted([plus, minus]) == [1, 2]) if said == "1 of one sign, 2 of the other" else (0 in (plus, minus))
            )
        if "rank_JC_on_kerH" in case:
            sides = np.stack([theta[:4] + 1e-6 * np.eye(4), theta[:4] - 1e-6 * np.eye(4)])
            tips = np.exp(1j * np.cumsum(sides, axis=-1)[..., :2]) @ [robot.crank_1, robot.rod_1]
            rates = (tips[0] - tips[1]) / 2e-6
            near(robot.point_rates(theta[:4])[:, :4], [rates.real, rates.imag], 1e-8)
            motions = np.linalg.svd(H)[2][3:].T
            assert np.linalg.matrix_rank(robot.point_rates(theta) @ motions, 1e-6) == case["rank_JC_on_kerH"]
            near(np.abs(found.blocked[:, 0]), case["blocked_direction"], 1e-7)
            bad = [name for name, driven in pairs().items() if driven not in choose_actuators(H, 2, 3)]
            assert bad == case["actuated_pairs_singular"]


@pytest.mark.capability("08-54", "08-65")
def test_five_bar_with_its_rods_in_line():
    case = CASES["ch08-113-fivebar-links-2-3-aligned"]
    robot, expected = FiveBar(*case["L"]), case["expected"]
    assert expected["cls"] == "actuator, nondegenerate"
    for root in expected["roots"]:
        q = np.radians([case["alpha_deg"], root["beta_deg"]])
        B, D = robot.crank_ends(q)
        assert np.linalg.norm(D - B) == pytest.approx(robot.rod_1 + robot.rod_2, abs=1e-9)
        C = B + robot.rod_1 / (robot.rod_1 + robot.rod_2) * (D - B)
        near(C, root["C"], case["tol"])
        s = [q[0], np.arctan2(*(D - B)[::-1]), np.arctan2(*(D - B)[::-1]), q[1] + np.pi]
        theta = np.diff(s, prepend=0.0)
        found = robot.singularity(theta)
        assert found.status is LoopSingularity.NONDEGENERATE
        assert (found.rank, found.driven.rank_passive) == (expected["rank_H"], expected["rank_Hp"])
        assert not found.driven.independent
        rate = found.driven.admissible[:, 0]
        near(-rate[1] / rate[0], root["dbeta_dalpha_feasible"], case["tol"])
        assert found.driven.forbidden[:, 0] @ rate == pytest.approx(0, abs=1e-12)
        near(abs(found.second_order), root["abs_w_g_vv"], case["tol"])


@pytest.mark.capability("08-51", "08-62")
def test_three_crank_parallelogram():
    case = CASES["ch08-117-three-crank-parallelogram"]
    robot, expected = ParallelCranks(1.0, [0.0, 2.0, 4.0]), case["expected"]
    turned = np.append(np.full(3, np.radians(60)), 0.0)
    near(robot.closure(turned), np.zeros(4), 1e-15)
    s = np.linalg.svd(robot.loop_matrix(turned), compute_uv=False)
    near(s, expected["at_60_deg"]["singular_values"], case["tol"])
    found = robot.singularity(turned)
    assert found.rank == expected["at_60_deg"]["rank_H"]
    assert found
    flat = robot.singularity(np.zeros(4))
    assert flat.rank == expected["flat"]["rank_H"]
    near(
        np.linalg.svd(robot.loop_matrix(np.zeros(4)), compute_uv=False),
        expected["flat"]["singular_values"],
        case["tol"],
    )
    assert flat.status is not LoopSingularity.REGULAR
    assert expected["flat"]["tangent_cone"] == "psi = 0 only: angle1=angle2=angle3"
    assert flat.tangents.shape == (1, 4)
    near(np.abs(flat.tangents[0]), np.append(np.full(3, 3**-0.5), 0.0), 1e-9)


@pytest.mark.capability("08-50")
def test_closure_curvature_is_a_difference():
    chain, h = PlanarChain([1.0, 0.7, 1.3, 0.9, 1.1]), 1e-5
    theta = np.array([0.4, -0.8, 1.2, 0.3])
    second = chain.curvature(theta)
    for k in range(4):
        step = h * np.eye(4)[k]
        matrix = (chain.loop_matrix(theta + step) - chain.loop_matrix(theta - step)) / (2 * h)
        near(second[:, k, :], matrix, 1e-8)
    np.testing.assert_allclose(chain.loop_matrix(theta)[2], 1.0)


def test_every_key_is_read():
    others = {name: item for name, item in globals().items() if name != "test_every_key_is_read"}
    assert unread_after(others, OWN) == []
