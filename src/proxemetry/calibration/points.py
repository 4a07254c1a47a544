"""A camera's place from points of the floor whose pixels and metres are known, by least squares."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..camera import Camera, FloorFrame, Mount
from ..camera.floor_view import to_floor, to_pixels
from ..errors import CameraError
from ..files import csv_lines, read_text
from .homography import focal_of, homography, place_of
from .least_squares import minimise

#: How well the principal point of an uncalibrated camera is known, as a share of the picture's long side.
PRINCIPAL_REL_SD = 0.01
#: What a click and a tape are worth unless they are stated: standard deviations.
CLICK_SD_PX, TAPE_SD_M = 2.0, 0.05
#: Pixels or metres beyond which no picture and no place of one camera reaches; their squares are ordinary numbers.
LARGEST = 1e7
COLUMNS = ("u_px", "v_px", "x_m", "y_m")
#: A lens of which nothing is known: about a normal one, and by how much it may be another (logarithm).
OPEN_FOCAL_LOG_SD = 1.0
_TYPICAL_FIELD_RAD = math.radians(60.0)
#: Angles (radians), log height and places (metres) that nothing determines: a camera straight above has no roll of its
#: own.
_ANYWHERE = 100.0
#: A camera that looks down more steeply has no horizon worth the name, and no upper side of its pictures.
_STEEP_RAD = math.radians(60.0)
#: Of a height or a focal length against its start: what a step of the search may not go beyond.
_MOST_LOG = 30.0
#: The unknowns before the principal point: pitch, roll, log height, x, y, yaw and focal length.
_PRINCIPAL = 7
#: A point that misses by more standard deviations than this is named.
_WRONG = 3.5


@dataclass(frozen=True, eq=False)
class FloorPoints:
    """N points of the floor: points_px, shape (N, 2), where they are seen, and floor_m, shape (N, 2), where they are.

    click_sd_px, tape_sd_m: standard deviations along each axis. Raises CameraError for fewer than four points or any
    that is no finite number.
    """

    points_px: FloatArray
    floor_m: FloatArray
    click_sd_px: float = CLICK_SD_PX
    tape_sd_m: float = TAPE_SD_M

    def __post_init__(self) -> None:
        for name in ("points_px", "floor_m"):
            values = np.array(getattr(self, name), dtype=float).reshape(-1, 2)
            if not (fits := (abs(values) <= LARGEST).all(axis=1)).all():
                row = int(np.flatnonzero(~fits)[0]) + 1
                raise CameraError(
                    f"point {row} has no {name} of at most {LARGEST:g}: every point takes four such numbers"
                )
            object.__setattr__(self, name, values)
        if len(self.points_px) != len(self.floor_m):
            raise CameraError(f"{len(self.points_px)} pixels with {len(self.floor_m)} places: they must be as many")
        if len(self) < 4:
            raise CameraError(f"{len(self)} points: four or more are needed, spread over the floor and not on one line")
        if not (0 < self.click_sd_px <= LARGEST and 0 < self.tape_sd_m <= LARGEST):
            raise CameraError("the click's and the tape's standard deviations must be positive")

    def __len__(self) -> int:
        return len(self.points_px)

    @classmethod
    def read(cls, path: str | Path, click_sd_px: float = CLICK_SD_PX, tape_sd_m: float = TAPE_SD_M) -> FloorPoints:
        """Read a CSV file of u_px, v_px, x_m, y_m; raises CameraError with the line that is wrong."""
        try:
            lines = csv_lines(read_text(path))
        except OSError as error:
            raise CameraError(f"{path}: cannot be read ({error.strerror})") from error
        except UnicodeDecodeError as error:
            raise CameraError(f"{path}: not UTF-8 text; save it as CSV UTF-8") from error
        header = next((line for line in lines if line.strip()), "")
        semicolons = header.count(";") > header.count(",")
        reader = csv.DictReader(lines, delimiter=";" if semicolons else ",", skipinitialspace=True)
        if missing := [name for name in COLUMNS if name not in map(str.strip, reader.fieldnames or ())]:
            raise CameraError(f"{path}: there is no column {missing[0]}; it needs {', '.join(COLUMNS)}")
        rows: list[list[float]] = []
        for record in reader:
            cells = {(k or "").strip(): (v or "").strip() for k, v in record.items() if isinstance(v, str | None)}
            if not any(cells.values()):
                continue
            try:
                rows.append([float(cells[n].replace(",", ".") if semicolons else cells[n]) for n in COLUMNS])
            except ValueError as error:
                raise CameraError(f"{path}, line {reader.line_num}: {error}; every point takes four numbers") from None
        try:
            table = np.array(rows).reshape(-1, 4)
            return cls(table[:, :2], table[:, 2:], click_sd_px, tape_sd_m)
        except CameraError as error:
            raise CameraError(f"{path}: {error}") from error


@dataclass(frozen=True, eq=False)
class PointsFit:
    """The camera found from points, and how well they fit.

    residual_px, residual_m: shape (N, 2), where a point was clicked less where the camera would show it, and the same
    on the floor. surprise: shape (N,), the residual in standard deviations of click and tape. spread: by what factor
    the points miss more than click and tape would have them, 1 where they do not.
    """

    mount: Mount
    points: FloorPoints
    residual_px: FloatArray
    residual_m: FloatArray
    surprise: FloatArray
    spread: float

    @property
    def wrong(self) -> tuple[int, ...]:
        """Points, counted from 1, that miss by more than click and tape explain."""
        return tuple(int(k) + 1 for k in np.flatnonzero(self.surprise > _WRONG))


def from_points(points: FloorPoints, camera: Camera, *, focal_known: bool = True) -> PointsFit:
    """Return the mount of a camera that shows points of a level floor.

    camera: the intrinsics, believed within their standard deviations; with focal_known False its focal length is only
    where the search begins. Raises CameraError where the points determine no camera that sees them all.
    """
    start, frame, focal_log = _start(points, camera, focal_known)
    nominal = camera if focal_known else camera.with_focal(camera.f_px * math.exp(focal_log), source=camera.source)
    focal_sd = camera.focal_rel_sd if focal_known else OPEN_FOCAL_LOG_SD
    beforehand = np.array([focal_sd, camera.principal_sd_px, camera.principal_sd_px])
    expected = np.array([0.0 if focal_known else -focal_log / focal_sd, 0.0, 0.0])

    def mount_of(unknowns: FloatArray) -> Mount:
        pitch, roll, log_height, x, y, yaw = map(float, unknowns[:6])
        focal, cx, cy = map(float, unknowns[6:] * beforehand)  # in standard deviations of what is known beforehand
        lens = replace(
            nominal, fx=nominal.fx * math.exp(focal), fy=nominal.fy * math.exp(focal), cx=nominal.cx + cx,
            cy=nominal.cy + cy,
        )  # fmt: skip
        place = FloorFrame(x, y, yaw, frame.mirrored)
        return Mount.stated(pitch, roll, math.exp(log_height), camera=lens, floor_frame=place)

    def whitened(unknowns: FloatArray) -> FloatArray:
        if abs(unknowns[0]) > math.pi / 2 or (abs(unknowns[[2, 6]] * (1.0, focal_sd)) > _MOST_LOG).any():
            return np.full(2 * len(points) + 3, 1e6)
        return np.concatenate([_missed(mount_of(unknowns), points).ravel(), unknowns[6:] - expected])

    unknowns, normal = minimise(whitened, np.concatenate([start, [0.0, 0.0, 0.0]]))
    surprise = np.linalg.norm(_missed(mount_of(unknowns), points), axis=1) / math.sqrt(2)
    if not np.isfinite(surprise).all() or (surprise > 1e5).any():
        raise CameraError("no camera above the floor shows all these points before it: check their pixels and metres")
    freedom = 2 * len(points) - 6 - (0 if focal_known else 1)
    spread = math.sqrt(max(1.0, float((surprise**2).sum() * 2 / freedom))) if freedom > 0 else 1.0
    found = mount_of(unknowns)
    mount = _with_covariance(found, normal, spread, len(points), focal_sd)
    seen = to_pixels(found, _floor(found, points.floor_m))
    missed_m = _user(found, to_floor(found, points.points_px)) - points.floor_m
    return PointsFit(mount, points, points.points_px - seen, missed_m, surprise, spread)


def from_homography(
    px_to_floor: FloatArray, camera: Camera, *, focal_known: bool = True, click_sd_px: float = CLICK_SD_PX,
    tape_sd_m: float = TAPE_SD_M,
) -> PointsFit:  # fmt: skip
    """Return the mount behind a homography (3, 3) from pixels to metres: as four points of the picture give it.

    Raises CameraError where less than a third of the picture lies below the homography's horizon, or the horizon lies
    below the floor.
    """
    w, h = camera.width, camera.height
    grid = np.stack(np.meshgrid(np.linspace(0.1, 0.9, 17) * w, np.linspace(0.1, 0.95, 18) * h), axis=-1).reshape(-1, 2)
    seen = np.column_stack([grid, np.ones(len(grid))]) @ px_to_floor.T
    near = seen[-1, 2]  # the lowest row is floor, or nothing is
    depth = seen[:, 2] / near
    usable = grid[(depth > 0.15) & np.isfinite(depth)]
    if len(usable) < len(grid) / 3:
        raise CameraError(
            "the homography's horizon runs through the lower part of the picture: it does not describe a floor"
        )
    low, high = usable[:, 1].min(), usable[:, 1].max()
    corners = np.array([(0.1 * w, high), (0.9 * w, high), (0.1 * w, low), (0.9 * w, low)])
    corners = np.array([usable[np.linalg.norm(usable - corner, axis=1).argmin()] for corner in corners])
    floor = np.column_stack([corners, np.ones(4)]) @ px_to_floor.T
    points = FloorPoints(corners, floor[:, :2] / floor[:, 2:], click_sd_px, tape_sd_m)
    fit = from_points(points, camera, focal_known=focal_known)
    if math.cos(fit.mount.roll_rad) < 0 and fit.mount.pitch_rad < _STEEP_RAD:
        raise CameraError(
            "the homography's horizon runs through the lower part of the picture, or below it: upside down?"
        )
    return replace(fit, mount=replace(fit.mount, source="homography"))


def open_camera(width: int, height: int) -> Camera:
    """Return the camera of a picture of which nothing is known, for points to find its focal length."""
    return Camera.centred(max(width, height) / 2 / math.tan(_TYPICAL_FIELD_RAD / 2), width, height)


def _start(points: FloorPoints, camera: Camera, focal_known: bool) -> tuple[FloatArray, FloorFrame, float]:
    """Return pitch, roll, log height, x, y and yaw by linear equations, the floor's frame, and the log focal length."""
    straight = camera.undistorted(points.points_px)
    matrix = homography(points.floor_m, straight)
    focal = camera.fx
    if not focal_known:
        focal = focal_of(matrix, (camera.cx, camera.cy), camera.fx / camera.fy) or camera.fx
    inside = np.array([[focal, 0, camera.cx], [0, focal * camera.fy / camera.fx, camera.cy], [0, 0, 1]])
    pitch, roll, height, frame = place_of(np.linalg.inv(inside) @ matrix, points.floor_m)
    place = np.array([pitch, roll, math.log(height), frame.x_m, frame.y_m, frame.yaw_rad])
    return place, frame, math.log(focal / camera.fx)


def _missed(mount: Mount, points: FloorPoints) -> FloatArray:
    """Return how far each point is from where the camera would show it (N, 2), in standard deviations."""
    floor = _floor(mount, points.floor_m)
    seen = to_pixels(mount, floor)
    by = [
        (to_pixels(mount, _floor(mount, points.floor_m + aside)) - seen) / 1e-3 for aside in ((1e-3, 0.0), (0.0, 1e-3))
    ]
    sway = np.stack(by, axis=-1) * points.tape_sd_m
    covariance = sway @ sway.swapaxes(1, 2)
    # Close to the horizon a tape's width is the whole picture, next to which a click is lost in rounding.
    click = points.click_sd_px**2 + 1e-12 * np.trace(covariance, axis1=1, axis2=2)
    covariance = covariance + click[:, None, None] * np.eye(2)
    away = np.nan_to_num(points.points_px - seen, nan=1e6, posinf=1e6, neginf=-1e6)
    if not np.isfinite(covariance).all():
        return away
    return np.asarray(np.linalg.solve(np.linalg.cholesky(covariance), away[..., None])[..., 0], dtype=float)


def _floor(mount: Mount, points_m: FloatArray) -> FloatArray:
    return points_m if mount.floor_frame is None else mount.floor_frame.from_user(points_m)


def _user(mount: Mount, floor_m: FloatArray) -> FloatArray:
    return floor_m if mount.floor_frame is None else mount.floor_frame.to_user(floor_m)


def _with_covariance(mount: Mount, normal: FloatArray, spread: float, count: int, focal_sd: float) -> Mount:
    """Return the mount with the pitch, roll, height and focal length of its normal equations.

    Its principal point is held where it was found. Wherever that truly is, pitch and roll make up for it: together they
    put the floor where the points are, and a spread of the angles alone would move it.
    """
    try:
        held = (normal + np.diag([_ANYWHERE**-2] * 6 + [0.0] * 3))[:_PRINCIPAL, :_PRINCIPAL]
        covariance = np.linalg.inv(held) * spread**2
    except np.linalg.LinAlgError as error:
        raise CameraError(
            "the points determine no camera: take points that span an area, well below the horizon"
        ) from error
    which, scale = np.array([0, 1, 2, 6]), np.array([1.0, 1.0, 1.0, focal_sd])
    block = covariance[np.ix_(which, which)] * scale * scale[:, None]
    # Straight above, roll and heading are one: an angle that is off by more than half a turn is anywhere.
    sd = np.sqrt(np.maximum(np.diag(block), 0.0))
    shrink = np.where([True, True, False, False], np.minimum(1.0, math.pi / np.maximum(sd, 1e-300)), 1.0)
    block = block * shrink * shrink[:, None]
    known = np.diag(block) > 0
    rows = np.where(known[:, None] & known, block, np.nan)
    camera = mount.camera
    if camera is not None and known[3]:
        camera = replace(camera, focal_rel_sd=math.sqrt(block[3, 3]))
    if camera is not None:
        camera = replace(camera, principal_sd_px=0.0)
    return replace(
        mount, covariance=tuple(map(tuple, rows.tolist())), camera=camera, source=f"{count} points of the floor"
    )
