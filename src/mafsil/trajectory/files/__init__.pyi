from mafsil.trajectory.files.csv_file import read as read
from mafsil.trajectory.files.exporting import TrajectoryFile as TrajectoryFile
from mafsil.trajectory.files.exporting import export as export
