"""A connection of TLS that breaks closes no other."""

from __future__ import annotations

import contextlib
import socket
import ssl
from concurrent.futures import ThreadPoolExecutor

import pytest

from dolfingrip.jobs import connections
from dolfingrip.jobs.connections import broken_connections_are_errors


def send_until_it_breaks(to: ssl.SSLSocket) -> None:
    """Write to a peer that is gone; the first write may be answered by a reset."""
    for _ in range(100):
        with contextlib.suppress(ConnectionResetError):
            to.send(b"nobody reads this")


def test_a_broken_pipe_is_an_error_of_its_own_connection() -> None:
    """Without the package's own socket, Python 3.13 reports it on every connection."""
    security = connections.fresh_keys()
    server = security.get_listen_args("scheduler")["ssl_context"]
    client = security.get_connection_args("client")["ssl_context"]

    def connected() -> tuple[ssl.SSLSocket, ssl.SSLSocket]:
        with socket.create_server(("127.0.0.1", 0)) as listening, ThreadPoolExecutor(1) as pool:
            to = socket.create_connection(listening.getsockname())
            accepted, _ = listening.accept()
            its = pool.submit(server.wrap_socket, accepted, server_side=True)
            return client.wrap_socket(to), its.result(timeout=10)

    with broken_connections_are_errors():
        (broken, its_peer), (other, other_peer) = connected(), connected()
        broken.close()
        other_peer.setblocking(False)
        with pytest.raises(BrokenPipeError):
            send_until_it_breaks(its_peer)
        with pytest.raises(ssl.SSLWantReadError):
            other_peer.recv(1)
        other.send(b"heard")
        other_peer.setblocking(True)
        assert other_peer.recv(5) == b"heard"
        for each in (its_peer, other, other_peer):
            each.close()
