"""`python -m mafsil`."""

import sys

from mafsil.cli.main import main

sys.exit(main())
