"""`python -m mafsil.cli`."""

import sys

from mafsil.cli.main import main

sys.exit(main())
