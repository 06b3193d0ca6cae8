"""Worked numbers of the specification, part 10, about one joint, through `mafsil.one_joint`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil import one_joint

FILES = ("10-control.json", "10-more.json")
CASES = {case["id"]: case for name in FILES for case in json.loads(Path(__file__).with_name(name).read_text("utf-8"))}


def agree(got, expected, tol):
    expected = np.asarray(expected, dtype=float)
    assert np.all(np.abs(np.asarray(got) - expected) <= tol * np.maximum(1.0, np.abs(expected)))


def parts(name):
    case = CASES[name]
    return case["input"], case["expected"], case["tol"]


@pytest.mark.capability("10-24", "10-26", "10-27", "10-28")
def test_pd_damping_regimes():
    given, expected, tol = parts("pd_damping_regimes")
    damping = given["b"] + given["Kd"]
    kp = one_joint.kp_for_damping_ratio(given["M"], damping, given["zeta"])
    agree(kp, expected["Kp"], tol)
    loop = one_joint.SecondOrder.of_joint(given["M"], damping, kp)
    agree(loop.natural_frequency, expected["omega_n"], tol)
    agree(np.sort(loop.roots[0].real), expected["roots_zeta_1_5"], tol)
    agree(loop.roots[1].real, expected["root_zeta_1"], tol)
    agree(loop.roots[2].real, expected["roots_zeta_0_5"]["re"], tol)
    agree(np.abs(loop.roots[2].imag), expected["roots_zeta_0_5"]["im"], tol)
    agree(100 * loop.overshoot[2], expected["overshoot_pct_zeta_0_5"], tol)
    agree(loop.peak_time[2], expected["t_peak_zeta_0_5"], tol)
    agree(loop.settling_time(), expected["settle2pct_exact"], tol)
    agree(loop.settling_by_rule, expected["settle_4tau"], tol)


@pytest.mark.capability("10-23")
def test_hurwitz():
    given, expected, _ = parts("hurwitz")
    got = [bool(one_joint.routh_hurwitz(row)) for row in given["coeffs_high_to_low"]]
    assert got == expected["stable"]


@pytest.mark.capability("10-24", "10-25", "10-27")
def test_step_response_with_initial_velocity():
    given, expected, tol = parts("step_response_initial_velocity_three_regimes")
    loop = one_joint.SecondOrder.of_joint(given["M"], given["b"] + given["Kd"], given["Kp"])
    start = given["e0"], given["e_dot0"]
    agree(loop.damping_ratio, expected["zeta"], tol)
    agree(loop.response(given["t"], *start), expected["theta_e"], tol)
    peak = loop.opposite_peak(*start)
    agree(peak, expected["largest_theta_e_opposite_side"], tol)
    agree(100 * peak / abs(given["e0"]), expected["overshoot_pct_of_abs_e0"], tol)
    agree(loop.settling_time(*start), expected["settle_2pct_of_abs_e0"], tol)


@pytest.mark.capability("10-31")
def test_rest_error_of_pd():
    given, expected, tol = parts("pd_gravity_rest_error")
    load = given["m"] * given["r"] * given["g"]
    loop = one_joint.SecondOrder.of_joint(given["M"], given["b"] + given["Kd"], given["Kp"])
    agree(loop.damping_ratio, expected["zeta"], tol)
    rest = one_joint.steady_state_error(given["Kp"], load, given["theta_d"])
    agree(rest.error, expected["theta_e_inf"], tol)
    agree(rest.torque, expected["torque_inf"], tol)


@pytest.mark.capability("10-32", "10-33")
def test_integral_gain_under_gravity():
    given, expected, tol = parts("pid_ki_bound_under_gravity")
    goal = np.array([np.pi / 2, 0.0, -np.pi / 2, 1.0])
    joint, load = (given["M"], given["b"] + given["Kd"], given["Kp"]), given["m"] * given["g"] * given["r"]
    agree(one_joint.ki_limit(*joint, load, goal), expected["Ki_max_local"], tol)
    agree(one_joint.ki_limit(*joint), expected["Ki_max_printed_10_14"], tol)


@pytest.mark.capability("10-36", "10-109")
def test_tracking_of_ramp_and_sine():
    given, expected, tol = parts("tracking_error_pd_pid_ramp_sine")
    tracking = one_joint.TrackingError.of(given["M"], given["b"], given["Kp"], given["Ki"], given["Kd"])
    agree(tracking.ramp(2.0), expected["ramp_error"], tol)
    phasor = tracking.sine([2.0])[:, 0]
    agree(np.abs(phasor), expected["sine_error_amplitude"], tol)
    agree(np.angle(phasor), expected["sine_error_phase_rad"], tol)


def test_rest_with_a_wrong_model():
    given, expected, tol = parts("computed_torque_wrong_mass")
    one = given["one_joint"]
    # Computed torque at rest: M_hat Kp e + m g r_hat cos(theta) = m g r cos(theta).
    left = one["m"] * one["g"] * (one["r"] - one["r_hat"])
    rest = one_joint.steady_state_error(one["M_hat"] * one["Kp"], left, one["theta_d"])
    agree(rest.error, expected["one_joint_rest_error"], tol)


def book_arm(given, **changes):
    given = given | changes
    return one_joint.JointArm.of(given["M"], given["m"], given["r"], given["b"], given["g"])


@pytest.mark.capability("10-20", "10-32", "10-27")
def test_pid_beside_pd():
    given, expected, tol = parts("pid_vs_pd_response")
    assert given["continuous_time"]
    law = one_joint.JointLaw.pid(given["Kp"], [0.0, given["Ki"]], given["Kd"])
    run = one_joint.simulate_joint(
        book_arm(given), law, given["theta_d"], 40.0, start=-np.pi / 2, speed=given["theta_dot0"], step=1e-3
    )
    agree(run.error_at(expected["t"]), [expected["theta_e_pd"], expected["theta_e_pid"]], tol)
    agree(-100 * run.error[1].min() / (np.pi / 2), expected["pid_overshoot_pct"], 1e-4)  # The peak lies between ticks.
    agree(run.torque[1, -1], expected["pid_torque_inf"], tol)


@pytest.mark.capability("10-35")
def test_pid_as_pseudo_code():
    given, expected, tol = parts("pid_discrete_pseudocode")
    assert "difference" in given["velocity"]
    assert "hold" in given["torque"]
    plant = CASES[given["same_plant_as"]]["input"]
    law = one_joint.JointLaw.pid(plant["Kp"], plant["Ki"], plant["Kd"])
    for period, errors in zip(given["dt"], expected["theta_e_at_1_2_5_s"], strict=True):
        run = one_joint.simulate_sampled(book_arm(plant), law, 0.0, 5.0, period=period, start=-np.pi / 2)
        agree(run.error_at([1.0, 2.0, 5.0]), errors, tol)


@pytest.mark.capability("10-37", "10-38", "10-39", "10-40", "10-41")
def test_feedforward_feedback_and_computed_torque():
    given, expected, tol = parts("ff_fb_ct_tracking")
    arm, model = (book_arm(given, r=given[r]) for r in ("r_true", "r_hat"))
    gains = [given["gains"][k] for k in ("Kp", "Ki", "Kd")]

    def follow(law, centre, A):
        def reference(t):
            return centre - A * np.cos(t), A * np.sin(t), A * np.cos(t)

        return one_joint.simulate_joint(arm, law, reference, np.pi, start=centre - A, step=np.pi / 20000)

    for k, A in enumerate((1.0, np.pi / 4)):
        first = follow(one_joint.JointLaw.feedforward(model), -np.pi / 2, A)
        agree(abs(first.error[-1]), expected["task1_ff"][k]["final"], tol)
        agree(first.largest_error, expected["task1_ff"][k]["maxabs"], tol)
        rms = []
        for law, key in (
            (one_joint.JointLaw.computed_torque(model, *gains), "task2_computed_torque"),
            (one_joint.JointLaw.pid(*gains), "task2_fb_pid"),
            (one_joint.JointLaw.feedforward(model), "task2_ff"),
        ):
            run = follow(law, np.pi / 2, A)
            for name, got in (("final", run.error[-1]), ("rms", run.rms_error), ("effort", run.effort)):
                agree(got, expected[key][k][name], tol)
            rms.append(run.rms_error)
        assert expected["ordering"].startswith("rms: computed torque < feedback")
        assert rms == sorted(rms)


@pytest.mark.capability("10-32", "10-33")
def test_integral_gain_above_its_limit_grows():
    given, expected, _ = parts("pid_ki_bound_under_gravity")
    law = one_joint.JointLaw.pid(given["Kp"], [4.9, 5.4], given["Kd"])
    run = one_joint.simulate_joint(book_arm(given), law, np.pi / 2, 120.0, start=np.pi / 2 - 0.01, step=2e-3)
    early, late = (np.abs(run.error[:, part]).max(axis=-1) for part in (slice(0, 10000), slice(-10000, None)))
    assert bool(late[0] < early[0]) == expected["from_offset_0_01_Ki_4_9_decays"]
    assert bool(late[1] > early[1]) == expected["from_offset_0_01_Ki_5_4_grows"]


@pytest.mark.capability("10-105")
def test_stick_slip():
    given, expected, tol = parts("stick_slip_limit_cycle")
    assert not given["Kd"]
    assert not given["Ki"]
    assert not given["g"]
    cycle = one_joint.drives.stick_slip(given["M"], given["Kp"], given["b_static"], given["b_kinetic"], 0.1)
    for key, name in (
        ("error_at_breakaway", "error_at_breakaway"), ("slip_time", "slip_time"), ("slip_distance", "slip_distance"),
        ("error_at_restick", "error_at_restick"), ("stick_time", "stick_time"), ("period", "period"),
        ("peak_speed", "peak_speed"), ("first_motion_time_from_zero_error", "first_motion"),
    ):  # fmt: skip
        agree(getattr(cycle, name), expected[key], tol)


@pytest.mark.capability("10-65")
def test_force_error_against_a_rigid_wall():
    given, expected, tol = parts("force_pi")
    assert given["quasi_static"]
    assert given["F_e"] == "F_d - F_app"
    loop = one_joint.ForceLoop.of(given["Kfp"], given["Kfi"])
    agree(loop.time_constant, expected["time_constant"], tol)
    error = loop.quasi_static_error([0.0, 0.15, 1e3], given["constant_wrench_disturbance"])
    agree(error, [expected["F_e_at_0"], expected["F_e_at_0_15"], expected["F_e_inf"]], tol)


@pytest.mark.capability("10-66")
def test_runaway_without_contact():
    given, expected, tol = parts("force_law_free_space_runaway")
    loop = one_joint.ForceLoop.of(given["Kfp"], given["Kfi"], given["K_damp"])
    speed = loop.free_speed(given["t"], given["F_d"], given["mass"], given["v0"])
    agree(speed, [expected["speed_Kfi_10"], expected["speed_Kfi_0"]], tol)
    assert expected["late_speed_Kfi_10"].endswith("m Kfi F_d/Kdamp^2")
    agree(loop.late_speed([5.0], given["F_d"], given["mass"])[0], [expected["speed_Kfi_10"][2]], tol)


@pytest.mark.capability("10-78", "10-79")
def test_impedance_meets_a_wall():
    given, expected, tol = parts("impedance_robot_meets_wall")
    assert "-4000 x" in given["wall"]
    contact = one_joint.simulate_wall_contact(
        *(given[key] for key in "DBK"), reference=given["X_ref"], wall_stiffness=4000.0, start=given["x0"],
        speed=given["v0"],
    )  # fmt: skip
    for key, name in (
        ("contact_time", "contact_time"), ("contact_speed", "contact_speed"), ("peak_force", "peak_force"),
        ("time_of_peak_force_after_contact", "time_of_peak"), ("release_after_contact", "release"),
        ("rest_x", "rest_position"), ("rest_force", "rest_force"),
    ):  # fmt: skip
        agree(getattr(contact, name), expected[key], tol)
    assert (contact.status is one_joint.wall_contact.WallStatus.LOST) == expected["first_contact_is_lost"]


@pytest.mark.capability("10-43", "10-45", "10-46", "10-47")
def test_gears():
    given, expected, tol = parts("gear_reflected_inertia_matching")
    link, rotor = given["I_link"], given["I_motor"]
    matching = float(one_joint.drives.matching_ratio(link, rotor))
    ratios = [matching if isinstance(G, str) else G for G in given["G"]]
    gear = one_joint.Gear.of(ratios, rotor, given["efficiency"])
    rows = {key: [row[key] for row in expected["rows"]] for key in expected["rows"][0]}
    agree(gear.ratio, rows["G"], tol)
    agree(gear.reflected_inertia, rows["reflected"], tol)
    agree(gear.apparent_inertia(link), rows["apparent"], tol)
    agree(100 * gear.motor_share(link), rows["motor_share_pct"], tol)
    agree(gear.link_acceleration(link, given["motor_torque"]), rows["link_accel_for_motor_torque"], tol)
    rise = gear.payload_sensitivity(link, given["payload_inertia"])
    agree(100 * rise, rows["apparent_rise_pct_with_payload_0_4"], tol)
    book = given["book_example"]
    share = one_joint.Gear.of(book["G"], book["I_motor"]).motor_share(book["I_link"])
    agree(100 * share, expected["book_motor_share_pct"], tol)
