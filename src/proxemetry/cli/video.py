"""`proxemetry video`: clips in, a folder for each: paths, distances over time, and exposure."""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
from pathlib import Path
from typing import Any

from ..archive.store.folder import Folder
from ..clip.analysis import Wanted
from ..clip.boxes import Boxes
from ..clip.events import SHORTEST_S
from ..clip.measuring import Job
from ..clip.run import Outcome, clips_of, read_region, run_clip
from ..errors import ProxemetryError, SettingsError
from ..locate import LocateSettings
from ..measure import Settings
from ..people.attributes import PairsWhere
from . import DONE, NOTHING_DONE, SOME_FAILED, end_as_by_ctrl_c
from .attribute_options import add_pairs_where
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

_EXAMPLES = """examples:
  proxemetry video square.mp4 --out results --mount CAMERA.json
  proxemetry video square.mp4 --out results --focal-35mm 26          the camera's place from the people
  proxemetry video a.mp4 b.mp4 --out results --within 1.5 2 --fps 2  a folder each
  proxemetry video timelapse --out results --mount CAMERA.json       a folder of pictures of one fixed camera
  proxemetry video top.mp4 --out results --mount CAMERA.json --detections boxes.txt    boxes from a tracker

Run the same command again to continue where it stopped. Results: DIR/frames.csv, tracks.csv, people.csv,
pairs_over_time.csv, exposure.csv, events.csv (also as Parquet), summary.json, report.html, DIR/scenes/. Exit codes: 0
done; 1 done, but some clips or frames failed; 2 nothing could be done.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("clips", nargs="+", metavar="CLIP", help="video files, or folders of consecutive pictures")
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="results folder; for several clips, the folder that holds theirs"
    )
    parser.add_argument(
        "--fps", type=number, default=5.0, metavar="N", help="frames measured per second, at most (default: 5)"
    )
    _add_people(parser)
    add_camera_options(parser)
    add_mount_option(parser)
    _add_questions(parser)
    _add_output(parser)


def _add_people(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("people")
    add_pose_options(group)
    group.add_argument(
        "--detections", metavar="FILE",
        help="people found earlier: boxes as MOT Challenge text (they need --mount), or recorded:FILE of keypoints",
    )  # fmt: skip
    add_body_options(group)


def _add_questions(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("questions")
    group.add_argument(
        "--within", type=number, nargs="+", default=[1.0, 1.5, 2.0], metavar="M",
        help="distances in metres to report on (default: 1 1.5 2)",
    )  # fmt: skip
    group.add_argument(
        "--region", metavar="POLYGON.json", help="part of the floor for densities, as corners in metres (default: all)"
    )
    group.add_argument(
        "--groups", default="apart", choices=("apart", "ignore"),
        help="apart: the summary leads with pairs that do not belong together; ignore: with all pairs",
    )  # fmt: skip
    add_pairs_where(group)
    group.add_argument(
        "--min-event", type=number, default=SHORTEST_S, metavar="S", help="ignore shorter encounters (default: 1)"
    )


def _add_output(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("output and run")
    group.add_argument("--aggregate-only", action="store_true", help="write no tracks, no pairs and no keypoints")
    group.add_argument("--annotated", action="store_true", help="write the clip with people and distances drawn in")
    group.add_argument("--faces", default="blur", choices=("blur", "show"), help="heads in it (default: blur)")
    add_run_options(group)


def run(args: argparse.Namespace) -> int:
    """Measure the clips, print what came out, and return the exit code."""
    job, wanted = _job(args)
    paths = clips_of(args.clips)
    end_as_by_ctrl_c()
    if len(paths) == 1:
        numbers = _one(paths[0], args.out, args, job, wanted)
        _print(numbers, args)
        return SOME_FAILED if numbers["n_frames_failed"] else DONE
    return _several(paths, args, job, wanted)


def _several(paths: list[Path], args: argparse.Namespace, job: Job, wanted: Wanted) -> int:
    outcomes: list[Outcome] = []
    for path, name in zip(paths, _folder_names(paths), strict=True):
        out = f"{args.out}/{name}"
        try:
            outcomes.append(Outcome(path.name, name, _one(path, out, args, job, wanted)))
        except ProxemetryError as error:
            print(f"proxemetry: {error}", file=sys.stderr)
            outcomes.append(Outcome(path.name, name, None, str(error)))
    Folder(args.out).write("clips.csv", _clips_csv(outcomes).encode())
    failed = sum(o.summary is None for o in outcomes)
    print(f"{args.out}: {len(outcomes) - failed} of {len(outcomes)} clips measured; clips.csv has a row each")
    if failed == len(outcomes):
        return NOTHING_DONE
    return SOME_FAILED if failed or any(o.summary and o.summary["n_frames_failed"] for o in outcomes) else DONE


def _folder_names(paths: list[Path]) -> list[str]:
    """Return a folder's name for each clip: that of the file, numbered where two are called alike."""
    names: list[str] = []
    for path in paths:
        base = name = path.stem or "clip"
        count = 2
        while name in names:
            name, count = f"{base}_{count}", count + 1
        names.append(name)
    return names


def _clips_csv(outcomes: list[Outcome]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    fields = ("seconds", "n_frames", "n_frames_failed", "n_tracks", "people_at_least")
    writer.writerow(("clip", "folder", "status", "reason", *fields))
    for o in outcomes:
        values = [(o.summary or {}).get(f, "") for f in fields]
        writer.writerow((o.clip, o.folder, "failed" if o.summary is None else "ok", o.reason or "", *values))
    return out.getvalue()


def _job(args: argparse.Namespace) -> tuple[Job, Wanted]:
    limits = tuple(sorted(set(args.within)))
    if not limits or min(limits) <= 0:
        raise SettingsError("--within: distances are positive numbers of metres")
    if not 0 < args.fps <= 240:
        raise SettingsError(f"--fps {args.fps:g}: it must be above 0 and at most 240")
    require_jobs(args)
    if args.min_event < 0:
        raise SettingsError(f"--min-event {args.min_event:g}: it must be 0 or more")
    if args.annotated:
        if args.aggregate_only:
            raise SettingsError("--annotated shows everyone, --aggregate-only no one: leave one of them out")
        from ..clip.annotate import require_encoder

        require_encoder()
    mount = stated_mount(args)
    settings = Settings(
        "scene", LocateSettings(args.body_size, child_weight=child_weight(args)), focal_request(args), mount=mount
    )
    pose, boxes = args.pose, None
    if args.detections and args.detections.startswith("recorded:"):
        pose = args.detections
    elif args.detections:
        boxes = Boxes.read(args.detections)
    options = pose_options(args)
    region = read_region(args.region) if args.region else None
    return Job(pose, options, settings, boxes), Wanted(
        limits, region, mount, settings, args.min_event, PairsWhere.parsed(args.pairs_where)
    )  # fmt: skip


def _one(path: Path, out: str, args: argparse.Namespace, job: Job, wanted: Wanted) -> dict[str, Any]:
    from ..clip.page import write_page

    try:
        with Reporter("frame") as reporter:
            found, sums, numbers = run_clip(
                path, out, job, wanted, fps=args.fps, jobs=args.jobs, restart=args.restart,
                aggregate_only=args.aggregate_only, on_progress=reporter,
            )  # fmt: skip
        folder = Folder(out)
        run_json = json.loads(folder.read("run.json") or b"{}")
        write_page(found, sums, numbers, run_json, folder, aggregate_only=args.aggregate_only, groups=args.groups)
        if args.annotated:
            from ..clip.annotate import annotate

            print(f"{out}/{annotate(path, found, folder, fps=args.fps, faces=args.faces)}")
        return numbers
    except KeyboardInterrupt:
        raise KeyboardInterrupt("; the same command continues from there") from None


def _print(numbers: dict[str, Any], args: argparse.Namespace) -> None:
    print(
        f"{numbers['clip']}: {numbers['seconds']:.1f} s, {numbers['n_frames']} frames, {numbers['n_tracks']} tracks "
        f"(of {numbers['people_at_least']} to {numbers['people_at_most']} people)"
    )
    for note in dict.fromkeys([*numbers["cameras"].values(), *numbers["notes"]]):
        print(f"  {note}")
    moved = [s for s in numbers["shots"] if s["began"] == "camera moved"]
    if moved:
        often = "once" if len(moved) == 1 else f"{len(moved)} times"
        print(f"  the camera was moved {often}; see the column shot of frames.csv")
    kind, words = ("_apart", "not of one group") if args.groups == "apart" else ("", "all pairs")
    limits = {} if numbers["n_groups"] is None else numbers["within_m"]  # nobody was followed at any time
    for limit, found in limits.items():
        value = found[f"pair_seconds{kind}"]
        print(
            f"  within {limit} m, {words}: {value['seconds']:.1f} s [{value['low_s']:.1f}, {value['high_s']:.1f}], "
            f"{found[f'events{kind}']} encounters"
        )
    print(f"written to {args.out}: tables, summary.json, report.html")
