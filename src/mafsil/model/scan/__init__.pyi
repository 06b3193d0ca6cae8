from mafsil.model.scan.reader import ScanLimits as ScanLimits
from mafsil.model.scan.reader import read_heights as read_heights
from mafsil.model.scan.reader import read_points as read_points
