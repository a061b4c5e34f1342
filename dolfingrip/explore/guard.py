"""Who is let in: requests to this server's name, from its own pages, with its token."""

from __future__ import annotations

import hmac
from typing import Final
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from dolfingrip.explore.handover import leading_to

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
            text = "no token: open the address that dolfingrip explore printed"
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
