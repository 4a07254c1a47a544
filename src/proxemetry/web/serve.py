"""Start the page on this machine's own address, and nowhere else."""

from __future__ import annotations

import importlib
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable

import uvicorn

from ..errors import SettingsError
from .app import create_app
from .session import Review

ADDRESS = "127.0.0.1"
_LAST_PORT = 65535


def serve(review: Review, *, port: int = 0, open_browser: bool = True, tell: Callable[[str], None]) -> None:
    """Serve a review until it is interrupted. port: 0 takes any free one. tell: hears the address with its token.

    Raises SettingsError where the port is taken.
    """
    listener = _listener(port)
    try:
        chosen = listener.getsockname()[1]
        token = secrets.token_urlsafe(24)
        app = create_app(review, token, (f"{ADDRESS}:{chosen}", f"localhost:{chosen}"))
        address = f"http://{ADDRESS}:{chosen}/?token={token}"
        tell(address)
        threading.Thread(target=_warm_up, daemon=True).start()
        if open_browser:
            webbrowser.open(address)
        config = uvicorn.Config(app, log_level="error", access_log=False, server_header=False, lifespan="off")
        uvicorn.Server(config).run(sockets=[listener])
    finally:
        listener.close()


def _warm_up() -> None:
    """Load what a first correction needs while the first page is still being read."""
    importlib.import_module("proxemetry.locate.scenefit")


def _listener(port: int) -> socket.socket:
    if not 0 <= port <= _LAST_PORT:
        raise SettingsError(f"--port {port}: it must be 0 (any free one) to {_LAST_PORT}")
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
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
