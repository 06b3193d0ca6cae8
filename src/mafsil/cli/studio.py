"""`mafsil studio`: a robot, a job or recordings on a page that Python serves to this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.cli.answer import Answer
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say

if TYPE_CHECKING:
    import mafsil.studio.opening as opening
else:
    opening = lazily("mafsil.studio.opening")

LARGEST_PORT = 65535


def studio(what: list[str], port: str | None, open: bool, view: list[str] | None = None) -> Answer:
    """Serve until Ctrl-C.

    Args:
        what: a robot, a job file, or one or more recordings; the default robot if empty.
        port: at which to listen; any that is free if None.
        open: show the page in the browser.
        view: files with views of your own.

    Raises:
        MafsilError: what is given cannot be read, or the port is no port or is taken.
    """
    with opening.studio_of(what, _port(port), view or ()) as served:
        print(say("cli.studio_address", address=served.address), say("cli.studio_leave"), sep="\n", flush=True)
        served.serve(show=open)
    return Answer()


def _port(text: str | None) -> int:
    if text is None:
        return 0
    if not (text.isascii() and text.isdigit() and len(text) <= len(str(LARGEST_PORT))) or int(text) > LARGEST_PORT:
        raise InputError("studio.port", value=text, most=LARGEST_PORT)
    return int(text)
