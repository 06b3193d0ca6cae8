"""Pictures in files, by matplotlib: imported at the first picture."""

from mafsil.figures.animation import save_exponentials_animation as save_exponentials_animation
from mafsil.figures.animation import save_row_animation as save_row_animation
from mafsil.figures.configurations import save_configurations as save_configurations
from mafsil.figures.dh_frames import save_dh_frames as save_dh_frames
from mafsil.figures.dh_frames import save_link_motions as save_link_motions
from mafsil.figures.frames import save_frame_graph as save_frame_graph
from mafsil.figures.frames import save_frames as save_frames
from mafsil.figures.frames import save_rotation as save_rotation
from mafsil.figures.gimbals import save_gimbals as save_gimbals
from mafsil.figures.mechanism import save_mechanism as save_mechanism
from mafsil.figures.motion import save_motion as save_motion
from mafsil.figures.motion_over_time import save_trajectory as save_trajectory
from mafsil.figures.moving_body import save_displaced_body as save_displaced_body
from mafsil.figures.moving_body import save_solid_ball as save_solid_ball
from mafsil.figures.moving_body import save_space_velocity as save_space_velocity
from mafsil.figures.moving_body import save_two_frames as save_two_frames
from mafsil.figures.newton_tangents import save_newton_tangents as save_newton_tangents
from mafsil.figures.path_difficulties import save_path_difficulties as save_path_difficulties
from mafsil.figures.phase_plane import save_phase_plane as save_phase_plane
from mafsil.figures.pole import save_pole as save_pole
from mafsil.figures.profiles import save_profiles as save_profiles
from mafsil.figures.screw_motion import save_screw_motion as save_screw_motion
from mafsil.figures.velocity_and_force import save_free_bodies as save_free_bodies
from mafsil.figures.velocity_and_force import save_joint_screws as save_joint_screws
from mafsil.figures.velocity_and_force import save_unreachable_frame as save_unreachable_frame
