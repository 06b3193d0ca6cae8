"""One run of an arm that meets rigid surfaces: the general loop, and what the surfaces did at each tick."""

from __future__ import annotations

from mafsil.arrays import Floats, JointVector
from mafsil.control import tip_wrench_of
from mafsil.simulation.rigid_plant import RigidPlant
from mafsil.simulation.rigid_stepper import RigidStepper
from mafsil.simulation.run import Run
from mafsil.simulation.scenario import Scenario


class RigidRun(Run):
    """The run of a `RigidPlant`."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        assert isinstance(scenario.true_plant, RigidPlant)
        self.plant = scenario.true_plant
        self.held: list[tuple[int, ...]] = [()] * len(self.t)
        self._contacts.begin(*self.start)

    @property
    def _contacts(self) -> RigidStepper:
        assert isinstance(self.stepper, RigidStepper)
        return self.stepper

    def _acting(self, k: int, command: JointVector) -> JointVector:
        """The command; at each tick it is noted on what the tip is held."""
        self.held[k] = self._contacts.touching
        return command

    def _contact(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats:
        """(k, 6) what the surfaces and the environment exert on the tip."""
        wrench = self._contacts.forces(q, qd, tau, self._pushes(kept), self.held[kept])[1]
        environment = self.plant.environment
        return wrench if environment is None else wrench + tip_wrench_of(self.plant.robot, environment, q, qd)

    def _accelerations(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats:
        return self._contacts.forces(q, qd, tau, self._pushes(kept), self.held[kept])[0]

    def metadata(self) -> dict[str, object]:
        """What one needs to know besides the numbers, with what the surfaces did so far."""
        return super().metadata() | {"rigid_contact": self._contacts.events.to_dict()}
