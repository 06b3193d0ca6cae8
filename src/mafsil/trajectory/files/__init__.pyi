from mafsil.trajectory.files.csv_file import read_trajectory as read_trajectory
from mafsil.trajectory.files.exporting import TrajectoryFile as TrajectoryFile
from mafsil.trajectory.files.exporting import export as export
