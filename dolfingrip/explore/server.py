"""The explorer's server: a page, a websocket for its tabs, and downloads."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import uvicorn
from markupsafe import Markup
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from dolfingrip.config import ConfigError
from dolfingrip.explore import policy
from dolfingrip.explore.session import SOLVED, Session, parsed
from dolfingrip.explore.space import Space
from dolfingrip.files.whole import WriteError
from dolfingrip.foods.index import KINDS
from dolfingrip.report.page import front, html
from dolfingrip.report.page.scene import shown_fields
from dolfingrip.report.page.sources import EXPLORED
from dolfingrip.sections.gripper import ALPHA_DEG
from dolfingrip.serving.guard import HEADERS, LOOPBACK, Guard
from dolfingrip.serving.listening import announced, server_settings
from dolfingrip.version import __version__

PACKAGE = "dolfingrip.explore"


def rendered(space: Space, view: str) -> tuple[str, str]:
    """The page, and its Content-Security-Policy.

    Args:
        space: what varies.
        view: experiment that is shown first.
    """
    scripts = [html.script("vendor.js"), html.script("explore.js")]
    style = html.asset("report.css") + html.asset("explore.css")
    designs = front.front(space.loop, most_shapes=0)
    axes = [] if designs is None else _axes(space)
    data = {
        "sliders": space.sliders,
        "pressure": space.pressure,
        "grasp_kPa": policy.GRASP_KPA,
        "fields": shown_fields(),
        "front": None if designs is None else html.front_data(designs),
        "alpha_deg": ALPHA_DEG,
        "axes": axes,
        "view": view,
    }
    text = (
        html.templates(PACKAGE)
        .get_template("explore.html.j2")
        .render(
            style=Markup(style),
            scripts=[Markup(code) for code in scripts],
            data=Markup(html.json_text(data)),
            sliders=space.sliders,
            pressure=space.pressure,
            supply=space.supply,
            front=designs,
            axes=axes,
            view=view,
            poses=list(ALPHA_DEG),
            foods=[kind for kind in KINDS if kind != "file"],
            gripper=space.base.gripper,
            food=space.base.food,
            licences=html.licences("explore.js"),
            version=__version__,
        )
    )
    return text, html.content_policy(scripts, style, "'self'")


def _axes(space: Space) -> list[str]:
    """Names of the front's two outputs."""
    return list(space.surrogate.output_names[:2]) if space.surrogate else []


def application(session: Session, token: str, host: str, port: int) -> ASGIApp:
    """The guarded application.

    Args:
        session: answers tabs.
        token: that tabs must have.
        host: address that it listens at.
        port: of the server.
    """

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        await session.start()
        yield
        await session.close()

    async def index(request: Request) -> Response:
        solved = session.library.counts()
        text, policy = rendered(session.space, max(solved, key=solved.__getitem__))
        return HTMLResponse(text, headers={**HEADERS, "Content-Security-Policy": policy})

    async def export(request: Request) -> Response:
        suffix = f".{request.path_params['suffix']}"
        try:
            content = await session.work(
                session.export, suffix, parsed(request.query_params.get("design", ""))
            )
        except ConfigError as error:
            return PlainTextResponse(str(error), 422, HEADERS)
        except OSError as error:
            return PlainTextResponse(str(error), 507, HEADERS)
        named = {"Content-Disposition": f'attachment; filename="design{suffix}"'}
        return Response(content, 200, {**HEADERS, **named}, "application/octet-stream")

    async def tab(socket: WebSocket) -> None:
        await socket.accept()
        await Tab(session, socket).serve()

    routes = [
        Route("/", index),
        Route("/export/{suffix}", export),
        WebSocketRoute("/tab", tab),
    ]
    hosts = LOOPBACK if host in LOOPBACK else None
    return Guard(Starlette(routes=routes, lifespan=lifespan), token, port, hosts)


class Tab:
    """One open page: of its requests for a design only the newest is answered."""

    def __init__(self, session: Session, socket: WebSocket) -> None:
        self._session, self._socket = session, socket
        self._outbox: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._newest: dict[str, Any] | None = None
        self._asked = asyncio.Event()
        self._tasks: set[asyncio.Task[None]] = set()

    async def serve(self) -> None:
        """Serve until the page is closed."""
        tell = self._tell
        self._session.tabs.add(tell)
        tell(self._session.state())
        self._begin(self._send())
        self._begin(self._show())
        try:
            while (message := await self._socket.receive())["type"] != "websocket.disconnect":
                self._take(message.get("text") or "")  # bytes are no message
        finally:
            self._session.tabs.discard(tell)
            for task in self._tasks:
                task.cancel()

    def _tell(self, message: dict[str, Any]) -> None:
        """Send a message; a design is shown anew before the next solution takes its place."""
        if message != SOLVED:
            self._outbox.put_nowait(message)
        elif self._newest is not None:
            self._asked.set()

    def _begin(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled():
            task.exception()  # of a page that was closed; nobody is there to read it

    def _refuse(self, about: str, error: Exception, **more: Any) -> None:
        """Answer by an error; the tab lives on."""
        text = (
            str(error)
            if isinstance(error, ConfigError | WriteError)
            else f"{type(error).__name__}: {error}"
        )
        self._outbox.put_nowait({"is": "error", "about": about, "text": text, **more})

    def _take(self, text: str) -> None:
        try:
            message = parsed(text)
        except ConfigError as error:
            self._refuse("message", error)
            return
        what = message.get("do")
        if what == "show":
            self._newest = message
            self._asked.set()
        elif what in ("solve", "cancel", "follow", "rig", "plan"):
            self._begin(self._do(str(what), message))
        else:
            words = f"do = {what}: allowed: show, solve, cancel, follow, rig, plan"
            self._refuse("message", ConfigError(words))

    async def _do(self, what: str, message: dict[str, Any]) -> None:
        tell, session = self._outbox.put_nowait, self._session
        try:
            if what == "solve":
                await session.solve(message)
            elif what == "cancel":
                await session.cancel()
            elif what == "follow":
                tell(await session.follow(message))
            elif what == "rig":
                tell(await session.rig(message))
            else:
                await session.plan(message, tell)
        except Exception as error:
            self._refuse(what, error, id=message.get("id"))

    async def _show(self) -> None:
        while True:
            await self._asked.wait()
            self._asked.clear()
            message = self._newest
            assert message is not None
            try:
                self._outbox.put_nowait(await self._session.show(message))
            except Exception as error:
                self._refuse("show", error, id=message.get("id"))

    async def _send(self) -> None:
        while True:
            message = await self._outbox.get()
            try:
                text = json.dumps(message, allow_nan=False)
            except ValueError as error:  # a reading that is not a number, say
                self._refuse("message", error)
                continue
            await self._socket.send_text(text)


def serve(
    session: Session, token: str, listening: socket.socket, host: str, say: Callable[[str], None]
) -> None:
    """Serve until Ctrl-C.

    Args:
        session: answers tabs.
        token: that tabs must have.
        listening: from :func:`~dolfingrip.serving.listening.bound`.
        host: its address.
        say: called with the address to open, once it answers.
    """
    port = announced(listening, host, token, say)
    guarded = application(session, token, host, port)
    uvicorn.Server(server_settings(guarded)).run(sockets=[listening])


def state_folder(results: Path | None, out: Path | None) -> Path:
    """Return the folder for the explorer's solutions, ``explore`` beside the results by default.

    Args:
        results: first folder of results; None where there are none.
        out: folder that is asked for; None for the default.
    """
    if out is not None:
        return out
    return Path("out") / EXPLORED if results is None else results / EXPLORED
