"""`proxemetry doctor`: what each photo tells of its camera, and what it leaves out; without photos, of this machine.

No network is run.
"""

from __future__ import annotations

import argparse
import sys

from ..archive.store.photos import find_photos
from ..camera import CameraEstimate
from ..camera.focal import estimate_camera, row_of
from ..errors import PhotoError
from ..intervals import HALF_WIDTH_SD
from ..photo import Photo
from . import DONE, NOTHING_DONE, SOME_FAILED, installation
from .camera_options import WHAT_TO_STATE, add_camera_options, focal_request

_EXAMPLES = """examples:
  proxemetry doctor                                         is everything installed, and what to do if not
  proxemetry doctor photos                                  every candidate for every photo's focal length
  proxemetry doctor photos --missing                        only the photos that need a word from you
  proxemetry doctor scans --camera-table cameras.csv        try a camera table before measuring

The line with the arrow is the one that measuring would use; the interval is the central 90 %. Exit codes: 0 done;
1 some photos cannot be read; 2 none can.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "paths", nargs="*", metavar="PHOTO",
        help="photos, folders (searched all the way down), globs; none: check this installation",
    )  # fmt: skip
    parser.add_argument("--missing", action="store_true", help="print only photos without a focal length, or doubtful")
    add_camera_options(parser)


def run(args: argparse.Namespace) -> int:
    """Print a few lines a photo, or on this installation, and return the exit code."""
    if not args.paths:
        print("\n".join(installation.lines()))
        return DONE
    request, listing = focal_request(args), find_photos(args.paths)
    known, doubtful, unknown, failed = 0, 0, 0, 0
    spare = {row.line for row in request.camera_table.rows} if request.camera_table else set[int]()
    for name in listing.names:
        try:
            photo = Photo.open(listing.location(name), name)
        except PhotoError as error:
            failed += 1
            print(f"{name}: cannot be read\n  {str(error).removeprefix(f'{listing.location(name)}: ')}")
            continue
        estimate = estimate_camera(photo, request)
        if request.camera_table and (row := row_of(photo, request.camera_table)):
            spare.discard(row.line)
        known += estimate.camera is not None
        unknown += estimate.camera is None
        doubtful += estimate.camera is not None and bool(estimate.flags)
        if not args.missing or estimate.camera is None or estimate.flags:
            print("\n".join(lines_of(photo, estimate)))
    for line in sorted(spare):
        print(f"{args.camera_table}: line {line} is used for none of these photos")
    if unknown:
        print(f"\n{WHAT_TO_STATE}\n")
    if listing.passed_over:
        print(listing.passed_over)
    print(
        f"{len(listing.names)} photos: {known} with a focal length ({doubtful} of them doubtful), {unknown} without, "
        f"{failed} that cannot be read"
    )
    if failed == len(listing.names):
        print("proxemetry: none of the photos can be read; the lines above say why", file=sys.stderr)
        return NOTHING_DONE
    return SOME_FAILED if failed else DONE


def lines_of(photo: Photo, estimate: CameraEstimate) -> list[str]:
    """Return what is known of a photo's camera as lines of text: every candidate, the choice, what is missing."""
    metadata, camera = photo.metadata, estimate.camera
    named = ", ".join(filter(None, (metadata.model or metadata.make, metadata.lens))) or "camera not named"
    lines = [f"{photo.name}: {photo.width} x {photo.height}, {named}"]
    for candidate in estimate.candidates:
        chosen = camera is not None and candidate.source == camera.source
        rel_sd = camera.focal_rel_sd if camera is not None and chosen else candidate.rel_sd
        lines.append(
            f"  {'->' if chosen else '  '} {candidate.focal_px:8.0f} px  +-{100 * HALF_WIDTH_SD * rel_sd:3.0f} %  "
            f"{candidate.source}"
        )
        if chosen and estimate.why and len(estimate.candidates) > 1:
            lines.append(f"              why: {estimate.why}")
    if camera is not None and camera.principal_sd_px:
        lines.append(f"  principal point: the middle, +-{HALF_WIDTH_SD * camera.principal_sd_px:.0f} px")
    if estimate.lens is not None:
        lines.append(f"  distortion: {estimate.lens}")
    lines += [f"  doubt: {flag}" for flag in estimate.flags]
    if estimate.reason:  # what to do about it is said once, after all photos
        lines.append(f"  missing: {estimate.reason.partition('; ')[0]}")
    return lines
