from mafsil.model.xacro.expansion import expand as expand
from mafsil.model.xacro.expansion import is_xacro as is_xacro
from mafsil.model.xacro.expansion import left_over as left_over
