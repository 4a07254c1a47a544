"""`proxemetry annotate`: make a benchmark of one's own photos, on a page of this machine."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from functools import partial

from ..annotate.project import NO_POSE, Project
from ..annotate.scoring import DEFAULT_METHODS, RUN_FOLDER, Scores, score_own_run
from ..benchmark.report import comparison
from ..errors import SettingsError
from ..locate import METHODS
from . import DONE, SOME_FAILED, end_as_by_ctrl_c

_HOW = f"""How it works:
  1. Photos.  On each photo everyone whose place you measured gets a name (P0, P1, ...) and up to four points: the
     middle of the eyes, of the shoulders, of the torso and of the head. A back end proposes the points; you correct
     what is wrong. The benchmark's rules stand beside each part.
  2. Places.  Type coordinates (tiles make a good grid), or the distances that you taped between people and cameras.
     They are solved by least squares: every tape's misfit is shown, and what is ambiguous, missing or contradictory.
  3. Check and score.  The label files are checked as by `proxemetry score --check`, the photos are measured, and both
     protocols' figures are shown.

examples:
  proxemetry annotate photos --out labels                 open the page; run it again to continue
  proxemetry annotate photos --out labels --pose none     click every point yourself
  proxemetry annotate photos --out labels --labels cvat.json    begin with another tool's keypoints
  proxemetry annotate photos --out labels --check         write the files and list what is missing; no page
  proxemetry annotate photos --out labels --score         measure and score what is annotated; no page

DIR then holds body_pixel_locations.csv, ground_truth_locations.csv and camera_locations_photoshoot_identifiers.csv, the
form in which the KORTE benchmark is published, and beside them names of shoots, focal lengths and annotations.sqlite,
the log of all you did. Every command that takes --labels takes DIR:
  proxemetry score DIR/{RUN_FOLDER} --labels DIR --protocol seker2021
  proxemetry benchmark --images photos --labels DIR --out run --method all --camera-table DIR/camera_table.csv

Nothing leaves this machine, and photos are never changed.
"""

_HOW_IT_ENDS = "Ctrl-C ends it; everything is saved as you go"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.epilog = _HOW
    parser.add_argument(
        "photos", nargs="+", metavar="PHOTOS", help="photos, folders (searched all the way down), globs"
    )
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of annotations; created, or continued")
    parser.add_argument(
        "--pose", default="auto", metavar="NAME",
        help=f"back end that proposes points, as in measure: auto, a name, recorded:FILE, or {NO_POSE} (default: auto)",
    )  # fmt: skip
    parser.add_argument(
        "--labels", metavar="FILE",
        help="begin with another tool's labels: COCO keypoints (CVAT, Label Studio), Label Studio's JSON, OpenPose, "
        "every other file that recorded:FILE takes, or a folder of KORTE's files",
    )  # fmt: skip
    parser.add_argument("--who", default="annotator", metavar="NAME", help="name to keep annotations under")
    parser.add_argument("--check", action="store_true", help="write the label files and list every fault; no page")
    parser.add_argument("--score", action="store_true", help="measure and score the annotated photos; no page")
    parser.add_argument(
        "--method", default=",".join(DEFAULT_METHODS), metavar="NAMES",
        help=f"of --score: comma-separated: {', '.join(METHODS)} (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, metavar="N", help="of --score: worker processes (default: one per core)")
    parser.add_argument("--port", type=int, default=0, metavar="N", help="port on this machine (default: any free one)")
    parser.add_argument("--no-browser", action="store_true", help="print the address and open nothing")


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl-C, or check or score without a page."""
    who = args.who.strip()
    if not who:
        raise SettingsError("--who is empty: annotations are kept under a name")
    with_page = not (args.check or args.score)
    if with_page and (importlib.util.find_spec("starlette") is None or importlib.util.find_spec("uvicorn") is None):
        raise SettingsError("the page needs two more packages: pip install 'proxemetry[web]'")
    end_as_by_ctrl_c()
    project = Project(args.photos, args.out, pose=args.pose, who=who, on_progress=_tell_progress)
    try:
        for why in project.left_out:
            print(f"proxemetry: left out: {why}", file=sys.stderr)
        if args.labels:
            photos, people = project.start_from(args.labels)
            print(f"{args.labels}: {people} people read, on {photos} photos without annotations", file=sys.stderr)
        if args.check and _check(project):
            return SOME_FAILED
        if args.score:
            _score(project, tuple(dict.fromkeys(name.strip() for name in args.method.split(","))), args.jobs)
        if with_page:
            _serve(project, args)
    finally:
        project.close()
    return DONE


def _tell_progress(done: int, total: int) -> None:
    if total > 200 and done % 100 == 0 and sys.stderr.isatty():  # reading headers and hashes of many takes a while
        print(f"reading photos: {done} of {total}", end="\r", file=sys.stderr)


def _check(project: Project) -> int:
    """Print every fault, and return how many are not harmless."""
    for doubt in project.doubts():
        print(f"proxemetry: {doubt}", file=sys.stderr)
    faults = project.check()
    for fault in faults:
        print(fault)
    count = sum(not fault.harmless for fault in faults)
    print(f"{project.out}: {count or 'no'} fault{'' if count == 1 else 's'}")
    return count


def _score(project: Project, methods: tuple[str, ...], jobs: int | None) -> None:
    from .progress import Reporter

    with Reporter() as reporter:
        scores: Scores = score_own_run(project, methods, jobs=jobs, on_progress=reporter)
    for of in scores.values():
        print(comparison(of))
    print(f"results, predictions and scores: {project.out / RUN_FOLDER}")


def _serve(project: Project, args: argparse.Namespace) -> None:
    from ..web.annotate_app import create_annotate_app
    from ..web.serve import serve

    serve(
        partial(create_annotate_app, project), port=args.port, open_browser=not args.no_browser,
        on_ready=lambda address: print(f"annotation page: {address}\n{_HOW_IT_ENDS}", flush=True),
    )  # fmt: skip
