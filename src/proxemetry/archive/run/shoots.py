"""The photos of a run that state no focal length, size by size, as shoots of one camera (`--same-camera`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...calibration.background import GrayArray, is_at_one_place, small_gray
from ...calibration.shoot import LEAST_PHOTOS, ShootFit, told_by_shoot
from ...camera.others import SameShoot
from ...errors import PhotoError, ProxemetryError
from ...intervals import HALF_WIDTH_SD
from ...locate import LocateSettings
from ...people import People
from ...photo import Photo
from ...scene import Scene
from ...settings import Settings
from ..store import parts
from ..store.duck import attached
from ..store.folder import Folder, is_url
from ..store.photos import locate
from .camera_pool import CameraPool, Shoot, models_of

#: Sizes of photos that are looked at, those of most photos first, and photos of each.
_MOST_SIZES, _MOST_PHOTOS = 50, 300
#: Photos whose background is looked at, and how many of them must show the same for a camera that stayed.
_BACKGROUNDS, _LEAST_SAME = 24, 0.8
_LOOK_PX = 480
_WITHOUT_FOCAL = "status IN ('ok', 'no_camera') AND own_focal = 'none' AND n_people > 0"


@dataclass(frozen=True, eq=False)
class _Seen:
    """A photo with its people."""

    name: str
    width: int
    height: int
    people: People


def pool_of(folder: Folder, root: str | None, settings: Settings) -> CameraPool:
    """Return what the measured photos of a folder show about each other's cameras, as far as the settings ask."""
    models = models_of(folder) if settings.other_photos else {}
    shoots = shoots_of(folder, root, settings.locate) if settings.same_camera else {}
    return CameraPool(models, shoots)


def shoots_of(folder: Folder, root: str | None, settings: LocateSettings) -> dict[tuple[int, int], Shoot]:
    """Return what the people in all photos of each size show. root: where the photos are, None where there are none."""
    sizes: list[tuple[int, int]] = (
        attached(folder)
        .execute(
            f"SELECT greatest(width_px, height_px), least(width_px, height_px) FROM {parts.every_row(folder)} "
            f"WHERE {_WITHOUT_FOCAL} GROUP BY ALL HAVING count(*) >= {LEAST_PHOTOS} ORDER BY count(*) DESC, 1, 2 "
            f"LIMIT {_MOST_SIZES}"
        )
        .fetchall()
    )
    return {size: _shoot(_photos(folder, size), root, settings) for size in sizes}


def _photos(folder: Folder, size: tuple[int, int]) -> list[_Seen]:
    """Return photos of a size in a fixed arbitrary order, those held like most of them."""
    rows = (
        attached(folder)
        .execute(
            f"SELECT scene FROM {parts.every_row(folder)} WHERE {_WITHOUT_FOCAL} AND "
            "greatest(width_px, height_px) = $long AND least(width_px, height_px) = $short "
            f"ORDER BY md5(photo), photo LIMIT {_MOST_PHOTOS}",
            {"long": size[0], "short": size[1]},
        )
        .fetchall()
    )
    scenes = [Scene.from_json(text) for (text,) in rows]
    wide = sum(scene.width_px >= scene.height_px for scene in scenes) * 2 >= len(scenes)
    return [_Seen(s.photo, s.width_px, s.height_px, s.people) for s in scenes if (s.width_px >= s.height_px) == wide]


def _shoot(photos: Sequence[_Seen], root: str | None, settings: LocateSettings) -> Shoot:
    width, height = photos[0].width, photos[0].height
    named = f"{len(photos)} photos of {width} x {height} pixels without a focal length"
    background, shown = _background(photos, root)
    stayed = [photo for photo in photos if shown.get(photo.name, True)] if background is not None else list(photos)
    try:
        fit = told_by_shoot([p.people for p in stayed], width, height, settings, stayed=background is not None)
    except ProxemetryError as error:
        return Shoot(None, f"{named}: the people do not determine it ({error}): state it")
    low, high = (math.exp(fit.log_focal_px + side * HALF_WIDTH_SD * fit.log_sd) for side in (-1, 1))
    if fit.doubt is not None:
        return Shoot(None, f"{named}: their people leave it open ({low:.0f} to {high:.0f} px; {fit.doubt}): state it")
    said = (
        f"{named}: {math.exp(fit.log_focal_px):.0f} px ({low:.0f} to {high:.0f}) by the people of {fit.photos} of them"
    )
    told = SameShoot(fit.log_focal_px, fit.log_sd, fit.photos, fit.people, fit.mount)
    return Shoot(told, said + _rest(fit, stayed, len(photos)), background)


def _rest(fit: ShootFit, photos: Sequence[_Seen], count: int) -> str:
    """Return what else is to be said of a shoot, in words."""
    parts_of = [f", {fit.people} at once" if fit.people else ""]
    if fit.mount is not None:
        parts_of.append(
            f"; the camera stayed: {fit.mount.height_m:.1f} +- {fit.mount.height_sd_m:.1f} m above the floor"
        )
        if len(photos) < count:
            parts_of.append(f", but in {count - len(photos)} of them it was elsewhere")
    if fit.left_out:
        names = ", ".join(photos[k].name for k in fit.left_out[:3])
        more = ", ..." if len(fit.left_out) > 3 else ""
        parts_of.append(f"; of another camera or zoom by their people: {names}{more}")
    return "".join(parts_of)


def _background(photos: Sequence[_Seen], root: str | None) -> tuple[GrayArray | None, Mapping[str, bool]]:
    """Return the background that nearly all photos show, None where there is none; which of those looked at show it."""
    if root is None or is_url(root):
        return None, {}
    looked: dict[str, GrayArray] = {}
    for photo in photos[:_BACKGROUNDS]:
        try:
            looked[photo.name] = small_gray(Photo.open(locate(root, photo.name)).pixels(long_side_px=_LOOK_PX))
        except PhotoError:
            continue
    if len(looked) < LEAST_PHOTOS:
        return None, {}
    for reference in list(looked.values())[:3]:  # the first may be the odd one
        shown = {name: is_at_one_place(reference, gray) for name, gray in looked.items()}
        if sum(shown.values()) >= _LEAST_SAME * len(shown):
            return reference, shown
    return None, {}
