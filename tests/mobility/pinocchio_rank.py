"""Mobility of a linkage as drawn by Pinocchio: a tree of joints, a rigid constraint at each closing joint."""

import numpy as np
import pinocchio as pin

from mafsil import mobility as mo


class PinocchioLinkage:
    """Model and constraints of a linkage whose joints are split into those of one freedom."""

    def __init__(self, linkage):
        fine = mo.linkages.split_joints(linkage)
        self.model, self.where = pin.Model(), {fine.ground: (0, np.zeros(3))}
        for k, forward in fine.tree:
            each = fine.joints[k]
            parent, child = (each.parent, each.child) if forward else (each.child, each.parent)
            self.where[child] = self._add(parent, each, 1.0 if forward else -1.0)
        ends = []
        for k in fine.closing:
            each = fine.joints[k]
            index, origin = self._add(each.parent, each, 1.0)
            other, other_origin = self.where[each.child]
            ends.append((index, pin.SE3.Identity(), other, pin.SE3(np.eye(3), origin - other_origin)))
        self.columns = [int(fine.columns_of([name])[0]) for name in list(self.model.names)[1:]]
        rigid, local = pin.ContactType.CONTACT_6D, pin.ReferenceFrame.LOCAL
        self.constraints = [pin.RigidConstraintModel(rigid, self.model, *given, local) for given in ends]
        self.data = self.model.createData()
        self.constraint_data = [one.createData() for one in self.constraints]

    def _add(self, parent, each, sense):
        above, origin = self.where[parent]
        axis = sense * each.axis
        kind = {
            mo.linkages.Kind.REVOLUTE: lambda: pin.JointModelRevoluteUnaligned(axis),
            mo.linkages.Kind.PRISMATIC: lambda: pin.JointModelPrismaticUnaligned(axis),
            mo.linkages.Kind.HELICAL: lambda: pin.JointModelHelicalUnaligned(axis, each.pitch),
        }[each.kind]()
        return self.model.addJoint(above, kind, pin.SE3(np.eye(3), each.point - origin), each.name), each.point

    def configuration(self, theta):
        """Coordinates in the order of Pinocchio's joints, of those of the linkage, which `split_joints` leaves."""
        return np.asarray(theta, dtype=float)[self.columns]

    def jacobian(self, q=None):
        """Of all constraints, at coordinates in the order of Pinocchio's joints; as drawn if None."""
        pin.computeJointJacobians(self.model, self.data, pin.neutral(self.model) if q is None else q)
        pairs = zip(self.constraints, self.constraint_data, strict=True)
        return np.vstack([pin.getConstraintJacobian(self.model, self.data, m, d) for m, d in pairs])

    def mobility(self, q=None):
        """Freedoms minus rank."""
        if not self.constraints:
            return self.model.nv
        s = np.linalg.svd(self.jacobian(q), compute_uv=False)
        return self.model.nv - int((s > 1e-9 * s[0]).sum())
