"""The settings of a run, as one value: the same settings on the same photo give the same scene."""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from .camera import Mount
from .camera.focal import FocalRequest
from .errors import SettingsError
from .locate import METHODS, LocateSettings

DEFAULT_METHOD = "scene"


@dataclass(frozen=True)
class Settings:
    """The settings of a run; the same settings on the same photo give the same scene.

    method: one of `locate.METHODS`. locate: what is stated about the people. focal: what is stated about the camera.
    undistort: whether a known lens distortion is corrected in the keypoints. mount: where the camera is, for all photos
    of the run; a row of the camera table takes precedence over it. lines: whether the picture's straight lines
    are used, which show gravity where no mount does, and often a focal length that nothing states. drone: whether
    the height and the gimbal's angles that a drone writes into its photos are used where there is no mount.
    other_photos: whether, in a run of many, photos of the same camera model reveal the sensor that a photo's own file
    leaves open. same_camera: whether the photos of a run that state no focal length are, size by size, of one camera
    and lens: then it is found from the people in all of them.
    """

    method: str = DEFAULT_METHOD
    locate: LocateSettings = field(default_factory=LocateSettings)
    focal: FocalRequest = field(default_factory=FocalRequest)
    undistort: bool = True
    mount: Mount | None = None
    lines: bool = True
    drone: bool = True
    other_photos: bool = True
    same_camera: bool = False

    def __post_init__(self) -> None:
        self._check_kinds()
        if self.method not in METHODS:
            raise SettingsError(f"method {self.method!r} is unknown: use one of {', '.join(METHODS)}")
        if self.mount is not None and self.mount.camera is not None and self.focal.states_focal:
            raise SettingsError("the mount has a focal length of its own: leave out what else is stated of it")

    def _check_kinds(self) -> None:
        """Refuse values of another kind: undistort="no" would mean yes, focal={...} nothing."""
        kinds = {
            "locate": (LocateSettings, "a LocateSettings"),
            "focal": (FocalRequest, "a FocalRequest"),
            "mount": (Mount | None, "a Mount, as Mount.read(FILE) gives one"),
        }
        for name, (kind, wanted) in kinds.items():
            if not isinstance(getattr(self, name), kind):
                raise SettingsError(f"settings: {name} must be {wanted}, not {getattr(self, name)!r:.40}")
        for name in ("undistort", "lines", "drone", "other_photos", "same_camera"):
            value = getattr(self, name)
            if not isinstance(value, bool | np.bool_):
                raise SettingsError(f"settings: {name} is {value!r:.40}: it must be True or False")
            object.__setattr__(self, name, bool(value))

    @cached_property
    def without_table(self) -> Settings:
        """The same without the camera table: a scene carries the camera that was chosen by it."""
        if self.focal.camera_table is None:
            return self
        return replace(self, focal=replace(self.focal, camera_table=None))

    @cached_property
    def table(self) -> str:
        """The name of the camera table and the hash of its rows, "" where there is none."""
        table = self.focal.camera_table
        if table is None:
            return ""
        return f"{Path(table.source).name} sha256:{hashlib.sha256(repr(table.rows).encode()).hexdigest()}"

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as JSON values; of a camera table its `table`."""
        return copy.deepcopy(self._fields)

    @cached_property
    def _fields(self) -> dict[str, Any]:
        """The settings as JSON values, made once: every scene carries them."""
        fields = _json_value(asdict(replace(self.without_table, mount=None)))
        fields["mount"] = None if self.mount is None else self.mount.to_dict()
        if self.table:
            fields["focal"]["camera_table"] = self.table
        return fields

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Settings:
        """Return the settings that `to_dict` described; what it does not name is the default.

        A camera table is not among them: scenes carry the cameras that were chosen by it.
        """
        locate, focal = dict(fields.get("locate") or {}), dict(fields.get("focal") or {})
        for name in ("off_floor", "quirks"):
            locate[name] = frozenset(locate.get(name) or ())
        for part, name in ((locate, "body_sizes"), (focal, "sensor_mm")):
            part[name] = None if part.get(name) is None else tuple(part[name])
        if locate.get("statures") is not None:
            locate["statures"] = tuple(s and tuple(s) for s in locate["statures"])
        focal.pop("camera_table", None)
        return cls(
            fields.get("method") or DEFAULT_METHOD,
            LocateSettings(**locate),
            FocalRequest(**focal),
            fields.get("undistort", True),
            None if fields.get("mount") is None else Mount.from_dict(fields["mount"]),
            fields.get("lines", True),
            fields.get("drone", True),
            fields.get("other_photos", True),
            fields.get("same_camera", False),
        )


def _json_value(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _json_value(v) for k, v in value.items()}  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, frozenset | set):
        return sorted(_json_value(v) for v in value)  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, tuple | list):
        return [_json_value(v) for v in value]  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    return str(value) if isinstance(value, Path) else value
