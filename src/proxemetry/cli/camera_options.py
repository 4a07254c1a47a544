"""The options that state what is known of the cameras; commands that look at photos share them."""

from __future__ import annotations

import argparse

from ..camera_table import CameraTable
from ..focal import FocalRequest


def add_camera_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `FocalRequest`."""
    group = parser.add_argument_group("camera (what is stated here goes before the photos' metadata)")
    group.add_argument("--focal-mm", type=float, metavar="F", help="focal length of the lens, millimetres")
    group.add_argument("--sensor-mm", type=_size, metavar="WxH", help="width and height of the sensor, millimetres")
    group.add_argument("--focal-35mm", type=float, metavar="F", help="35 mm equivalent focal length")
    group.add_argument("--focal-px", type=float, metavar="F", help="focal length in pixels of the photos")
    group.add_argument(
        "--assume-fov", type=float, metavar="DEG", help="horizontal field of view to assume where nothing is known"
    )
    group.add_argument("--camera-table", metavar="FILE", help="CSV of what is known of single photos or cameras")


def focal_request(args: argparse.Namespace) -> FocalRequest:
    """Return what the options state; raises SettingsError or CameraError where they contradict each other."""
    table = CameraTable.read(args.camera_table) if args.camera_table else None
    return FocalRequest(
        args.focal_mm, args.focal_35mm, args.focal_px, args.sensor_mm, args.assume_fov, camera_table=table
    )


def _size(text: str) -> tuple[float, float]:
    width, _, height = text.lower().partition("x")
    try:
        return float(width), float(height)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: write WxH in millimetres, like 36x24") from None
