"""Singular configurations: whether, what is lost, why, and where all of them lie."""

from mafsil.performance.singularities.axis_cases import SingularityCause as SingularityCause
from mafsil.performance.singularities.determinant import DeterminantFactors as DeterminantFactors
from mafsil.performance.singularities.determinant import Factor as Factor
from mafsil.performance.singularities.determinant import determinant_factors as determinant_factors
from mafsil.performance.singularities.determinant import natural_task as natural_task
from mafsil.performance.singularities.locus import LocusComponent as LocusComponent
from mafsil.performance.singularities.locus import SingularityLocus as SingularityLocus
from mafsil.performance.singularities.locus import singularity_locus as singularity_locus
from mafsil.performance.singularities.screw_parameters import ScrewParameters as ScrewParameters
from mafsil.performance.singularities.screw_parameters import twist_screw as twist_screw
from mafsil.performance.singularities.screw_parameters import wrench_screw as wrench_screw
from mafsil.performance.singularities.screw_rank import ScrewRank as ScrewRank
from mafsil.performance.singularities.screw_rank import rank_of_screws as rank_of_screws
from mafsil.performance.singularities.singular_configuration import Singularity as Singularity
from mafsil.performance.singularities.singular_configuration import default_task as default_task
from mafsil.performance.singularities.singular_configuration import generic_rank as generic_rank
from mafsil.performance.singularities.singular_configuration import is_singular as is_singular
from mafsil.performance.singularities.singular_configuration import rank as rank
from mafsil.performance.singularities.singular_configuration import singular_values as singular_values
from mafsil.performance.singularities.singular_configuration import singularity as singularity
from mafsil.performance.singularities.singular_configuration import verdict_in_doubt as verdict_in_doubt
