"""What people type who know other toolboxes of robotics, and what to write here instead."""

from __future__ import annotations

ONE_POSE = "robot.ik_all(T) for all solutions, robot.ik(T, q0) for the nearest one"
BY_TABLE = 'mf.Robot.from_dh(rows, "classic")'
TRAPEZOID = "mf.trajectory.trapezoid(start, goal, acceleration=a, velocity=v)"

ATTRIBUTES: dict[str, str] = {
    **dict.fromkeys(("fk", "fkine", "forward", "getfk", "forward_kinematics"), "robot.fk(q)"),
    **dict.fromkeys(("ik", "ikine", "ikine_lm", "ikine_a", "ik_lm", "inverse_kinematics", "ik_all"), ONE_POSE),
    **dict.fromkeys(("jacobian", "jacobe", "jac"), "robot.jacobian(q), in the tip frame; rows: omega, then v"),
    **dict.fromkeys(
        ("jacob0", "geometric_jacobian"), 'robot.jacobian(q, expressed_in="aligned"), axes of {s}; rows: omega, then v'
    ),
    **dict.fromkeys(("teach", "view", "display", "animate", "visualize", "show"), "robot.show()"),
    "plot": "robot.plot(q), or robot.show() in the browser",
    **dict.fromkeys(("dof", "n_dof", "ndof", "num_joints", "njoints", "nq", "dofs"), "robot.n"),
    **dict.fromkeys(("rne", "rnea", "idyn"), "robot.inverse_dynamics(q, qd, qdd)"),
    **dict.fromkeys(("accel", "fdyn", "aba"), "robot.forward_dynamics(q, qd, tau)"),
    **dict.fromkeys(("inertia", "crba", "mass"), "robot.mass_matrix(q)"),
    **dict.fromkeys(("gravload", "gravity"), "robot.gravity_torque(q)"),
    **dict.fromkeys(("qlim", "joint_limits", "lower", "upper"), "robot.limits"),
    **dict.fromkeys(("links", "joints"), "robot.mechanism, which holds links and joints"),
    **dict.fromkeys(("manipulability", "maniplty"), "mf.performance.manipulability(robot, q)"),
    **dict.fromkeys(("workspace", "reach"), "robot.workspace()"),
    **dict.fromkeys(("singularity", "is_singular"), "robot.singularity(q)"),
    "derive": 'robot.derive("jacobian")',
    **dict.fromkeys(("list_robots", "models"), "mf.robots()"),
    **{name: f'mf.load("{name}")' for name in ("panda", "puma560", "ur3e", "ur5", "ur5e", "ur10e", "iiwa7", "fr3")},
    **dict.fromkeys(("dhrobot", "erobot", "seriallink", "revolutedh", "from_table"), BY_TABLE),
    **dict.fromkeys(("se3", "transform", "homogeneous"), "mf.Pose(T), or mf.Pose.of(R, p)"),
    **dict.fromkeys(("so3", "rotx", "roty", "rotz"), "mf.Rotation.from_axis_angle(axis, angle)"),
    **dict.fromkeys(
        ("from_matrix", "as_matrix"), "mf.Rotation(R) or mf.Pose(T), which take the matrix; it stands in .array"
    ),
    "from_xyz_rpy": "mf.Pose.of(mf.Rotation.from_rpy(rpy), xyz)",
    "rpy": 'mf.Rotation.from_rpy(rpy), or .euler("xyz") of a rotation',
    "inv": ".inverse()",
    **dict.fromkeys(("trapezoidal", "trapveltraj", "lspb", "jtraj"), TRAPEZOID),
    **dict.fromkeys(
        ("with_mass_error", "mass_error", "scale_masses", "with_scaled_masses"),
        "mf.simulation.Plant(robot).with_scaled_inertia(1.3), a plant with 30 % more mass than the controller knows",
    ),
    **dict.fromkeys(
        ("grashof", "grashof_class", "is_grashof"), "mf.mobility.FourBar(crank, coupler, rocker, ground).grashof"
    ),
    **dict.fromkeys(
        ("coupler_curve", "coupler_curves"),
        "mf.mobility.FourBar(crank, coupler, rocker, ground).coupler_curves(along, across)",
    ),
    **dict.fromkeys(
        ("text", "formulas", "formula", "latex", "html", "to_text", "to_latex", "to_html"),
        "mf.derivation.to_text(derivation), to_latex or to_html",
    ),
    **dict.fromkeys(("success", "converged", "ok"), "if answer: ..., or answer.status"),
    **dict.fromkeys(("solutions", "results"), "list(answer), or for one in answer: ..."),
    **dict.fromkeys(("message", "reason"), "answer.explain()"),
    "toppra": "mf.trajectory.time_optimal(path, limits)",
    "ruckig": "mf.trajectory.jerk_limited(start, goal, limits)",
    "rrt": "robot.plan(scene, start, goal)",
    "place": "mf.optimal_base_placement(robot, targets)",
    "mend": "mf.repair(path)",
    "doctor": "mf.trajectory.suggest_fixes(points, durations, robot)",
    "mend_path": "mf.trajectory.suggest_path_fixes",
    "degeneracy": "robot.mass_matrix_singularity(q)",
    "gain_card": "mf.control.tune_gains",
    "tip_ways": "mf.control.compare_pose_errors",
    "felt_constraint": "mf.control.contact.estimate_contact_constraint",
    "suitable_family": "mf.control.recommend_controller",
    "fast_damping": "mf.control.singular_perturbation_control",
    "plan_in_turn": "mf.planning.plan_prioritized",
    "plan_past": "mf.planning.plan_around_moving",
    "plan_together": "mf.planning.plan_coupled",
    "meet_wall": "mf.one_joint.simulate_wall_contact",
    "rest_under_gravity": "mf.one_joint.steady_state_error",
    "locked_subsets": "mf.mobility.mobility_with_locked_joints",
    "redundancy": "mf.mobility.redundant_constraints(linkage), mf.ik.redundancy(robot)",
    "configuration_space": "mf.planning.configuration_space_obstacles(arm), mf.mobility.configuration_space(linkage)",
    "windings": "answer.multi_turn_solutions()",
    "together": 'robot.fused_routine("mass_matrix", "inverse_dynamics")',
    "trace": "mf.mobility.trace_motion(linkage)",
    "locked": 'robot.with_locked_joints({"finger": 0.02})',
    "timed": "plan.time_optimal(limits)",
    "optimised": "plan.optimise()",
    "stretched": "motion.scale_time(factor)",
    "mended": "diagnosis.apply_fix()",
    "unblended": "path.with_sharp_corners()",
    "parted": "cell.split(q)",
    "joined": "cell.join(q_of_arms)",
    "moved": "in_frame(T) of contacts and grasps, drive(q, ...) of wheels, integrate(x, step) of poses",
    "closed": "chain.close_loops(q), arm.close_loop(law, reference)",
    "followed": "backlash.link_position(motor)",
    "combined": "mf.control.combine",
    "saturated": "mf.control.saturate",
    "delayed": "mf.control.add_delay",
    "synchronised": "mf.trajectory.synchronise_axes",
    "assembled": "mf.mobility.close_drawing",
    "space_named": "mf.mobility.named_space",
    "instantaneous": "mf.mobility.instantaneous_mobility",
    "mobilities": "mf.mobility.batch_mobility",
    "good_motors": "mf.parallel.choose_actuators",
    "legs_of": "mf.parallel.legs_from_screws",
    "avoid_moving": "mf.planning.avoid_moving_obstacles",
    "coordinate": "mf.planning.coordinate_robots",
    "loops_kept": "mf.planning.loop_constraints",
    "learn": "mf.simulation.iterative_learning",
    "suitable_integrator": "mf.simulation.choose_integrator",
    "cluster_of": "mf.simulation.cluster_executor",
    "run_sampled": "mf.one_joint.simulate_sampled",
    "rest_of_joints": "mf.one_joint.steady_state_of_joints",
    "modelwarning": "mafsil.errors.ModelWarning",
}
"""By the name in small letters."""

STATUS = 'answer.status.name, such as "FOUND"; whether an answer is good: if answer'


def attribute(name: str) -> str | None:
    """What to write instead of a name that there is not, if its word is known elsewhere.

    Args:
        name: as typed.
    """
    return STATUS if name.endswith("Status") else ATTRIBUTES.get(name.casefold())


ARGUMENTS: dict[str, str] = {
    "margin": "clearance",
    "keep": "constraints",
    "moving": "active_joints",
    "shorten": "shortcut_iterations",
    "nodes": "max_nodes",
    "rest": "known_free",
    "deg": "degrees",
    "kp": "natural_frequency",
    "kd": "damping_ratio",
    "omega": "natural_frequency",
    "zeta": "damping_ratio",
    "initial": "q0",
    "seed_q": "q0",
    "q_init": "q0",
    "ee": "frame",
    "link_name": "frame",
    "rb": "base",
    "re": "platform",
    "timeout": "seconds",
    "max_iter": "restarts",
    "press": "normal_force",
}
"""Where the one is not known and the other is taken."""

NAMES: dict[str, str] = {
    "kuka": "iiwa7",
    "iiwa": "iiwa7",
    "franka": "panda",
    "puma": "puma560",
    "stanford": "stanford_arm",
    "scara": "cobra600",
    "ur10": "ur10e",
    "ur3": "ur3e",
    "two_link": "planar2r",
    "2r": "planar2r",
    "3r": "planar3r",
    "stewart": "stewart_gough",
    "gough": "stewart_gough",
    "bennett_linkage": "bennett",
    "crank_slider": "slider_crank",
}
"""Of robots and mechanisms in the libraries."""

JOB_KEYS: dict[str, str] = {
    "stiffness": "kp",
    "rate_gain": "kd",
    "keep": "constraints",
    "own_clearance": "self_clearance",
    "rest": "known_free",
    "speed_share": "speed_scale",
    "acceleration_share": "acceleration_scale",
    "mass_share": "mass_uncertainty",
    "turn_stiffness": "rotational_stiffness",
    "turn_damping": "rotational_damping",
    "tip_turn_rate": "tip_angular_speed",
    "press": "normal_force",
}
"""Of job files, where the one is not known and the other is."""

COMMANDS: dict[str, tuple[str, ...]] = {
    "singular": ("singularity",),
    "check": ("check-homework", "check-job"),
    **dict.fromkeys(("bench", "benchmark"), ("compare",)),
    **dict.fromkeys(("place", "placement", "reachability"), ("base-placement",)),
    "doctor": ("info", "suggest-fixes"),
    **dict.fromkeys(("version", "env", "cache", "selftest"), ("info",)),
    **dict.fromkeys(("validate", "check_urdf"), ("lint",)),
    **dict.fromkeys(("simulate", "sim", "execute"), ("run",)),
    **dict.fromkeys(("view", "plot", "teach", "describe"), ("show",)),
    **dict.fromkeys(("robots", "ls", "models"), ("list",)),
    **dict.fromkeys(("kinematics", "forward", "forward-kinematics", "fkine"), ("fk",)),
    **dict.fromkeys(("inverse", "inverse-kinematics", "ikine"), ("ik",)),
    **dict.fromkeys(("jacobian", "symbolic", "equations"), ("derive", "singularity")),
    **dict.fromkeys(("gravity", "torque", "rnea", "inverse-dynamics"), ("dynamics",)),
    **dict.fromkeys(("linkage", "four-bar"), ("mobility", "synthesis")),
    **dict.fromkeys(("gui", "serve", "edit"), ("studio",)),
    **dict.fromkeys(("codegen", "generate"), ("export",)),
}
"""Of the command line: one or several commands, or actions of a command."""
