from mafsil.studio.studio import Studio as Studio
