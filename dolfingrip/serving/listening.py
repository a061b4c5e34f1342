"""Listening: a socket at a free port, the address to open, and how an application is served."""

from __future__ import annotations

import errno
import socket
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import uvicorn
from starlette.types import ASGIApp

from dolfingrip.sections.errors import ConfigError
from dolfingrip.serving.guard import Patience
from dolfingrip.serving.policy import POLICY, ServingPolicy

EVERY: Final = ("0.0.0.0", "::")
"""Hosts that mean every address of a machine."""

FAR: Final = ("192.0.2.1", 9)
"""An address that is nobody's (RFC 5737), by which the system tells the way to others."""


def bound(host: str, port: int | None) -> socket.socket:
    """A socket that listens at an address.

    Args:
        host: address.
        port: None: the first free one from ``POLICY.port`` on; 0: any.

    Raises:
        ConfigError: one line, if it cannot be had.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    tried = [port] if port is not None else [POLICY.port + i for i in range(POLICY.ports)]
    for number in tried:
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, number))
            return listener
        except OSError as error:
            listener.close()
            if error.errno != errno.EADDRINUSE:
                raise ConfigError(f"--host {host}: {error.strerror}") from None
    raise ConfigError(f"--port {tried[0]}: in use; allowed: another, or 0 for any")


def reachable(host: str) -> str:
    """Return an address at which a server can be opened.

    Args:
        host: that it listens at; of one that means every address of this machine, the one by which
            other machines reach it is returned.
    """
    if host not in EVERY:
        return host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(FAR)  # sends nothing: it chooses the way, and with it the address
        except OSError:  # without a network
            return socket.gethostname()
        return str(probe.getsockname()[0])


def announced(listening: socket.socket, host: str, token: str, say: Callable[[str], None]) -> int:
    """Listen, tell the address to open, and return the port.

    Args:
        listening: from :func:`bound`.
        host: its address.
        token: that pages must have.
        say: called with the address.
    """
    port = int(listening.getsockname()[1])
    name = reachable(host)
    name = f"[{name}]" if ":" in name else name
    listening.listen()  # a browser may come before the loop runs
    say(f"http://{name}:{port}/?token={token}")
    return port


def server_settings(guarded: ASGIApp, policy: ServingPolicy = POLICY) -> uvicorn.Config:
    """How an application is served.

    Args:
        guarded: the application.
        policy: limits of messages and of half-open requests.
    """
    http: Any = partial(Patience, policy=policy)
    return uvicorn.Config(
        guarded, log_level="critical", access_log=False, server_header=False,
        ws_max_size=policy.largest_message, timeout_graceful_shutdown=1, http=http,
    )  # fmt: skip
