"""Numbers only: iterations, integrators and their honest outcomes; no robot."""

from mafsil.solvers.adaptive import Budget as Budget
from mafsil.solvers.adaptive import Tolerance as Tolerance
from mafsil.solvers.adaptive import integrate_adaptively as integrate_adaptively
from mafsil.solvers.embedded import EmbeddedPair as EmbeddedPair
from mafsil.solvers.events import Event as Event
from mafsil.solvers.integrate import first_order as first_order
from mafsil.solvers.integrate import integrate as integrate
from mafsil.solvers.integrate import second_order as second_order
from mafsil.solvers.least_squares import damped_step as damped_step
from mafsil.solvers.least_squares import levenberg_marquardt as levenberg_marquardt
from mafsil.solvers.outcome import Outcome as Outcome
from mafsil.solvers.outcome import SolverStatus as SolverStatus
from mafsil.solvers.pairs import PAIRS as PAIRS
from mafsil.solvers.pairs import pair as pair
from mafsil.solvers.solution import Crossing as Crossing
from mafsil.solvers.solution import IntegrationStatus as IntegrationStatus
from mafsil.solvers.solution import Solution as Solution
from mafsil.solvers.tableaus import METHODS as METHODS
from mafsil.solvers.tableaus import Method as Method
from mafsil.solvers.tableaus import Splitting as Splitting
from mafsil.solvers.tableaus import Tableau as Tableau
from mafsil.solvers.tableaus import method as method
