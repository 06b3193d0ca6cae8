from mafsil.model.library.registry import close_names as close_names
from mafsil.model.library.registry import load as load
from mafsil.model.library.registry import names as names
