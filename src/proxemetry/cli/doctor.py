"""`proxemetry doctor`: what each photo states about its camera, and what it lacks; without photos, of this machine.

No network is run unless `--pose` names one.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence

from ..archive.figures.focal_bases import in_words
from ..archive.store.photos import find_photos
from ..camera import CameraEstimate, FocalBasis, Mount
from ..camera.choice import PictureLines, choose_camera, with_gravity
from ..camera.focal import FocalRequest, row_of
from ..errors import PhotoError, one_line
from ..people import People, PoseBackend
from ..people.skeleton import COCO_17
from ..photo import Photo
from . import DONE, NOTHING_DONE, SOME_FAILED, installation
from .camera_options import WHAT_TO_STATE, add_camera_options, add_mount_option, focal_request, stated_mount
from .camera_words import words_of

#: With --no-lines so many pictures are decoded at most: a few seconds.
_DECODED = 100

_EXAMPLES = f"""examples:
  proxemetry doctor                                         is everything installed, and what to do if not
  proxemetry doctor photos                                  every candidate for every photo's focal length
  proxemetry doctor photos --missing                        only the photos whose lens you should state
  proxemetry doctor photos --pose auto                      look for people too, as evidence
  proxemetry doctor scans --camera-table cameras.csv        try a camera table before measuring

The line with the arrow is the one that measuring would use; the interval holds 90 %; "equivalent: 28 mm" is the 35 mm
equivalent. Pictures are decoded, which finds files that were cut short; with --no-lines those of {_DECODED} photos,
spread over all. Exit codes: 0 done; 1 some photos cannot be read; 2 none can.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "paths", nargs="*", metavar="PHOTO",
        help="photos, folders (searched all the way down), globs; none: check this installation",
    )  # fmt: skip
    parser.add_argument("--missing", action="store_true", help="print only photos without a focal length, or doubtful")
    parser.add_argument("--pose", metavar="NAME", help="look for people too: auto, a back end's name, or recorded:FILE")
    parser.add_argument("--no-lines", action="store_true", help="do not use straight lines in the pictures (quicker)")
    add_camera_options(parser)
    add_mount_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print a few lines a photo, or on this installation, and return the exit code."""
    if not args.paths:
        print("\n".join(installation.lines()))
        return DONE
    request, listing = focal_request(args), find_photos(args.paths)
    backend, mount = _backend(args.pose), stated_mount(args)
    tally, decoded = _Tally(), set(_spread(listing.names) if args.no_lines else listing.names)
    spare = {row.line for row in request.camera_table.rows} if request.camera_table else set[int]()
    for name in listing.names:
        try:
            photo = Photo.open(listing.location(name), name)
            estimate = _asked(photo, request, backend, mount, lines=not args.no_lines)
            if name in decoded:
                photo.pixels(1)  # as small as the decoder makes it; what was decoded above is not decoded again
        except PhotoError as error:
            tally.failed += 1
            print(f"{one_line(name)}: cannot be read\n  {_without(listing.location(name), error)}")
            continue
        if request.camera_table and (row := row_of(photo, request.camera_table)):
            spare.discard(row.line)
        tally.count(estimate)
        if not args.missing or estimate.camera is None or estimate.flags:
            print("\n".join(words_of(photo, estimate, people_asked=backend is not None)))
    for line in sorted(spare):
        print(f"{args.camera_table}: line {line} is used for none of these photos")
    if tally.unknown or tally.bases[FocalBasis.ASSUMED]:
        unknown = "Without a focal length there are no distances. " if tally.unknown else ""
        assumed = "Where a focal length is ASSUMED, intervals are wide. " if tally.bases[FocalBasis.ASSUMED] else ""
        print(f"\n{unknown}{assumed}{WHAT_TO_STATE}\n")
    if listing.passed_over:
        print(listing.passed_over)
    if len(decoded) < len(listing.names):
        print(f"{len(decoded)} pictures, spread over all, were decoded; without --no-lines all are")
    print(f"{len(listing.names)} photo{'' if len(listing.names) == 1 else 's'}: {tally}")
    if tally.failed == len(listing.names):
        print("proxemetry: none of the photos can be read; see the lines above", file=sys.stderr)
        return NOTHING_DONE
    return SOME_FAILED if tally.failed else DONE


def _spread(names: Sequence[str]) -> list[str]:
    """Return at most `_DECODED` names, evenly spread."""
    count = min(len(names), _DECODED)
    return [names[k * len(names) // count] for k in range(count)]


class _Tally:
    """How many photos had what."""

    def __init__(self) -> None:
        self.bases: Counter[FocalBasis] = Counter()
        self.doubtful = self.unknown = self.failed = 0

    def count(self, estimate: CameraEstimate) -> None:
        """Count one photo."""
        if estimate.source is None:
            self.unknown += 1
            return
        self.bases[estimate.source.kind.basis] += 1
        self.doubtful += bool(estimate.flags)

    def __str__(self) -> str:
        kinds = f"{in_words(self.bases)}; " if self.bases else ""
        known = f"{self.bases.total()} with a focal length ({kinds}{self.doubtful} of them doubtful)"
        return f"{known}, {self.unknown} without, {self.failed} that cannot be read"


def _without(path: str, error: PhotoError) -> str:
    """Return a message without the photo's path before it."""
    return str(error).removeprefix(one_line(f"{path}: x").removesuffix("x"))


def _backend(name: str | None) -> PoseBackend | None:
    if name is None:
        return None
    from ..pose import backend_named

    return backend_named(name)


def _asked(
    photo: Photo, request: FocalRequest, backend: PoseBackend | None, mount: Mount | None, *, lines: bool
) -> CameraEstimate:  # fmt: skip
    """Return what is found out about a photo's camera as measuring would; raises PhotoError."""
    people = People.none(COCO_17) if backend is None else backend.detect(photo)
    picture = PictureLines(photo, people) if lines else None
    estimate = choose_camera(photo, people, request, mount, picture)
    return estimate if picture is None else with_gravity(estimate, picture, mount)
