# Made by docs/make_robot_stub.py from the files of mechanics/quantities.
from inspect import Signature
from typing import Any

from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism

def signature_of(row: Quantity) -> Signature: ...

class Routine(lazy[Any]):
    row: Quantity
    def __init__(self, row: Quantity) -> None: ...

class Motionless:
    def __init__(self, mechanism: Mechanism, name: str) -> None: ...
    def __call__(self, q: ArrayLike, *, frame: str | None = None, out: Floats | None = None) -> Floats: ...

class Routines:
    def centroidal_momentum_matrix(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Centroidal momentum matrix: (k, l) = A qd, about the centre of mass of all that the joints carry.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            A (*batch, 6, n) [kg m^2 | kg m, kg m | kg], expressed in the axes of {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013
        """

    def centroidal_momentum(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Momentum of the robot, angular first, about the centre of mass of all that the joints carry.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            (k, l) (*batch, 6) [N m s, N s], expressed in the axes of {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013
        """

    def centroidal_momentum_rate(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Time derivative of the momentum about the centre of mass: the wrench that everything outside exerts.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            d(k, l)/dt (*batch, 6) [N m, N], expressed in the axes of {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013
        """

    def center_of_mass(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Centre of mass of all that the joints carry.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            p_sc (*batch, 3) [m], expressed in {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013, eq. 20
        """

    def com_jacobian(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Jacobian of the centre of mass: dp_sc/dt = J_com qd.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            J_com (*batch, 3, n) [m | 1], expressed in {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013
        """

    def coriolis_matrix(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Coriolis matrix of the Christoffel symbols: C qd = c, dM/dt - 2 C skew.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            C (*batch, n, n) [N m s | N s].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1.3, prop. 8.1
        """

    def christoffel_symbols(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Christoffel symbols of the first kind: c_i = sum of Gamma_ijk qd_j qd_k.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            Gamma (*batch, n, n, n) [kg m^2 | kg m | kg].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.12
        """

    def centrifugal_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Centrifugal efforts: the sum of Gamma_ijj qd_j^2.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            c_centrifugal (*batch, n) [N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1.1
        """

    def coriolis_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Coriolis efforts: the sum of 2 Gamma_ijk qd_j qd_k over j < k.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            c_Coriolis (*batch, n) [N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1.1
        """

    def inverse_dynamics_derivatives(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Derivatives of inverse dynamics, in closed form: [0] by q, [1] by qd, [2] by qdd, the mass matrix.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            dtau/d(q, qd, qdd) (*batch, 3, n, n) [N m | N per rad | m, and per s, s^2].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Singh, Wensing, Echeandia 2022
        """

    def forward_dynamics_derivatives(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        tau: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Derivatives of forward dynamics, in closed form: [0] by q, [1] by qd, [2] by tau, the inverse mass matrix.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            tau: (*batch, n) joint efforts [N m | N].
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            dqdd/d(q, qd, tau) (*batch, 3, n, n) [rad/s^2 | m/s^2 per rad | m, per their rates, per N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Carpentier & Mansard 2018
        """

    def kinetic_energy(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Kinetic energy of all links and armatures.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            K (*batch) [J].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1.3
        """

    def potential_energy(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Potential energy of all links in gravity; zero height at the origin of {s}.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            P (*batch) [J].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1
        """

    def lagrange_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Joint efforts of a motion from the energies, by Lagrange's equations: a second `inverse_dynamics`.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            tau (*batch, n) [N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1.2
        """

    def mass_matrix(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Mass matrix, symmetric: kinetic energy qd' M qd / 2.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            M (*batch, n, n) [kg m^2 | kg m | kg].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 6.2
        """

    def forward_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        tau: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Joint accelerations that efforts produce: M qdd = tau - c - g - J' F_tip.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            tau: (*batch, n) joint efforts [N m | N].
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            qdd (*batch, n) [rad/s^2 | m/s^2].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 6.5 and 7.3
        """

    def inverse_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Joint efforts that produce a motion: tau = M qdd + c + g + J' F_tip.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            base_acceleration: (*batch, 6) time derivative of the base's twist, without gravity; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            tau (*batch, n) [N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Luh, Walker, Paul 1980; Lynch & Park, Modern Robotics, sec. 8.3
        """

    def velocity_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Centrifugal and Coriolis efforts c(q, qd).

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            c (*batch, n) [N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1
        """

    def gravity_torque(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Efforts g(q) that hold the robot still against gravity.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            g (*batch, n) [N m | N].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.1
        """

    def regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Efforts per inertial parameter of each link (m, h, Ixx, Iyy, Izz, Ixy, Ixz, Iyz), in the links' frames.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            Y (*batch, n, L, 10) [m/s^2, 1/s^2 and so on].

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Atkeson, An & Hollerbach 1986
        """

    def payload_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Efforts per inertial parameter of a body fixed to the tip frame, or to a named link's frame.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            frame: name of the link whose frame is meant; the tip frame if None.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            Y_f (*batch, n, 10) [m/s^2, 1/s^2 and so on], expressed in the frame itself.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Atkeson, An & Hollerbach 1986
        """

    def forward_kinematics(
        self,
        q: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Pose of the tip frame, or of a named link's frame, in the space frame {s}.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            frame: name of the link whose frame is meant; the tip frame if None.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            T_sf (*batch, 4, 4) [1, m], expressed in {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 4.1
        """

    def link_poses(
        self,
        q: ArrayLike,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Poses of all links in the space frame {s}, in the order of `mechanism.links`.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            T_sl (*batch, L, 4, 4) [1, m], expressed in {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 4.1
        """

    def jacobian_space(
        self,
        q: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Space Jacobian: V_s = J_s qd, rows (omega, v).

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            frame: name of the link whose frame is meant; the tip frame if None.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            J_s (*batch, 6, n) [1 | m], expressed in {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, def. 5.1
        """

    def jacobian_body(
        self,
        q: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Body Jacobian: V_b = J_b qd, rows (omega, v).

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            frame: name of the link whose frame is meant; the tip frame if None.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            J_b (*batch, 6, n) [1 | m], expressed in the frame itself.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, def. 5.2
        """

    def jacobian_space_rate(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Time derivative of the space Jacobian: dV_s/dt = J_s qdd + dJ_s/dt qd.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            frame: name of the link whose frame is meant; the tip frame if None.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            dJ_s/dt (*batch, 6, n) [1/s | m/s], expressed in {s}.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.6
        """

    def jacobian_body_rate(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Time derivative of the body Jacobian: dV_b/dt = J_b qdd + dJ_b/dt qd.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            frame: name of the link whose frame is meant; the tip frame if None.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            dJ_b/dt (*batch, 6, n) [1/s | m/s], expressed in the frame itself.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, sec. 8.6
        """

    def link_twists(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        base_twist: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Body twists of all links, each in its own frame, in the order of `mechanism.links`.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            V_l (*batch, L, 6) [rad/s, m/s], expressed in the links' frames.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.50
        """

    def link_accelerations(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Time derivatives of the body twists of all links, gravity given back, each in its own frame.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            base_acceleration: (*batch, 6) time derivative of the base's twist, without gravity; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            dV_l/dt (*batch, L, 6) [rad/s^2, m/s^2], expressed in the links' frames.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.51
        """

    def com_twists(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        base_twist: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Twists of all links in frames at their centres of mass, parallel to {s} at zero coordinates.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            V_i (*batch, L, 6) [rad/s, m/s], expressed in frames at the centres of mass.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.50
        """

    def com_accelerations(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Time derivatives of the twists at the centres of mass, gravity given back.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            base_acceleration: (*batch, 6) time derivative of the base's twist, without gravity; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            dV_i/dt (*batch, L, 6) [rad/s^2, m/s^2], expressed in frames at the centres of mass.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.51
        """

    def link_wrenches(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Wrenches that each link gets from the one before (the first from the ground), through any joint.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            base_acceleration: (*batch, 6) time derivative of the base's twist, without gravity; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            F_l (*batch, L, 6) [N m, N], expressed in the links' frames.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.53
        """

    def com_wrenches(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """Wrenches as `link_wrenches`, at the centres of mass, in axes parallel to {s} at zero coordinates.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            qd: (*batch, n) joint rates [rad/s | m/s].
            qdd: (*batch, n) joint accelerations [rad/s^2 | m/s^2].
            tip_wrench: (*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.
            base_twist: (*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.
            base_acceleration: (*batch, 6) time derivative of the base's twist, without gravity; optional.
            out: array for the result.
            threads: how many threads share a large batch; all cores if None.
            degrees: joint coordinates, rates and accelerations are given in degrees; all else stays SI.

        Returns:
            F_i (*batch, L, 6) [N m, N], expressed in frames at the centres of mass.

        Raises:
            InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.

        Reference: Lynch & Park, Modern Robotics, eq. 8.53
        """
