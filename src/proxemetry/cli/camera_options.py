"""The options that state what is known of the cameras; commands that look at photos share them."""

from __future__ import annotations

import argparse
import sys

from ..camera import Mount
from ..camera.focal import FocalRequest
from ..camera.table import CameraTable

#: How `doctor` is made to use the people in a photo.
ASK_THE_PEOPLE = "--pose auto looks for them"
#: For photos without a focal length: how to state one.
WHAT_TO_STATE = """What you know of the lens can be stated:
  photo by photo, camera by camera    --camera-table FILE (or in `proxemetry review`)
  for all photos at once              --focal-35mm F, --focal-mm F --sensor-mm WxH, or --focal-px F
  as a guess, where nothing is known  --assume-fov DEG"""
#: 35 mm equivalents of lenses that are sold: fisheyes of 8 mm to telephotos of 800. The review page asks beyond these.
USUAL_35MM = (8.0, 800.0)


def add_camera_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `FocalRequest`."""
    group = parser.add_argument_group("camera (all but --assume-fov override the camera details stored in the photos)")
    group.add_argument("--focal-mm", type=number, metavar="F", help="focal length of the lens, millimetres")
    group.add_argument("--sensor-mm", type=_size, metavar="WxH", help="width and height of the sensor, millimetres")
    group.add_argument("--focal-35mm", type=number, metavar="F", help="35 mm equivalent focal length, of all photos")
    group.add_argument("--focal-px", type=number, metavar="F", help="focal length in pixels of the photos")
    group.add_argument(
        "--assume-fov",
        type=number,
        metavar="DEG",
        help="field of view to assume where nothing is known, along the photo's long side",
    )
    group.add_argument(
        "--no-assume", action="store_true",
        help="no distances where the focal length is unknown, instead of a marked assumption",
    )  # fmt: skip
    group.add_argument("--camera-table", metavar="FILE", help="CSV of what is known about single photos or cameras")


def add_mount_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that names where the camera is."""
    parser.add_argument(
        "--mount", metavar="CAMERA.json",
        help="the camera's place, the same in all photos: from `proxemetry calibrate`, or written by hand",
    )  # fmt: skip


def stated_mount(args: argparse.Namespace) -> Mount | None:
    """Return the mount that `--mount` names, or None; raises CameraError where it is not a mount."""
    return Mount.read(args.mount) if args.mount else None


def focal_request(args: argparse.Namespace) -> FocalRequest:
    """Return what the options state; what is doubtful about it is printed on standard error.

    Raises SettingsError or CameraError where options contradict each other.
    """
    table = CameraTable.read(args.camera_table) if args.camera_table else None
    request = FocalRequest(
        args.focal_mm,
        args.focal_35mm,
        args.focal_px,
        args.sensor_mm,
        args.assume_fov,
        camera_table=table,
        assume=not args.no_assume,
    )
    if args.focal_35mm is not None and not USUAL_35MM[0] <= args.focal_35mm <= USUAL_35MM[1]:
        _doubt(
            f"--focal-35mm {args.focal_35mm:g} is unusual: lenses have {USUAL_35MM[0]:g} to {USUAL_35MM[1]:g} mm. "
            "Is it right?"
        )
    if args.focal_mm is not None and args.sensor_mm is None:
        _doubt(
            "--focal-mm without --sensor-mm WxH is used only for photos whose file names a camera with a known sensor; "
            "for the others add --sensor-mm, or give --focal-35mm F instead"
        )
    return request


def _doubt(text: str) -> None:
    print(f"proxemetry: {text}", file=sys.stderr)


def number(text: str) -> float:
    """Return a number as it is written on a command line; for argparse."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number: write it like 28 or 4.25") from None


def _size(text: str) -> tuple[float, float]:
    width, _, height = text.lower().partition("x")
    try:
        return float(width), float(height)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: write WxH in millimetres, like 36x24") from None
