from mafsil.job.language.cells import fill_variables as fill_variables
from mafsil.job.language.cells import with_cells as with_cells
from mafsil.job.language.resolving import resolve as resolve
from mafsil.job.language.statements import JobFile as JobFile
from mafsil.job.language.table_checks import require_signals as require_signals
from mafsil.job.language.units import in_si as in_si
