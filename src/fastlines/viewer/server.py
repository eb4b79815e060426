"""The server of the page: on the loopback address only, and on a port that is free."""

from __future__ import annotations

import errno
import os
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from ..arrays import count
from ..errors import InputError
from ..support.optional import optional

#: The only address that is served, and the ports that are tried if none is given.
HOST, PORTS = "127.0.0.1", range(8080, 8180)
#: Guards the console while a server of viser speaks.
_SPEAKS = threading.Lock()


def viser() -> Any:
    """Import viser, or say which extra has it."""
    return optional("viser", "the viewer", "view")


def free_port(port: int | None) -> int:
    """Return a port to serve on: the given one, for 0 any, and by default the first free one from 8080 on.

    Raises
    ------
    InputError
        If the given port is none, or is taken, or is not allowed.
    """
    if port is None:
        free = next((each for each in PORTS if _refusal(each) is None), None)
        if free is None:
            raise InputError(f"ports {PORTS[0]} to {PORTS[-1]} are all in use; name another one by port=")
        return free
    count("port", port, 0, 65535)
    if port == 0:
        with socket.socket() as probe:
            probe.bind((HOST, 0))
            return int(probe.getsockname()[1])
    if (reason := _refusal(port)) is not None:
        raise InputError(f"port {port} {reason}; choose another one, or none to take a free one")
    return port


def _refusal(port: int) -> str | None:
    """Return why a port cannot be served; None if it can."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        if os.name == "posix":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except PermissionError:
            return "is not allowed to this user"
        except OSError as error:
            return "is in use" if error.errno == errno.EADDRINUSE else f"cannot be used: {error.strerror}"
    return None


def start_server(port: int | None) -> Any:
    """Start a server of viser on a port as `free_port` chooses it, and say nothing.

    Raises
    ------
    InputError
        As in `free_port`.
    """
    while True:
        wanted = free_port(port)
        with _silent(), _of_own_pages(wanted):
            server = viser().ViserServer(host=HOST, port=wanted, verbose=False)
        # No page may publish the scene on a server elsewhere.
        server.request_share_url = lambda verbose=True: None
        if server.get_port() == wanted:
            return server
        stop_server(server)  # somebody has taken the port meanwhile


@contextmanager
def _of_own_pages(port: int) -> Iterator[None]:
    """Let a server that starts here accept only connections of its own pages: browsers let any site connect."""
    module = optional("websockets.asyncio.server", "the viewer", "view")
    serve, origins = module.serve, [None, *(f"http://{host}:{port}" for host in (HOST, "localhost"))]
    module.serve = partial(serve, origins=origins)
    try:
        yield
    finally:
        module.serve = serve


def stop_server(server: Any) -> None:
    """Stop a server, without a word."""
    with _silent():
        server.stop()


@contextmanager
def _silent() -> Iterator[None]:
    """Keep viser from printing: it writes panels to the console of rich."""
    import rich

    console = rich.get_console()
    with _SPEAKS:
        before, console.quiet = console.quiet, True
        try:
            yield
        finally:
            console.quiet = before
