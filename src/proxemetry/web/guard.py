"""Access to the page: only this machine's own browser tab, and no other site through it.

A page of the open web may send requests to 127.0.0.1 from a visitor's browser. So a request needs the session's random
token as a cookie, the Host that this server was opened under (against names that turn to 127.0.0.1 later), and, where
it changes anything, an Origin that is this page.
"""

from __future__ import annotations

import hmac
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
}
_SAFE_METHODS = ("GET", "HEAD")


class Guard:
    """Refuses what is not the page's own request, and puts the protective headers on every answer.

    token: what the address opened at the start carries. hosts: the "name:port" that the server answers to.
    """

    def __init__(self, app: ASGIApp, token: str, hosts: tuple[str, ...]) -> None:
        self._app = app
        self._token = token
        self._hosts = hosts
        # Cookies know no ports: two reviews on one machine must not overwrite each other's.
        self._cookie = f"proxemetry_{hosts[0].rpartition(':')[2]}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one connection."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return

        async def protected(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers[name] = value
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        answer = self._refusal(scope)
        await (answer or self._app)(scope, receive, protected)

    def _refusal(self, scope: Scope) -> Response | None:
        """Return the answer to a request that goes no further, None for one that does."""
        headers = Headers(scope=scope)
        if headers.get("host") not in self._hosts:
            return PlainTextResponse("This page answers under its own address only.", 421)
        origin = headers.get("origin")
        own = tuple(f"http://{host}" for host in self._hosts)
        if origin not in own and (origin is not None or scope["method"] not in _SAFE_METHODS):
            return PlainTextResponse("This request does not come from the page itself.", 403)
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return PlainTextResponse("This request does not come from the page itself.", 403)
        offered = QueryParams(scope["query_string"]).get("token")
        if scope["method"] == "GET" and scope["path"] == "/" and offered is not None and self._fits(offered):
            answer = RedirectResponse("/", 303)
            answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict", path="/")
            return answer
        if not self._fits(self._carried(headers)):
            text = "This needs the address that the program printed, with its token."
            return PlainTextResponse(text, 403)
        return None

    def _carried(self, headers: Headers) -> str:
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self._cookie)
        except CookieError:
            return ""
        return cookie.value if cookie else ""

    def _fits(self, offered: str) -> bool:
        return hmac.compare_digest(offered.encode(), self._token.encode())
