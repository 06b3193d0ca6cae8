"""The robot as immutable data, and what makes it: readers and writers of files, tables, mass properties, lint."""

from mafsil.model.actuator import Actuator as Actuator
from mafsil.model.actuator import Friction as Friction
from mafsil.model.denavit_hartenberg import Convention as Convention
from mafsil.model.denavit_hartenberg import DHRow as DHRow
from mafsil.model.denavit_hartenberg import mechanism_from_dh as mechanism_from_dh
from mafsil.model.exponentials import Screws as Screws
from mafsil.model.exponentials import mechanism_from_screws as mechanism_from_screws
from mafsil.model.exponentials import screws as screws
from mafsil.model.joint import Joint as Joint
from mafsil.model.joint import JointKind as JointKind
from mafsil.model.joint import Mimic as Mimic
from mafsil.model.limits import Limits as Limits
from mafsil.model.link import Inertial as Inertial
from mafsil.model.link import Link as Link
from mafsil.model.loop_file import with_loops as with_loops
from mafsil.model.mechanism import JointLimits as JointLimits
from mafsil.model.mechanism import Mechanism as Mechanism
from mafsil.model.mechanism import Provenance as Provenance
from mafsil.model.shape import Box as Box
from mafsil.model.shape import Capsule as Capsule
from mafsil.model.shape import Cylinder as Cylinder
from mafsil.model.shape import Mesh as Mesh
from mafsil.model.shape import Shape as Shape
from mafsil.model.shape import Sphere as Sphere
from mafsil.model.skeleton import with_skeleton as with_skeleton
