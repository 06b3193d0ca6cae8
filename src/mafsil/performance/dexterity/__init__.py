"""How well an arm moves and pushes at a configuration: ellipsoids, measures, directions, isotropy."""

from mafsil.performance.dexterity.directions import largest_speed as largest_speed
from mafsil.performance.dexterity.directions import least_joint_rate as least_joint_rate
from mafsil.performance.dexterity.directions import torque_along as torque_along
from mafsil.performance.dexterity.isotropy import IsotropySearch as IsotropySearch
from mafsil.performance.dexterity.isotropy import isotropic_configurations as isotropic_configurations
from mafsil.performance.dexterity.manipulability import Ellipsoid as Ellipsoid
from mafsil.performance.dexterity.manipulability import PlanarEllipse as PlanarEllipse
from mafsil.performance.dexterity.manipulability import ellipsoid_of as ellipsoid_of
from mafsil.performance.dexterity.manipulability import force_ellipsoid as force_ellipsoid
from mafsil.performance.dexterity.manipulability import jacobian_hessian as jacobian_hessian
from mafsil.performance.dexterity.manipulability import manipulability as manipulability
from mafsil.performance.dexterity.manipulability import manipulability_gradient as manipulability_gradient
from mafsil.performance.dexterity.manipulability import planar_ellipse as planar_ellipse
from mafsil.performance.dexterity.manipulability import velocity_ellipsoid as velocity_ellipsoid
