"""`proxemetry benchmark`: run a method on a benchmark's photos, or on its annotated points, and score it."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..benchmark import DEFAULT_PROTOCOL, PROTOCOLS, Predictions, Score, read_labels, score, write_predictions
from ..benchmark.predictions import by_stated_distances
from ..benchmark.report import comparison
from ..benchmark.tables import TABLES
from ..camera.request import FocalRequest
from ..camera.table import CameraTable
from ..errors import OutputError, SettingsError
from ..evaluate import predict_labels, predict_photos
from ..locate import BODY_SIZES, METHODS, LocateSettings
from ..settings import DEFAULT_METHOD, Settings
from ..text_tables import terminal_width
from . import DONE
from .score import check_output, show

HOW = """KORTE is 96 photographs of people at measured places. The photos and labels are their authors' to give:

1. Open https://doi.org/10.23729/b2ea87e6-b845-46b8-abf3-cdbe299ce8b0 and download the photos and the three label
   files (body_pixel_locations.csv, ground_truth_locations.csv, camera_locations_photoshoot_identifiers.csv).
2. Put the label files into one folder, for example korte/labels, and the photos into another, korte/photos.
3. Check the labels:        proxemetry score --check korte/labels
4. Run and score:           proxemetry benchmark --images korte/photos --labels korte/labels --out korte/run
   Run the same command again to continue where it stopped.
5. The paper's tables:      proxemetry benchmark --images korte/photos --labels korte/labels --out korte/run
                            --method scene,combined --protocol seker2021 --table all
   korte/run/predictions_METHOD.json hold the answers, for `proxemetry score`.

Without the photos the geometry alone can be tried on the annotated points, given each photo's focal length in
korte/labels/focal_lengths.csv or focal_lengths_recovered.csv (columns filename,focal_length_mm):
                            proxemetry benchmark --keypoints labels --labels korte/labels --method all

Cite the benchmark as: M. Seker, A. Männistö, A. Iosifidis, J. Raitoharju, Automatic Social Distance Estimation From
Images: Performance Evaluation, Test Benchmark, and Algorithm, arXiv 2103.06759; journal version in Machine Learning
with Applications, 2022, doi 10.1016/j.mlwa.2022.100427.
"""

_EXAMPLES = """examples:
  proxemetry benchmark --how                                 how to get the photos, step by step
  proxemetry benchmark --images korte/photos --labels korte/labels --out korte/run
  proxemetry benchmark --images korte/photos --labels korte/labels --out korte/run --method all --protocol seker2021
  proxemetry benchmark --keypoints labels --labels korte/labels --method all      without photos
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("--how", action="store_true", help="explain how to get the photos and run the benchmark")
    parser.add_argument("--labels", metavar="DIR", help="folder with the three label files")
    parser.add_argument("--images", metavar="DIR", help="folder with the photos")
    parser.add_argument(
        "--keypoints",
        metavar="labels|FILE",
        help="no photos needed. labels: the annotated points as keypoints; FILE: recorded keypoints of the photos",
    )
    parser.add_argument(
        "--method", action="append", metavar="NAMES",
        help=f"comma-separated: {', '.join(METHODS)}, or all; may be given again "
        f"(default: {DEFAULT_METHOD})",
    )  # fmt: skip
    parser.add_argument(
        "--protocol", choices=list(PROTOCOLS), default=DEFAULT_PROTOCOL,
        help="rules of scoring: v1, corrected (default), or seker2021, as published",
    )  # fmt: skip
    parser.add_argument("--pose", default="auto", metavar="NAME", help="the back end that finds people in the photos")
    parser.add_argument(
        "--camera-table", metavar="FILE.csv", help="what is known about the photos' cameras, as in measure"
    )
    parser.add_argument("--body-size", choices=BODY_SIZES, default="adults", help="KORTE shows adults (the default)")
    parser.add_argument("--out", metavar="DIR", help="keep results, predictions and scores here; needed with --images")
    parser.add_argument("--jobs", type=int, metavar="N", help="worker processes (default: one per core)")
    parser.add_argument("--table", choices=list(TABLES), help="one of the paper's tables")
    parser.add_argument(
        "--format", choices=("text", "csv", "latex"), default="text", help="form of --table (default: text)"
    )
    parser.add_argument("--plot", metavar="FILE", help="draw the score, or the table, to this file")
    parser.add_argument("--json", metavar="FILE", help="write the score to this file (one method only)")
    parser.add_argument("--csv", metavar="FILE", help="write one row per photo to this file (one method only)")


def run(args: argparse.Namespace) -> int:
    """Run the methods and print their scores."""
    if args.how:
        print(HOW, end="")
        return DONE
    if not args.labels or (args.images is None) == (args.keypoints is None):
        raise SettingsError("benchmark needs --labels DIR and either --images DIR or --keypoints; see --how")
    methods = _methods(",".join(args.method or [DEFAULT_METHOD]))
    check_output(args, len(methods))
    labels = read_labels(args.labels, errata=PROTOCOLS[args.protocol].errata)
    settings = {m: Settings(method=m, locate=LocateSettings(body_size=args.body_size)) for m in methods}
    if args.keypoints != "labels":
        answers = _measured(args, settings)
    else:
        answers = {m: Predictions(predict_labels(labels, s), f"{m} on annotated points") for m, s in settings.items()}
    if args.protocol == "seker2021":
        answers = by_stated_distances(answers)
    scores = {m: score(labels, given, args.protocol) for m, given in answers.items()}
    if args.out:
        annotated = args.keypoints == "labels"  # these depend on the protocol, by its labels
        _keep(Path(args.out), answers, scores, f"_{args.protocol}" if annotated else "", args.protocol)
    if len(scores) > 1 and not args.table:
        print(comparison(scores, terminal_width()), end="")
    else:
        show(scores, args)
    return DONE


def _measured(args: argparse.Namespace, settings: dict[str, Settings]) -> dict[str, Predictions]:
    """Find people in the photos, or in the file of recorded keypoints, and place them by each method."""
    from .progress import Reporter

    if not args.out:
        raise SettingsError(
            "benchmark needs --out DIR here: what is finished is kept there, and a rerun continues from it"
        )
    pose = f"recorded:{args.keypoints}" if args.keypoints else args.pose
    focal = FocalRequest(camera_table=CameraTable.read(args.camera_table)) if args.camera_table else None
    with Reporter() as reporter:
        return predict_photos(
            args.images, args.out, settings, pose=pose, focal=focal, jobs=args.jobs, on_progress=reporter
        )


def _methods(names: str) -> list[str]:
    methods = list(METHODS) if names == "all" else list(dict.fromkeys(name.strip() for name in names.split(",")))
    for method in methods:
        if method not in METHODS:
            raise SettingsError(f"method {method!r} is unknown: use some of {', '.join(METHODS)}, or all")
    return methods


def _keep(folder: Path, answers: dict[str, Predictions], scores: dict[str, Score], suffix: str, protocol: str) -> None:
    """Write each method's predictions and score."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for method, given in answers.items():
            write_predictions(folder / f"predictions_{method}{suffix}.json", given)
            (folder / f"score_{method}_{protocol}.json").write_text(scores[method].to_json(), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written ({error.strerror})") from error
