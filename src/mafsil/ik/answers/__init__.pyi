from mafsil.ik.answers.batch import SolutionBatch as SolutionBatch
from mafsil.ik.answers.branch import Branch as Branch
from mafsil.ik.answers.pose_question import LimitExcess as LimitExcess
from mafsil.ik.answers.pose_question import SolutionFamily as SolutionFamily
from mafsil.ik.answers.solution_set import SolutionSet as SolutionSet
