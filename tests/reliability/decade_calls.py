"""One small, valid call of every public function with a real argument: each decimal literal in it is driven in turn.

A literal with a point (`1.0`) is driven, one without (`1`) is not. Names are those of `SPACE`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import mafsil as mf
from mafsil import (
    collision,
    control,
    geometry,
    mobility,
    one_joint,
    parallel,
    planning,
    simulation,
    trajectory,
)
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.model import screws
from mafsil.model.dh_from_axes import dh_from_mechanism
from tests.parallel.closed_chains import four_bar

CALLS = (
    # control
    "control.contact.admittance_radius(inertia=1.0, damping=1.0, stiffness=1.0, period=0.001)",
    "control.contact.admittance_radius(inertia=1.0, damping=1.0, stiffness=1.0, period=0.001, explicit=True)",
    "control.constraint_table(constrained=(True, False), wanted=(0.0, 0.1), names=('x', 'y'))",
    "control.contact.contact_mode(normal_force=1.0, tangential_force=[1, 2], friction=0.5)",
    "control.current_loop(law=PID, bandwidth=50.0)",
    "control.add_delay(law=PID, delay=0.01)",
    "control.contact.effective_admittance(inertia=1.0, damping=1.0, stiffness=1.0, kp=10.0, kd=5.0, period=0.001)",
    "control.elastic_linearization(arm=ELASTIC, trajectory=STILL, rate=20.0)",
    "control.encoder_loop(law=PID, resolution=0.01, filter_time=0.1)",
    "control.export_law(robot=R2, law=PID, period=0.001)",
    "control.laws.follow_with_loops(chain=BARS, path=CRANK, q_start=BAR_Q, task='position', tolerance=1e-6, slack=0.0)",
    "control.contact.free_speed(wrench=1.0, kp=2.0, ki=3.0, damping=1.0, mass=1.0, t=[0, 1])",
    "control.tune_gains(robot=R2, period=0.001, delay=0.001, damping_ratio=0.7, poses=3)",
    "control.contact.guiding_line(point=[0, 0, 0], direction=[1, 0, 0], stiffness=10.0, damping=1.0)",
    "control.contact.guiding_plane(point=[0, 0, 0], normal=[1, 0, 0], stiffness=10.0, damping=1.0)",
    "control.contact.hybrid_certificate(law=HYBRID, t=T3, q=Q23, qd=0 * Q23, wrench=W3, allowed=0.05)",
    "control.impedance_by_force(robot=R2, impedance=SOFT, reference=HOLD, sensor=felt, coordinates=XY, clamp=5.0)",
    "control.analysis.impedance_class(impedance=SOFT, environment=STIFF, frequency=1.0)",
    "control.inertia_gains(robot=R2, q=Q2, period=0.001, natural_frequency=55.0, damping_ratio=0.7)",
    "control.joint_coupling(robot=R2, samples=10, coupling=0.1, spread=0.1, gravity_share=0.1)",
    "control.contact.least_virtual_mass(damping=1.0, stiffness=1.0, period=0.01)",
    "control.analysis.min_max(robot=R2, share=0.2, rate=10.0, damping=10.0, width=1.0)",
    "control.model_predictive(robot=R2, horizon=2, interval=0.02, position=1e4, rate=10.0, acceleration=0.01)",
    "control.contact.sampled_wall_radius(mass=1.0, damping=1.0, stiffness=1.0, period=0.01)",
    "control.contact.sliding_friction(normal_force=1.0, velocity=[1, 0], friction=0.5)",
    "control.sliding_mode(robot=R2, share=0.2, rate=10.0, damping=10.0, margin=1.0, width=0.02)",
    "control.contact.stiffest_wall(damping=1.0, period=0.01)",
    "control.task_computed_torque(robot=R2, reference=HOLD, natural_frequency=20.0, damping_ratio=1.0, "
    "integral=0.0, rest_frequency=2.0)",
    "control.compare_pose_errors(start=NEAR, goal=FAR, axes=('body',), natural_frequency=10.0, damping_ratio=1.0, "
    "duration=0.5)",
    # derivation
    "derivation.check_dh(rows=DH, mechanism=R2, tolerance=1e-6)",
    "derivation.check_jacobian(J=[['0', '0']] * 6, mechanism=R2, q=Q2, values={'L1': 1.0}, tolerance=1e-6)",
    "derivation.check_screws(S=SCREWS, mechanism=R2, tolerance=1e-6)",
    # identification
    "mf.identification.estimate_payload(robot=R2, log=LOG, bandwidth=5.0)",
    "mf.identification.excitation_trajectory(robot=R2, period=10.0, harmonics=2, candidates=1, improvements=0, "
    "speed=1.0)",
    # motion over time
    "mf.simulation.forward_dynamics_trajectory(robot=R2, q=Q2, duration=0.1, step=0.05, tolerance=1e-6, "
    "most_steps=200, seconds=1.0)",
    "mf.simulation.forward_dynamics_trajectory(robot=R2, q=Q2, duration=0.1, step=0.01, method='rk4', most_steps=200)",
    "mf.simulation.free_body_motion(body=BODY, T=NEAR, V=[0, 1, 0, 0, 0, 0], duration=0.1, tolerance=1e-6, "
    "most_steps=200, seconds=1.0)",
    "mf.simulation.inverse_dynamics_trajectory(robot=R2, motion=lambda t: [0.1 * t, 0.2], t=[0, 1, 2])",
    # grasp
    "grasp.rank_grasps(grasps=[PINCH], length=1.0)",
    "grasp.contact_state(force=[0, 0, 1], mu=0.5)",
    "grasp.corner_contact(point=(0, 0), normals=[(-1, 0), (0, -1)], mu=0.5)",
    "grasp.eliminate(A=np.array([[1.0, 2.0], [3.0, 4.0]]), tolerance=1e-10)",
    "grasp.line_contact(start=(0, 0, 1), end=(1, 0, 1), normal=(0, 0, -1), mu=0.5)",
    "grasp.patch_contact(corners=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], normal=(0, 0, 1), mu=0.5, gamma=0.1)",
    "grasp.plan_grasps(body=CUBE, mu=0.5, gamma=0.1, opening=2.0, tries=30, best=2)",
    "grasp.resist(contacts=PINCH.contacts, wrench=[0, -1, 0], push=2.0)",
    "grasp.robustness(grasp=PINCH, position=0.01, angle=0.1, friction=0.1, length=1.0, samples=10)",
    # ik
    "ik.arm_structure(robot=R6, tolerance=2e-5)",
    "ik.bounded_rates(robot=R2, q=Q2, V=[0.1, 0.2], rows=[3, 4], region=0.05, damping=0.05, limits=[1.0, 1.0])",
    "ik.find_root(f=lambda x: x * x - 2, x0=[1.0], tolerance=1e-12)",
    "ik.integrate_rates(robot=R2, q0=Q2, twist=lambda t, q: [0.1, 0.0], duration=0.1, step=0.05, rows=[3, 4])",
    "ik.inverse_kinematics(robot=R6, T_sd=TIP6, tolerance=1e-9)",
    "ik.inverse_kinematics(robot='panda', T_sd=TIP7, free=0.4, tolerance=1e-9)",
    "ik.newton_ik(robot=R3, T_sd=TIP3, q0=Q3, rotation_tolerance=1e-10, position_tolerance=1e-10, max_steps=5, "
    "damping=0.1)",
    "ik.structure.puma_shape(robot='puma560', tolerance=2e-5)",
    "ik.solve_ik(robot=R3, T_sd=TIP3, q0=Q3, tolerance=1e-10, rotation_tolerance=1e-8, restarts=3, seconds=1.0)",
    "ik.structure.strokes(r=[1.0, 0.5, 0], v=[1, 0, 0], c=2.0)",
    "ik.track(robot=R3, T_path=TIPS3, q0=Q3, tolerance=1e-9, largest_step=0.1)",
    "ik.twist_of_motion(X=turning, t=0.5, step=0.001)",
    # mobility
    "mobility.instantaneous_mobility(linkage=FOUR, share=1e-9)",
    "mobility.mobility(source=FOUR, play=1e-4)",
    "mobility.assembly_modes(linkage=FOUR, given={'A': 1.0}, starts=8)",
    "mobility.configuration_curves(linkage=FOUR, starts=2, step=0.1, steps=20)",
    "mobility.configuration_surfaces(linkage=FIVE, starts=1, step=0.3, points=10)",
    "mobility.bodies.explicit_body(implicit=[0, 0, 1, 0], d_AB=1.0)",
    "mobility.self_motion_manifold(lengths=[1.0, 2.0, 3.0], distance=1.0)",
    "mobility.generic_mobility(linkage=FOUR, step=0.05, samples=2)",
    "grasp.eliminate(A=[[1.0, 2], [3, 4]])",
    "mobility.bodies.implicit_body(explicit=[0, 0, 1], d_AB=1.0)",
    "mobility.joint(name='A', kind='H', bodies=['a', 'b'], axis=[0, 0, 1], pitch=0.1, limits=(-1.0, 1.0))",
    "mobility.bodies.joint_residual(kind='R', x=X6, d_AB=1.0, theta=0.1, slot=0.1)",
    "mobility.bodies.planar_body(A=[0, 0], phi=0, d_AB=1.0)",
    "mobility.bodies.planar_residual(x=[0, 0, 2, 0], d_AB=1.0)",
    "mobility.bodies.points_of_body(A=[0, 0, 0], lon=0, lat=0, psi=0, d_AB=1.0, d_AC=1.1, d_BC=1.2)",
    "mobility.bodies.second_body(kind='R', A=[0, 0], phi_AB=0, d_AB=1.0, d_CD=0.8, theta=0, d=1, slot=0.1)",
    "mobility.spaces.spatial_2r(alpha=1.0, distance=1.0, offset=0.2)",
    "mobility.synthesis.chebyshev_spacing(lower=0.0, upper=1.0, count=3)",
    "mobility.synthesis.cognates(linkage=mobility.FourBar(1.0, 2.2, 2.0, 2.5), along=1.4, across=0.9, samples=16)",
    "mobility.synthesis.synthesise_spherical_function(inputs=[0.0, 0.5, 1.1], outputs=[0.7, 1.1, 1.6], ground=1.2)",
    "mobility.synthesise_function(inputs=[0.0, 0.3, 0.6], outputs=[0.0, 0.2, 0.5], ground=1.0)",
    "mobility.bodies.third_point(A=[0, 0], B=[1, 0], d_AC=1.0, d_BC=0.9)",
    "mobility.trace_motion(linkage=FOUR, step=0.1, steps=20)",
    "mobility.trace_surface(linkage=FIVE, step=0.3, points=10)",
    "parallel.legs.calibrate_rods(robot=RODS, q=RODS_Q, measured=RODS_SEEN, held_out=0.4, angle_tolerance=0.01, "
    "length_tolerance=0.01)",
    "mf.identification.calibrate_arm(robot=R2, q=RODS_Q[:, :2], measured=RODS_SEEN, held_out=0.4, "
    "angle_tolerance=0.01, length_tolerance=0.01)",
    "parallel.legs.rod_indices(robot=RODS, x=[0, 0, -0.7], length=0.1, motor_stiffness=1.0, rod_stiffness=1.0, "
    "motor_error=0.001, rod_error=0.001)",
    "parallel.legs.RodMasses(platform=1.0, rods=np.full(3, 0.1), com=np.zeros(3), inertia=np.eye(3), arms=np.ones(3), "
    "motors=np.ones(3), sleeves=np.ones(3))",
    "mobility.linkages.turn_crank(linkage=FOUR, crank='A', speed=2.0, rows=8)",
    "mobility.library.bennett(a=1.0, alpha=0.5, b=1.6, theta=1.0)",
    "mobility.library.chain(joints=2, length=1.0)",
    "mobility.library.delta(base=0.5, platform=0.2, arm=0.6, height=1.1, half=0.1)",
    "mobility.library.door(tilt=0.1)",
    "mobility.library.eclipse(radius=1.0, platform=0.5, height=1.2)",
    "mobility.library.elliptic_trammel(length=2.0, theta=0.6)",
    "mobility.library.five_bar(ground=2.0, T1=(0.3, 1.0), T2=(1.7, 1.1), M=(1.6, 2.0))",
    "mobility.library.four_bar(crank=2.0, coupler=4.0, rocker=3.5, ground=4.5, theta=1.0)",
    "mobility.library.kaleidocycle(radius=1.0)",
    "mobility.library.parallelogram(crank=1.0, ground=2.0, theta=1.0)",
    "mobility.library.peaucellier(arm=3.0, side=1.2, crank=1.0, theta=0.5)",
    "mobility.library.planar_platform(base=2.0, platform=0.7, center=(0.2, 0.1), angle=0.3)",
    "mobility.library.quick_return(crank=1.0, ground=2.0, theta=1.0)",
    "mobility.library.sarrus(width=1.0, height=1.6, knee=0.6)",
    "mobility.library.scotch_yoke(crank=1.0, theta=0.7)",
    "mobility.library.screw_press(first=0.01, second=0.004)",
    "mobility.library.slider_crank(crank=1.0, rod=3.0, offset=0.0, theta=0.7)",
    "mobility.library.slotted_slider_crank(crank=1.0, rod=3.0, theta=0.7)",
    "mobility.library.spherical_four_bar(axes=((1.0, 0.0, 0.0), (0.8, 0.5, 0.3), (0.2, 0.9, 0.5), (0, 1, 0.1)))",
    "mobility.library.stewart_gough(base=1.0, platform=0.6, center=(0.05, -0.1, 1.2), base_spread=0.35, "
    "platform_spread=0.7)",
    "mobility.library.three_cranks(pivots=(0.0, 1.5, 3.0), length=1.0, angles=1.0)",
    "mobility.library.three_prs(base=1.0, platform=0.6, height=1.3)",
    "mobility.library.three_rps(base=1.0, platform=0.6, height=1.3)",
    "mobility.library.three_upu(base=1.0, platform=0.5, height=2.0, offset=(0.0, 0.0, 0.0))",
    "mobility.library.tripteron(reach=1.0)",
    "mobility.library.universal_shaft(bend=0.5, theta=0.4)",
    # one joint
    "one_joint.first_unstable_delay(arm=ARM, law=LAW, period=0.01, most=50)",
    "one_joint.measure_response(t=T3, error=[1, 0, 0], band=0.02)",
    "one_joint.simulate_joint(arm=ARM, law=LAW, reference=1.0, duration=0.05, start=0.1, speed=0.2, step=0.001)",
    "one_joint.simulate_sampled(arm=ARM, law=LAW, reference=1.0, duration=0.05, period=0.01, start=0.1, speed=0.2)",
    "one_joint.sweep_rate(arm=ARM, law=LAW, goal=1.0, duration=0.1, periods=[0.02, 0.01], start=0.1, gain=0.05)",
    # parallel
    "parallel.closed_inverse_kinematics(robot=BARS, T=BAR_TIP, task='position', tolerance=1e-9, "
    "rotation_tolerance=1e-9, starts=4)",
    "parallel.delta_legs(robot=DELTA, q=0.35)",
    "parallel.platforms.eliminant(values=lambda t: t * t - 2, degree=2, radius=1.0)",
    "parallel.simulate_closed(chain=HEAVY, q=HEAVY_Q, duration=0.02, step=0.01)",
    "parallel.three_rps(base=1.0, platform=0.6, height=1.3)",
    "parallel.three_upu(base=1.0, platform=0.6, height=1.3)",
    "parallel.platforms.trim_leading(coefficients=np.array([1 + 0j, 2, 0]), share=1e-9)",
    # performance
    "performance.force_ellipsoid(robot=R3, q=Q3, part='planar', length=0.5)",
    "performance.velocity_ellipsoid(robot=R3, q=Q3, part='planar', length=0.5)",
    "performance.isotropic_configurations(robot=R2, task='planar_position', length=0.5, starts=2, iterations=5)",
    "performance.largest_speed(robot=R3, q=Q3, direction=[1, 0], part='planar', length=0.5)",
    "performance.dexterity.least_joint_rate(robot=R3, q=Q3, direction=[1, 0], part='planar', length=0.5)",
    "performance.manipulability(robot=R3, q=Q3, task='planar', length=0.5)",
    "performance.manipulability_gradient(robot=R3, q=Q3, task='planar', length=0.5)",
    "performance.in_equilibrium(wrenches=[[1, 0, 0, 0, 0, 1], [-1, 0, 0, 0, 0, -1]], length=1.0, tolerance=1e-9)",
    "performance.is_singular(robot=R3, q=Q3, task='planar', length=0.5, tolerance=1e-6)",
    "performance.statics.pinned_arm(robot=R3, q=Q3, steps=3, step=0.02)",
    "performance.rank(robot=R3, q=Q3, task='planar', length=0.5, tolerance=1e-6)",
    "performance.singularities.rank_of_screws(S=SCREWS, length=1.0, tolerance=1e-6)",
    "performance.scaled_jacobian(robot=R3, q=Q3, task='planar', length=0.5)",
    "performance.self_motion(robot=R3, q=Q3, task='planar_position', tolerance=1e-6)",
    "performance.singular_values(robot=R3, q=Q3, task='planar', length=0.5)",
    "performance.singularity(robot=R3, q=Q3, task='planar', length=0.5, tolerance=1e-6)",
    "performance.singularities.twist_screw(V=[0, 0, 1, 1, 0, 2], length=1.0)",
    "performance.singularities.wrench_screw(F=[0, 0, 1, 1, 0, 2], length=1.0)",
    "performance.singularities.verdict_in_doubt(robot=R3, q=Q3, task='planar', length=0.5, tolerance=1e-6)",
    "performance.statics.structure_wrenches(robot=R3, q=Q3, tolerance=1e-6)",
    "performance.tip_wrench(robot=R3, q=Q3, tau=[0.1, 0.2, 0.3], task='planar', tolerance=1e-6)",
    "performance.virtual_work(robot=R3, q=Q3, tau=[0, 0, 0], tolerance=1e-9)",
    "performance.workspace_map(robot=R3, samples=50, view='xy', cell=0.2)",
    "performance.workspace_map(robot=R3, samples=50, view='xz', cell=0.2, at=0.1, "
    "ranges={R3.joint_names[0]: (-1.0, 1.0)})",
    # planning
    "mf.optimal_base_placement(robot=R2, targets=SPOTS, region=((-1.0, 1.0), (-1.0, 1.0)), yaws=1, spacing=1.0, "
    "enough_clearance=0.1, refinements=0)",
    "mf.plan(robot=CHECKER, scene=None, start=Q2, goal=G2, seconds=1.0, max_nodes=50, shortcut_iterations=2)",
    "mf.plan(robot=R2, scene=None, start=Q2, goal=G2, max_nodes=50, shortcut_iterations=2, "
    "clearance=0.01, self_clearance=0.0, radius=0.01)",
    "planning.avoid_moving_obstacles(collides=lambda s, t: (s > 0.4) & (s < 0.5) & (t < 1), duration=1.0, horizon=3.0, "
    "cells=20)",
    "planning.bench_planners(queries=[QUERY], planners=['rrt_connect'], seeds=(0,), seconds=1.0, max_nodes=50)",
    "planning.coordinate_robots(collides=lambda a, b: (a > 0.4) & (b > 0.4) & (a < 0.5) & (b < 0.5), durations=(1.0, "
    "2.0), cells=20)",
    "planning.disc_distance(centre=[0.5, 0.0], radius=0.3)([[3, 0]])",
    "planning.find_path(problem=PROBLEM, start=[0, 0], goal=[0, 1], seconds=1.0, max_nodes=50)",
    "planning.loop_constraints(mechanism=BAR_MECHANISM, tolerance=0.001)",
    "planning.plan_approach(checker=PLAIN3, start=Q3, T_goal=TIP3, away=(0.0, 0.01, 0.0), seconds=1.0)",
    "planning.plan_prioritized(cell=CELL, start={'a': Q2}, goal={'a': G2}, limits=SWIFT, seconds=1.0)",
    "planning.plan_around_moving(cell=CELL, name='a', start={'a': Q2}, goal=G2, limits=SWIFT, others={}, seconds=1.0)",
    "planning.plan_coupled(cell=CELL, start={'a': Q2}, goal={'a': G2}, seconds=1.0, max_nodes=50, "
    "shortcut_iterations=2)",
    "planning.planar_arm(lengths=[1.0, 1.0], world=WORLD, thickness=0.1, base=(0.0, 0.0))",
    "planning.log_search(query=QUERY, seconds=1.0, max_nodes=20)",
    # simulation
    "simulation.chalk_on_board(robot=R6, q=Q6, length=0.05, normal_force=5.0, friction=0.2, duration=1.0)",
    "simulation.eraser_on_board(robot=R6, q=Q6, length=0.05, normal_force=8.0, half_width=0.02, friction=0.2, "
    "duration=1.0)",
    "simulation.iterative_learning(scenario=SHORT, passes=2, gain=1.0, cutoff=20.0)",
    "simulation.learning_factor(gains=GAINS, gain=1.0, cutoff=20.0)",
    "simulation.monte_carlo(scenario=SHORT, variation=VARIED, runs=2, bound=0.1)",
    "simulation.open_a_door(robot=R6, q=Q6, radius=0.4, angle=-0.5, wrong=0.05, duration=2.0)",
    "simulation.peg_in_hole(robot=R6, q=Q6, off=0.001, depth=0.03, clearance=0.0002, duration=2.0)",
    "simulation.simulate_elastic(arm=ELASTIC, law=ELASTIC_LAW, trajectory=STILL, duration=0.01, step=0.001, "
    "effort_limit=10.0)",
    "simulation.choose_integrator(plant=PLANT, q=[Q2], step=0.001)",
    "mf.Scenario(robot=R2, trajectory=STILL, law=PID, duration=0.1, step=0.01, period=0.02)",
    # design
    "mf.design.accuracy(robot=STUDY, q=[0, 0], tolerances=mf.design.Tolerances(zero=0.001), payload=1.0, samples=9)",
    "mf.design.allocate(robot=R2, q=Q2, wanted=0.001, costs={'zero': 1.0})",
    "mf.design.pick_drives(design=STUDY, catalogue=SIZES, q=Q23, qd=0 * Q23 + 1, qdd=0 * Q23, payload=1.0, "
    "backlash=0.01)",
    "mf.design.optimise(arm=FAMILY, tasks=CHORE, goals=['mass'], limits={'mass': 9.0}, population=5, generations=1)",
    "mf.design.hypervolume(f=[[1.0, 2.0], [2.0, 1.0]], reference=[3.0, 3.0])",
    "mf.design.payload_map(design='puma560', at=0.1, cell=0.5, rpy=[[3.0, 0.0, 0.0]])",
    "mf.design.reach_map(design=R2, plane='xy', at=0.1, cell=0.5, rpy=[[3.0, 0.0, 0.0]])",
    # trajectory
    "trajectory.bspline(control_points=[[0.0], [1.0], [2.0], [1.0]], duration=1.0)",
    "trajectory.cartesian_line(robot=R6, q_start=Q6, T_goal=LINE6, duration=2.0, tolerance=1e-6)",
    "trajectory.check(trajectory=MOTION, limits=MOVE, tolerance=1e-9)",
    "trajectory.circle_path(T_start=NEAR, centre=[1.0, 0, 0], axis=[0, 0, 1.0], angle=1.0)",
    "trajectory.compare_routes(robot=R6, q_start=Q6, q_goal=NEXT6, duration=0.5, rate=20.0)",
    "trajectory.continuity(trajectory=MOTION, tolerance=1e-6)",
    "trajectory.cubic(start=[0.0], goal=[1.0], duration=2.0, start_velocity=0.1, goal_velocity=0.2)",
    "trajectory.diagnose_path(robot=R6, path=PATH6, q_start=Q6, duration=2.0, samples=11)",
    "trajectory.double_s(start=[0.0], goal=[1.0], velocity=1.0, acceleration=2.0, jerk=5.0)",
    "trajectory.double_s(start=[0.0], goal=[1.0], velocity=1.0, acceleration=2.0, jerk=5.0, duration=4.0)",
    "trajectory.export(trajectory=MOTION, path=FILE, limits=MOVE, rate=125.0)",
    "trajectory.follow(robot=R6, path=PATH6, q_start=Q6, tolerance=1e-6, slack=0.0)",
    "trajectory.jerk_limited(start=[0.0], goal=[1.0], limits=MOVE1, start_velocity=0.1, start_acceleration=0.1, "
    "goal_velocity=0.1, goal_acceleration=0.1, minimum_duration=0.5, cycle=0.01)",
    "trajectory.jerk_limited(start=[0.0, 0.0], goal=[1.0, 0.5], limits=LIMITS(velocity=1.0, acceleration=2.0, "
    "jerk=5.0))",
    "trajectory.jerk_limited(start=[0.0, 0.0], goal=[1.0, 0.5], limits=MOVE, minimum_duration=9.0, cycle=0.01)",
    "trajectory.joined_path(legs=LEGS, blend=0.01, blend_angle=0.1)",
    "trajectory.joint_motion(robot=R6, path=PATH6, q_start=Q6, duration=1.0, rate=20.0)",
    "trajectory.linear_blends(points=[[0.0], [1.0], [0.5]], durations=[2.0, 2.0], acceleration=5.0)",
    "trajectory.linear_blends(points=[[0.0], [1.0], [0.5]], velocity=1.0, acceleration=5.0, stops={1: 0.5})",
    "trajectory.linear_blends(points=[[0.0], [1.0], [0.5]], durations=[2.0, 2.0], acceleration=5.0, "
    "through={1: None}, delta=0.2)",
    "trajectory.online(position=[0.0], limits=MOVE1, cycle=0.01, velocity=0.1, acceleration=0.1)",
    "trajectory.prove(trajectory=MOTION, limits=MOVE, halvings=5, tolerance=1e-9)",
    "trajectory.quintic(start=[0.0], goal=[1.0], duration=2.0, start_velocity=0.1, goal_velocity=0.2, "
    "start_acceleration=0.1, goal_acceleration=0.2)",
    "trajectory.reachability(robot=R6, path=PATH6, samples=5, resolution=1e-9)",
    "trajectory.profiles.rest(position=[1.0], duration=2.0)",
    "trajectory.septic(start=[0.0], goal=[1.0], duration=2.0, start_derivatives=(0.1, 0.2, 0.3))",
    "trajectory.sequence(*PARTS, rests=(0.1, 0.2), tolerance=1e-6)",
    "trajectory.time_optimal(path=JOINTS, limits=SWIFT, robot=R2, tip_speed=1.0, tip_acceleration=2.0, "
    "tip_angular_speed=3.0, "
    "intervals=20)",
    "trajectory.time_optimal(path=JOINTS, limits=LIMITS(velocity=1.0, acceleration=2.0), intervals=20)",
    "trajectory.trapezoid(start=[0.0], goal=[1.0], acceleration=2.0, velocity=1.0)",
    "trajectory.trapezoid(start=[0.0], goal=[1.0], acceleration=2.0, duration=3.0)",
    "trajectory.via_rates(robot=R6, q=Q6, linear=[1, 0, 0], most_condition=1000.0)",
    # values that describe
    "mf.model.Actuator(rotor_inertia=0.1, gear_ratio=10.0, armature=0.0)",
    "mf.Contact(point=(0, 0), normal=(1, 0), mu=0.5, curvature=1.0, finger_curvature=2.0)",
    "mf.Contact(point=(0, 0, 0), normal=(1, 0, 0), mu=0.5, gamma=0.1)",
    "mf.model.Friction(viscous=0.1, coulomb=0.2, coulomb_negative=0.3, offset=0.0)",
    "mf.model.Inertial(mass=1.0)",
    "mf.model.Joint(name='j', kind=mf.model.JointKind.HELICAL, parent='a', child='b', pitch=0.1)",
    "mf.model.Limits(lower=-1.0, upper=1.0, velocity=1.0, acceleration=1.0, jerk=1.0, effort=1.0)",
    "mf.control.Impedance.of(m=1, inertia=1.0, damping=2.0, stiffness=3.0)",
    "control.Gains.of(1, kp=1.0, kd=2.0)",
    "control.Wall(point=np.zeros(3), normal=np.array([0, 0, 1]), stiffness=10.0, damping=1.0, friction=0.1, "
    "slow=0.001)",
    "collision.Obstacle(collision.Box(size=(1.0, 2.0, 3.0)))",
    "collision.Obstacle(collision.Capsule(radius=0.1, length=1.0))",
    "collision.Obstacle(collision.Cone(radius=0.1, length=1.0))",
    "collision.Obstacle(collision.Cylinder(radius=0.1, length=1.0))",
    "collision.Obstacle(collision.Sphere(radius=0.1))",
    "collision.ConvexHull(points=HULL, rounding=0.1)",
    "collision.HeightMap(heights=np.zeros((2, 2)), size=(1.0, 2.0), base=-1.0)",
    "collision.PointCloud(points=np.zeros((1, 3)), radius=0.1)",
    "grasp.FrictionLaw(mu_s=0.5, mu_k=0.4, viscous=0.1, aging=0.1)",
    "mobility.FourBar(crank=2.0, coupler=4.0, rocker=3.5, ground=4.5)",
    "mobility.SliderCrank(crank=1.0, rod=3.0, offset=0.1)",
    "mobility.bodies.Car(length=1.0)",
    "mobility.bodies.Cart(radius=0.1, width=1.0)",
    "mobility.bodies.Coin(radius=0.1)",
    "parallel.DeltaRobot(base=0.3, platform=0.1, arm=0.3, forearm=0.8)",
    "parallel.FiveBar(crank_1=1.0, rod_1=2.0, rod_2=2.0, crank_2=1.0, ground=1.5)",
    "parallel.StewartPlatform.on_circles(base=1.0, platform=0.6, base_angles=range(6), "
    "platform_angles=np.arange(6) + 0.3)",
    "planning.Problem(lower=[-1.0], upper=[1.0], free=lambda q: q[:, 0] < 2, resolution=0.02)",
    "simulation.WrenchPulse(start=0.0, duration=0.1, push=[0, 0, 0, 0, 0, 1])",
    "one_joint.DiscreteLoop(period=0.01, kp=1.0, ki=0.1, kd=0.1, filter_time=0.1)",
)  # fmt: skip

PACKAGES = ("derivation", "grasp", "ik", "performance")
"""Parts of mafsil that only the texts name."""

SLOW = (
    "control.compare_pose_errors", "control.tune_gains", "derivation.check_jacobian",
    "mf.identification.estimate_payload", "mf.identification.excitation_trajectory", "grasp.plan_grasps",
    "mobility.assembly_modes", "mobility.configuration_curves",
    "mobility.configuration_surfaces", "mobility.generic_mobility", "mobility.trace_motion", "mobility.trace_surface",
    "parallel.closed_inverse_kinematics", "performance.isotropic_configurations", "performance.statics.pinned_arm",
    "mf.optimal_base_placement",
    "planning.plan_approach", "planning.plan_prioritized", "planning.plan_around_moving", "trajectory.cartesian_line",
    "trajectory.compare_routes", "trajectory.diagnose_path", "trajectory.follow", "trajectory.joined_path",
    "trajectory.time_optimal", "simulation.monte_carlo", "simulation.iterative_learning", "trajectory.export",
    "control.laws.follow_with_loops",
    "ik.structure.puma_shape", "ik.inverse_kinematics", "control.export_law", "mf.plan",
    "grasp.rank_grasps", "grasp.robustness",
    "mobility.library.stewart_gough", "mobility.library.three_upu", "mobility.library.three_cranks",
    "mobility.library.delta", "ik.track", "parallel.simulate_closed", "one_joint.sweep_rate",
    "mf.simulation.free_body_motion",
    "ik.solve_ik", "trajectory.joint_motion", "mobility.library.spherical_four_bar", "mobility.library.three_prs",
    "mobility.library.three_rps", "mobility.library.eclipse", "performance.workspace_map",
    "simulation.simulate_elastic", "mf.design.optimise",
)  # fmt: skip
"""Functions of more than some milliseconds a call: driven through few values."""

ABSENT = {
    "mf.design.allocate": ("cost", "bound"),
    "mf.design.payload_map": ("payload", "q", "least", "least_at", "largest"),
    "mf.design.pick_drives": ("total", "mass", "peak", "heat", "speed"),
    "mf.design.optimise": ("peak", "rms", "speed", "energy", "payload", "frequency", "measures"),
    "ik.track": ("stopped_at", "drift"),
    "one_joint.measure_response": ("peak_time", "settling_time", "rise_time", "overshoot"),
    "control.compare_pose_errors": ("settling_time",),
    "one_joint.sweep_rate": ("settling_time", "overshoot", "peak_time", "rise_time", "longest", "advised"),
    "performance.force_ellipsoid": ("characteristic",),
    "performance.velocity_ellipsoid": ("characteristic",),
    "mf.optimal_base_placement": ("q",),
    "performance.singularities.wrench_screw": ("point", "pitch"),
    "performance.singularities.twist_screw": ("point", "pitch"),
    "planning.bench_planners": ("clearance",),
    "trajectory.joint_motion": ("stopped_at", "drift"),
    "trajectory.time_optimal": ("position", "speed", "turn_rate"),
    "control.model_predictive": ("limit",),
    "mobility.mobility": ("order",),
}
"""Fields that are documented to be NaN or infinite where there is nothing to say."""

LONG = {
    "trajectory.joined_path(blend_angle)": (1e-30, 1e-10),
    "trajectory.joint_motion(duration)": (1e2, 1e30), "trajectory.joint_motion(rate)": (1e3, 1e30),
    "ik.integrate_rates(duration)": (1e2, 1e5), "ik.integrate_rates(step)": (1e-8, 1e-4),
    "one_joint.simulate_joint(duration)": (1e2, 1e7), "one_joint.simulate_joint(step)": (1e-10, 1e-5),
    "one_joint.simulate_sampled(duration)": (1e2, 1e7), "one_joint.simulate_sampled(period)": (1e-10, 1e-5),
    "one_joint.sweep_rate(duration)": (1e1, 1e7), "one_joint.sweep_rate(periods[0])": (1e-10, 1e-4),
    "one_joint.sweep_rate(periods[1])": (1e-10, 1e-4), "trajectory.diagnose_path(duration)": (1e-30, 1e-10),
    "parallel.simulate_closed(duration)": (1e1, 1e5), "parallel.simulate_closed(step)": (1e-8, 1e-4),
    "simulation.simulate_elastic(duration)": (1e1, 1e5), "simulation.simulate_elastic(step)": (1e-8, 1e-4),
    "planning.avoid_moving_obstacles(duration)": (1e-4, 1e-2),
}  # fmt: skip
"""Arguments by whose sizes the work grows, up to a number of steps that is refused: sizes between are left out."""

OPEN: dict[str, str] = {}
"""Arguments that still fail somewhere, and why; the test fails too when one of them no longer does."""

EXCLUDED = {
    "mafsil.book.figure.values": "sliders by their names: tests/book drives each to its ends and beyond",
    "mafsil.ik.integrate_rates.twist": "a function",
    "mafsil.ik.twist_of_motion.X": "a function",
    "mafsil.planning.bench_planners.progress": "a function",
    "mafsil.job.bench_laws.progress": "a function",
    "mafsil.job.driving.simulate_plan.progress": "a function",
    "mafsil.job.planning.plan_moves.progress": "a function",
    "mafsil.job.planning.plan_moves.stops": "times at which searches ended, as a drive gives them back",
    "mafsil.simulation.inverse_dynamics_trajectory.motion": "a function",
    "mafsil.identify.held_out": "three seconds a call",
    "mafsil.identify.bandwidth": "three seconds a call; the same rule as in estimate_payload",
    "mafsil.identify.prior_spread": "three seconds a call",
    "mafsil.identify.smoothing": "three seconds a call",
    "mafsil.mobility.synthesise_path.tolerance": "a search of a minute; what is refused stands in its own tests",
    "mafsil.mobility.linkages.write_plates.width": "writes files; what is refused stands in its own tests",
    "mafsil.mobility.linkages.write_plates.hole": "writes files; what is refused stands in its own tests",
    "mafsil.one_joint.run_loop.desired": "the annotation of a function's result",
    "mafsil.verify.limit": "a routine of the developer: seconds a call; the limit is read only in the verdict",
}
"""Arguments that are not driven, and why."""


def turning(t: Any) -> Any:
    """A pose that turns about z and moves along x."""
    return geometry.pose.exp(np.array([0.0, 0.0, 1.0, 0.5, 0.0, 0.0]) * t)


def felt(q: Any, qd: Any) -> Any:
    """What a sensor of two forces feels."""
    return np.zeros(np.shape(q))


class NoEffort:
    """A law of joints with springs that does nothing."""

    def __call__(self, t: Any, state: Any, reference: Any) -> Any:
        return np.zeros_like(state.q)

    def session(self, period: float) -> Any:
        return self


FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
    (1, 5, 7), (1, 7, 3),
])  # fmt: skip


@cache
def space(folder: str) -> dict[str, Any]:
    """The names that the calls use.

    Args:
        folder: where files may be written.
    """
    names = {**globals(), **{name: getattr(mf, name) for name in PACKAGES}, "FILE": f"{folder}/motion.csv"}
    for part in (_arms, _laws, _mechanisms, _motions, _scenes, _designs):
        names.update(part(names))
    return names


def _arms(_: dict[str, Any]) -> dict[str, Any]:
    r2, r3, r6 = mf.load("planar2r"), mf.load("planar3r"), mf.load("puma560")
    q2, q3, q6 = np.array([0.3, 0.5]), np.array([0.3, 0.5, 0.4]), np.array([0.1, 0.8, 0.6, 0.2, 0.7, 0.3])
    g2 = np.array([0.6, 0.2])
    line = r6.forward_kinematics(q6)
    line[0, 3] += 0.01
    t = np.linspace(0.0, 2.0, 41)
    q = np.stack([np.sin(3 * t), np.cos(2 * t)], axis=1)
    qd, qdd = np.gradient(q, t, axis=0), np.gradient(np.gradient(q, t, axis=0), t, axis=0)
    return {
        "R2": r2, "R3": r3, "R6": r6, "Q2": q2, "Q3": q3, "Q6": q6, "G2": g2, "NEXT6": q6 + 0.1,
        "NEAR": np.eye(4), "FAR": turning(0.3), "TIP3": r3.forward_kinematics(q3 + 0.1),
        "TIPS3": r3.forward_kinematics(q3 + np.linspace(0, 0.1, 4)[:, None]), "LINE6": line,
        "TIP6": r6.forward_kinematics(q6 + 0.05),
        "PANDA": mf.load("panda"), "TIP7": mf.load("panda").forward_kinematics([0.1, 0.2, 0.3, -1.5, 0.4, 1.6, 0.4]),
        "DH": dh_from_mechanism(r2.mechanism).rows, "SCREWS": screws(r2.mechanism).S_s,
        "LOG": mf.identification.MotionLog(t=t, q=q, tau=r2.inverse_dynamics(q, qd, qdd)),
        "BODY": RigidBody(mf.model.Inertial(mass=1.0, inertia=np.diag([1.0, 2.0, 2.5]))),
    }  # fmt: skip


def _designs(_: dict[str, Any]) -> dict[str, Any]:
    tube = {"outer": 0.06, "wall": 0.003}
    family = mf.design.ParametricArm.of({
        "convention": "modified", "gravity": [0.0, -9.81, 0.0],
        "parameters": {"a": {"value": 0.5, "low": 0.3, "high": 0.7}},
        "joint": [{"tube": tube, "drive": {"mass": 2.0, "stiffness": 1e4}}, {"a": "a", "tube": tube}],
        "tool": {"xyz": [0.4, 0.0, 0.0]},
    })  # fmt: skip
    one = {"name": "a", "peak_torque": 9.0, "continuous_torque": 5.0, "speed": 500.0, "rotor_inertia": 1e-5}
    return {
        "FAMILY": family, "STUDY": family.at(), "CHORE": mf.design.TaskSet.of({"points": [[0.5, 0.1, 0.0]]}),
        "SIZES": mf.design.Catalogue.of([{**one, "ratio": 100.0, "efficiency": 0.8, "mass": 2.0}]),
    }  # fmt: skip


def _laws(names: dict[str, Any]) -> dict[str, Any]:
    r2, hold, xy = names["R2"], control.hold_pose(np.eye(4)), control.TaskCoordinates(rows=(3, 4))
    force = control.hybrid_control(
        r2, hold, [[0.0, 1.0]], [0.0, 1.0], coordinates=xy, gains=control.Gains.of(2, 50.0, 9.0, 20.0), sensor=felt,
        force_kp=0.4, force_ki=5.0,
    )  # fmt: skip
    return {
        "PID": control.pid(2, 10.0, 0.0, 1.0), "HOLD": hold, "XY": xy, "HYBRID": force,
        "GAINS": control.Gains.of(2, 100.0, 20.0),
        "SOFT": control.Impedance.of(2, inertia=1.0, damping=20.0, stiffness=500.0),
        "STIFF": control.Impedance.of(2, stiffness=2000.0),
        "T3": np.array([0.0, 1.0, 2.0]), "Q23": np.tile(names["Q2"], (3, 1)), "W3": np.zeros((3, 6)),
        "ELASTIC": control.elastic_arm(r2, [2000.0, 1000.0], motor_inertia=[0.4, 0.1]), "ELASTIC_LAW": NoEffort(),
        "ARM": one_joint.JointArm.of(0.5, friction=0.1), "LAW": one_joint.JointLaw.pid(51.0, 0.0, 10.0),
    }  # fmt: skip


def _mechanisms(names: dict[str, Any]) -> dict[str, Any]:
    bars = mobility.mechanism_of(mobility.library.four_bar())
    chain = parallel.ClosedChain(bars)
    q = chain.close_loops(np.zeros(chain.n)).q
    tip = chain.robot.forward_kinematics(q)
    moved = chain.close_loops(q + 0.01 * np.eye(1, chain.n)[0], hold=chain.actuated).q
    contacts = [mf.Contact((-1, 0), (1, 0), mu=0.5), mf.Contact((1, 0), (-1, 0), mu=0.5)]
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    heavy = parallel.ClosedChain(four_bar())
    made = mobility.bodies.second_body("R", [0, 0], 0.1, 1.0, 0.8, theta=0.1)
    return {
        "BARS": chain, "BAR_Q": q, "BAR_TIP": tip, "BAR_MECHANISM": bars,
        "CRANK": trajectory.line_path(tip, chain.robot.forward_kinematics(moved)),
        "RODS": parallel.legs.rotary_delta(0.2, 0.05, 0.3, 0.8),
        "RODS_Q": 0.3 + 0.1 * np.sin(np.arange(36.0)).reshape(12, 3),
        "RODS_SEEN": mf.identification.Measured(heights=-0.7 + 0.01 * np.sin(np.arange(12.0))),
        "FOUR": mobility.library.four_bar(), "FIVE": mobility.library.five_bar(), "PINCH": mf.Grasp(contacts),
        "CUBE": collision.TriangleMesh(cube, FACES), "HULL": cube, "DELTA": parallel.DeltaRobot(0.3, 0.1, 0.3, 0.8),
        "HEAVY": heavy, "HEAVY_Q": heavy.close_loops([0.5, 0.5, 1.5], hold=["A"]).q,
        "X6": np.array([0.0, 0.0, 0.1, *made.C, 0.2]),
    }  # fmt: skip


def _motions(names: dict[str, Any]) -> dict[str, Any]:
    r2, q2 = names["R2"], names["Q2"]
    still, limits = trajectory.profiles.rest(q2, 0.1), trajectory.MotionLimits.of
    legs = [trajectory.line_path(np.eye(4), turning(0.3)), trajectory.line_path(turning(0.3), turning(0.5))]
    return {
        "STILL": still, "LIMITS": lambda **given: limits(2, **given), "LEGS": legs,
        "MOVE": limits(2, velocity=2.0, acceleration=5.0, jerk=50.0),
        "SWIFT": limits(2, velocity=2.0, acceleration=5.0),
        "MOVE1": limits(1, velocity=2.0, acceleration=5.0, jerk=50.0),
        "MOTION": trajectory.quintic(q2, names["G2"], 1.0),
        "PARTS": [trajectory.quintic([0.0], [1.0], 1.0), trajectory.quintic([1.0], [2.0], 1.0),
                  trajectory.quintic([2.0], [3.0], 1.0)],
        "PATH6": trajectory.line_path(names["R6"].forward_kinematics(names["Q6"]), names["LINE6"]),
        "JOINTS": trajectory.JointPath.through([q2, names["G2"], [0.7, 0.7]]),
        "SHORT": mf.Scenario(robot=r2, trajectory=still, law=names["PID"], step=0.01),
        "VARIED": simulation.Variation(payload=(0.0, 0.1)), "PLANT": simulation.Plant(r2),
    }  # fmt: skip


def _scenes(names: dict[str, Any]) -> dict[str, Any]:
    r2, r3 = names["R2"], names["R3"]
    problem = planning.Problem([-1, -1], [1, 1], lambda q: np.linalg.norm(q, axis=1) > -1.0)
    square = [[-1.0, 3.0], [1.0, 3.0], [1.0, 4.0], [-1.0, 4.0]]
    return {
        "CHECKER": collision.Checker(r2, radius=0.02, self_collision=False),
        "PLAIN3": collision.Checker(r3, radius=0.02, self_collision=False),
        "CELL": collision.MultiArmCell([collision.ArmMount("a", r2, radius=0.02, self_collision=False)]),
        "PROBLEM": problem, "QUERY": planning.Query("plain", problem, np.zeros(2), np.array([0.5, 0.5])),
        "WORLD": planning.PolygonWorld.of([-5, -5], [5, 5], [square]), "SPOTS": r2.forward_kinematics([[0.3, 0.5]]),
    }  # fmt: skip
