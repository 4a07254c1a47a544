"""People as boxes that another program found: where a box stands on the floor, by the camera's mount alone.

For views in which no pose back end finds people, such as from straight above, and for users with a detector of their
own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies, Floor
from ..camera import CameraEstimate, Mount
from ..distances import ground_frame
from ..errors import CameraError, KeypointsError
from ..files import read_bytes
from ..measure import Settings
from ..people import People
from ..people.skeleton import COCO_17
from ..photo import Photo
from ..scene import Scene

#: How well a box's lower edge and middle show where the feet are, in box heights and widths.
_FOOT_SD_HEIGHTS, _FOOT_SD_WIDTHS = 0.03, 0.08
#: Files often have whole pixels, so that even the smallest box is known no better than that.
_WHOLE_PX_SD = 0.5
#: A box whose lower edge comes so near the horizon that its place is not known within its own distance has none.
_FAR_REL_SD = 1.0
#: No picture has as many pixels or frames; the numbers' squares are ordinary numbers.
_LARGEST = 1e9
#: The middle of a standing torso is so high above the floor (ANSUR II: acromion 1.39 m, trochanterion 0.87 m).
_TORSO_M = 1.13


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes of a MOT Challenge text file: frame number from 1, -> x0, y0, x1, y1 and score, shape (P, 5)."""

    name: str
    sha256: str
    frames: Mapping[int, FloatArray] = field(repr=False)

    @classmethod
    def read(cls, path: str | Path) -> Boxes:
        """Read `frame, id, left, top, width, height, score, ...`; raises KeypointsError for any other line."""
        path = Path(path)
        try:
            content = read_bytes(path)
        except OSError as error:
            raise KeypointsError(f"{path}: cannot be read ({error.strerror})") from error
        rows: dict[int, list[list[float]]] = {}
        for number, line in enumerate(content.decode("utf-8-sig", "replace").splitlines(), start=1):
            cells = line.replace(",", " ").split()
            if not cells:
                continue
            try:
                frame, _, left, top, width, height, *rest = map(_number, cells)
            except ValueError as error:
                raise KeypointsError(
                    f"{path}, line {number}: not `frame, id, left, top, width, height, score` of MOT Challenge"
                ) from error
            score = min(1.0, rest[0]) if rest and rest[0] >= 0 else 1.0
            if score > 0 and width > 0 and height > 0:
                rows.setdefault(int(frame), []).append([left, top, left + width, top + height, score])
        return cls(path.name, hashlib.sha256(content).hexdigest(), {k: np.array(v) for k, v in rows.items()})

    def scene(self, photo: Photo, source: int, settings: Settings) -> Scene:
        """Return the people of a frame, `source` being its number in the clip from 0; raises CameraError."""
        found = self.frames.get(source + 1, np.zeros((0, 5)))
        count, joints = len(found), len(COCO_17)
        people = People(
            COCO_17, np.full((count, joints, 2), np.nan), np.zeros((count, joints)), found[:, :4], found[:, 4]
        )
        mount = settings.mount
        if (
            mount is None
            or mount.camera is None
            or not np.isfinite([mount.pitch_rad, mount.roll_rad, mount.height_m]).all()
        ):
            raise CameraError("boxes stand on the floor of a calibrated camera: give --mount, with its focal length")
        mount.check_size(photo.width, photo.height)
        estimate = CameraEstimate(mount.camera, mount=mount)
        reason = None if count else "no people found"
        return Scene(
            photo.name, photo.sha256, photo.width, photo.height, "ok", reason, estimate, people, standing(people, mount)
        )


def standing(people: People, mount: Mount) -> Bodies:
    """Return boxes as bodies that stand where their lower edge touches the floor; nowhere above the horizon."""
    camera = mount.camera
    assert camera is not None
    boxes = people.boxes_px
    pitch, roll = mount.pitch_rad, mount.roll_rad
    up = np.array([np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch), -np.sin(pitch)])
    axes = ground_frame(up)
    feet = np.stack([(boxes[:, 0] + boxes[:, 2]) / 2, boxes[:, 3]], axis=-1)
    sizes = boxes[:, 2:4] - boxes[:, :2]
    sd = np.hypot((_FOOT_SD_WIDTHS, _FOOT_SD_HEIGHTS) * sizes, _WHOLE_PX_SD)
    place = _on_floor(camera.rays(feet), axes, mount.height_m)
    slopes = np.stack([
        (_on_floor(camera.rays(feet + step), axes, mount.height_m) - place) for step in np.eye(2)
    ], axis=-1)  # fmt: skip
    known = np.asarray(np.isfinite(place).all(axis=1) & np.isfinite(slopes).all(axis=(1, 2)), dtype=bool).reshape(-1)
    own = axes[:2].T @ (slopes * sd[:, None, :] ** 2 @ slopes.transpose(0, 2, 1)) @ axes[:2]
    reach = (place**2).sum(axis=1) + mount.height_m**2
    told = np.asarray(own.trace(axis1=1, axis2=2) <= _FAR_REL_SD**2 * reach, dtype=bool).reshape(-1)
    size = np.array([camera.width, camera.height])
    inside = np.asarray(((feet >= -size) & (feet <= 2 * size)).all(axis=1), dtype=bool).reshape(-1)
    reasons = [
        "the box lies outside the picture" if not i else "the box ends above the horizon" if not k
        else None if t else "the box ends too near the horizon"
        for i, k, t in zip(inside.tolist(), known.tolist(), told.tolist(), strict=True)
    ]  # fmt: skip
    known &= told & inside
    count = len(boxes)
    covariance = np.full((count, 3, count, 3), np.nan)
    placed = np.flatnonzero(known)
    for k in placed:
        covariance[k][:, placed] = 0.0
    for k in placed:
        covariance[k, :, k, :] = own[k] + np.outer(up, up) * 0.1**2
    positions = place @ axes[:2] + (_TORSO_M - mount.height_m) * up
    positions[~known] = np.nan
    basis = tuple("box" if k else "" for k in known.tolist())
    floor = Floor(mount.height_m, pitch, roll, mount.height_sd_m, float(mount.sd[0]), float(mount.sd[1]))
    return Bodies(positions, covariance.reshape(3 * count, 3 * count), "box", basis, tuple(reasons), up=up, floor=floor)


def _number(cell: str) -> float:
    value = float(cell)
    if not abs(value) <= _LARGEST:
        raise ValueError(cell)
    return value


def _on_floor(rays: FloatArray, axes: FloatArray, height_m: float) -> FloatArray:
    """Return where rays (n, 3) meet the floor, metres to the right and ahead (n, 2); NaN where they do not."""
    turned = rays @ axes.T
    down = np.where(turned[:, 2] < -1e-6, -turned[:, 2], np.nan)
    return turned[:, :2] * (height_m / down)[:, None]
