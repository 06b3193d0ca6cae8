"""Who may speak with the server: pages that it has served itself, under a token that nobody can guess.

A page of another site can make the browser send requests here, but it cannot read the token; a name that was bent to
this machine (DNS rebinding) arrives under a foreign Host.
"""

from __future__ import annotations

import hmac
import secrets
from dataclasses import dataclass, field
from email.message import Message

TOKEN_BYTES = 24
_LOCAL = ("127.0.0.1", "localhost")
_ONCE = ("Host", "Origin", "Sec-Fetch-Site", "Content-Length", "Content-Type", "Transfer-Encoding")
"""Headers that decide something: given twice, two readers of a request may each believe another one."""


@dataclass(frozen=True)
class Access:
    """What a request has to bring.

    Attributes:
        port: at which the server listens.
        token: first part of every path.
    """

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_BYTES), repr=False)

    def path(self, target: str) -> str | None:
        """What is asked for behind the token; None if the token is missing or wrong.

        Args:
            target: of the request, such as `/<token>/events`.
        """
        given, _, rest = target.partition("?")[0].removeprefix("/").partition("/")
        right = hmac.compare_digest(given.encode("utf-8", "replace"), self.token.encode())
        return rest if right else None

    def from_here(self, headers: Message, *, changes: bool) -> bool:
        """Whether a request is for this server and comes from one of its own pages.

        Args:
            headers: of the request.
            changes: it is more than a look: then its origin must be said.
        """
        if any(len(headers.get_all(name) or ()) > 1 for name in _ONCE):
            return False
        hosts = [f"{name}:{self.port}" for name in _LOCAL]
        host = headers.get("Host", "").lower()
        if host not in hosts:
            return False
        origins = headers.get_all("Origin") or []
        if origins != [f"http://{host}"] and (changes or origins):
            return False
        return headers.get("Sec-Fetch-Site", "none") in ("same-origin", "none")
