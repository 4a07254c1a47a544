"""What the photos of a run show about each other's cameras, once all are measured: by model, and by shoot.

Models come from what files state (`camera.others.SameModel`); shoots, asked for with `--same-camera`, from the people
of all photos of one size that state no focal length. Both rest on what the first pass over the photos wrote alone, so
that they come out the same in whatever order photos were measured, by whomever, and however often the run was stopped.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from ...calibration.background import GrayArray, is_at_one_place, small_gray
from ...camera.others import (
    CropRange,
    Others,
    SameModel,
    SameShoot,
    model_from_dict,
    model_to_dict,
    shoot_from_dict,
    shoot_to_dict,
)
from ...errors import OutputError
from ...photo import Photo
from ..store import parts
from ..store.duck import attached
from ..store.folder import CAMERAS_FILE, Folder
from ..store.part_rows import OwnFocal

_SCHEMA = "proxemetry.cameras/1"
#: Models and, of each, focal lengths that are kept: more than any archive has.
_MOST_MODELS, _MOST_CROPS = 20_000, 48
_ROWS_AT_ONCE = 4096
#: Photos whose file states the focal length beyond doubt are evidence; the others may use it. By what each showed
#: alone.
_TELLS, _OPEN = "own_focal = 'sure'", "status IN ('ok', 'no_camera') AND own_focal IN ('doubtful', 'none')"
_COLUMNS = ("photo", "camera_make", "camera_model", "width_px", "height_px", "own_focal", "others")


@dataclass(frozen=True, eq=False)
class Shoot:
    """One shoot: what it shows (None for nothing), why not, and the background of a camera that stayed."""

    told: SameShoot | None
    said: str
    background: GrayArray | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON values, the background as a PNG in base64."""
        picture = None
        if self.background is not None:
            picture = base64.b64encode(cv2.imencode(".png", self.background)[1].tobytes()).decode()
        told = None if self.told is None else shoot_to_dict(self.told)
        return {"told": told, "said": self.said, "background": picture}

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Shoot:
        """Read what `to_dict` wrote."""
        told = None if fields["told"] is None else shoot_from_dict(fields["told"])
        if fields["background"] is None:
            return cls(told, fields["said"])
        png = np.frombuffer(base64.b64decode(fields["background"]), np.uint8)
        return cls(told, fields["said"], np.asarray(cv2.imdecode(png, cv2.IMREAD_GRAYSCALE), dtype=np.uint8))

    def of(self, photo: Photo) -> SameShoot | None:
        """Return what it determines of a photo: the camera's place only where the photo shows the same background."""
        if self.told is None or self.told.mount is None:
            return self.told
        same = self.told.mount.size_px == (photo.width, photo.height) and self.background is not None
        if same and photo.path is not None and self.background is not None:
            same = is_at_one_place(self.background, small_gray(photo.pixels(long_side_px=_LOOK_PX)))
        return self.told if same and photo.path is not None else self.told.without_place


#: How large a picture is decoded to look at its background.
_LOOK_PX = 480


@dataclass(frozen=True, eq=False)
class CameraPool:
    """The evidence on cameras: on models by (make, model), of shoots by the long and the short side of their photos."""

    models: Mapping[tuple[str, str], SameModel] = field(default_factory=dict[tuple[str, str], SameModel])
    shoots: Mapping[tuple[int, int], Shoot] = field(default_factory=dict[tuple[int, int], Shoot])

    _digests: dict[tuple[int, int], str] = field(
        default_factory=dict[tuple[int, int], str], init=False, repr=False, compare=False
    )

    def __bool__(self) -> bool:
        return bool(self.models) or any(shoot.told is not None for shoot in self.shoots.values())

    def to_json(self) -> bytes:
        """Return it as `cameras.json` holds it: the same pool gives the same bytes."""
        fields = {
            "schema": _SCHEMA,
            "models": [model_to_dict(model) for _, model in sorted(self.models.items())],
            "shoots": [{"size_px": size, **shoot.to_dict()} for size, shoot in sorted(self.shoots.items())],
        }
        return (json.dumps(fields, indent=1, allow_nan=False) + "\n").encode()

    @classmethod
    def from_json(cls, content: bytes) -> CameraPool:
        """Read what `to_json` wrote."""
        fields = json.loads(content)
        models = [model_from_dict(m) for m in fields["models"]]
        shoots = {(s["size_px"][0], s["size_px"][1]): Shoot.from_dict(s) for s in fields["shoots"]}
        return cls({(m.make, m.model): m for m in models}, shoots)

    def digest_for(self, row: Mapping[str, Any]) -> str:
        """Return the evidence on a photo, by its row of a part, as a digest; "" for none."""
        model, shoot = self._of(row)
        key = id(model), id(shoot)  # of the pool's own: a million rows ask about a few models and shoots
        if key not in self._digests:
            self._digests[key] = _digest(model, shoot)
        return self._digests[key]

    def others_of(self, row: Mapping[str, Any], photo: Photo) -> Others:
        """Return the evidence on a photo, by its row of a part."""
        model, shoot = self._of(row)
        return Others(model, None if shoot is None else shoot.of(photo))

    def _of(self, row: Mapping[str, Any]) -> tuple[SameModel | None, Shoot | None]:
        model = self.models.get((row["camera_make"] or "", row["camera_model"] or ""))
        if row["own_focal"] == OwnFocal.DOUBTFUL:  # its own file says something: a sensor may settle it
            return model, None
        size = (max(row["width_px"] or 0, row["height_px"] or 0), min(row["width_px"] or 0, row["height_px"] or 0))
        shoot = self.shoots.get(size)
        return model, shoot if shoot is not None and shoot.told is not None else None


def _digest(model: SameModel | None, shoot: Shoot | None) -> str:
    told = [None if model is None else model_to_dict(model), None if shoot is None else shoot.to_dict()]
    return "" if told == [None, None] else hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:16]


def open_rows(folder: Folder) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield shard and row of every photo on which others may be evidence."""
    names = ", ".join(_COLUMNS)
    cursor = attached(folder)
    cursor.execute(
        f"SELECT regexp_extract(filename, 'part-(\\d+)[.]parquet$', 1)::INTEGER, {names} "
        f"FROM {parts.every_row(folder, with_names=True)} WHERE {_OPEN}"
    )
    while batch := cursor.fetchmany(_ROWS_AT_ONCE):
        for shard, *values in batch:
            yield shard, dict(zip(_COLUMNS, values, strict=True))


def is_open(row: Mapping[str, Any]) -> bool:
    """Return whether others may be evidence on a photo, by its row of a part, as `open_rows` has it."""
    return row["status"] in ("ok", "no_camera") and row["own_focal"] in (OwnFocal.DOUBTFUL, OwnFocal.NONE)


def models_of(folder: Folder) -> dict[tuple[str, str], SameModel]:
    """Return what photos beyond doubt show about the models of other photos in the run."""
    every = parts.every_row(folder)
    rows: list[tuple[Any, ...]] = (
        attached(folder)
        .execute(
            f"WITH asked AS (SELECT DISTINCT camera_make AS make, camera_model AS model FROM {every} "
            f"WHERE {_OPEN} AND camera_model IS NOT NULL ORDER BY ALL LIMIT {_MOST_MODELS}), "
            "told AS (SELECT coalesce(camera_make, '') AS make, camera_model AS model, round(focal_mm, 1) AS mm, "
            "focal_px / sqrt(width_px ** 2 + height_px ** 2) * sqrt(36 ** 2 + 24 ** 2) / focal_mm AS crop "
            f"FROM {every} SEMI JOIN asked ON camera_make IS NOT DISTINCT FROM make AND camera_model = model "
            f"WHERE {_TELLS} AND focal_mm > 0) "
            "SELECT make, model, mm, quantile_cont(crop, 0.1), quantile_cont(crop, 0.9), count(*) AS n FROM told "
            "WHERE mm > 0 GROUP BY make, model, mm "
            f"QUALIFY row_number() OVER (PARTITION BY make, model ORDER BY count(*) DESC, mm) <= {_MOST_CROPS} "
            "ORDER BY make, model, mm"
        )
        .fetchall()
    )
    crops: dict[tuple[str, str], list[CropRange]] = {}
    for make, model, mm, low, high, count in rows:
        crops.setdefault((make, model), []).append(CropRange(mm, round(low, 5), round(high, 5), count))
    return {key: SameModel(*key, tuple(told)) for key, told in crops.items()}


def write_pool(folder: Folder, pool: CameraPool) -> str:
    """Write the pool into the results folder and return its digest."""
    content = pool.to_json()
    if folder.read(CAMERAS_FILE) != content:
        folder.write(CAMERAS_FILE, content)
    return hashlib.sha256(content).hexdigest()


def read_pool(folder: Folder, digest: str) -> CameraPool:
    """Return the pool of that digest; raises OutputError where there is another one."""
    content = folder.read(CAMERAS_FILE) or b""
    if hashlib.sha256(content).hexdigest() != digest:
        raise OutputError(f"{folder.path(CAMERAS_FILE)}: changed while it was used; run the same command again")
    return CameraPool.from_json(content)


def stale_shards(folder: Folder, pool: CameraPool) -> list[int]:
    """Return the shards with photos about whose cameras the evidence from others has changed."""
    return sorted({shard for shard, row in open_rows(folder) if pool.digest_for(row) != (row["others"] or "")})
