"""Who is let in: requests to this server's name, from its own pages, with its token, in time.

The address has the token, so it stands neither in the folder of results, which may be sent to
others, nor in the browser's command line, which every user of the machine can read: a browser gets
it by a file that its user alone may read.
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import html
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from dolfingrip.files import whole
from dolfingrip.sections.private import cache_folder
from dolfingrip.serving.policy import POLICY, ServingPolicy


@dataclass(frozen=True, slots=True)
class Handover:
    """The file of the server whose results are in a folder.

    Attributes:
        file: HTML that leads to the address.
    """

    file: Path

    @staticmethod
    def of(results: Path) -> Handover:
        """The file for a folder of results.

        Args:
            results: the folder.

        Raises:
            ConfigError: one line, where another user could write to the cache.
        """
        name = hashlib.sha256(os.fsencode(results.resolve())).hexdigest()[:16]
        return Handover(cache_folder("dolfingrip", "explore") / f"{name}.html")

    def write(self, address: str) -> None:
        """Lead to an address.

        Args:
            address: of the server, with the token.

        Raises:
            WriteError: one line.
        """
        whole.write(self.file, leading_to(address), mode=0o600)

    def before(self) -> tuple[int, str] | None:
        """Port and token of the server that wrote the file last; None if none did."""
        try:
            text = self.file.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        match = re.search(r'href="http://[^/"]+:(\d+)/\?token=([\w-]{32,})"', text)
        return (int(match[1]), match[2]) if match else None


def leading_to(address: str) -> str:
    """An HTML page that leads to an address.

    Args:
        address: of a page, absolute or on the same server.
    """
    shown = html.escape(address)
    return (
        '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">'
        f'<meta http-equiv="refresh" content="0;url={shown}"><title>dolfingrip</title>'
        f'<a href="{shown}">the page</a>\n'
    )


LOOPBACK: Final = ("127.0.0.1", "localhost", "::1")

HEADERS: Final = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}
"""Of every answer."""


class Guard:
    """Lets nobody in without the token, and no page of another origin.

    A request to ``/?token=…`` gets the token as a cookie, and a page that leads on. The cookie's
    name has the port, since browsers share cookies between ports.

    Args:
        app: what is guarded.
        token: random text.
        port: of the server.
        hosts: names of this server; None: any, as on an address that is not loopback.
    """

    def __init__(self, app: ASGIApp, token: str, port: int, hosts: tuple[str, ...] | None) -> None:
        self._app, self._token = app, token
        self._cookie = f"dolfingrip-{port}"
        self._hosts = hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or pass on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refused = self._refused(scope)
        if refused is None:
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await refused(scope, receive, send)
        else:
            await receive()  # the connection that is refused, which the server answers by 403
            await send({"type": "websocket.close", "code": 1008})

    def _refused(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if self._hosts is not None and _name(host) not in self._hosts:
            return PlainTextResponse("another host", 400, HEADERS)
        origin = headers.get("origin")
        needed = scope["type"] == "websocket" or scope.get("method") not in ("GET", "HEAD")
        if (origin is not None or needed) and origin != f"http://{host}":
            return PlainTextResponse("another origin", 403, HEADERS)
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if scope["type"] == "http" and scope["path"] == "/" and given:
            if not self._right(given):
                return PlainTextResponse("another token", 403, HEADERS)
            # no redirect: where the browser comes from a file, it would keep the cookie back
            answer = HTMLResponse(leading_to("/"), 200, HEADERS)
            answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict", path="/")
            return answer
        if not self._right(cookie_parser(headers.get("cookie", "")).get(self._cookie, "")):
            text = "no token: open the address that dolfingrip printed"
            return PlainTextResponse(text, 403, HEADERS)
        return None

    def _right(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self._token.encode())


def _name(host: str) -> str:
    """The name in a Host header, without the port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


class Patience(H11Protocol):
    """An HTTP connection that is ended where its request does not arrive.

    The newest may always come: where too many wait, the one that has waited longest is ended.

    Args:
        given: uvicorn's own.
        policy: how many may wait, and how long.
        more: uvicorn's own.
    """

    def __init__(self, *given: Any, policy: ServingPolicy = POLICY, **more: Any) -> None:
        super().__init__(*given, **more)
        self._policy = policy

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take up a connection."""
        super().connection_made(transport)
        self._since = self.loop.time()
        waiting = [c for c in self.connections if isinstance(c, Patience) and c.half_open]
        if len(waiting) > self._policy.half_open:
            min(waiting, key=lambda c: c._since).transport.abort()
        self.loop.call_later(self._policy.request_s, self._look)

    @property
    def half_open(self) -> bool:
        """True where a request has begun, or is the first to come, and has not arrived."""
        cycle: Any = self.cycle
        if cycle is None:
            return True
        return bool(cycle.response_complete) and self.timeout_keep_alive_task is None

    def _look(self) -> None:
        if self not in self.connections:  # it has ended, or is a websocket
            return
        if self.half_open:
            self.transport.abort()
        else:
            self.loop.call_later(self._policy.request_s, self._look)
