from mafsil import verbs

class Verbs:
    derive = verbs.derive
    fk = verbs.fk
    ik = verbs.ik
    ik_all = verbs.ik_all
    jacobian = verbs.jacobian
    plan = verbs.plan
    plot = verbs.plot
    show = verbs.show
    simulate = verbs.simulate
    singularity = verbs.singularity
    verify = verbs.verify
    workspace = verbs.workspace
