"""`proxemetry measure`: photos in, a results folder out."""

from __future__ import annotations

import argparse
import sys

from ..archive.run.run import ENGINES, Outcome
from ..archive.run.run import run as run_archive
from ..archive.run.work import Job
from ..archive.store.folder import OVERLAYS
from ..archive.store.results import Results
from ..errors import SettingsError
from ..locate import FLOORS, METHODS, QUIRKS, LocateSettings
from ..settings import DEFAULT_METHOD, Settings
from . import DONE, NOTHING_DONE, SOME_FAILED, Once, end_as_by_ctrl_c
from .camera_options import add_camera_options, add_mount_option, focal_request, number, stated_mount
from .progress import Reporter
from .run_options import (
    add_body_options,
    add_pose_options,
    add_run_options,
    child_weight,
    pose_options,
    require_jobs,
)
from .tally import print_results

_EXAMPLES = """examples:
  proxemetry measure photos --out results                          a folder of photos
  proxemetry measure photos --out results --overlays --faces blur  with a picture of each photo to check
  proxemetry measure photos --out results --safe-distance 1.5
  proxemetry measure IMG_1.JPG IMG_2.JPG --out results --focal-mm 50 --sensor-mm 36x24
  proxemetry measure scans --out results --assume-fov 50           no metadata: assumed, and marked as assumed
  proxemetry measure frames --out results --mount CAMERA.json      a fixed camera, calibrated once
  proxemetry measure --pose recorded:keypoints.json --out results  keypoints from elsewhere, with or without photos
  proxemetry measure archive --out results --shard 3/40            one of 40 jobs on one shared folder

Run the same command again to continue where it stopped, or to measure photos that were added. Results: DIR/photos.csv,
people.csv and pairs.csv (also as Parquet), DIR/scenes/, DIR/run.json, DIR/overlays/. Exit codes: 0 done; 1 done, but
some photos failed (their rows have the reason); 2 nothing could be done.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "paths", nargs="*", metavar="PATH", help="photos, folders (searched all the way down), globs, URLs"
    )
    parser.add_argument(
        "--out", default="results", metavar="DIR", help="results folder, a path or a URL (default: results)"
    )
    _add_method(parser)
    parser.add_argument("--no-lines", action="store_true", help="do not use straight lines in the picture")
    parser.add_argument(
        "--same-camera", action="store_true",
        help="photos of one size without a focal length were taken with one camera and lens: find it "
             "from the people in all of them",
    )  # fmt: skip
    parser.add_argument(
        "--no-other-photos",
        action="store_true",
        help="each photo by itself: no sensor size from other photos of the same camera model",
    )
    parser.add_argument("--no-drone", action="store_true", help="ignore the height and gimbal angles in a drone's file")
    parser.add_argument("--no-undistort", action="store_true", help="do not correct lens distortion")
    add_camera_options(parser)
    add_mount_option(parser)
    _add_output(parser)
    _add_run(parser)


def _add_method(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("method")
    add_pose_options(group)
    defaults = LocateSettings()
    group.add_argument(
        "--method", default=DEFAULT_METHOD, choices=METHODS, action=Once,
        help="scene: one fit of all people, the floor and the camera; the others are the paper's, for comparison "
        f"(default: {DEFAULT_METHOD})",
    )  # fmt: skip
    add_body_options(group)
    group.add_argument(
        "--floor", default=defaults.floor, choices=FLOORS,
        help=f"shared: one level floor for all, except people marked off-floor in a review (default: {defaults.floor})",
    )  # fmt: skip
    group.add_argument(
        "--quirks", type=_names, default=frozenset[str](), metavar="A,B",
        help=f"peculiarities of the published code, for comparison: {', '.join(QUIRKS)}",
    )  # fmt: skip


def _add_output(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("output")
    group.add_argument(
        "--overlays", action="store_true", help="draw every photo with people, distances and the view from above"
    )
    group.add_argument(
        "--faces", default="show", choices=("show", "blur"), help="in overlays: blur pixelates the heads"
    )
    group.add_argument("--safe-distance", type=number, metavar="M", help="count the pairs nearer than M metres")
    group.add_argument("--with-names", action="store_true", help="copy names and captions from the metadata")
    group.add_argument("--with-gps", action="store_true", help="copy the coordinates from the metadata")


def _add_run(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("run")
    add_run_options(group)
    group.add_argument("--engine", default="local", choices=ENGINES, help="ray: on a Ray cluster")
    group.add_argument("--shard", type=_share, metavar="I/N", help="do the I-th of N shares of the work (I from 1)")
    group.add_argument("--repair", action="store_true", help="measure again the photos of parts that are damaged")


def _share(text: str) -> tuple[int, int]:
    part, _, whole = text.partition("/")
    try:
        return int(part), int(whole)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: write I/N, like 3/40") from None


def _names(text: str) -> frozenset[str]:
    return frozenset(name.strip() for name in text.split(",") if name.strip())


def run(args: argparse.Namespace) -> int:
    """Measure, print what came out, and return the exit code."""
    job = _job(args)
    require_jobs(args)
    if args.safe_distance is not None and not args.safe_distance > 0:
        raise SettingsError(f"--safe-distance {args.safe_distance}: it must be a positive number of metres")
    if args.overlays:
        from ..archive.figures.overlays import require_plotting

        require_plotting(args.out)
    end_as_by_ctrl_c()
    try:
        with Reporter() as reporter:
            outcome = run_archive(
                args.paths, job, jobs=args.jobs, engine=args.engine, shard=args.shard, restart=args.restart,
                repair=args.repair, safe_distance_m=args.safe_distance, on_progress=reporter,
            )  # fmt: skip
        return _finish(args, outcome)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("; the same command continues from there") from None


def _job(args: argparse.Namespace) -> Job:
    focal = focal_request(args)
    locate = LocateSettings(args.body_size, floor=args.floor, quirks=args.quirks, child_weight=child_weight(args))
    return Job(
        args.out,
        args.pose,
        pose_options(args),
        Settings(
            args.method,
            locate,
            focal,
            undistort=not args.no_undistort,
            mount=stated_mount(args),
            lines=not args.no_lines,
            drone=not args.no_drone,
            other_photos=not args.no_other_photos,
            same_camera=args.same_camera,
        ),
        args.with_names,
        args.with_gps,
    )


def _finish(args: argparse.Namespace, outcome: Outcome) -> int:
    if not outcome.complete:
        left = outcome.n_shards - outcome.finished
        print(
            f"{args.out}: {outcome.measured.photos} photos measured; {left} of {outcome.n_shards} parts are still to "
            "come from the other shards; the last one to finish writes the tables",
            file=sys.stderr,
        )
        return SOME_FAILED if outcome.measured.failed else DONE
    results = Results.open(args.out)
    if args.overlays:
        _draw(results, args)
    failed = print_results(results)
    if failed == outcome.photos and outcome.photos:
        print(
            f"proxemetry: {args.out}: none of the photos could be measured; their rows have the reason", file=sys.stderr
        )
        return NOTHING_DONE
    _print_what_next(args)
    return SOME_FAILED if failed else DONE


def _print_what_next(args: argparse.Namespace) -> None:
    """Print where the pictures are, and what people do next."""
    if args.overlays:
        open_faces = "" if args.faces == "blur" else " (faces are not blurred: --faces blur before you share them)"
        print(f"pictures in {args.out}/{OVERLAYS}{open_faces}")
    print(f"next     proxemetry review {args.out}   look through the photos and correct what is wrong")
    print(f"         proxemetry report {args.out}   one page with figures, doubts and a methods paragraph")


def _draw(results: Results, args: argparse.Namespace) -> None:
    from ..archive.figures.overlays import draw
    from ..archive.run.pool import default_jobs

    draw(results, faces=args.faces, jobs=default_jobs() if args.jobs is None else args.jobs)
