"""What reports and pages draw: a robot as solids in Python, and the scripts that show solids in a browser."""

from mafsil.scene.drawing import Drawing as Drawing
from mafsil.scene.drawing import compact as compact
from mafsil.scene.modules import Source as Source
from mafsil.scene.modules import one_script as one_script
from mafsil.scene.solids import Body as Body
from mafsil.scene.solids import Colour as Colour
from mafsil.scene.solids import Solid as Solid
from mafsil.scene.solids import as_data as as_data
from mafsil.scene.solids import packed as packed
