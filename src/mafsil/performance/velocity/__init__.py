"""Velocities of the tip from rates of the joints: Jacobians of frames, points and tasks, with units and without."""

from mafsil.performance.velocity.jacobians import analytic_jacobian as analytic_jacobian
from mafsil.performance.velocity.jacobians import body_from_space as body_from_space
from mafsil.performance.velocity.jacobians import jacobian_by_inspection as jacobian_by_inspection
from mafsil.performance.velocity.jacobians import joint_twists as joint_twists
from mafsil.performance.velocity.jacobians import point_velocity as point_velocity
from mafsil.performance.velocity.jacobians import space_from_body as space_from_body
from mafsil.performance.velocity.jacobians import symbolic_jacobian_by_inspection as symbolic_jacobian_by_inspection
from mafsil.performance.velocity.jacobians import tool_jacobian as tool_jacobian
from mafsil.performance.velocity.scaling import TOLERANCE as TOLERANCE
from mafsil.performance.velocity.scaling import characteristic_length as characteristic_length
from mafsil.performance.velocity.scaling import scaled_jacobian as scaled_jacobian
from mafsil.performance.velocity.tasks import TASKS as TASKS
from mafsil.performance.velocity.tasks import task_coordinates as task_coordinates
from mafsil.performance.velocity.tasks import task_jacobian as task_jacobian
from mafsil.performance.velocity.tasks import task_rows as task_rows
