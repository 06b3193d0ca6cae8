from mafsil.kernels.export.exported import FORMS as FORMS
from mafsil.kernels.export.exported import Export as Export
from mafsil.kernels.export.exported import export as export
from mafsil.kernels.export.legend import Legend as Legend
from mafsil.kernels.export.object_file import Bundle as Bundle
from mafsil.kernels.export.object_file import bundle as bundle
