"""`proxemetry calibrate`: where a fixed camera is, once, for all its photos."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..calibration.points import CLICK_SD_PX, TAPE_SD_M
from ..camera import Camera, Mount
from ..camera.focal import FocalRequest
from ..camera.mount import STATED_ANGLE_SD_RAD
from ..errors import CameraError, PhotoError, SettingsError
from ..photo import Photo
from . import DONE
from .camera_options import add_camera_options, focal_request, number
from .named_pictures import FPS, first_photos

_EXAMPLES = """examples:
  proxemetry calibrate frame.jpg --points points.csv --out camera.json     four points on the floor or more: the best
  proxemetry calibrate clip.mp4 --out camera.json                          from the people in it: 30 or more
  proxemetry calibrate photos --length 120,540,610,530,6.2 --out camera.json   from the people and a taped line
  proxemetry calibrate frame.jpg --height-m 7 --pitch-deg 16.5 --out camera.json   what is already known
  proxemetry calibrate drone.jpg --out camera.json                         a drone's photo states where it was taken

points.csv has the columns u_px,v_px,x_m,y_m: pixels of the upright full-size picture, metres on the floor from any
corner you like. Next to camera.json a picture is written with the floor's metre grid and the horizon: check that they
fit. Then: proxemetry measure photos --out results --mount camera.json
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("paths", nargs="*", metavar="PATH", help="photos of the camera, folders of them, or a clip")
    parser.add_argument(
        "--out", required=True, metavar="CAMERA.json", help="file to write, with a picture (.png) beside it"
    )
    parser.add_argument("--size", type=_size, metavar="WxH", help="size of the photos in pixels, if no photo is given")
    known = parser.add_argument_group("what is known (with none of these, the people are used)")
    known.add_argument("--points", metavar="FILE.csv", help="points on the floor: u_px,v_px,x_m,y_m, four or more")
    known.add_argument(
        "--length",
        action="append",
        metavar="U,V,U,V,M",
        default=[],
        help="a taped line on the floor; may be given again",
    )
    known.add_argument("--homography", metavar="FILE", help="three lines of three numbers: pixels to floor metres")
    known.add_argument("--height-m", type=number, metavar="H", help="height of the lens above the floor")
    known.add_argument(
        "--pitch-deg", type=number, metavar="P", help="degrees by which the camera looks down; 90: straight down"
    )
    known.add_argument(
        "--roll-deg", type=number, metavar="R", help="degrees by which it is tilted sideways (default: unknown)"
    )
    known.add_argument("--subtitles", metavar="FILE.srt", help="of a drone's clip: its height and gimbal")
    known.add_argument("--height-sd-m", type=number, metavar="SD", help="default: 3 %% of the height")
    known.add_argument("--pitch-sd-deg", type=number, metavar="SD", help="default: 1")
    known.add_argument("--roll-sd-deg", type=number, metavar="SD", help="default: 1")
    known.add_argument("--click-sd-px", type=number, metavar="SD", default=CLICK_SD_PX, help="default: %(default)g")
    known.add_argument("--tape-sd-m", type=number, metavar="SD", default=TAPE_SD_M, help="default: %(default)g")
    people = parser.add_argument_group("people")
    people.add_argument("--pose", default="auto", metavar="NAME", help="back end, or recorded:FILE (default: auto)")
    people.add_argument(
        "--fps", type=number, metavar="N",
        help=f"frames a second of a clip to look at (default: {FPS:g}); for photos: the rate at "
             "which they were taken",
    )  # fmt: skip
    people.add_argument(
        "--different-people",
        action="store_true",
        help="no person is in more than one photo: count everyone as a different person",
    )
    add_camera_options(parser)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        return int(width), int(height)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: write WxH in pixels, like 1920x1080") from None


@dataclass(frozen=True, eq=False)
class Picture:
    """The first of the camera's photos or frames, for its lens and size and to draw on."""

    photo: Photo | None
    width: int
    height: int


def run(args: argparse.Namespace) -> int:
    """Find the mount, write it, print what it means and draw the floor."""
    ways = [name for name in ("points", "homography", "subtitles") if getattr(args, name)]
    stated = any(v is not None for v in (args.height_m, args.pitch_deg, args.roll_deg))
    if len(ways) + stated > 1:
        raise SettingsError(
            "the camera's place is stated twice: one of --points, --homography, --subtitles, --height-m"
        )
    picture = _picture(args)
    camera, focal_known = lens_of_picture(picture, focal_request(args))
    mount, notes, distances, marks = _found(args, ways, stated, picture, camera, focal_known)
    out = Path(args.out)
    if not out.parent.is_dir():
        raise SettingsError(f"--out {out}: there is no folder {out.parent}")
    mount.write(out)
    from ..calibration.report import lines_of

    print("\n".join([str(out), *lines_of(mount, distances), *notes]))
    drawn = _draw(mount, picture, out, marks)
    if drawn:
        print(f"check that the grid and the horizon fit the picture: {drawn}")
    return DONE


def lens_of_picture(picture: Picture, request: FocalRequest) -> tuple[Camera, bool]:
    """Return the lens of a picture, and whether its focal length is known."""
    from ..calibration.lens import lens_of

    photo = picture.photo or Photo("picture", picture.width, picture.height, "")
    return lens_of(photo, request)


def _found(
    args: argparse.Namespace, ways: list[str], stated: bool, picture: Picture, camera: Camera, focal_known: bool
) -> tuple[Mount, list[str], tuple[float, ...], np.ndarray | None]:
    """Return the mount, what else to print, how far people are, and pixels to mark."""
    if "points" in ways or "homography" in ways:
        return _from_points(args, camera, focal_known)
    lens = camera if focal_known else None
    if "subtitles" in ways:
        from ..calibration.drone import from_subtitles

        return from_subtitles(args.subtitles, lens), [], (), None
    if stated:
        return _with_lengths(args, _stated(args, lens, picture), [], ())
    drone = _drone(picture, lens)
    if drone is not None:
        return drone, [], (), None
    if args.length and not args.paths and ":" not in args.pose:
        return _with_lengths(args, Mount(camera=lens, size_px=(picture.width, picture.height)), [], ())
    from .calibrate_people import people_fit

    fit = people_fit(args, camera, focal_known)
    notes = [f"{fit.n_people} different people in {fit.n_frames} photos or frames", *fit.doubts]
    return _with_lengths(args, fit.mount, notes, fit.distances_m)


def _from_points(
    args: argparse.Namespace, camera: Camera, focal_known: bool
) -> tuple[Mount, list[str], tuple[float, ...], np.ndarray | None]:
    from ..calibration.homography import read_homography
    from ..calibration.points import FloorPoints, from_homography, from_points

    if args.points:
        points = FloorPoints.read(args.points, args.click_sd_px, args.tape_sd_m)
        fit = from_points(points, camera, focal_known=focal_known)
    else:
        fit = from_homography(
            read_homography(args.homography), camera, focal_known=focal_known, click_sd_px=args.click_sd_px,
            tape_sd_m=args.tape_sd_m,
        )  # fmt: skip
    notes = [
        f"point {k}: off by {math.hypot(*px):.1f} px, {math.hypot(*m):.2f} m"
        + (" - check it" if k in fit.wrong else "")
        for k, (px, m) in enumerate(zip(fit.residual_px, fit.residual_m, strict=True), 1)
    ]
    if fit.spread > 1.5:
        notes.append(
            f"the points are off by {fit.spread:.1f} times what click and tape explain: the intervals are wider"
        )
    return fit.mount, notes, (), fit.points.points_px


def _stated(args: argparse.Namespace, lens: Camera | None, picture: Picture) -> Mount:
    def angle(name: str, default: float = math.nan) -> float:
        value = getattr(args, name)
        return default if value is None else math.radians(value)

    return Mount.stated(
        angle("pitch_deg"), angle("roll_deg"), math.nan if args.height_m is None else args.height_m,
        pitch_sd_rad=angle("pitch_sd_deg", STATED_ANGLE_SD_RAD), roll_sd_rad=angle("roll_sd_deg", STATED_ANGLE_SD_RAD),
        height_sd_m=args.height_sd_m, size_px=(picture.width, picture.height), camera=lens,
    )  # fmt: skip


def _with_lengths(
    args: argparse.Namespace, mount: Mount, notes: list[str], distances: tuple[float, ...]
) -> tuple[Mount, list[str], tuple[float, ...], np.ndarray | None]:
    if not args.length:
        return mount, notes, distances, None
    from ..calibration.lengths import Length, with_lengths

    lengths = [Length.parsed(text) for text in args.length]
    mount, away = with_lengths(mount, lengths, args.click_sd_px, args.tape_sd_m)
    results = [f"length {k}: {length.metres:g} m, comes out at {length.metres - off:.2f} m"
            for k, (length, off) in enumerate(zip(lengths, away, strict=True), 1)]  # fmt: skip
    return mount, [*notes, *results], distances, np.concatenate([length.ends_px for length in lengths])


def _drone(picture: Picture, lens: Camera | None) -> Mount | None:
    if picture.photo is None or picture.photo.path is None:
        return None
    from ..calibration.drone import from_xmp

    return from_xmp(picture.photo.path, lens)


def _picture(args: argparse.Namespace) -> Picture:
    """Return the first photo or frame; raises SettingsError where there is none."""
    for photo in first_photos(args.paths):
        return Picture(photo, photo.width, photo.height)
    if args.pose.startswith("recorded:"):
        from ..pose.recorded import Recorded

        recorded = Recorded(args.pose.partition(":")[2])
        for name in recorded.photos:
            photo = recorded.photo(name)
            return Picture(None, photo.width, photo.height)
    if args.size is None:
        raise SettingsError("give a photo or a clip of the camera, or --size WxH: pixels mean nothing without it")
    return Picture(None, *args.size)


def _draw(mount: Mount, picture: Picture, out: Path, marks: np.ndarray | None) -> Path | None:
    """Write the picture with the floor drawn on it; None where the mount does not know the floor's place."""
    try:
        from ..calibration.report import floor_drawn

        pixels = np.full((picture.height, picture.width, 3), 60, np.uint8)
        if picture.photo is not None:
            pixels = picture.photo.pixels()
        drawn = floor_drawn(pixels, mount, marks)
    except (CameraError, PhotoError) as error:
        print(f"no picture: {error}", file=sys.stderr)
        return None
    from PIL import Image

    path = out.with_suffix(".png")
    Image.fromarray(drawn).save(path)
    return path
