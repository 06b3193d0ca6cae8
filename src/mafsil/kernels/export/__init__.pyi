from mafsil.kernels.export.exported import FORMS as FORMS
from mafsil.kernels.export.exported import Export as Export
from mafsil.kernels.export.exported import export as export
from mafsil.kernels.export.legend import Legend as Legend
from mafsil.kernels.export.objects.bundle import Bundle as Bundle
from mafsil.kernels.export.objects.bundle import bundle as bundle
