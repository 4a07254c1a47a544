"""What the pages' addresses share: errors as one line, bodies of limited size, and the pages' own files."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Iterator
from importlib import resources

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from ..errors import PhotoError, ProxemetryError

_KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}

#: A sender that stops in the middle is not waited for longer.
_SECONDS_FOR_A_PIECE = 30.0

Handler = Callable[[Request], Awaitable[Response]]


#: What is still read, and thrown away, of a body that is too large: beyond it the connection is closed.
_MOST_IGNORED_BYTES = 2_000_000


class _TooLargeError(Exception):
    def __init__(self, limit: int, announced: int | None) -> None:
        super().__init__(f"more than {limit:,} bytes: neither a photo nor a correction")
        self.hang_up = announced is None or announced > _MOST_IGNORED_BYTES


def static_routes(home: str = "index.html") -> list[Route]:
    """Return one route a file of the pages: nothing of a request's path ever meets a file system.

    home: the page shown at "/"; the others' pages are not served.
    """
    return list(_static_routes(home))


def _static_routes(home: str) -> Iterator[Route]:
    folder = resources.files("proxemetry.web") / "static"
    for file in sorted(folder.iterdir(), key=lambda f: f.name):
        ending = file.name[file.name.rfind(".") :]
        if ending not in _KINDS or (ending == ".html" and file.name != home):
            continue
        route = _static(file.read_bytes(), _KINDS[ending])
        yield Route("/" if file.name == home else f"/static/{file.name}", route)


def _static(content: bytes, kind: str) -> Handler:
    async def answer(_: Request) -> Response:
        return Response(content, media_type=f"{kind}; charset=utf-8", headers={"Cache-Control": "no-cache"})

    return answer


def answering(handler: Handler) -> Handler:
    """Return a handler whose errors are answers: one line with what is wrong and what to do."""

    async def answer(request: Request) -> Response:
        try:
            return await handler(request)
        except LookupError as error:
            if type(error) is not LookupError:  # a key that a program missed is a bug, not an address
                raise
            return error_answer(404, str(error))
        except _TooLargeError as error:
            # Hanging up is what ends an upload whose sender continues.
            return JSONResponse({"error": str(error)}, 413, {"Connection": "close"} if error.hang_up else None)
        except PhotoError as error:
            return error_answer(422, str(error))
        except (ProxemetryError, ValueError) as error:
            return error_answer(400, str(error))

    return answer


def error_answer(status: int, text: str) -> Response:
    """Return the answer to a request that cannot be followed."""
    return JSONResponse({"error": text}, status)


async def _next(chunks: AsyncGenerator[bytes, None]) -> bytes | None:
    """Return the next piece of a body, None at its end; raises ValueError where none comes for long."""
    try:
        return await asyncio.wait_for(anext(chunks, None), _SECONDS_FOR_A_PIECE)
    except TimeoutError as error:
        raise ValueError(f"nothing came for {_SECONDS_FOR_A_PIECE:g} seconds") from error


async def body_of(request: Request, limit: int) -> bytes:
    """Return a request's body, read no further than the limit whatever length its head states."""
    length = request.headers.get("content-length", "")
    announced = int(length) if length.isdigit() else None
    if announced is not None and announced > limit:
        raise _TooLargeError(limit, announced)
    content = bytearray()
    chunks = request.stream()
    while (chunk := await _next(chunks)) is not None:
        content += chunk
        if len(content) > limit:
            raise _TooLargeError(limit, announced)
    return bytes(content)
