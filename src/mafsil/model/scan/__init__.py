"""Files of scanners and cameras: points, and heights on a grid."""

from mafsil.model.scan.reader import ScanLimits, read_heights, read_points

__all__ = ["ScanLimits", "read_heights", "read_points"]
