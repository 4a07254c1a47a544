"""The order of the stages: photo -> camera -> people -> bodies -> scene. Everything above this is a thin face."""

from __future__ import annotations

import copy
import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np

from . import __version__
from .bodies import Bodies
from .camera import Camera, CameraEstimate
from .errors import SettingsError
from .focal import FocalRequest, estimate_camera
from .locate import METHODS, LocateSettings, method_named
from .locate.self_calibration import with_people
from .people import People, PoseBackend
from .photo import Photo, RGBArray
from .scene import Provenance, Scene

DEFAULT_METHOD = "scene"

_NO_CAMERA = "the photo's focal length is unknown"


@dataclass(frozen=True)
class Settings:
    """What a run is told; the same settings on the same photo give the same scene.

    method: one of `locate.METHODS`. locate: what is stated of the people. focal: what is stated of the camera.
    undistort: whether a known lens distortion is taken out of the keypoints.
    """

    method: str = DEFAULT_METHOD
    locate: LocateSettings = field(default_factory=LocateSettings)
    focal: FocalRequest = field(default_factory=FocalRequest)
    undistort: bool = True

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise SettingsError(f"method {self.method!r} is unknown: use one of {', '.join(METHODS)}")

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as JSON values; of a camera table the name and the hash of what it says."""
        return copy.deepcopy(self._fields)

    @cached_property
    def _fields(self) -> dict[str, Any]:
        """The settings as JSON values, made once: every scene carries them, and a camera table may be long."""
        table = self.focal.camera_table
        fields = _plain(asdict(replace(self, focal=replace(self.focal, camera_table=None))))
        if table is not None:
            digest = hashlib.sha256(repr(table.rows).encode()).hexdigest()
            fields["focal"]["camera_table"] = f"{Path(table.source).name} sha256:{digest}"
        return fields

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any], method: str | None = None) -> Settings:
        """Return the settings that `to_dict` described; what it does not name is the default, `method` for its own.

        A camera table is not among them: scenes carry the cameras that were chosen by it.
        """
        locate, focal = dict(fields.get("locate") or {}), dict(fields.get("focal") or {})
        for name in ("off_floor", "quirks"):
            locate[name] = frozenset(locate.get(name) or ())
        for part, name in ((locate, "body_sizes"), (focal, "sensor_mm")):
            part[name] = None if part.get(name) is None else tuple(part[name])
        focal.pop("camera_table", None)
        return cls(
            fields.get("method") or method or DEFAULT_METHOD,
            LocateSettings(**locate),
            FocalRequest(**focal),
            fields.get("undistort", True),
        )


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, frozenset | set):
        return sorted(_plain(v) for v in value)  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]  # pyright: ignore[reportUnknownVariableType]
    return str(value) if isinstance(value, Path) else value


def measure(
    photo: str | Path | RGBArray | Photo,
    *,
    pose: str | PoseBackend | Callable[..., Any] = "auto",
    camera: Camera | CameraEstimate | FocalRequest | None = None,
    method: str | None = None,
    settings: Settings | None = None,
) -> Scene:
    """Measure one photo.

    photo: a file, upright RGB pixels of shape (H, W, 3), or a `Photo`. pose: a back end or its name. camera: what is
    known of it, before what the photo's metadata say. method and camera take precedence over `settings`.

    Raises PhotoError where the photo cannot be read, CameraError, ModelError or SettingsError where what is asked for
    cannot be had. A photo without a known focal length is no error: its scene lists the people, and says why.
    """
    started = time.perf_counter()
    settings = settings or Settings()
    settings = replace(
        settings,
        method=method or settings.method,
        focal=camera if isinstance(camera, FocalRequest) else settings.focal,
    )
    if not isinstance(cast(object, camera), Camera | CameraEstimate | FocalRequest | None):
        raise SettingsError(f"camera must be a Camera, a CameraEstimate or a FocalRequest, not {camera!r:.40}")
    photo = _opened(photo)
    backend = _backend(pose)
    people = backend.detect(photo)
    estimate = _estimate(photo, people, camera or _recorded_camera(backend, photo, settings), settings)
    made_by = Provenance(__version__, settings.method, backend.name, dict(backend.models), settings.to_dict())
    about = photo.metadata.about()
    scene = place(photo.name, photo.sha256, photo.width, photo.height, people, estimate, settings)
    return replace(scene, made_by=made_by, about=about, seconds=time.perf_counter() - started)


def place(
    name: str, sha256: str, width: int, height: int, people: People, estimate: CameraEstimate, settings: Settings
) -> Scene:
    """Return the scene of people already found with a camera already chosen: the last two stages alone."""
    bodies, status, reason = _locate(people, estimate, settings)
    return Scene(
        name, sha256, width, height, status, reason, estimate, people, bodies,
        Provenance(__version__, settings.method, settings=settings.to_dict()),
    )  # fmt: skip


def remeasure(
    scene: Scene, settings: Settings, *, people: People | None = None, camera: CameraEstimate | None = None
) -> Scene:
    """Return a scene placed anew with corrected people, camera or settings; the photo is not looked at."""
    fresh = place(
        scene.photo, scene.sha256, scene.width_px, scene.height_px,
        scene.people if people is None else people, camera or scene.camera, settings,
    )  # fmt: skip
    made_by = replace(scene.made_by, method=settings.method, settings=settings.to_dict())
    return replace(fresh, made_by=made_by, about=scene.about, seconds=scene.seconds)


def _opened(photo: str | Path | RGBArray | Photo) -> Photo:
    if isinstance(photo, Photo):
        return photo
    return Photo.from_array(photo) if isinstance(photo, np.ndarray) else Photo.open(photo)


def _backend(pose: str | PoseBackend | Callable[..., Any]) -> PoseBackend:
    from .pose import backend_named

    if isinstance(pose, str):
        return backend_named(pose)
    if hasattr(pose, "detect"):
        return cast(PoseBackend, pose)
    from .pose.callables import CallableBackend

    return CallableBackend(cast(Callable[[RGBArray], Any], pose))


def _recorded_camera(backend: PoseBackend, photo: Photo, settings: Settings) -> Camera | None:
    """Return the camera that a keypoint file gives for the photo, unless the user states one for the run."""
    camera_of = getattr(backend, "camera_of", None)
    return camera_of(photo) if camera_of is not None and settings.focal == FocalRequest() else None


def _estimate(
    photo: Photo, people: People, camera: Camera | CameraEstimate | FocalRequest | None, settings: Settings
) -> CameraEstimate:
    if isinstance(camera, CameraEstimate):
        return camera
    if isinstance(camera, Camera):
        return CameraEstimate(camera)
    estimate = estimate_camera(photo, settings.focal)
    return with_people(estimate, people, photo.width, photo.height)


def _locate(people: People, estimate: CameraEstimate, settings: Settings) -> tuple[Bodies, str, str | None]:
    if estimate.camera is None:
        # What to do about it is told once a photo, not in the rows of all its people and pairs.
        bodies = Bodies.unplaced(len(people), settings.method, _NO_CAMERA)
        return bodies, "no_camera", estimate.reason or _NO_CAMERA
    camera = estimate.camera
    if settings.undistort:
        people = replace(people, keypoints_px=camera.undistorted(people.keypoints_px))
    bodies = method_named(settings.method)(people, camera.without_distortion(), settings.locate)
    return bodies, "ok", None if len(people) else "nobody found"
