from mafsil.kernels.batch import Evaluator as Evaluator
from mafsil.kernels.identity import fingerprint as fingerprint
from mafsil.kernels.kernel import Kernel as Kernel
from mafsil.kernels.kernel import compile as compile
from mafsil.kernels.kernel import warm as warm
from mafsil.kernels.layout import Port as Port
from mafsil.kernels.layout import Signature as Signature
from mafsil.kernels.provenance import Provenance as Provenance
