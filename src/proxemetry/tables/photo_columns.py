"""The columns of `photos`: one row a photo."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..camera import FocalBasis, FocalSource
from ..scene import STATUSES, Scene
from .column import Column, Value


def _if_counted(value: Callable[[Scene], Value]) -> Callable[[Scene], Value]:
    """No people were counted in a photo that could not be read or was excluded: that is no zero to average in."""
    return lambda s: None if s.status in ("failed", "excluded") else value(s)


def _camera(attribute: str) -> Callable[[Scene], Value]:
    return lambda s: None if s.camera.camera is None else getattr(s.camera.camera, attribute)


def _focal_source(scene: Scene) -> Value:
    return None if scene.camera.source is None else str(scene.camera.source)


def _focal_kind(scene: Scene) -> Value:
    return None if scene.camera.source is None else scene.camera.source.kind.value


def _focal_basis(scene: Scene) -> Value:
    return None if scene.camera.source is None else scene.camera.source.kind.basis.value


def _assumed(scene: Scene) -> Value:
    return None if scene.camera.camera is None else scene.camera.is_assumed


def _camera_flags(scene: Scene) -> Value:
    return "; ".join(map(str, scene.camera.flags)) or None


def _mount_source(scene: Scene) -> Value:
    return None if scene.camera.mount is None else scene.camera.mount.source


def _about(attribute: str) -> Callable[[Scene], Value]:
    return lambda s: getattr(s.about, attribute)


def _corrections(scene: Scene) -> Value:
    return 0 if scene.review is None else scene.review.corrections


def _note(scene: Scene) -> Value:
    return None if scene.review is None else scene.review.note


def _floor(attribute: str, scale: float = 1.0) -> Callable[[Scene], Value]:
    return lambda s: None if s.bodies.floor is None else getattr(s.bodies.floor, attribute) * scale


_DEGREES = 180 / math.pi

PHOTOS = (
    Column("photo", "VARCHAR", "", "path of the photo, relative to the folder named", lambda s: s.photo),
    Column("sha256", "VARCHAR", "", "SHA-256 of the file", lambda s: s.sha256 or None),
    Column(
        "status",
        "VARCHAR",
        "",
        "ok, no_camera (people without distances), failed or excluded",
        lambda s: s.status,
        STATUSES,
    ),
    Column("reason", "VARCHAR", "", "why the status is not ok, and what to do", lambda s: s.reason),
    Column("width_px", "INTEGER", "px", "width of the upright photo", lambda s: s.width_px or None),
    Column("height_px", "INTEGER", "px", "height of the upright photo", lambda s: s.height_px or None),
    Column("focal_px", "DOUBLE", "px", "focal length in pixels of the upright photo", _camera("f_px")),
    Column("focal_source", "VARCHAR", "", "where the focal length came from; ASSUMED is a guess", _focal_source),
    Column("n_people", "INTEGER", "", "people found; empty where the photo is failed or excluded", _if_counted(len)),
    Column("n_pairs", "INTEGER", "", "pairs with a distance", _if_counted(lambda s: s.distances.below(math.inf))),
    Column("seconds", "DOUBLE", "s", "computing time", lambda s: s.seconds),
    Column("focal_rel_sd", "DOUBLE", "", "relative standard deviation of the focal length", _camera("focal_rel_sd")),
    Column("focal_assumed", "BOOLEAN", "", "true: the focal length is a guess, see focal_source", _assumed),
    Column(
        "focal_basis",
        "VARCHAR",
        "",
        "what the focal length rests on: a statement, the photo's file, lines, people or other photos, or a guess",
        _focal_basis,
        tuple(basis.value for basis in FocalBasis),
    ),
    Column(
        "focal_kind",
        "VARCHAR",
        "",
        "what gave the focal length, as one word",
        _focal_kind,
        tuple(source.value for source in FocalSource),
    ),
    Column("camera_flags", "VARCHAR", "", "what is doubtful about the camera", _camera_flags),
    Column("camera_height_m", "DOUBLE", "m", "height of the camera above the floor", _floor("height_m")),
    Column("camera_pitch_deg", "DOUBLE", "deg", "camera pitch, positive looks down", _floor("pitch_rad", _DEGREES)),
    Column("mount_source", "VARCHAR", "", "where prior knowledge of the camera's place came from", _mount_source),
    Column("date", "VARCHAR", "", "when the photo was taken (its metadata)", _about("date")),
    Column("country", "VARCHAR", "", "country (its metadata)", _about("country")),
    Column("city", "VARCHAR", "", "city (its metadata)", _about("city")),
    Column("source", "VARCHAR", "", "agency or source (its metadata)", _about("source")),
    Column("camera_make", "VARCHAR", "", "maker of the camera (its metadata)", _about("camera_make")),
    Column("camera_model", "VARCHAR", "", "model of the camera (its metadata)", _about("camera_model")),
    Column("creator", "VARCHAR", "", "who took the photo (its metadata; --with-names)", _about("creator")),
    Column("caption", "VARCHAR", "", "caption (its metadata; --with-names)", _about("caption")),
    Column(
        "names",
        "VARCHAR",
        "",
        "names of those shown (its metadata; --with-names)",
        lambda s: "; ".join(s.about.people) or None,
    ),
    Column("latitude_deg", "DOUBLE", "deg", "where it was taken (its metadata; --with-gps)", _about("latitude_deg")),
    Column("longitude_deg", "DOUBLE", "deg", "where it was taken (its metadata; --with-gps)", _about("longitude_deg")),
    Column("corrections", "INTEGER", "", "corrections made by hand that are in these numbers", _corrections),
    Column("note", "VARCHAR", "", "a reviewer's remark", _note),
)


def safe_distance_columns(limit_m: float | None) -> tuple[Column, ...]:
    """Return the further columns of the photos table: the safe distance of the run and the pairs below it."""
    return (
        Column("safe_distance_m", "DOUBLE", "m", "the distance asked for with --safe-distance", lambda s: limit_m),
        Column(
            "n_below_safe",
            "INTEGER",
            "",
            "pairs nearer than safe_distance_m",
            _if_counted(lambda s: None if limit_m is None else s.distances.below(limit_m)),
        ),
    )
