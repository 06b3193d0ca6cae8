from mafsil.identification.excitation import ExcitationTrajectory as ExcitationTrajectory
from mafsil.identification.excitation import excitation_trajectory as excitation_trajectory
from mafsil.identification.identify import identify as identify
from mafsil.identification.log import MotionLog as MotionLog
from mafsil.identification.payload import Payload as Payload
from mafsil.identification.payload import estimate_payload as estimate_payload
from mafsil.identification.result import Identification as Identification
from mafsil.identification.smoothing import read_log as read_log
