"""The program: `mafsil`, `python -m mafsil`, `python -m mafsil.cli`; one command, and out.

A process that has printed its answer and closed its files has nothing to tidy up: taking the objects of all modules
apart took a quarter of the time of a short command.
"""

import atexit
import gc
import os
import sys
import threading
from contextlib import suppress
from typing import NoReturn

from mafsil.cli.main import main

YOUNG = 50_000
"""Objects between two looks for circles of garbage: modules that are imported and grammars leave none."""


def program() -> NoReturn:
    """Run the command that was typed, and end the process with its exit code."""
    gc.set_threshold(YOUNG, *gc.get_threshold()[1:])
    code = main()
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join()
    atexit._run_exitfuncs()  # pyright: ignore[reportPrivateUsage] Python has no other name for it
    for stream in (sys.stdout, sys.stderr):
        with suppress(BrokenPipeError):  # The reader has gone: nothing is wrong.
            stream.flush()
    os._exit(code)


if __name__ == "__main__":
    program()
