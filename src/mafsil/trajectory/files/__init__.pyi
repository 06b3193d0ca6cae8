from mafsil.trajectory.files.exporting import TrajectoryFile as TrajectoryFile
from mafsil.trajectory.files.exporting import export as export
from mafsil.trajectory.files.exporting import read_trajectory as read_trajectory
