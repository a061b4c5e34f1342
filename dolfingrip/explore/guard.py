"""Who is let in: requests to this server's name, from its own pages, with its token."""

from __future__ import annotations

import hmac
import os
import secrets
from http.cookies import SimpleCookie
from pathlib import Path
from typing import Final
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

LOOPBACK: Final = ("127.0.0.1", "localhost", "::1")

HEADERS: Final = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}
"""Of every answer."""


def token(folder: Path) -> str:
    """The token of a folder, made at the first call; nobody else may read it.

    A server that is started again lets in the tabs of the one before.
    """
    file = folder / "token"
    folder.mkdir(parents=True, exist_ok=True)
    try:
        known = file.read_text(encoding="ascii").strip()
        if len(known) >= 32 and not file.stat().st_mode & 0o077:
            return known
        file.unlink()
    except (FileNotFoundError, ValueError):
        pass
    found = secrets.token_urlsafe(32)
    handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(handle, "w", encoding="ascii") as stream:
        stream.write(found)
    return found


class Guard:
    """Lets nobody in without the token, and no page of another origin.

    A request to ``/?token=…`` gets the token as a cookie, whose name has the port, since browsers
    share cookies between ports.

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
            answer = RedirectResponse("/", 303, HEADERS)
            answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict", path="/")
            return answer
        cookies: SimpleCookie = SimpleCookie()
        cookies.load(headers.get("cookie", ""))
        found = cookies.get(self._cookie)
        if found is None or not self._right(found.value):
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
