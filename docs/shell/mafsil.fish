complete -c mafsil -n __fish_use_subcommand -a run -d 'solve a job file: plan, simulate, and write a report'
complete -c mafsil -n '__fish_seen_subcommand_from run' -l out
complete -c mafsil -n '__fish_seen_subcommand_from run' -l progress
complete -c mafsil -n '__fish_seen_subcommand_from run' -l open
complete -c mafsil -n '__fish_seen_subcommand_from run' -l dry-run
complete -c mafsil -n '__fish_seen_subcommand_from run' -l set
complete -c mafsil -n '__fish_seen_subcommand_from run' -l plant
complete -c mafsil -n '__fish_seen_subcommand_from run' -l real-time
complete -c mafsil -n '__fish_seen_subcommand_from run' -l log
complete -c mafsil -n '__fish_seen_subcommand_from run' -l runs
complete -c mafsil -n '__fish_seen_subcommand_from run' -l cluster
complete -c mafsil -n '__fish_seen_subcommand_from run' -l json
complete -c mafsil -n '__fish_seen_subcommand_from run' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from run' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from run' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from run' -l help
complete -c mafsil -n '__fish_seen_subcommand_from run' -a 'mafsil mujoco kinematic'
complete -c mafsil -n __fish_use_subcommand -a check-job -d 'plan a job without simulating it: moves, durations, findings; exit code 1 if it cannot be done'
complete -c mafsil -n '__fish_seen_subcommand_from check-job' -l program
complete -c mafsil -n '__fish_seen_subcommand_from check-job' -l json
complete -c mafsil -n '__fish_seen_subcommand_from check-job' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from check-job' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from check-job' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from check-job' -l help
complete -c mafsil -n __fish_use_subcommand -a demo -d 'run the built-in pick-and-place job'
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l out
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l progress
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l open
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l json
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from demo' -l help
complete -c mafsil -n __fish_use_subcommand -a sweep -d 'plan a job for many values of its variables: cycle times, and why some cases are infeasible'
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l simulate
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l progress
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l json
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from sweep' -l help
complete -c mafsil -n __fish_use_subcommand -a compare -d 'compare control laws or planners on a job: errors, efforts, energy, robustness to unmodelled payload, delay and rate; paths, times, lengths (two runs: `mafsil diff`)'
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l laws
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l planners
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l seeds
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l seconds
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l replay
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l log
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l better
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l out
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l progress
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l open
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l json
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from compare' -l help
complete -c mafsil -n '__fish_seen_subcommand_from compare' -a 'control planners log'
complete -c mafsil -n __fish_use_subcommand -a diff -d 'compare the results of two runs: job, cycle, errors, efforts, moves, findings'
complete -c mafsil -n '__fish_seen_subcommand_from diff' -l json
complete -c mafsil -n '__fish_seen_subcommand_from diff' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from diff' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from diff' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from diff' -l help
complete -c mafsil -n __fish_use_subcommand -a studio -d 'show and edit a robot, a job or recordings in the browser (local server, Ctrl-C stops it)'
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l port
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l open
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l view
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l json
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from studio' -l help
complete -c mafsil -n __fish_use_subcommand -a list -d 'list the built-in robots'
complete -c mafsil -n '__fish_seen_subcommand_from list' -l json
complete -c mafsil -n '__fish_seen_subcommand_from list' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from list' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from list' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from list' -l help
complete -c mafsil -n __fish_use_subcommand -a book -d 'show pages, figures, worked examples, remarks, errata and exercises of the textbook by number, write exercise sheets and collect marks; without a number, list them'
complete -c mafsil -n '__fish_seen_subcommand_from book' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from book' -l seed
complete -c mafsil -n '__fish_seen_subcommand_from book' -l level
complete -c mafsil -n '__fish_seen_subcommand_from book' -l answer
complete -c mafsil -n '__fish_seen_subcommand_from book' -l hints
complete -c mafsil -n '__fish_seen_subcommand_from book' -l solution
complete -c mafsil -n '__fish_seen_subcommand_from book' -l students
complete -c mafsil -n '__fish_seen_subcommand_from book' -l exam
complete -c mafsil -n '__fish_seen_subcommand_from book' -l eastern-digits
complete -c mafsil -n '__fish_seen_subcommand_from book' -l files
complete -c mafsil -n '__fish_seen_subcommand_from book' -l out
complete -c mafsil -n '__fish_seen_subcommand_from book' -l json
complete -c mafsil -n '__fish_seen_subcommand_from book' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from book' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from book' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from book' -l help
complete -c mafsil -n __fish_use_subcommand -a show -d 'print joints, limits, masses, screw axes and data sources of a robot, or write its 3D page'
complete -c mafsil -n '__fish_seen_subcommand_from show' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from show' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from show' -l out
complete -c mafsil -n '__fish_seen_subcommand_from show' -l open
complete -c mafsil -n '__fish_seen_subcommand_from show' -l view
complete -c mafsil -n '__fish_seen_subcommand_from show' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from show' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from show' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from show' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from show' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from show' -l model
complete -c mafsil -n '__fish_seen_subcommand_from show' -l base
complete -c mafsil -n '__fish_seen_subcommand_from show' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from show' -l json
complete -c mafsil -n '__fish_seen_subcommand_from show' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from show' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from show' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from show' -l help
complete -c mafsil -n '__fish_seen_subcommand_from show' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a fk -d 'forward kinematics: pose of the tip or of another link'
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l frame
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l model
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l base
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l json
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from fk' -l help
complete -c mafsil -n '__fish_seen_subcommand_from fk' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a ik -d 'inverse kinematics: joint coordinates for a pose, or why there are none'
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l pose
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l all
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l near
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l task
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l frame
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l model
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l base
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l json
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from ik' -l help
complete -c mafsil -n '__fish_seen_subcommand_from ik' -a 'pose position axis arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a dynamics -d 'inverse or forward dynamics of a state, with mass matrix, Coriolis and gravity terms; or the motion over time'
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l q
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l qd
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l qdd
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l tau
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l duration
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l out
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l frictionless
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l quantities
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l model
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l base
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l json
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -l help
complete -c mafsil -n '__fish_seen_subcommand_from dynamics' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a plan -d 'plan a collision-free path (continuously verified) and time it'
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l start
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l goal
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l pose
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l box
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l angle
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l upright
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l orientation
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l line
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l plane
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l scene
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l clearance
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l self-clearance
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l planner
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l srdf
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l known-free
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l active-joints
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l seed
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l seconds
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l out
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l model
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l base
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l json
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from plan' -l help
complete -c mafsil -n '__fish_seen_subcommand_from plan' -a 'rrt_connect prm rrt_star lazy_prm_star trajectory_optimisation cell_decomposition arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a base-placement -d 'find a base pose from which all targets can be reached, with a map'
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l targets
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l scene
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l x
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l y
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l height
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l yaws
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l spacing
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l enough-clearance
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l stands-on
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l model
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l base
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l json
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -l help
complete -c mafsil -n '__fish_seen_subcommand_from base-placement' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a design -d 'design an arm in a file: robot, tasks, payload, reach, accuracy, tolerances, drives, search'
complete -c mafsil -n '__fish_seen_subcommand_from design' -l values
complete -c mafsil -n '__fish_seen_subcommand_from design' -l catalogue
complete -c mafsil -n '__fish_seen_subcommand_from design' -l seed
complete -c mafsil -n '__fish_seen_subcommand_from design' -l out
complete -c mafsil -n '__fish_seen_subcommand_from design' -l json
complete -c mafsil -n '__fish_seen_subcommand_from design' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from design' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from design' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from design' -l help
complete -c mafsil -n '__fish_seen_subcommand_from design' -a 'robot tasks report payload reach accuracy allocate drives search'
complete -c mafsil -n __fish_use_subcommand -a singularity -d 'singularity of a configuration: rank, cause, lost motions, wrenches carried by the structure'
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l task
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l model
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l base
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l json
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -l help
complete -c mafsil -n '__fish_seen_subcommand_from singularity' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a statics -d 'joint efforts for a wrench at the tip, or the reverse; and the reaction wrench of every joint'
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l wrench
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l tau
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l given-in
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l model
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l base
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l json
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from statics' -l help
complete -c mafsil -n '__fish_seen_subcommand_from statics' -a 'body space tip arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a workspace -d 'reachable workspace of the tip: size with its error, bounds, voids, and a picture'
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l view
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l samples
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l cell
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l seed
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l model
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l base
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l json
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -l help
complete -c mafsil -n '__fish_seen_subcommand_from workspace' -a 'xyz xy xz yz radial arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a dh -d 'Denavit-Hartenberg table of a robot, modified and classic, with base and tool poses'
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l convention
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l radians
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l model
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l base
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l json
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from dh' -l help
complete -c mafsil -n '__fish_seen_subcommand_from dh' -a 'modified classic arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a derive -d 'derive formulas step by step: kinematics, Jacobian, inverse kinematics or equations of motion'
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l method
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l convention
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l format
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l out
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l model
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l base
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l json
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from derive' -l help
complete -c mafsil -n '__fish_seen_subcommand_from derive' -a 'fk jacobian ik dynamics dh screws modified classic text latex html arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a check-homework -d 'compare a Denavit-Hartenberg table, screw axes or a Jacobian with a robot, and name every mistake'
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l dh
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l screws
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l jacobian
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l convention
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l kind
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l q
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l letter
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l model
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l base
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l json
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -l help
complete -c mafsil -n '__fish_seen_subcommand_from check-homework' -a 'modified classic space body tip arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a convert -d 'convert a rotation or pose between all representations'
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l rpy
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l quaternion
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l matrix
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l axis-angle
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l euler
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l rotation-vector
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l gibbs
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l pose
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l exponential
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l screw
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l planar
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l position
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l all-sequences
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l project
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l json
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from convert' -l help
complete -c mafsil -n __fish_use_subcommand -a mobility -d 'mobility of a mechanism: Gruebler count, rank, finite mobility; redundant constraints, idle freedoms, actuation, Grashof type of four-bars'
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l q
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l rule
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l play
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l locked-joints
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l actuated
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l subsets
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l surfaces
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l json
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -l help
complete -c mafsil -n '__fish_seen_subcommand_from mobility' -a 'planar spherical spatial'
complete -c mafsil -n __fish_use_subcommand -a linkage -d 'links of a linkage and their lengths; --turn drives it once round: rates, accelerations, joint forces, motor effort, transmission angles'
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l turn
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l crank
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l speed
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l rows
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l out
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l json
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from linkage' -l help
complete -c mafsil -n __fish_use_subcommand -a parallel -d 'inverse and forward kinematics, singularities and forces of a parallel robot'
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l pose
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l motors
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l load
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l ways
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l json
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from parallel' -l help
complete -c mafsil -n __fish_use_subcommand -a synthesis -d 'synthesis of linkages for poses, points or a function: all solutions, circuits, branches, transmission angles'
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l candidate
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l cognates
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l json
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from synthesis' -l help
complete -c mafsil -n __fish_use_subcommand -a grasp -d 'force and form closure of a grasp with certificates, free motions, and contact forces for a load; or plan grasps of a mesh'
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l facets
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l steps
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l fingers
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l mu
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l gamma
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l opening
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l length
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l about
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l clearance
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l push
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l picture
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l json
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from grasp' -l help
complete -c mafsil -n __fish_use_subcommand -a lint -d 'report errors and doubtful values in a robot description, and write a corrected file'
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l fix
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l only
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l model
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l json
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from lint' -l help
complete -c mafsil -n '__fish_seen_subcommand_from lint' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a verify -d 'compare every quantity of a robot with independent methods'
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l against
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l states
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l seed
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l model
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l base
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l json
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from verify' -l help
complete -c mafsil -n '__fish_seen_subcommand_from verify' -a 'pinocchio mujoco arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a identify -d 'identify masses, inertias and friction from a log of motion and efforts, or the payload at the tip'
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l out
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l at-rest
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l rotor-inertia
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l validation
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l held-out
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l bandwidth
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l degrees
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l model
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l base
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l json
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from identify' -l help
complete -c mafsil -n '__fish_seen_subcommand_from identify' -a 'arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a export -d 'export a quantity of a robot as C with test vectors, object file, PTX or WebAssembly'
complete -c mafsil -n '__fish_seen_subcommand_from export' -l to
complete -c mafsil -n '__fish_seen_subcommand_from export' -l target
complete -c mafsil -n '__fish_seen_subcommand_from export' -l real
complete -c mafsil -n '__fish_seen_subcommand_from export' -l frame
complete -c mafsil -n '__fish_seen_subcommand_from export' -l function
complete -c mafsil -n '__fish_seen_subcommand_from export' -l out
complete -c mafsil -n '__fish_seen_subcommand_from export' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from export' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from export' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from export' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from export' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from export' -l model
complete -c mafsil -n '__fish_seen_subcommand_from export' -l base
complete -c mafsil -n '__fish_seen_subcommand_from export' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from export' -l json
complete -c mafsil -n '__fish_seen_subcommand_from export' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from export' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from export' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from export' -l help
complete -c mafsil -n '__fish_seen_subcommand_from export' -a 'c object ptx wasm page double float arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a trajectory -d 'motions in CSV files: check limits, suggest fixes, compare profiles, export to a controller'
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l out
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l rate
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l acceleration
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l jerk
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l curve
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l remedy
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l tip
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l driven
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l failed
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l lock
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l tool
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l payload
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l xacro-arg
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l model
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l base
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l gravity
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l json
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -l help
complete -c mafsil -n '__fish_seen_subcommand_from trajectory' -a 'check suggest-fixes compare export spline stops slower slower_leg stop leave_out arm6r cobra600 elbow6r fr3 generalized_puma iiwa7 offset_puma offset_stanford panda planar2r planar2r_point_masses planar3r puma560 rrprrr rrprrr_upright rrrp rv7flm scara_rrrp spatial3r stanford_arm ur10e ur3e ur5 ur5e'
complete -c mafsil -n __fish_use_subcommand -a completion -d 'print a tab-completion script for bash, zsh or fish'
complete -c mafsil -n '__fish_seen_subcommand_from completion' -l json
complete -c mafsil -n '__fish_seen_subcommand_from completion' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from completion' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from completion' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from completion' -l help
complete -c mafsil -n '__fish_seen_subcommand_from completion' -a 'bash zsh fish'
complete -c mafsil -n __fish_use_subcommand -a man -d 'print the manual page: mafsil man > mafsil.1'
complete -c mafsil -n '__fish_seen_subcommand_from man' -l json
complete -c mafsil -n '__fish_seen_subcommand_from man' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from man' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from man' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from man' -l help
complete -c mafsil -n __fish_use_subcommand -a info -d 'print versions, processor and cache, and test the compiled code'
complete -c mafsil -n '__fish_seen_subcommand_from info' -l export-check
complete -c mafsil -n '__fish_seen_subcommand_from info' -l build
complete -c mafsil -n '__fish_seen_subcommand_from info' -l json
complete -c mafsil -n '__fish_seen_subcommand_from info' -l lang
complete -c mafsil -n '__fish_seen_subcommand_from info' -l no-color
complete -c mafsil -n '__fish_seen_subcommand_from info' -l debug
complete -c mafsil -n '__fish_seen_subcommand_from info' -l help
