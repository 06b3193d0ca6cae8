from mafsil.model.library.registry import close_names as close_names
from mafsil.model.library.registry import library_name as library_name
from mafsil.model.library.registry import load as load
from mafsil.model.library.registry import robots as robots
from mafsil.model.library.registry import same_letters as same_letters
