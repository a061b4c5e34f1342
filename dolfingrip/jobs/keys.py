"""Keys of a cluster: client, scheduler and workers talk to nobody who has none."""

from __future__ import annotations

import subprocess
from typing import Any, Final

from dolfingrip.sections.errors import ConfigError

_MAKE: Final = [
    "openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
    "-noenc", "-subj", "/CN=dolfingrip", "-days", "365", "-keyout", "-", "-out", "-",
]  # fmt: skip
"""Prints a private key and its certificate, which is its own authority. Dask's own
``Security.temporary`` makes the like with a package that is needed for nothing else."""


def fresh() -> Any:
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
