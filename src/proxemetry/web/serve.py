"""Start the page on this machine's own address, and nowhere else."""

from __future__ import annotations

import asyncio
import importlib
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable
from typing import Any

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from ..errors import SettingsError

ADDRESS = "127.0.0.1"
_LAST_PORT = 65535
#: How long a request's head may take to arrive, and how long open requests are waited for at the end.
_SECONDS_FOR_A_HEAD, _SECONDS_TO_END = 20.0, 2


class PatientProtocol(H11Protocol):
    """HTTP whose connections are closed where no whole request arrives for long: browsers hold a few, attackers all."""

    _timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for the first head."""
        super().connection_made(transport)
        self._watch()

    def data_received(self, data: bytes) -> None:
        """Take in what came; a head that is not whole yet is not waited for longer than one that never came."""
        super().data_received(data)
        self._watch()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing."""
        super().connection_lost(exc)
        if self._timer is not None:
            self._timer.cancel()

    def _watch(self) -> None:
        waiting = self._is_waiting()
        if waiting and self._timer is None:
            self._timer = self.loop.call_later(_SECONDS_FOR_A_HEAD, self._close_if_waiting)
        elif not waiting and self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _is_waiting(self) -> bool:
        cycle: Any = self.cycle  # none before the first request
        return cycle is None or cycle.response_complete

    def _close_if_waiting(self) -> None:
        self._timer = None
        if self._is_waiting() and not self.transport.is_closing():
            self.transport.close()


#: What makes a page's application of the token and of the "name:port" that it answers to.
Application = Callable[[str, tuple[str, ...]], ASGIApp]


def serve(
    application: Application, *, port: int = 0, open_browser: bool = True, on_ready: Callable[[str], None]
) -> None:  # fmt: skip
    """Serve a page until it is interrupted.

    port: 0 takes any free one. on_ready: is called with the address and its token.

    Raises SettingsError where the port is taken.
    """
    listener = _listener(port)
    try:
        chosen = listener.getsockname()[1]
        token = secrets.token_urlsafe(24)
        app = application(token, (f"{ADDRESS}:{chosen}", f"localhost:{chosen}"))
        address = f"http://{ADDRESS}:{chosen}/?token={token}"
        on_ready(address)
        threading.Thread(target=_warm_up, daemon=True).start()
        if open_browser:
            webbrowser.open(address)
        uvicorn.Server(configuration(app)).run(sockets=[listener])
    finally:
        listener.close()


def configuration(app: ASGIApp) -> uvicorn.Config:
    """Return how the page is served."""
    return uvicorn.Config(
        app, log_level="error", access_log=False, server_header=False, lifespan="off", http=PatientProtocol,
        timeout_graceful_shutdown=_SECONDS_TO_END,
    )  # fmt: skip


def _warm_up() -> None:
    """Load what a first correction needs while the first page is still being read."""
    importlib.import_module("proxemetry.locate.scenefit")


def _listener(port: int) -> socket.socket:
    if not 0 <= port <= _LAST_PORT:
        raise SettingsError(f"--port {port}: it must be 0 (any free one) to {_LAST_PORT}")
    # With the protocol named, asyncio sends answers at once (TCP_NODELAY): without, each waits some 40 ms.
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((ADDRESS, port))
        listener.listen()  # the browser may ask before the server has started
    except OSError as error:
        listener.close()
        raise SettingsError(
            f"port {port} is taken on this machine ({error.strerror}): choose another --port"
        ) from error
    return listener
