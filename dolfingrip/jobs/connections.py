"""Connections of a cluster: their keys, and errors that stay with the connection that breaks.

Client, scheduler and workers talk to nobody who has no key. Dask's workers preload this module.
"""

from __future__ import annotations

import signal
import ssl
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Final

from dolfingrip.sections.errors import ConfigError

_MAKE: Final = [
    "openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
    "-noenc", "-subj", "/CN=dolfingrip", "-days", "365", "-keyout", "-", "-out", "-",
]  # fmt: skip
"""Prints a private key and its certificate, which is its own authority. Dask's own
``Security.temporary`` makes the like with a package that is needed for nothing else."""


def fresh_keys() -> Any:
    """A Dask ``Security`` with a key of its own, which is kept in memory alone.

    Raises:
        ConfigError: one line, where no key can be made.
    """
    from distributed import Security

    try:
        done = subprocess.run(_MAKE, capture_output=True, text=True, check=False)
    except OSError as error:
        raise ConfigError(f"keys of the workers: openssl: {error.strerror}") from None
    start = done.stdout.find("-----BEGIN CERTIFICATE")
    if done.returncode or start < 0:
        last = (done.stderr.strip().splitlines() or ["no certificate"])[-1]
        raise ConfigError(f"keys of the workers: openssl: {last}")
    key, certificate = done.stdout[:start], done.stdout[start:]
    roles = ("client", "scheduler", "worker")
    return Security(
        require_encryption=True,
        tls_ca_file=certificate,
        **{f"tls_{role}_key": key for role in roles},
        **{f"tls_{role}_cert": certificate for role in roles},
    )


PRELOAD: Final = [__name__]
"""Modules that a worker of Dask imports before it connects."""


@contextmanager
def broken_connections_are_errors() -> Iterator[None]:
    """Turn a connection that breaks into an error of Python, which concerns no other connection.

    PETSc takes SIGPIPE for a crash and ends the process, and TLS writes to a connection as it is
    closed. So this thread, and threads and processes that it starts, block the signal: the write
    raises BrokenPipeError.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    socket_before = ssl.SSLContext.sslsocket_class
    dask_setup()
    try:
        yield
    finally:
        ssl.SSLContext.sslsocket_class = socket_before
        if signal.SIGPIPE not in before:
            signal.sigtimedwait({signal.SIGPIPE}, 0)  # discards one that waits
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def dask_setup(_worker: Any = None) -> None:
    """Let each TLS connection of this process keep its errors to itself.

    Args:
        _worker: Dask passes the worker that preloads this module.
    """
    ssl.SSLContext.sslsocket_class = _Socket


class _Socket(ssl.SSLSocket):
    """A TLS socket that leaves no error to the next socket of its thread.

    OpenSSL keeps a queue of errors for each thread, and Python does not empty it after an error of
    the operating system (python/cpython issue 148594). Every other connection of the thread would
    report that error as its own, and Dask would close it.
    """

    def send(self, *arguments: Any) -> int:
        with _errors_forgotten():
            return super().send(*arguments)

    def read(self, *arguments: Any) -> Any:
        with _errors_forgotten():
            return super().read(*arguments)

    def do_handshake(self, block: bool = False) -> None:
        with _errors_forgotten():
            super().do_handshake(block)

    def unwrap(self) -> Any:
        with _errors_forgotten():
            return super().unwrap()


@contextmanager
def _errors_forgotten() -> Iterator[None]:
    """Empty OpenSSL's queue of errors after one of the operating system."""
    try:
        yield
    except ssl.SSLError:
        raise  # Python has emptied the queue
    except OSError:
        # Python's own way to empty the queue is a refusal that Python itself makes
        with suppress(ssl.SSLError):
            ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT).set_ciphers("none")
        raise
