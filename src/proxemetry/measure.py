"""The order of the stages: photo -> camera -> people -> bodies -> scene. Everything above this is a thin face."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from .bodies import MOST_DEPTH_MISFIT, MOST_MISFIT, Bodies
from .camera import Camera, CameraEstimate, Doubt, Flag, FocalSource, Mount
from .camera.choice import PictureLines, choose_camera, with_flight, with_gravity
from .camera.focal import FocalRequest
from .camera.others import Others
from .errors import AssumedFocalWarning, CameraError, PhotoError, SettingsError
from .locate import MEASURE_PUPILS, LocateSettings, method_named
from .people import People, PoseBackend
from .photo import Photo, RGBArray
from .pose.recording import Recording
from .scene import Provenance, Scene
from .settings import Settings
from .version import __version__

_NO_CAMERA = "the photo's focal length is unknown"


def measure(
    photo: str | Path | RGBArray | Photo,
    *,
    pose: str | PoseBackend | Callable[..., Any] = "auto",
    camera: Camera | CameraEstimate | FocalRequest | None = None,
    mount: Mount | None = None,
    focal_35mm: float | None = None,
    focal_mm: float | None = None,
    sensor_mm: tuple[float, float] | None = None,
    focal_px: float | None = None,
    method: str | None = None,
    settings: Settings | None = None,
    others: Others | None = None,
) -> Scene:
    """Measure one photo.

    photo: a file, upright RGB pixels of shape (H, W, 3), or a `Photo`. pose: a back end or its name. camera: what is
    known about the camera; it takes precedence over the photo's metadata. mount: where the camera is; its intrinsics,
    if it has any, are used if no camera is given. focal_35mm, focal_mm with sensor_mm, focal_px: the focal length
    where `camera` is not given, as the options of the command line of the same names. others: what is known from
    other photos of the same camera. method, camera and mount take precedence over `settings`.

    Raises PhotoError where the photo cannot be read, KeypointsError where a back end's answer is malformed,
    CameraError, ModelError or SettingsError where the request cannot be met. A photo without a known focal length
    is no error: where neither its lines nor its people show one, it is measured with the wide interval of published
    photos, an AssumedFocalWarning and its mark; with `FocalRequest(assume=False)` its scene lists the people alone.
    """
    started = time.perf_counter()
    settings = _checked_settings(Settings() if settings is None else settings)
    stated = FocalRequest(focal_mm=focal_mm, focal_35mm=focal_35mm, focal_px=focal_px, sensor_mm=sensor_mm)
    if stated != FocalRequest():
        if camera is not None:
            raise SettingsError("state the focal length or the camera, not both")
        camera = stated
    settings = replace(
        settings,
        method=method or settings.method,
        focal=camera if isinstance(camera, FocalRequest) else settings.focal,
        mount=settings.mount if mount is None else mount,
    )
    if not isinstance(cast(object, camera), Camera | CameraEstimate | FocalRequest | None):
        raise SettingsError(f"camera must be a Camera, a CameraEstimate or a FocalRequest, not {camera!r:.40}")
    photo = _opened(photo)
    backend = _backend(pose, settings.method)
    people = backend.detect(photo)
    lines = PictureLines(photo, people) if settings.lines and len(people) else None
    if lines is not None:
        people = replace(people, framed=lines.people_in_frames())
    estimate = _estimate(photo, people, camera or _recorded_camera(backend, photo, settings), settings, lines, others)
    if settings.drone and settings.method == Settings().method:
        estimate = with_flight(estimate, photo, settings.mount)
    if lines is not None and settings.method == Settings().method:
        estimate = with_gravity(estimate, lines, settings.mount)
    _warn_of_assumption(estimate, photo)
    made_by = Provenance(__version__, backend.name, dict(backend.models), settings.table)
    scene = place(photo.name, photo.sha256, photo.width, photo.height, people, estimate, settings)
    if scene.status == "ok" and not len(people):
        scene = replace(scene, reason=_why_no_people(backend, photo) or scene.reason)
    return replace(scene, made_by=made_by, about=photo.metadata.about(), seconds=time.perf_counter() - started)


def place(
    name: str, sha256: str, width: int, height: int, people: People, estimate: CameraEstimate, settings: Settings,
    mount: Mount | None = None,
) -> Scene:  # fmt: skip
    """Return the scene of people already found with a camera already chosen: the last two stages alone.

    mount: where the camera is, instead of the estimate's and, after that, the settings'.

    Raises CameraError where the camera or its mount is of a photo of another size, SettingsError where the settings
    speak of people who are not there.
    """
    estimate = replace(estimate, mount=mount or estimate.mount or settings.mount)
    _check_size(estimate.camera, width, height)
    if estimate.mount is not None:
        estimate.mount.check_size(width, height)
    _check_rows(settings.locate, len(people))
    bodies, status, reason = _locate(people, estimate, settings)
    estimate = _with_contradiction(_with_depth_contradictions(estimate, people, bodies), bodies)
    return Scene(
        name, sha256, width, height, status, reason, estimate, people, bodies,
        settings=settings.without_table, made_by=Provenance(__version__, camera_table=settings.table),
    )  # fmt: skip


def remeasure(
    scene: Scene, settings: Settings, *, people: People | None = None, camera: Camera | CameraEstimate | None = None
) -> Scene:
    """Return a scene computed again with corrected people, camera or settings; the photo is not read.

    Raises what `place` raises.
    """
    settings = _checked_settings(settings)
    estimate = CameraEstimate(camera) if isinstance(camera, Camera) else camera or scene.camera
    fresh = place(
        scene.photo, scene.sha256, scene.width_px, scene.height_px,
        scene.people if people is None else people, estimate, settings,
    )  # fmt: skip
    return replace(fresh, made_by=scene.made_by, review=scene.review, about=scene.about, seconds=scene.seconds)


def _opened(photo: str | Path | RGBArray | Photo) -> Photo:
    if isinstance(photo, Photo):
        return photo
    if isinstance(photo, np.ndarray):
        return Photo.from_array(photo)
    if not isinstance(cast(object, photo), str | Path):
        raise PhotoError(
            f"a photo is a path, upright RGB pixels of shape (H, W, 3) or a Photo, not {type(photo).__name__}: of a "
            "PIL image give its file, or numpy.asarray(image.convert('RGB')), which has nothing on the lens"
        )
    return Photo.open(photo)


def _checked_settings(settings: Settings) -> Settings:
    if not isinstance(cast(object, settings), Settings):
        raise SettingsError(
            f"settings must be a Settings, not {type(settings).__name__}: Settings(locate=..., focal=...)"
        )
    return settings


def _check_size(camera: Camera | None, width: int, height: int) -> None:
    """Refuse the camera of a larger or smaller copy: every distance would be off by their ratio."""
    if camera is not None and (camera.width, camera.height) != (width, height):
        raise CameraError(
            f"the camera is of {camera.width} x {camera.height} pixels, the photo of {width} x {height}: give "
            f"camera.resized({width}, {height}) if the photo was resized, camera.cropped(...) if it was cropped"
        )


def _check_rows(settings: LocateSettings, count: int) -> None:
    """Refuse what is stated of people by row where the rows are not those of the people."""
    for name, stated in (("body_sizes", settings.body_sizes), ("statures", settings.statures)):
        if stated is not None and len(stated) != count:
            raise SettingsError(f"{name} has {len(stated)} entries for {count} people: one each, None for most")
    if any(isinstance(row, bool | np.bool_) for row in settings.off_floor):
        raise SettingsError("off_floor is a mask: it names the rows of people, as numpy.flatnonzero(mask) does")
    beyond = sorted(row for row in settings.off_floor if not 0 <= row < count)
    if beyond:
        raise SettingsError(f"off_floor names person {beyond[0]}, but there are {count} people, counted from 0")


def _backend(pose: str | PoseBackend | Callable[..., Any], method: str) -> PoseBackend:
    from .pose import PoseOptions, backend_named

    if isinstance(pose, str):
        return backend_named(pose, PoseOptions(pupils=method in MEASURE_PUPILS))
    if hasattr(pose, "detect"):
        return cast(PoseBackend, pose)
    if not callable(cast(object, pose)):
        hint = "; people found before are given as lambda pixels: people" if isinstance(pose, People) else ""
        raise SettingsError(
            f"pose must be a back end's name, a back end or a function of pixels, not {type(pose).__name__}{hint}"
        )
    from .pose.callables import CallableBackend

    return CallableBackend(cast(Callable[[RGBArray], Any], pose))


def _recorded_camera(backend: PoseBackend, photo: Photo, settings: Settings) -> Camera | None:
    """Return the camera that a keypoint file gives for the photo, unless the user states one for the run."""
    if not isinstance(backend, Recording) or settings.focal != FocalRequest():
        return None
    found_with_place = settings.mount is not None and settings.mount.camera is not None
    return None if found_with_place else backend.camera_of(photo)


def _why_no_people(backend: PoseBackend, photo: Photo) -> str | None:
    """Return why a back end that does not look at the photo finds no people."""
    return backend.why_no_people(photo) if isinstance(backend, Recording) else None


def _estimate(
    photo: Photo, people: People, camera: Camera | CameraEstimate | FocalRequest | None, settings: Settings,
    lines: PictureLines | None, others: Others | None,
) -> CameraEstimate:  # fmt: skip
    if isinstance(camera, CameraEstimate):
        return camera
    if isinstance(camera, Camera):
        return CameraEstimate(camera)
    return choose_camera(photo, people, settings.focal, settings.mount, lines, others)


def _warn_of_assumption(estimate: CameraEstimate, photo: Photo) -> None:
    if estimate.source is not None and estimate.source.kind is FocalSource.ASSUMED_PRIOR:
        warnings.warn(
            f"{photo.name}: focal length {estimate.source}; every distance is as uncertain. "
            "State it: measure(..., camera=FocalRequest(focal_35mm=35)), or refuse: FocalRequest(assume=False)",
            AssumedFocalWarning, stacklevel=3,
        )  # fmt: skip


def _locate(people: People, estimate: CameraEstimate, settings: Settings) -> tuple[Bodies, str, str | None]:
    if estimate.camera is None:
        # What to do about it stands once a photo, not in the rows of all its people and pairs.
        bodies = Bodies.unplaced(len(people), settings.method, _NO_CAMERA)
        return bodies, "no_camera", estimate.reason or _NO_CAMERA
    camera = estimate.camera
    if settings.undistort:
        people = replace(people, keypoints_px=camera.undistorted(people.keypoints_px))
    locate = method_named(settings.method)
    bodies = locate(people, camera.without_distortion(), settings.locate, estimate.mount)
    return bodies, "ok", None if len(people) else "no people found"


def _with_contradiction(estimate: CameraEstimate, bodies: Bodies) -> CameraEstimate:
    """Return the estimate with a doubt where the people contradict the mount."""
    kept = tuple(flag for flag in estimate.flags if flag.doubt is not Doubt.MOUNT)
    if not bodies.mount_misfit > MOST_MISFIT:
        return replace(estimate, flags=kept)
    assert estimate.mount is not None
    off = f"{estimate.mount.source}; {bodies.mount_misfit:.1f} standard deviations off"
    doubt = f"the people contradict the camera's pitch, roll or height ({off}), or they stand on no level floor"
    return replace(estimate, flags=(*kept, Flag(Doubt.MOUNT, doubt)))


#: People whose stated depths are named as contradicted; beyond, they are counted.
_MOST_NAMED = 3


def _with_depth_contradictions(estimate: CameraEstimate, people: People, bodies: Bodies) -> CameraEstimate:
    """Return the estimate with a doubt where the picture contradicts depths that are stated of people."""
    kept = tuple(flag for flag in estimate.flags if flag.doubt is not Doubt.DEPTH)
    rows = np.flatnonzero(np.abs(bodies.depth_misfit) > MOST_DEPTH_MISFIT)
    if not len(rows):
        return replace(estimate, flags=kept)
    named = ", ".join(
        f"person {row} {people.depth_m[row]:.3g} m stated, {bodies.positions_m[row, 2]:.3g} m seen"
        for row in rows[:_MOST_NAMED]
    )
    more = f" and {len(rows) - _MOST_NAMED} more" if len(rows) > _MOST_NAMED else ""
    doubt = f"the picture contradicts {len(rows)} of the {int(np.isfinite(people.depth_m).sum())} stated depths"
    return replace(estimate, flags=(*kept, Flag(Doubt.DEPTH, f"{doubt} ({named}{more})")))
