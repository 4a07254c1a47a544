"""The addresses of the annotation page: each parses, asks the project, and answers."""

from __future__ import annotations

from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from ..annotate.project import Project
from ..annotate.scoring import DEFAULT_METHODS, score_own_run
from ..archive.review.actions import Action
from ..files import parse_json
from .annotate_view import about_view, card_view, photo_view, places_view, scores_view, words_of
from .answers import answering, body_of, error_answer, static_routes
from .background import BackgroundWork
from .cache import LruCache
from .guard import Guard
from .pictures import SIZES_PX, jpeg

#: What an action may hold.
MOST_JSON_BYTES = 64_000
_PICTURES_BYTES = 200_000_000


def create_annotate_app(project: Project, token: str, hosts: tuple[str, ...]) -> Guard:
    """Return the guarded application; token and hosts as `Guard` takes them."""
    page = _Page(project)
    routes = [
        Route("/api/about", answering(page.about)),
        Route("/api/photos", answering(page.photos)),
        Route("/api/photos/{identity:int}", answering(page.photo)),
        Route("/api/photos/{identity:int}/propose", answering(page.propose), methods=["POST"]),
        Route("/api/photos/{identity:int}/picture", answering(page.picture)),
        Route("/api/actions", answering(page.act), methods=["POST"]),
        Route("/api/undo", answering(page.undo), methods=["POST"]),
        Route("/api/redo", answering(page.redo), methods=["POST"]),
        Route("/api/places/{shoot:int}", answering(page.places)),
        Route("/api/check", answering(page.check)),
        Route("/api/scoring", answering(page.scoring), methods=["GET", "POST", "DELETE"]),
        *static_routes("annotate.html"),
    ]
    return Guard(Starlette(routes=routes), token, hosts)


class _Page:
    """The handlers; whatever computes or writes does so off the event loop."""

    def __init__(self, project: Project) -> None:
        self._project = project
        self._scoring = BackgroundWork()
        self._pictures = LruCache[tuple[int, int], bytes](_PICTURES_BYTES, len)

    async def about(self, request: Request) -> Response:
        return JSONResponse(await run_in_threadpool(about_view, self._project))

    async def photos(self, request: Request) -> Response:
        def cards() -> list[dict[str, Any]]:
            return [card_view(k, p, self._project.notes(k)) for k, p in enumerate(self._project.photos)]

        return JSONResponse({"photos": await run_in_threadpool(cards)})

    async def photo(self, request: Request) -> Response:
        return await self._view(int(request.path_params["identity"]))

    async def _view(self, identity: int) -> Response:
        return JSONResponse(await run_in_threadpool(photo_view, self._project, identity))

    async def propose(self, request: Request) -> Response:
        identity = int(request.path_params["identity"])
        await run_in_threadpool(self._project.propose, identity)
        return await self._view(identity)

    async def act(self, request: Request) -> Response:
        fields = parse_json((await body_of(request, MOST_JSON_BYTES)).decode(), finite=True)
        if not isinstance(fields, dict) or not isinstance(fields.get("value"), dict):
            raise ValueError("an annotation is {photo, action, value: {...}}")
        identity = fields.get("photo")
        if identity is not None and (not isinstance(identity, int) or isinstance(identity, bool)):
            raise ValueError("photo is the number of one, or null")
        await run_in_threadpool(self._project.act, identity, str(fields.get("action")), fields["value"])
        return JSONResponse({}) if identity is None else await self._view(identity)

    async def undo(self, request: Request) -> Response:
        return self._stepped(await run_in_threadpool(self._project.undo), "undo")

    async def redo(self, request: Request) -> Response:
        return self._stepped(await run_in_threadpool(self._project.redo), "redo")

    def _stepped(self, action: Action | None, what: str) -> Response:
        """Answer with what was taken or brought back, and on which photo (null: of a shoot)."""
        if action is None:
            return error_answer(409, f"there is nothing to {what}")
        photo = next((k for k, p in enumerate(self._project.photos) if p.sha256 == action.sha256), None)
        shoot = action.value.get("shoot") if photo is None else None
        return JSONResponse({"photo": photo, "shoot": shoot, "text": words_of(action)})

    async def picture(self, request: Request) -> Response:
        size, identity = int(request.query_params.get("size", "1600")), int(request.path_params["identity"])
        if size not in SIZES_PX:
            raise ValueError(f"a picture's size is one of {', '.join(map(str, SIZES_PX))}")
        photo = self._project.photo(identity).photo
        content = await run_in_threadpool(self._pictures.get, (identity, size), lambda: jpeg(photo, size))
        return Response(content, media_type="image/jpeg", headers={"Cache-Control": "private, max-age=600"})

    async def places(self, request: Request) -> Response:
        return JSONResponse(await run_in_threadpool(places_view, self._project, int(request.path_params["shoot"])))

    async def check(self, request: Request) -> Response:
        faults = await run_in_threadpool(self._project.check)
        listed = [{"file": f.file, "line": f.line, "text": f.text, "harmless": f.harmless} for f in faults]
        doubts, files = await run_in_threadpool(self._project.doubts), await run_in_threadpool(self._project.write)
        return JSONResponse({"faults": listed, "doubts": doubts, "files": files})

    async def scoring(self, request: Request) -> Response:
        if request.method == "DELETE":
            self._scoring.stop()
        elif request.method == "POST":
            project = self._project
            self._scoring.start(
                lambda hear: scores_view(score_own_run(project, DEFAULT_METHODS, on_progress=hear), project)
            )
        return JSONResponse(self._scoring.state())
