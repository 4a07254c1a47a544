"""The page's addresses: each parses, asks the session, and answers."""

from __future__ import annotations

import math
from dataclasses import asdict

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from ..errors import SettingsError
from ..files import parse_json
from .answers import answering, body_of, error_answer, static_routes
from .calibrating import Clicked
from .gallery import Query
from .guard import Guard
from .measuring import Measuring, folders
from .pictures import SIZES_PX
from .session import Review
from .stores import DropStore, FolderStore

#: What a request may carry: a correction, and a dropped photo.
MOST_JSON_BYTES, MOST_UPLOAD_BYTES = 64_000, 100_000_000


def create_app(review: Review, token: str, hosts: tuple[str, ...]) -> Guard:
    """Return the guarded application; token and hosts as `Guard` takes them."""
    page = _Page(review)
    routes = [
        Route("/api/about", answering(page.about)),
        Route("/api/photos", answering(page.photos)),
        Route("/api/photos/{identity:int}", answering(page.photo)),
        Route("/api/photos/{identity:int}/actions", answering(page.act), methods=["POST"]),
        Route("/api/photos/{identity:int}/undo", answering(page.undo), methods=["POST"]),
        Route("/api/photos/{identity:int}/calibration", answering(page.calibrate), methods=["POST"]),
        Route("/api/photos/{identity:int}/calibration/{name}", answering(page.save_camera), methods=["POST"]),
        Route("/api/photos/{identity:int}/alike", answering(page.alike)),
        Route("/api/photos/{identity:int}/picture", answering(page.picture)),
        Route("/api/export", answering(page.export), methods=["POST"]),
        Route("/api/tables.zip", answering(page.tables)),
        Route("/api/reviewers", answering(page.reviewers)),
        Route("/api/agreement", answering(page.agreement)),
        Route("/api/drop", answering(page.drop), methods=["POST"]),
        Route("/api/folders", answering(page.folders)),
        Route("/api/measuring", answering(page.measuring), methods=["GET", "POST", "DELETE"]),
        Route("/api/measuring/open", answering(page.open_measured), methods=["POST"]),
        *static_routes(),
    ]
    return Guard(Starlette(routes=routes), token, hosts)


class _Page:
    """The handlers of one review; whatever computes does so off the event loop."""

    def __init__(self, review: Review) -> None:
        self._review = review
        self._measuring = Measuring()

    def _no_folder_yet(self) -> None:
        """Refuse what only a page without a results folder does: a review stays with the folder it was opened for."""
        if not isinstance(self._review.store, DropStore):
            raise SettingsError("this page reviews a results folder; `proxemetry` alone measures another one")

    async def folders(self, request: Request) -> Response:
        self._no_folder_yet()
        return JSONResponse(await run_in_threadpool(folders, request.query_params.get("path", "")))

    async def measuring(self, request: Request) -> Response:
        self._no_folder_yet()
        if request.method == "DELETE":
            self._measuring.stop()
        elif request.method == "POST":
            fields = parse_json((await body_of(request, MOST_JSON_BYTES)).decode(), finite=True)
            if not isinstance(fields, dict):
                raise ValueError("a run is {folder, out, focal_35mm}")
            focal = fields.get("focal_35mm")
            if focal is not None and (isinstance(focal, bool) or not isinstance(focal, int | float)):
                raise ValueError("focal_35mm is a number or null")
            self._measuring.start(str(fields.get("folder", "")), str(fields.get("out", "")), focal)
        return JSONResponse(self._measuring.state())

    async def open_measured(self, request: Request) -> Response:
        self._no_folder_yet()
        state = self._measuring.state()
        if state["status"] != "done":
            raise SettingsError("nothing is measured yet")
        dropped, old = self._review.store, self._review
        fresh = await run_in_threadpool(FolderStore, state["out"])
        self._review = await run_in_threadpool(Review, fresh, old.who, faces=old.faces, blind=old.blind)
        if isinstance(dropped, DropStore):
            dropped.close()
        return JSONResponse({})

    async def about(self, request: Request) -> Response:
        return JSONResponse(await run_in_threadpool(self._review.about))

    async def photos(self, request: Request) -> Response:
        page = max(int(request.query_params.get("page", "0")), 0)
        return JSONResponse(await run_in_threadpool(self._review.page, _query(request), page))

    async def photo(self, request: Request) -> Response:
        return await self._view(request)

    async def _view(self, request: Request) -> Response:
        number = int(request.path_params["identity"])
        return JSONResponse(await run_in_threadpool(self._review.view, number, _query(request)))

    async def act(self, request: Request) -> Response:
        fields = parse_json((await body_of(request, MOST_JSON_BYTES)).decode(), finite=True)
        if not isinstance(fields, dict) or not isinstance(fields.get("value"), dict):
            raise ValueError("a correction is {action, value: {...}}")
        number = int(request.path_params["identity"])
        await run_in_threadpool(self._review.act, number, str(fields.get("action")), fields["value"])
        return await self._view(request)

    async def alike(self, request: Request) -> Response:
        scope = request.query_params.get("scope", "")
        found = await run_in_threadpool(self._review.alike, int(request.path_params["identity"]), scope)
        return JSONResponse({"photos": found})

    async def calibrate(self, request: Request) -> Response:
        clicked, number = await _clicked(request), int(request.path_params["identity"])
        return JSONResponse(await run_in_threadpool(self._review.calibrate, number, clicked))

    async def save_camera(self, request: Request) -> Response:
        clicked, number = await _clicked(request), int(request.path_params["identity"])
        name = str(request.path_params["name"])
        return JSONResponse(await run_in_threadpool(self._review.save_camera, number, clicked, name))

    async def undo(self, request: Request) -> Response:
        number = int(request.path_params["identity"])
        undone = await run_in_threadpool(self._review.undo, number)
        if undone is None:
            return error_answer(409, "there is nothing of yours to undo on this photo")
        return await self._view(request)

    async def picture(self, request: Request) -> Response:
        size = int(request.query_params.get("size", "1600"))
        if size not in SIZES_PX:
            raise ValueError(f"a picture's size is one of {', '.join(map(str, SIZES_PX))}")
        content = await run_in_threadpool(self._review.picture, int(request.path_params["identity"]), size)
        return Response(content, media_type="image/jpeg", headers={"Cache-Control": "private, max-age=600"})

    async def export(self, request: Request) -> Response:
        return JSONResponse({"files": await run_in_threadpool(self._review.export)})

    async def tables(self, request: Request) -> Response:
        headers = {"Content-Disposition": 'attachment; filename="proxemetry-tables.zip"', "Cache-Control": "no-store"}
        content = await run_in_threadpool(self._review.tables)
        return Response(content, media_type="application/zip", headers=headers)

    async def reviewers(self, request: Request) -> Response:
        return JSONResponse({"reviewers": await run_in_threadpool(self._review.store.log.people)})

    async def agreement(self, request: Request) -> Response:
        names = (request.query_params.get("one", ""), request.query_params.get("other", ""))
        found = await run_in_threadpool(self._review.agreement, *names)
        fields = {**asdict(found), "share_alike": found.share_alike}
        missing = {k: None for k, v in fields.items() if isinstance(v, float) and not math.isfinite(v)}
        return JSONResponse({**fields, **missing})

    async def drop(self, request: Request) -> Response:
        store = self._review.store
        if not isinstance(store, DropStore):
            what = "this page reviews a results folder; `proxemetry review` alone takes dropped photos"
            return error_answer(409, what)
        content = await body_of(request, MOST_UPLOAD_BYTES)
        photo = await run_in_threadpool(store.add, content, request.query_params.get("name", ""))
        return JSONResponse({"id": await run_in_threadpool(self._review.added, photo)})


async def _clicked(request: Request) -> Clicked:
    fields = parse_json((await body_of(request, MOST_JSON_BYTES)).decode(), finite=True)
    if not isinstance(fields, dict):
        raise ValueError("a calibration is {points, lengths, lens}")
    return Clicked.parsed(fields)


def _query(request: Request) -> Query:
    asked = request.query_params
    return Query(asked.get("show", "all"), asked.get("sort", "name"), asked.get("group"), asked.get("text", "")[:200])
