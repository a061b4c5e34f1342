"""Dots that a person clicks on the first frame, in the browser."""

from __future__ import annotations

import base64
import json
import secrets
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import uvicorn
from markupsafe import Markup
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from dolfingrip.report.page.html import content_policy, templates
from dolfingrip.sections.errors import ConfigError
from dolfingrip.serving.guard import HEADERS, LOOPBACK, Guard
from dolfingrip.serving.listening import announced, bound, server_settings
from dolfingrip.serving.policy import POLICY
from dolfingrip.tracking.frames import Frame, Image

LEAST: Final = 3
MOST: Final = 200
"""Numbers of dots that can be followed."""


def pick(frame: Frame, name: str, say: Callable[[str], None]) -> np.ndarray:
    """Let a person click dots, and wait until that is done.

    Args:
        frame: the first one.
        name: of the video or picture.
        say: called with the address to open.

    Returns:
        Places (n, 2) in px.

    Raises:
        ConfigError: one line, where no port is free, or it was ended before dots were clicked.
    """
    listening = bound(LOOPBACK[0], None)
    return clicked(frame.image, name, listening, secrets.token_urlsafe(32), say)


def clicked(
    image: Image, name: str, listening: socket.socket, token: str, say: Callable[[str], None]
) -> np.ndarray:
    """Serve the page at a socket until dots are clicked; see :func:`pick`.

    Args:
        image: the first frame.
        name: of the video or picture.
        listening: from :func:`~dolfingrip.serving.listening.bound`.
        token: that the page must have.
        say: called with the address to open.
    """
    picked: list[np.ndarray] = []

    def take(places_px: np.ndarray) -> None:
        picked.append(places_px)
        server.should_exit = True

    port = announced(listening, LOOPBACK[0], token, say)
    server = uvicorn.Server(server_settings(application(image, name, token, port, take)))
    try:
        server.run(sockets=[listening])
    except KeyboardInterrupt:
        picked.clear()
    if not picked:
        raise ConfigError("--pick: ended before dots were clicked; allowed: --points, or none")
    return picked[0]


def application(
    image: Image, name: str, token: str, port: int, take: Callable[[np.ndarray], None]
) -> ASGIApp:
    """Make the guarded page, which sends the places of dots.

    Args:
        image: the first frame.
        name: of the video or picture.
        token: that the page must have.
        port: of the server.
        take: called with the places (n, 2) in px.
    """
    text, policy = _page(image, name)

    async def index(request: Request) -> Response:
        return HTMLResponse(text, headers={**HEADERS, "Content-Security-Policy": policy})

    async def dots(request: Request) -> Response:
        body = b""
        async for part in request.stream():
            body += part
            if len(body) > POLICY.largest_message:
                return PlainTextResponse("too long", 413, HEADERS)
        try:
            places_px = _places(body, image)
        except ConfigError as error:
            return PlainTextResponse(str(error), 422, HEADERS)
        take(places_px)
        return PlainTextResponse("These dots are followed; close this page.", 200, HEADERS)

    routes = [Route("/", index), Route("/dots", dots, methods=["POST"])]
    return Guard(Starlette(routes=routes), token, port, LOOPBACK)


def _page(image: Image, name: str) -> tuple[str, str]:
    """The page, and its Content-Security-Policy."""
    import cv2

    folder = Path(__file__).parent / "templates"
    style = (folder / "pick.css").read_text(encoding="utf-8")
    script = (folder / "pick.js").read_text(encoding="utf-8").replace("{{ least }}", str(LEAST))
    _, png = cv2.imencode(".png", image)
    text = templates("dolfingrip.tracking").get_template("pick.html.j2").render(
        name=name, style=Markup(style), script=Markup(script),
        image=base64.b64encode(png.tobytes()).decode("ascii"),
    )  # fmt: skip
    return text, content_policy([script], style, "'self'")


def _places(body: bytes, image: Image) -> np.ndarray:
    """Places that a page has sent, (n, 2) px.

    Raises:
        ConfigError: one line with what is allowed.
    """
    height, width = image.shape[:2]
    try:
        sent: Any = json.loads(body)
        places_px = np.array(sent, dtype=float)
    except (ValueError, TypeError, RecursionError):
        places_px = np.zeros(0)
    pairs = places_px.ndim == 2 and places_px.shape[1] == 2 and LEAST <= len(places_px) <= MOST
    if not pairs or not ((places_px >= -0.5) & (places_px <= [width, height])).all():
        raise ConfigError(f"dots: allowed: {LEAST} to {MOST} places in the frame")
    return places_px
