from mafsil.model.lint.finding import FAULTS as FAULTS
from mafsil.model.lint.linting import findings as findings
from mafsil.model.lint.linting import lint as lint
from mafsil.model.lint.linting import repair as repair
